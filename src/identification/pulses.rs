//! The rough inertia of a joint, from pulses of two efforts from rest, each way.
//!
//! ```text
//! weak     u_1 = 1.5 F     x = a_1 t^2 / 2     -+->  J = (u_2 - u_1) / (a_2 - a_1)
//! strong   u_2 = 2.5 F     x = a_2 t^2 / 2      +    the mean of 1 / J of both senses
//! ```
//!
//! `F` is the rough breakaway effort. A pulse lasts for 64 counts and 30 ticks. It ends earlier at
//! three tenths of the travel bound; at the same share of the speed bound, after 30 ticks; at twice
//! that share of the speed bound, at any time; or after a second. If the joint has not left its
//! place after that second, `F` was the effort at which a bristle or a shaft gave way: the effort
//! of the pulse replaces `F`, and the pulse is repeated.
//!
//! Guarantees: a pulse that ends by its speed has three counts or more, since an encoder disc on an
//! edge shows one or two. A pulse of few ticks or of few counts is marked as rough: its inertia is
//! used only by the loop of the next steps.
//!
//! Does badly: rough pulses show the inertia only roughly. The time of a pulse is known to a tick,
//! which may be the delay of the drive, and its travel to a count. The loop tolerates an inertia
//! that is too small better than one that is too large, so the shorter time is used. Over rigid
//! joints of all accelerations, the inertia of rough pulses is between 0.14 and 1.9 of the true
//! one, and that of the others between 0.94 and 1.17: a test checks these figures.

use super::settings::IdentificationPlan;

/// Efforts of the weak and of the strong pulse, in rough breakaway efforts, and the largest share
/// of the effort bound that the strong one uses.
const PULSES: [f32; 2] = [1.5, 2.5];
const BELOW: f32 = 0.9;
/// Travel (counts) and time (ticks) after which a pulse ends, and its longest time (s).
const COUNTS: u32 = 64;
const TICKS: u32 = 30;
const LONGEST_S: f32 = 1.0;
/// Share of the travel bound and of the speed bound at which a pulse ends earlier. Before its ticks
/// are over, it ends at twice this share of the speed bound.
const SHARE: f32 = 0.3;
/// Travel that an encoder disc on an edge shows of a joint at rest, counts.
const EDGE: u32 = 2;
/// Least number of counts for an inertia that can be compared with another one. One count of the
/// strong pulse's 16 is 6 % of its acceleration. One count of the weak pulse's five or so, at a
/// third of the acceleration, is as much of the difference of both.
const FEW: u32 = 16;

/// A pulse at a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pulse {
    pub strong: bool,
    pub reverse: bool,
    /// The effort without its sign, V.
    pub size: f32,
    /// Ticks since the start of the pulse, and travel of the joint without its sign, counts.
    pub elapsed: u32,
    pub moved: u32,
}

/// Next step after a tick of a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// The pulse continues.
    Lasts,
    /// The pulse has shown its acceleration.
    Measured,
    /// The joint has not left its place: the pulse is repeated with more effort.
    Again,
    /// The joint has not left its place, and the effort is close to its bound already.
    Still,
}

/// Findings of the pulses so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pulses {
    /// The weaker pulse either way: effort (V) and acceleration (deg/s^2).
    weaker: [[f32; 2]; 2],
    /// Inverse of the inertia: the mean of both senses, or half of the first one's as long as the
    /// second is missing.
    per_inertia: f32,
    /// The rough inertia, V/(deg/s^2).
    pub inertia: f32,
    /// Position of the joint after half of the longest time of a pulse, counts.
    halfway: i32,
    /// Whether a pulse had too few ticks or counts.
    is_rough: bool,
}

impl Pulse {
    /// Returns the effort of a pulse (V, without its sign) for a rough breakaway effort and the
    /// largest effort (V).
    pub fn size(strong: bool, rough: f32, largest: f32) -> f32 {
        let most = BELOW * largest;
        let [weak_effort, strong_effort] = if PULSES[1] * rough < most {
            PULSES.map(|share| share * rough)
        } else {
            [rough + 0.4 * (most - rough), most]
        };
        if strong { strong_effort } else { weak_effort }
    }

    /// Returns whether the pulse ends: it has enough travel and time, or has reached a bound.
    fn is_enough(&self, settings: &IdentificationPlan) -> bool {
        let Self { moved, elapsed, .. } = *self;
        let bounds = &settings.bounds;
        // The speed at the end is twice the mean one.
        let speed = 2.0 * moved as f32 / elapsed as f32;
        let is_long = elapsed > TICKS;
        let fast = if is_long { SHARE } else { 2.0 * SHARE } * bounds.speed;
        moved >= COUNTS && is_long
            || moved as f32 > SHARE * bounds.travel as f32
            || moved > EDGE && speed > fast
            || elapsed > settings.ticks(LONGEST_S)
    }

    /// Returns whether a pulse shows the inertia only roughly.
    const fn is_short(&self) -> bool {
        self.elapsed <= TICKS && self.moved <= 2 * COUNTS || self.moved < FEW
    }
}

impl Pulses {
    /// Returns the inertia that the pulses have met, V/(deg/s^2); zero: they show it only roughly,
    /// or not yet.
    pub const fn met(&self) -> f32 {
        if self.is_rough { 0.0 } else { self.inertia }
    }

    /// Evaluates a tick of a pulse with the joint at `counts`, and returns the next step.
    pub fn update(&mut self, pulse: &Pulse, counts: i32, settings: &IdentificationPlan) -> Next {
        let Pulse { strong, reverse, size, elapsed, moved } = *pulse;
        let longest = settings.ticks(LONGEST_S);
        if !pulse.is_enough(settings) {
            if 2 * elapsed <= longest {
                self.halfway = counts;
            }
            return Next::Lasts;
        }
        // Only a bristle or a shaft gave way before, and the joint itself has not left its place:
        // it needs more effort. A joint that slides goes farther in the second half of the time
        // than in the first, however few its counts are.
        let later = counts.wrapping_sub(self.halfway).unsigned_abs();
        if moved < COUNTS && 2 * later <= moved && elapsed > longest {
            let most = BELOW * settings.bounds.effort;
            return if size < BELOW * most { Next::Again } else { Next::Still };
        }
        let is_short = pulse.is_short();
        self.is_rough |= is_short;
        // The effort has been held for a tick less, and for two with a delay.
        let held = elapsed.saturating_sub(1 + u32::from(is_short)).max(1);
        let time = held as f32 * settings.tick;
        let acceleration = 2.0 * moved as f32 * settings.count / (time * time);
        let weaker = &mut self.weaker[usize::from(reverse)];
        if strong {
            let [before, slower] = *weaker;
            let slope = (acceleration - slower) / (size - before);
            // Whatever the friction is, at most the whole effort accelerates the inertia.
            let least = acceleration / size;
            self.per_inertia += 0.5 * slope.max(least);
            self.inertia = 1.0 / self.per_inertia;
        }
        *weaker = [size, acceleration];
        Next::Measured
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::safety::open_loop::Bounds;

    const TICK: f32 = 1e-3;
    const COUNT: f32 = 0.01;

    /// Settings with a speed bound, counts a tick.
    fn settings(speed: f32) -> IdentificationPlan {
        let bounds = Bounds { effort: 4.0, travel: 18_000, speed, ticks: 300_000 };
        IdentificationPlan {
            bounds,
            tick: TICK,
            count: COUNT,
            quiet: 200,
            window: 200,
            fast: 1.0,
            slow: 0.1,
        }
    }

    /// A rigid joint with a breakaway effort of 1 V that slides with `slip` (V).
    #[derive(Clone, Copy, Debug)]
    struct Joint {
        /// Acceleration per volt, counts/(tick^2 V).
        gain: f64,
        slip: f64,
        /// Ticks after which an effort acts, and where on a count the joint rests.
        delay: u32,
        phase: f64,
    }

    /// Pulses of a joint by the closed form `x = a t^2 / 2`: the inertia that they find over the
    /// true one, and the most counts and ticks of a strong pulse.
    fn pulsed(joint: Joint, settings: &IdentificationPlan) -> (Pulses, f64, [u32; 2]) {
        let mut pulses = Pulses::default();
        let mut longest = [0; 2];
        for (strong, reverse) in [(false, false), (false, true), (true, false), (true, true)] {
            let size = Pulse::size(strong, 1.0, settings.bounds.effort);
            let acceleration = joint.gain * (f64::from(size) - joint.slip);
            for elapsed in 1..10_000u32 {
                let held = f64::from(elapsed.saturating_sub(1 + joint.delay));
                let way = 0.5 * acceleration * held * held;
                let way = if reverse { -way } else { way };
                let counts = (joint.phase + way).floor() as i32;
                let moved = counts.unsigned_abs();
                let pulse = Pulse { strong, reverse, size, elapsed, moved };
                match pulses.update(&pulse, counts, settings) {
                    Next::Lasts => continue,
                    Next::Measured => {}
                    other => panic!("{other:?}: {joint:?}"),
                }
                if strong {
                    longest = [longest[0].max(moved), longest[1].max(elapsed)];
                }
                break;
            }
        }
        let gain = f64::from(COUNT) / f64::from(TICK * TICK) * joint.gain;
        let found = f64::from(pulses.inertia) * gain;
        (pulses, found, longest)
    }

    /// Joints from those that a pulse accelerates to the speed bound in two ticks to those that
    /// need half a second.
    fn joints() -> impl Iterator<Item = Joint> {
        (0..60).flat_map(|step| {
            let gain = 8.0 * 0.8f64.powi(step);
            [0.5, 0.8, 1.0].into_iter().flat_map(move |slip| {
                [0, 1].into_iter().flat_map(move |delay| {
                    [0.05, 0.35, 0.65, 0.95].map(|phase| Joint { gain, slip, delay, phase })
                })
            })
        })
    }

    #[test]
    fn pulses_that_are_trusted_show_the_inertia_and_short_ones_roughly() {
        let (mut trusted, mut rough) = ([f64::MAX, 0.0f64], [f64::MAX, 0.0f64]);
        for speed in [0.05, 0.2, 1.0, 4.0] {
            let settings = settings(speed);
            for joint in joints() {
                let (pulses, found, [counts, ticks]) = pulsed(joint, &settings);
                let is_trusted = pulses.met() > 0.0;
                let range = if is_trusted { &mut trusted } else { &mut rough };
                *range = [range[0].min(found), range[1].max(found)];
                assert!(counts > EDGE, "{joint:?} at {speed}: {counts} counts, {ticks} ticks");
                assert!(!is_trusted || counts >= FEW, "{joint:?} at {speed}: {counts} counts");
            }
        }
        // An eighth of a count, and a tick of delay in 30.
        assert!(0.94 < trusted[0] && trusted[0] < 0.96, "{trusted:?}");
        assert!(1.12 < trusted[1] && trusted[1] < 1.17, "{trusted:?}");
        // Three counts in two ticks, of which one is taken for the delay's; and a weak and a strong
        // pulse that differ by that tick, where all of the effort is taken for inertia at most.
        assert!(0.14 < rough[0] && rough[0] < 0.17, "{rough:?}");
        assert!(1.7 < rough[1] && rough[1] < 1.9, "{rough:?}");
    }

    #[test]
    fn a_pulse_ends_at_the_least_travel_that_shows_its_speed_and_by_the_second_at_the_latest() {
        let pulse = |elapsed, moved| {
            let pulse = Pulse { strong: true, reverse: false, size: 2.5, elapsed, moved };
            pulse.is_enough(&settings(0.05))
        };
        // One and two counts are a disc on an edge, however slow the bound is.
        assert_eq!(
            [(31, 2), (31, 3), (3, 2), (3, 3)].map(|(t, x)| pulse(t, x)),
            [false, true, false, true]
        );
        // 2 x 3 / 450 counts a tick are less than 0.3 of 0.05, and 2 x 4 / 450 more.
        assert_eq!([3, 4].map(|moved| pulse(450, moved)), [false, true]);
        assert_eq!([1000, 1001].map(|elapsed| pulse(elapsed, 0)), [false, true]);
    }
}
