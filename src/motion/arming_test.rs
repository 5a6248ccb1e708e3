//! The test at arming: a small motion that shows a dead or reversed encoder, or a broken coupling,
//! before the loop closes.
//!
//! ```text
//! effort  ^        effort bound of the jog
//!         |      /|                              / one way, until each encoder has shown 8 counts
//!         |    /  |                              \ to zero, until the joint rests
//!         +--/----+---rests------\----+--rests---> the loop closes where the joint stands
//!         |                        \  |            the same the other way
//! ```
//!
//! The test runs the guarded [jog](crate::motion::jog), with the jog's bounds of effort, rate,
//! speed and time, and `device.arming_test_deg` as its travel. The jog's effort is above the
//! breakaway and below a stall. Unlike a jog, a way ends only if both encoders have moved, and a
//! joint beyond the bound of the speed comes to rest and is pushed back. The first way is positive,
//! or negative near the upper end of the range of positions. The monitors that assume a direction
//! or a ratio are off, all others are on.
//!
//! ```text
//! load       motor      fault
//! follows    follows    none
//! against one of them   reversed encoder
//! follows    silent     encoders disagree: the motor's encoder is dead
//! silent     follows    encoders disagree, if the motor went as far as the travel: the load's
//!                       encoder is dead, or the coupling broken; else a stall: the load is held
//! silent     silent     stall: the motor does not move, or the only encoder is dead
//! ```
//!
//! Guarantees: with an encoder that counts, no side is driven farther than the travel from where it
//! began. A joint that a load moves goes on for `v h + v^2 / (2 a)`: `v` is its speed at the bound,
//! at most `sqrt(2 A x)` after the travel `x` at the acceleration `A` of the load less the
//! friction, and `a` the deceleration of the holding brake, which closes then, or without one that
//! of the loop that takes the joint over, once its soft start suffices. With the only encoder dead,
//! each way goes as far as the ramp of the effort pushes the joint.
//!
//! Does badly: a slip within slack and wind-up, a ratio that is a little wrong, and a fault that
//! needs more effort to show, are not detected. A load that slides down without effort cannot be
//! distinguished from one with little friction: the loop takes it over. One that moves against the
//! first effort looks like a reversed encoder.

use super::jog::{Jog, JogEnd, JogFindings, Verdict, Way};
use crate::safety::fault::Fault;

/// A test at arming that is prepared for its ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmingTest {
    jog: Jog,
    /// Angles of a count of load and motor, deg; the second is zero with one encoder.
    counts: [f32; 2],
}

/// What one encoder has shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    Follows,
    Against,
    Silent,
    /// It moved the same way under both efforts.
    Pulled,
}

impl ArmingTest {
    /// Prepares a test with the bounds of a jog and another travel (deg), for counts of load and
    /// motor with these angles (deg); zero: there is no encoder of the motor.
    pub fn new(jog: Jog, travel: f32, counts: [f32; 2]) -> Self {
        let [load, motor] = counts;
        let motor_travel = if motor > 0.0 { (travel / motor) as u32 } else { u32::MAX };
        let jog = jog.with_both([(travel / load) as u32, motor_travel]);
        Self { jog, counts }
    }

    /// Returns the largest travel, counts of the encoder that measures the position.
    pub(crate) const fn travel(&self) -> u32 {
        self.jog.travel()
    }

    /// Returns the jog of the test. If `is_mirrored`, its first way is the negative one.
    pub const fn jog(&self, is_mirrored: bool) -> Jog {
        self.jog.mirrored(is_mirrored)
    }

    /// Returns the fault that a test has found, and its value in the fault's unit; `None` if all
    /// encoders follow the effort.
    pub fn fault(&self, found: &JogFindings) -> Option<(Fault, f32)> {
        let [first, second] = &found.ways;
        let load = shown(found.verdict(), first.moved);
        let motor =
            found.motor_verdict().map(|verdict| shown(verdict, first.motor_moved.unwrap_or(0)));
        let reaches_travel = found.ways.iter().any(|way| way.ended == JogEnd::Travel);
        let fault = match (load, motor) {
            (Shown::Follows, None | Some(Shown::Follows)) => return None,
            (Shown::Against, _) | (_, Some(Shown::Against)) => Fault::EncoderReversed,
            (Shown::Silent, None | Some(Shown::Silent)) => Fault::Stall,
            (_, Some(Shown::Silent)) => Fault::EncodersDisagree,
            (Shown::Silent, Some(_)) if reaches_travel => Fault::EncodersDisagree,
            _ => Fault::Stall,
        };
        let [load_deg, motor_deg] = self.farthest(found);
        let value = match fault {
            Fault::EncodersDisagree => motor_deg - load_deg,
            Fault::EncoderReversed if motor == Some(Shown::Against) => motor_deg,
            Fault::EncoderReversed => load_deg,
            _ => first.effort.max(second.effort),
        };
        Some((fault, value))
    }

    /// Returns the travels of load and motor (deg) in the way in which the two sides went farther,
    /// positive in the direction of the effort.
    fn farthest(&self, found: &JogFindings) -> [f32; 2] {
        let [load, motor] = self.counts;
        let travels = |way: &Way, sign: f32| {
            [way.moved as f32 * load, way.motor_moved.unwrap_or(0) as f32 * motor]
                .map(|travel| travel * sign)
        };
        let [first, second] = &found.ways;
        let (first, second) = (travels(first, 1.0), travels(second, -1.0));
        let size = |[load, motor]: [f32; 2]| load.abs().max(motor.abs());
        if size(second) > size(first) { second } else { first }
    }
}

/// Returns what an encoder has shown, with its travel on the first way, counts. One way alone shows
/// the direction: from rest, a joint goes where it is pushed.
const fn shown(verdict: Verdict, first: i32) -> Shown {
    match verdict {
        Verdict::Agrees => Shown::Follows,
        Verdict::RunsOn if first > 0 => Shown::Follows,
        Verdict::Reversed | Verdict::RunsOn => Shown::Against,
        Verdict::Still | Verdict::Noise => Shown::Silent,
        Verdict::Pulled => Shown::Pulled,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::jog::{JogBounds, JogState};
    use crate::units::value::Table as _;

    /// A count of the load is 0.02 deg, one of the motor 0.01 deg; the travel is 1 deg.
    fn test() -> ArmingTest {
        let bounds = JogBounds { speed: 1e3, ..JogBounds::EXAMPLE };
        ArmingTest::new(Jog::new(&bounds, 0.001, 0.02), 1.0, [0.02, 0.01])
    }

    fn way(moved: i32, motor_moved: Option<i32>, ended: JogEnd) -> Way {
        Way { effort: 0.5, moved, motor_moved, counted: moved.unsigned_abs(), ended }
    }

    #[test]
    fn each_row_of_the_table_is_its_fault() {
        use Fault::{EncoderReversed, EncodersDisagree, Stall};
        use JogEnd::{Effort, Moved, Not, Travel};
        let untried = Way::default();
        let two = |load: [i32; 2], motor: [i32; 2], ended| {
            [0, 1].map(|at| way(load[at], Some(motor[at]), ended))
        };
        let one = |load: [i32; 2], ended| load.map(|moved| way(moved, None, ended));
        for (ways, fault) in [
            (two([8, -8], [16, -20], Moved), None),
            (one([8, -9], Moved), None),
            // A joint that slides on, or that nothing has pushed back.
            ([way(60, Some(90), Travel), untried], None),
            ([way(60, None, Travel), untried], None),
            (two([8, -8], [-16, 20], Moved), Some((EncoderReversed, -0.2))),
            (two([-8, 8], [16, -20], Moved), Some((EncoderReversed, -0.16))),
            ([way(-8, None, Travel), untried], Some((EncoderReversed, -0.16))),
            ([way(51, Some(0), Travel), untried], Some((EncodersDisagree, -1.02))),
            ([way(0, Some(101), Travel), untried], Some((EncodersDisagree, 1.01))),
            // A load that is held: the motor winds the gear up, and stops before the travel.
            (two([0, 0], [30, -30], Effort), Some((Stall, 0.5))),
            (two([0, 0], [0, 0], Effort), Some((Stall, 0.5))),
            (one([0, 0], Effort), Some((Stall, 0.5))),
            (one([8, 8], Moved), Some((Stall, 0.5))),
            ([way(7, Some(7), Not), untried], Some((Stall, 0.5))),
        ] {
            let found = JogFindings { ways };
            let said = test().fault(&found);
            assert_eq!(said.map(|said| said.0), fault.map(|fault| fault.0), "{found:?}");
            let difference = said.zip(fault).map_or(0.0, |(said, fault)| said.1 - fault.1);
            assert!(difference.abs() < 1e-5, "{found:?}: {said:?}");
        }
    }

    /// The load runs 8 counts ahead of a motor that has shown only 7: no verdict before the eighth.
    #[test]
    fn a_way_ends_once_both_encoders_have_shown_eight_counts() {
        let (test, mut state) = (test(), JogState::start(0));
        for tick in 0..20 {
            let effort = test.jog(false).update(&mut state, tick.min(12), Some(tick.min(7)));
            assert!(effort > 0.0, "{tick}");
        }
        assert_eq!(test.jog(false).update(&mut state, 12, Some(8)), 0.0);
        assert_eq!(state.found().ways[0].ended, JogEnd::Moved);
    }

    #[test]
    fn motor_ends_the_test_at_the_travel_and_so_does_a_load_without_it() {
        for (load, motor) in [(0, 1), (1, 0)] {
            let (test, mut state) = (test(), JogState::start(0));
            let ticks = (0..200).take_while(|tick| {
                test.jog(false).update(&mut state, load * tick, Some(motor * tick));
                !state.is_over()
            });
            // 1 deg is 100 counts of the motor and 50 of the load; the next one is beyond.
            let most = if motor == 1 { 101 } else { 51 };
            assert_eq!(ticks.count(), most);
            assert_eq!(
                test.fault(state.found()).map(|found| found.0),
                Some(Fault::EncodersDisagree)
            );
        }
    }

    #[test]
    fn mirrored_test_pushes_the_other_way_first_and_finds_the_same() {
        let (plain, mirrored) = (test().jog(false), test().jog(true));
        let (mut here, mut there) = (JogState::start(0), JogState::start(0));
        for tick in 0..400 {
            let at = if tick < 100 { tick / 10 } else { 10 };
            let effort = plain.update(&mut here, at, Some(2 * at));
            let other = mirrored.update(&mut there, -at, Some(-2 * at));
            assert_eq!(effort, -other, "{tick}");
            assert!(tick > 50 || effort > 0.0);
        }
        assert_eq!(here.found(), there.found());
    }

    /// A joint that breaks away in a jump of 30 counts is pushed back, and is sound.
    #[test]
    fn joint_beyond_the_bound_of_the_speed_comes_to_rest_and_is_pushed_back() {
        let bounds = JogBounds { speed: 1.0, ..JogBounds::EXAMPLE };
        let test = ArmingTest::new(Jog::new(&bounds, 0.001, 0.02), 1.0, [0.02, 0.0]);
        let mut state = JogState::start(0);
        for (counts, ticks) in [(0, 100), (30, 300), (0, 300)] {
            (0..ticks).for_each(|_| {
                test.jog(false).update(&mut state, counts, None);
            });
        }
        let [first, second] = state.found().ways;
        assert_eq!((first.moved, first.ended, second.moved), (30, JogEnd::Speed, -30));
        assert!(state.is_over());
        assert_eq!(test.fault(state.found()), None);
    }
}
