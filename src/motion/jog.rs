//! The guarded jog: the first powered motion of a new joint, open loop, within bounds.
//!
//! ```text
//! effort  ^        effort bound - - - - - - - - -
//!         |      /|                                 / rises by  rate h  a tick
//!         |    /  | 8 counts: the direction shows   | to zero at once
//!         +--/----+---rests------\----+-----------> ticks
//!         |                        \  | 8 counts
//! ```
//!
//! The effort rises from zero in the positive sense until the joint has moved by 8 counts, and goes
//! to zero at once. When the joint rests, the effort rises the other way. The joint's counts
//! against the sign of the effort show whether the encoder's direction is right. Nothing has to be
//! tuned or known: no gain, no friction, no direction. No law runs.
//!
//! If no count comes, the effort ends at its bound, and the other way is tried. Every other bound
//! of [`crate::safety::open_loop`] ends the jog. So does a motor with its own encoder that goes
//! farther than the bound of the travel, and the largest twist of the gear, away from where it
//! began: then the load's encoder may be dead. So do a stop, a silent link and a fault. The
//! monitors that assume the direction (reversal, following error), or the ratio of two encoders,
//! are off in a jog. All others are on.
//!
//! Guarantees: with an encoder that counts, the joint goes no farther from its start than
//! `travel + v^2 / (2 a) + v h`. Here `v` is the speed at the bound: `speed + sqrt(16 q A)`, since
//! 8 counts of `q` are tolerated at the largest acceleration `A` of the joint; `a` is the
//! deceleration by friction, and `h` the sample time. With an encoder that is dead, each way goes
//! as far as a ramp of [`effort`](JogBounds::effort) at [`rate`](JogBounds::rate) pushes the joint:
//! see docs/reference/wiring.md for the figures of a joint, and the tests for the closed form.
//!
//! Does badly: friction above the effort's bound looks like a motor that is not connected. A load
//! that moves the joint as soon as a brake opens shows no direction: it is reported as a load.

use serde::{Deserialize, Serialize};

use crate::control::controller::ControllerConfig;
use crate::control::device_config::DeviceConfig;
use crate::safety::monitor::Standstill;
use crate::safety::open_loop::{Bound, Bounds, OpenLoopState, SLACK};
use crate::units::error::{HUGE, InvalidValue, above, between};
use crate::units::value::{Key, Table, key, table};

/// Distance that shows the direction, counts: twice what a joint at rest may show.
pub const TELLING: u32 = SLACK;

/// Time within two counts after which a joint rests between the two ways, s. From the speed that a
/// jog ends with, friction stops a joint in less.
const QUIET: f32 = 0.2;

/// Time in which the effort rises to its bound, s, if the breakaway effort is known. A faster rise
/// moves a joint whose encoder is dead less far, but leaves less time to see a heavy joint move.
/// The thesis's joint, a slow one, shows its direction at 0.5 of 0.6 V.
const RISE: f32 = 1.0;

/// Time in which the effort rises to its bound, s, if the breakaway effort is unknown. The bound
/// may be far beyond it then, and only the short time keeps a joint with a dead encoder from going
/// far.
const UNKNOWN_RISE: f32 = 0.5;

/// The longest jog, s.
const LONGEST: f32 = 60.0;

/// Allowed rounding of a bound, as a fraction of it.
const ROUNDING: f32 = 1e-6;

table! {
    /// The bounds of a jog in a user's units, which the device keeps. None of them can be off.
    ///
    /// The examples are those of the thesis's joint (5 V, breakaway 0.4 V, 0.00242 deg).
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct JogBounds (jog) "jog" {
        /// Largest effort, V. Derived: one and a half times the effort that starts the joint
        /// (`limits.breakaway_v`), and no more than `duty_max` lets through; a quarter of that if
        /// nothing is known of the joint.
        effort: f32 = 0x0B01 "effort_v", Above(0.0, HUGE), Derived(0.6);
        /// Rate of the effort, V/s, no faster than the soft start. Derived: `effort_v` in a
        /// second, or in half of one if nothing is known of the joint: the slower, the farther goes
        /// a joint whose encoder is dead.
        rate: f32 = 0x0B02 "rate_v_per_s", Above(0.0, HUGE), Derived(0.6);
        /// Largest distance from where the jog began, deg. Derived: 2 deg, or 16 counts if that is
        /// more; 8 show the direction.
        travel: f32 = 0x0B03 "travel_deg", Above(0.0, HUGE), Derived(2.0);
        /// Largest speed, deg/s. 8 counts more than that are let pass. Derived: twice `travel_deg`
        /// a second.
        speed: f32 = 0x0B04 "speed_deg_per_s", Above(0.0, HUGE), Derived(4.0);
        /// Longest time of the whole jog, s.
        time: f32 = 0x0B05 "time_s", Above(0.0, LONGEST), Default(10.0);
    }
}

pub(crate) const EFFORT: Key = key(JogBounds::ABOUT, "effort");
const RATE: Key = key(JogBounds::ABOUT, "rate");
const TRAVEL: Key = key(JogBounds::ABOUT, "travel");
const SPEED: Key = key(JogBounds::ABOUT, "speed");
const TIME: Key = key(JogBounds::ABOUT, "time");

/// Bounds that a client requests for a jog, in the units of [`JogBounds`]: at most the device's
/// own. None: the device's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JogRequest {
    /// Largest effort, V.
    pub effort: Option<f32>,
    /// Rate of the effort, V/s.
    pub rate: Option<f32>,
    /// Largest distance, deg.
    pub travel: Option<f32>,
    /// Largest speed, deg/s.
    pub speed: Option<f32>,
    /// Longest time, s.
    pub time: Option<f32>,
}

impl JogBounds {
    /// Returns the derived bounds of a machine that sets none. `breakaway` is the effort that
    /// starts the joint (V), or zero if it is unknown.
    pub fn derived(controller: &ControllerConfig, device: &DeviceConfig, breakaway: f32) -> Self {
        let full_scale = controller.drive.full_scale;
        let largest = full_scale * controller.drive.duty_max;
        let (effort, rise) = match breakaway {
            known if known > 0.0 => ((1.5 * known).min(largest), RISE),
            _ => (0.25 * largest, UNKNOWN_RISE),
        };
        let travel = (2.0 * TELLING as f32 * controller.encoder.resolution).clamp(2.0, HUGE);
        // A drive of next to no volts would round to zero, which is no valid bound.
        let effort = effort.max(f32::MIN_POSITIVE);
        Self {
            effort,
            rate: (effort / rise).min(steepest(full_scale, device)).max(f32::MIN_POSITIVE),
            travel,
            speed: (2.0 * travel).min(HUGE),
            ..Self::EXAMPLE
        }
    }

    /// Rejects an effort that rises faster than the output's limit does after arming (soft start).
    pub(crate) fn check(&self, full_scale: f32, device: &DeviceConfig) -> Result<(), InvalidValue> {
        between(RATE, self.rate, 0.0, steepest(full_scale, device))
    }

    /// Returns the bounds that a client requests, or the device's own where the request has none.
    ///
    /// # Errors
    /// Returns an error that names the value beyond the device's own, or too small to show a
    /// direction.
    pub fn less(&self, asked: &JogRequest, resolution: f32) -> Result<Self, InvalidValue> {
        let pick = |key, asked: Option<f32>, own: f32, least: f32| match asked {
            None => Ok(own),
            // A decimal that rounds to the device's own bound is accepted as that bound.
            Some(asked) if asked > own && asked <= own * (1.0 + ROUNDING) => Ok(own),
            Some(asked) if least > 0.0 => between(key, asked, least, own).map(|()| asked),
            Some(asked) => above(key, asked, 0.0, own).map(|()| asked),
        };
        let telling = (TELLING as f32 * resolution).min(self.travel);
        Ok(Self {
            effort: pick(EFFORT, asked.effort, self.effort, 0.0)?,
            rate: pick(RATE, asked.rate, self.rate, 0.0)?,
            travel: pick(TRAVEL, asked.travel, self.travel, telling)?,
            speed: pick(SPEED, asked.speed, self.speed, 0.0)?,
            time: pick(TIME, asked.time, self.time, 0.0)?,
        })
    }
}

/// Returns the steepest rate that the soft start allows, V/s.
fn steepest(full_scale: f32, device: &DeviceConfig) -> f32 {
    if device.soft_start > 0.0 { full_scale / device.soft_start } else { HUGE }
}

/// A jog that is prepared for its ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jog {
    /// Rise of the effort in a tick, V.
    rung: f32,
    bounds: Bounds,
    /// Largest travel of a motor with its own encoder, counts of that encoder.
    motor_travel: u32,
    /// Time for which a joint at rest stays within two counts, ticks.
    quiet: u32,
    /// Whether it is a [test at arming](crate::motion::arming_test): each encoder has to move, and
    /// a joint beyond the bound of the speed comes to rest.
    needs_both: bool,
    /// Whether the first way is the negative one: the jog then runs in mirrored counts.
    is_mirrored: bool,
}

/// Reason why one way of a jog, the push in one direction, has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum JogEnd {
    /// This way has not ended yet, or was not tried.
    #[default]
    Not,
    /// The joint has moved far enough to show the direction.
    Moved,
    /// The effort has reached its bound, or the most that drive and supply allow.
    Effort,
    /// The joint exceeded the travel bound.
    Travel,
    /// The joint exceeded the speed bound.
    Speed,
    /// The time ran out.
    Time,
}

/// Findings of one way of a jog.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Way {
    /// Largest effort, V, without its sign; zero: this way was not tried.
    pub effort: f32,
    /// Travel from the start of this way to its end, counts.
    pub moved: i32,
    /// Travel of the motor, counts of its own encoder; `moved` is then that of the load. `None`
    /// with one encoder.
    pub motor_moved: Option<i32>,
    /// Sum of all counts on the way, without their sign.
    pub counted: u32,
    /// Reason why this way has ended.
    pub ended: JogEnd,
}

/// Findings of a jog: first with positive effort, then with negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JogFindings {
    /// Both ways, in their order.
    pub ways: [Way; 2],
}

/// Verdict of a jog on the wiring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The encoder counts in the sense of the effort.
    Agrees,
    /// The encoder counts against the effort.
    Reversed,
    /// The joint moves the same way under both efforts: a load moves it.
    Pulled,
    /// The joint kept moving without effort after the first way, and the second was not tried.
    RunsOn,
    /// Nothing has moved, as far as the encoder shows.
    Still,
    /// The encoder counts to and fro, with too little net travel to show a direction.
    Noise,
}

impl JogFindings {
    /// Returns the sum of all counts of both ways, without their sign.
    const fn counted(&self) -> u32 {
        let [first, second] = &self.ways;
        first.counted.saturating_add(second.counted)
    }

    /// Returns the verdict on the wiring: of two encoders, on the load's.
    ///
    /// One way alone shows the direction if the other was tried and nothing moved: from rest, a
    /// joint that begins to move under a slow effort goes where it is pushed.
    pub fn verdict(&self) -> Verdict {
        self.verdict_on(self.ways.map(|way| way.moved), self.counted())
    }

    /// Returns the verdict on the wiring of the motor's own encoder; `None` with one encoder.
    pub fn motor_verdict(&self) -> Option<Verdict> {
        let [first, second] = self.ways.map(|way| way.motor_moved);
        Some(self.verdict_on([first?, second.unwrap_or(0)], 0))
    }

    /// Returns whether all encoders count in the sense of the effort.
    pub fn agrees(&self) -> bool {
        let of_motor = self.motor_verdict().unwrap_or(Verdict::Agrees);
        self.verdict() == Verdict::Agrees && of_motor == Verdict::Agrees
    }

    /// Returns the verdict on an encoder that has moved by these counts on both ways. `counted` is
    /// the sum of all its counts, without their sign.
    fn verdict_on(&self, moved: [i32; 2], counted: u32) -> Verdict {
        let [first, second] = moved.map(|moved| {
            let is_clear = moved.unsigned_abs() >= TELLING;
            if is_clear { moved.signum() } else { 0 }
        });
        match (first, second) {
            (0, 0) if counted >= TELLING => Verdict::Noise,
            (0, 0) => Verdict::Still,
            (1 | -1, 0) if self.ways[1].effort == 0.0 => Verdict::RunsOn,
            (1, 0 | -1) | (0, -1) => Verdict::Agrees,
            (-1, 0 | 1) | (0, 1) => Verdict::Reversed,
            _ => Verdict::Pulled,
        }
    }
}

/// The state of a jog from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JogState {
    phase: Phase,
    open_loop: OpenLoopState,
    standstill: Standstill,
    /// Whether it is the second way.
    second: bool,
    /// Present effort, in rungs.
    rung: u32,
    /// Position at the start of this way, and at the last tick, counts.
    origin: i32,
    counts: i32,
    /// The same of the motor's own encoder, from the first tick on.
    motor_origin: Option<i32>,
    motor_counts: i32,
    found: JogFindings,
}

/// The phases of a jog: it pushes each way, and rests between the two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    #[default]
    Pushing,
    Resting,
    Over,
}

impl Jog {
    /// Prepares a jog for a loop of `sample_time` (s) with counts of `resolution` (deg). The bounds
    /// have been validated.
    pub fn new(bounds: &JogBounds, sample_time: f32, resolution: f32) -> Self {
        // The conversions saturate.
        let ticks = |s: f32| (libm::roundf(s / sample_time) as u32).max(1);
        Self {
            rung: bounds.rate * sample_time,
            bounds: Bounds {
                effort: bounds.effort,
                travel: (bounds.travel / resolution) as u32,
                speed: bounds.speed * sample_time / resolution,
                ticks: ticks(bounds.time),
            },
            quiet: ticks(QUIET),
            motor_travel: u32::MAX,
            needs_both: false,
            is_mirrored: false,
        }
    }

    /// Bounds the travel of a motor with its own encoder, whose counts have the angle `count` (deg
    /// of the joint), while the gear holds a twist of `twist` (deg) at most; zero: it is unknown,
    /// and bounds nothing.
    #[must_use]
    pub fn with_motor(self, bounds: &JogBounds, count: f32, twist: f32) -> Self {
        let motor_travel =
            if twist > 0.0 { ((bounds.travel + twist) / count) as u32 } else { u32::MAX };
        Self { motor_travel, ..self }
    }

    /// Returns the jog of a test at arming, with the largest travels of load and motor, counts of
    /// their encoders.
    pub(super) const fn with_both(self, [travel, motor_travel]: [u32; 2]) -> Self {
        let bounds = Bounds { travel, ..self.bounds };
        Self { bounds, motor_travel, needs_both: true, ..self }
    }

    /// Returns the jog with its first way the negative one, or the positive one.
    pub(super) const fn mirrored(self, is_mirrored: bool) -> Self {
        Self { is_mirrored, ..self }
    }

    /// Returns the largest travel, counts.
    pub(super) const fn travel(&self) -> u32 {
        self.bounds.travel
    }

    /// Runs one tick with the joint at `counts`, and returns the effort from now on, V. With two
    /// encoders, `motor` is the position of the motor, counts of its own encoder.
    pub fn update(&self, state: &mut JogState, counts: i32, motor: Option<i32>) -> f32 {
        if self.is_mirrored {
            return -self.advance(state, counts.wrapping_neg(), motor.map(i32::wrapping_neg));
        }
        self.advance(state, counts, motor)
    }

    fn advance(&self, state: &mut JogState, counts: i32, motor: Option<i32>) -> f32 {
        let travel = counts.wrapping_sub(core::mem::replace(&mut state.counts, counts));
        if let Some(motor) = motor {
            state.motor_counts = motor;
            state.motor_origin.get_or_insert(motor);
        }
        let still = state.standstill.update(counts);
        match state.phase {
            Phase::Pushing => self.push(state, travel),
            Phase::Resting => {
                match self.bounds.admit(&mut state.open_loop, counts, 0.0) {
                    // The joint slows down.
                    Err(Bound::Speed) if self.needs_both && still >= self.quiet => {
                        state.open_loop.rests();
                        state.begin_second();
                    }
                    Err(Bound::Speed) if self.needs_both => {}
                    Err(bound) => state.end(bound.into()),
                    Ok(_) if still >= self.quiet => state.begin_second(),
                    Ok(_) => {}
                }
                0.0
            }
            Phase::Over => 0.0,
        }
    }

    fn push(&self, state: &mut JogState, travel: i32) -> f32 {
        let (counts, origin) = (state.counts, state.origin);
        let way = state.way();
        way.moved = counts.wrapping_sub(origin);
        way.counted = way.counted.saturating_add(travel.unsigned_abs());
        let mut has_moved = way.moved.unsigned_abs() >= TELLING;
        if let Some(origin) = state.motor_origin {
            let moved = state.motor_counts.wrapping_sub(origin);
            state.way().motor_moved = Some(moved);
            has_moved &= !self.needs_both || moved.unsigned_abs() >= TELLING;
            if !has_moved && moved.unsigned_abs() > self.motor_travel {
                state.end(JogEnd::Travel);
                return 0.0;
            }
        }
        state.rung = state.rung.saturating_add(1);
        let size = state.rung as f32 * self.rung;
        let effort = if state.second { -size } else { size };
        match self.bounds.admit(&mut state.open_loop, counts, effort) {
            Ok(_) | Err(Bound::Effort) if has_moved => state.rest(JogEnd::Moved),
            Ok(effort) => {
                state.way().effort = size;
                return effort;
            }
            Err(Bound::Effort) => state.rest(JogEnd::Effort),
            Err(Bound::Speed) if self.needs_both => state.rest(JogEnd::Speed),
            Err(bound) => state.end(bound.into()),
        }
        0.0
    }
}

impl From<Bound> for JogEnd {
    fn from(bound: Bound) -> Self {
        match bound {
            Bound::Travel => Self::Travel,
            Bound::Speed => Self::Speed,
            Bound::Time => Self::Time,
            Bound::Effort => Self::Effort,
        }
    }
}

impl JogState {
    /// Returns the state of a jog that begins with a joint at rest at `counts`.
    pub fn start(counts: i32) -> Self {
        let open_loop = OpenLoopState::start(counts);
        Self { open_loop, origin: counts, counts, ..Self::default() }
    }

    /// Returns whether the jog has ended. Its effort is zero then.
    pub const fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over)
    }

    /// Returns the findings so far.
    pub const fn found(&self) -> &JogFindings {
        &self.found
    }

    /// Ends this way, because drive and supply do not allow the requested effort.
    pub fn capped(&mut self) {
        if self.phase == Phase::Pushing {
            self.rest(JogEnd::Effort);
        }
    }

    const fn way(&mut self) -> &mut Way {
        let [first, second] = &mut self.found.ways;
        if self.second { second } else { first }
    }

    /// Ends this way. After the first, the joint comes to rest; after the second, the jog is over.
    fn rest(&mut self, ended: JogEnd) {
        self.way().ended = ended;
        self.standstill = Standstill::default();
        self.phase = if self.second { Phase::Over } else { Phase::Resting };
    }

    fn begin_second(&mut self) {
        self.phase = Phase::Pushing;
        self.second = true;
        self.rung = 0;
        self.origin = self.counts;
        self.motor_origin = self.motor_origin.map(|_| self.motor_counts);
    }

    /// Ends the jog at a bound. If the joint was coming to rest, the bound counts as the end of the
    /// second way, which is not tried.
    fn end(&mut self, ended: JogEnd) {
        self.second |= self.phase == Phase::Resting;
        self.way().ended = ended;
        self.phase = Phase::Over;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::drive::DriveConfig;
    use crate::control::encoder::Encoder;

    #[test]
    fn the_verdict_is_that_of_both_ways_or_of_the_only_one_that_has_one() {
        let way = |effort, moved: i32, counted| Way {
            effort,
            moved,
            counted,
            ended: JogEnd::Effort,
            motor_moved: None,
        };
        let [still, untried] = [way(0.6, 0, 0), way(0.0, 0, 0)];
        let [up, down] = [way(0.4, 8, 8), way(0.4, -8, 8)];
        for (first, second, verdict) in [
            (up, down, Verdict::Agrees),
            (down, up, Verdict::Reversed),
            // A hard stop on one side.
            (up, still, Verdict::Agrees),
            (still, down, Verdict::Agrees),
            (down, still, Verdict::Reversed),
            (still, up, Verdict::Reversed),
            (up, up, Verdict::Pulled),
            (down, down, Verdict::Pulled),
            (up, untried, Verdict::RunsOn),
            (down, untried, Verdict::RunsOn),
            (still, still, Verdict::Still),
            (still, untried, Verdict::Still),
            // Seven counts show no direction, and are noise only if they go to and fro.
            (way(0.6, 7, 7), way(0.6, 0, 0), Verdict::Still),
            (way(0.6, 1, 5), way(0.6, 0, 3), Verdict::Noise),
            (way(0.6, 1, 5), way(0.6, 0, 2), Verdict::Still),
        ] {
            let found = JogFindings { ways: [first, second] };
            assert_eq!(found.verdict(), verdict, "{found:?}");
            assert_eq!((found.motor_verdict(), found.agrees()), (None, verdict == Verdict::Agrees));
        }
    }

    #[test]
    fn both_encoders_must_count_in_the_sense_of_the_effort() {
        let found = |load: [i32; 2], motor: [i32; 2]| JogFindings {
            ways: [0, 1].map(|way| Way {
                effort: 0.4,
                moved: load[way],
                motor_moved: Some(motor[way]),
                counted: load[way].unsigned_abs(),
                ended: JogEnd::Moved,
            }),
        };
        for (load, motor, verdicts) in [
            ([8, -8], [400, -380], [Verdict::Agrees, Verdict::Agrees]),
            ([8, -8], [-400, 380], [Verdict::Agrees, Verdict::Reversed]),
            ([-8, 8], [400, -380], [Verdict::Reversed, Verdict::Agrees]),
            ([0, 0], [400, -380], [Verdict::Still, Verdict::Agrees]),
            ([8, -8], [0, 0], [Verdict::Agrees, Verdict::Still]),
        ] {
            let found = found(load, motor);
            assert_eq!([Some(found.verdict()), found.motor_verdict()], verdicts.map(Some));
            assert_eq!(found.agrees(), verdicts == [Verdict::Agrees; 2], "{found:?}");
        }
    }

    /// A load that counts nothing: the motor goes as far as the bound of the travel and the twist
    /// allow, and no second way begins.
    #[test]
    fn motor_ends_a_jog_whose_load_does_not_count() {
        let bounds = JogBounds { travel: 2.0, ..JogBounds::EXAMPLE };
        let jog = Jog::new(&bounds, 0.001, 0.02).with_motor(&bounds, 0.01, 1.0);
        let mut state = JogState::start(7);
        let mut motor = 1000;
        let ticks = (0..1000).take_while(|tick| {
            motor += i32::from(tick % 2 == 0);
            jog.update(&mut state, 7, Some(motor));
            !state.is_over()
        });
        // One count in each second tick: 300 counts are 3 deg, and the next one is beyond.
        assert_eq!(ticks.count(), 602);
        let [first, second] = state.found().ways;
        assert_eq!((first.motor_moved, first.ended), (Some(301), JogEnd::Travel));
        assert_eq!((second.ended, state.found().verdict()), (JogEnd::Not, Verdict::Still));
        assert_eq!(state.found().motor_verdict(), Some(Verdict::RunsOn));
    }

    #[test]
    fn no_bound_is_derived_as_none_and_no_rate_is_steeper_than_the_soft_start() {
        for (full_scale, duty_max, resolution, soft_start, breakaway) in [
            (5.0, 1.0, 0.00242, 0.5, 0.4),
            (5.0, 0.1, 0.18, 10.0, 3.0),
            (24.0, 1.0, 1.0, 0.0, 0.0),
            (1e-30, 1e-9, 1e-9, 10.0, 0.0),
        ] {
            let drive = DriveConfig { full_scale, duty_max, ..DriveConfig::EXAMPLE };
            let encoder = Encoder { resolution, ..Encoder::EXAMPLE };
            let controller = ControllerConfig { drive, encoder, ..ControllerConfig::EXAMPLE };
            let device = DeviceConfig { soft_start, ..DeviceConfig::EXAMPLE };
            let bounds = JogBounds::derived(&controller, &device, breakaway);
            use crate::units::value::Values;
            assert_eq!((bounds.validate(), bounds.check(full_scale, &device)), (Ok(()), Ok(())));
            assert!(bounds.effort <= (full_scale * duty_max).max(f32::MIN_POSITIVE), "{bounds:?}");
            // The direction can show before the travel ends.
            assert!(bounds.travel >= 16.0 * resolution && bounds.travel >= 2.0, "{bounds:?}");
        }
        let examples = JogBounds::derived(&ControllerConfig::EXAMPLE, &DeviceConfig::EXAMPLE, 0.4);
        assert!((examples.effort / JogBounds::EXAMPLE.effort - 1.0).abs() < 1e-6);
        assert!((examples.rate / JogBounds::EXAMPLE.rate - 1.0).abs() < 1e-6);
        assert_eq!(examples.travel, JogBounds::EXAMPLE.travel);
        assert_eq!(examples.speed, JogBounds::EXAMPLE.speed);
    }
}
