//! The twist between the encoders of motor and load, which reveals a dead encoder or a broken
//! coupling.
//!
//! With the motor at `y` and the load at `l`, both since arming, in deg of the joint:
//!
//! ```text
//! a fault:  five ticks in a row with
//!           |y - l| > w_max,  and the motor silent for 20 ms, but not the load, or
//!                             the load silent for 20 ms, and so long no effort > breakaway_v
//!           |y - l| > w_dyn,  and the load silent for 20 ms, or both moved opposite ways
//! ```
//!
//! At rest, the load's friction holds a twist of the gear's slack and of its wind-up under the
//! breakaway effort. `w_max` is twice that, since a joint can be armed wound up one way and wind up
//! the other way. In motion a healthy load can lag more, but then it goes the way of its motor; or
//! its motor draws back while it still slides. A load that is blocked or held is wound up further
//! by a larger effort. Both stay within `w_dyn`, the twist that the full effort can wind up.
//!
//! Guarantees: with a right `w_max`, a joint that is moved by hand, by its load or by its motor
//! does not trip. Does badly: while nothing moves, nothing is detected. Noise of a count is no
//! silence: a dead encoder whose wires pick up noise is left to the other monitors. A `w_max` that
//! is too small for the gear trips falsely: a prototype did with the stiffness configured twice too
//! high, and never with half of it. With a wrong ratio, the computed twist grows with the travel of
//! the joint.

use super::Seen;
use super::limits::{Limits, Units};
use crate::control::motor_encoder::MotorEncoder;
use crate::units::saturation::bounded;

/// Time without a count after which an encoder is silent, s.
const SILENT_S: f32 = 0.02;

/// Fewest ticks without a count after which an encoder is silent, for a slow loop.
const LEAST_TICKS: u32 = 3;

/// Travel since arming beyond which the positions at arming are moved along, counts: up to there
/// the computed twist is within half a count.
const FARTHEST: u32 = 1 << 22;

/// Ticks in a row that trip.
const TICKS: u8 = 5;

/// The monitor, prepared for the counts of both encoders.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twist {
    /// Angles of a count of motor and load, deg.
    counts: [f32; 2],
    /// w_max and w_dyn, deg.
    most: [f32; 2],
    /// Ticks without a count after which an encoder is silent.
    silent: u32,
    /// Effort that moves any healthy load, codes.
    breakaway: i32,
}

/// Positions at arming, and numbers of ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct TwistState {
    /// Positions of motor and load at arming, counts since power-on; none before the first tick.
    armed_at: Option<[i32; 2]>,
    /// Ticks since the effort was beyond the breakaway.
    calm: u16,
    /// Ticks in a row beyond the largest twist.
    ticks: u8,
    /// The present twist, at most what the full effort winds up, deg.
    pub twist: f32,
    /// Whether the ratio of both encoders is unknown, so that their difference is no twist.
    is_ratio_unknown: bool,
}

impl TwistState {
    /// Turns the monitor off until the next arming: a jog finds directions and ratio.
    pub const fn suppose(&mut self) {
        self.is_ratio_unknown = true;
    }
}

impl Twist {
    /// Prepares the monitor; `None` with one encoder, or without a largest twist.
    pub fn new(motor: &MotorEncoder, limits: &Limits, units: &Units) -> Option<Self> {
        let count = motor.count()?;
        (motor.twist > 0.0).then(|| Self {
            counts: [count, units.count],
            most: [motor.twist, motor.swing],
            silent: Units::whole(SILENT_S, units.tick).max(LEAST_TICKS),
            breakaway: units.codes(limits.breakaway_effort),
        })
    }

    /// Checks a tick with the code that was applied, and returns the twist (deg) that trips.
    pub fn check(&self, state: &mut TwistState, seen: &Seen, code: i32) -> Option<f32> {
        let motor = seen.motor?;
        if state.is_ratio_unknown {
            return None;
        }
        let now = [motor.position, seen.position];
        let armed_at = state.armed_at.get_or_insert(now);
        let ways = [0, 1].map(|side| now[side].wrapping_sub(armed_at[side]));
        let twist = ways[0] as f32 * self.counts[0] - ways[1] as f32 * self.counts[1];
        state.twist = bounded(twist, self.most[1]);
        if ways.iter().any(|way| way.unsigned_abs() > FARTHEST) {
            let wound_up = libm::roundf(twist / self.counts[0]) as i32;
            *armed_at = [now[0].wrapping_sub(wound_up), now[1]];
        }
        let beyond = self.breakaway > 0 && code.abs() > self.breakaway;
        state.calm = if beyond { 0 } else { state.calm.saturating_add(1) };
        let [at_rest, in_motion] = self.most;
        let is_silent = |standstill: u32| standstill >= self.silent;
        let is_opposite = motor.travel.signum() * seen.travel.signum() < 0;
        let most = if is_silent(seen.standstill) {
            if u32::from(state.calm) >= self.silent { at_rest } else { in_motion }
        } else if is_silent(motor.standstill) {
            at_rest
        } else if is_opposite {
            in_motion
        } else {
            f32::INFINITY
        };
        let disagree = twist.abs() > most;
        state.ticks = if disagree { state.ticks + 1 } else { 0 };
        (state.ticks >= TICKS).then_some(twist)
    }
}

#[cfg(test)]
mod tests {
    use super::super::SeenMotor;
    use super::*;

    /// A count of the motor is 1 deg, one of the load 2 deg, a tick 1 ms.
    const UNITS: Units = Units { count: 2.0, code: 1.0, tick: 0.001, supply: 1.0 };

    fn monitor() -> Twist {
        let motor = MotorEncoder { count: 1.0, twist: 10.0, swing: 40.0, ..MotorEncoder::NONE };
        let limits = Limits { breakaway_effort: 5.0, ..Limits::OFF };
        Twist::new(&motor, &limits, &UNITS).unwrap()
    }

    /// A joint that no effort beyond its breakaway has wound up.
    fn calm() -> TwistState {
        TwistState { calm: 99, ..TwistState::default() }
    }

    /// Counts of motor and load, and the ticks for which they have stood still.
    const fn seen([motor, load]: [i32; 2], [motor_still, load_still]: [u32; 2]) -> Seen {
        let motor = SeenMotor { travel: 0, position: motor, standstill: motor_still };
        Seen { travel: 0, position: load, standstill: load_still, motor: Some(motor), missed: 0 }
    }

    /// Returns the tick that trips and its twist, of ten ticks after arming at 7 and 7 counts.
    fn trips(counts: [i32; 2], still: [u32; 2]) -> Option<(usize, f32)> {
        let (monitor, mut state) = (monitor(), calm());
        assert_eq!(monitor.check(&mut state, &seen([7, 7], [99, 99]), 0), None);
        let now = seen([7 + counts[0], 7 + counts[1]], still);
        (1..=10).find_map(|tick| Some((tick, monitor.check(&mut state, &now, 5)?)))
    }

    #[test]
    fn silent_side_and_a_twist_beyond_the_largest_trip_in_the_fifth_tick() {
        assert_eq!(trips([11, 0], [0, 20]), Some((5, 11.0)), "dead encoder of the load");
        assert_eq!(trips([0, -6], [20, 0]), Some((5, 12.0)), "dead encoder of the motor");
        assert_eq!(trips([-11, 0], [0, 20]), Some((5, -11.0)));
        assert_eq!(trips([10, 0], [0, 20]), None, "wound up as far as allowed");
        assert_eq!(trips([11, 0], [0, 19]), None, "both have moved lately");
        assert_eq!(trips([100, 50], [0, 20]), None, "both went as far");
    }

    #[test]
    fn sides_that_go_opposite_ways_disagree_and_a_load_that_lags_does_not() {
        let monitor = monitor();
        let trips = |travels: [i32; 2]| {
            let mut state = calm();
            let at = |tick: i32| {
                let [motor, load] = travels.map(|travel| travel * tick);
                let of_motor = SeenMotor { travel: travels[0], position: motor, standstill: 0 };
                let of_load = Seen { travel: travels[1], position: load, ..Seen::default() };
                Seen { motor: Some(of_motor), ..of_load }
            };
            (0..20).find_map(|tick| Some((tick, monitor.check(&mut state, &at(tick), 0)?)))
        };
        // 3 deg a tick: beyond 40 deg from the 14th tick on.
        assert_eq!(trips([1, -1]), Some((18, 54.0)));
        assert_eq!(trips([4, 1]), None, "2 deg a tick");
    }

    #[test]
    fn four_ticks_and_a_tick_within_begin_anew() {
        let (monitor, mut state) = (monitor(), calm());
        let mut check = |motor| monitor.check(&mut state, &seen([motor, 0], [0, 20]), 0);
        assert_eq!(check(0), None);
        for _ in 0..3 {
            assert!((0..4).all(|_| check(11).is_none()) && check(10).is_none());
        }
        assert!((0..4).all(|_| check(11).is_none()) && check(11).is_some());
    }

    #[test]
    fn nothing_is_watched_with_one_encoder_or_without_a_largest_twist() {
        assert!(Twist::new(&MotorEncoder::NONE, &Limits::OFF, &UNITS).is_none());
        let unwatched = MotorEncoder { count: 1.0, ..MotorEncoder::NONE };
        assert!(Twist::new(&unwatched, &Limits::OFF, &UNITS).is_none());
        let mut state = TwistState::default();
        let one = Seen { motor: None, ..seen([0, 0], [0, 99]) };
        assert_eq!(monitor().check(&mut state, &one, 0), None);
    }

    /// A load that is blocked: 30 deg under an effort of 6, of which 5 move any healthy load.
    #[test]
    fn effort_that_winds_a_blocked_load_up_is_no_fault_within_what_it_can_wind_up() {
        let (monitor, mut state) = (monitor(), calm());
        let _ = monitor.check(&mut state, &seen([0, 0], [99, 99]), 0);
        let mut check = |motor, code, ticks: u32| {
            (0..ticks).find_map(|_| monitor.check(&mut state, &seen([motor, 0], [0, 99]), code))
        };
        assert_eq!(check(30, -6, 100), None);
        assert_eq!(check(30, 0, 19), None, "the motor has 20 ms to spring back");
        assert_eq!(check(30, 0, 9), Some(30.0));
        assert_eq!(check(41, 6, 100), Some(41.0), "more than the full effort winds up");
    }

    #[test]
    fn counts_that_wrap_are_no_twist() {
        let (monitor, mut state) = (monitor(), calm());
        let mut at = [0_i32; 2];
        // Twice around the range of the motor's counts, with 6 deg of twist.
        for _ in 0..5000 {
            at = [at[0].wrapping_add(2_000_000), at[1].wrapping_add(1_000_000)];
            let now = [at[0].wrapping_add(6), at[1]];
            assert_eq!(monitor.check(&mut state, &seen(now, [99, 99]), 0), None, "{at:?}");
        }
    }
}
