//! Inching: motion that is slower than the joint can slide, made of attempts at rest.
//!
//! ```text
//! v = |r'|,  s = sgn r',  lag = s (r - y)
//! slow     r' != 0,  p = r,  v <= v_g,  0.2 s |p''| <= v
//! w        0 at a count, at r' = 0 and outside of MOVE;  otherwise  w += h v
//! begins   slow, v <= v_i, in MOVE, and  at rest with  w > min(6 q, 1.5 q + 0.1 s v)
//!                                    or  lag < -min(6 q, 3 q + 0.1 s v):  STUCK
//! ends     r' = 0:  the rest goes on as any other
//!          not slow,  v > 1.5 v_i,  lag > 6 q  or  barred:  MOVE
//! barred   in a slow loop or with the encoder on the load, after |lag| > 16 q; with the latter,
//!          also from r' = 0 on;  until v > v_g, or on the motor r' = 0
//!
//! E = e + 6 ms r' + s q / 2;  an attempt for E if  s E >= q  or  s E <= -1.5 q
//! the attempt is judged by  (y - y_f) sgn E,  y_f the position before it
//! v_g = 2 q / h,  v_i = 0.4 q / h (0.2 q / h in a slow loop)
//! ```
//!
//! Source: the figures are those of a prototype of this law, except the bar. Below the speed at
//! which friction falls, a loop of any gain sticks and slips: it waits until its integral or its
//! error exceeds the breakaway effort, and jumps. A pulse of the law moves the joint by a count or
//! two, so a row of pulses follows the set point to within one or two counts. `w` is the travel of
//! the set point since the last count: a joint that slides makes a count for each count of this
//! travel, and one that sticks does not. Pulses that aim half a count and 6 ms ahead of the set
//! point have no error on average, since a pulse is decided late and ends early.
//!
//! Why not at higher speed: an attempt lasts some 15 ticks, which is a count at `v_i` / 6. If the
//! joint slides at a lower speed than that, it is not at rest, and inching does not begin.
//!
//! In a slow loop, and with the encoder on the load, a pulse that throws the joint bars the rule,
//! so that it is not thrown to and fro: a pulse of one tick goes far there, and the load breaks
//! away behind a wound-up gear. With the encoder on the load the rule is barred from the start.
//! Without the bar, monitors tripped 43 to 71 of 300 simulated joints on each ramp of 1 to 300
//! counts a second; with it, one in 3600 such ramps. The slow end of a faster motion is not barred:
//! its pulses bring one joint in a hundred more to rest there. In a fast loop with the encoder on
//! the motor there is no bar: a light motor behind a soft gear is thrown as well, but without
//! pulses it swings farther (with two samples of delay to 360 counts instead of 19).
//!
//! Guarantees: nothing here acts while the set point rests. Does badly: at a constant speed it ends
//! only by lagging, so a joint that could slide goes on with pulses; a motor that is light against
//! the load behind a soft gear jumps by more than a pulse.

use crate::control::profile::bounded_acceleration::LimitedReference;

/// Time in which a slow profile changes its speed by no more than the speed itself, s.
const STEADY: f32 = 0.2;

/// Time by which an attempt aims ahead of the set point, s.
const AHEAD: f32 = 0.006;

/// Travel of the set point within which a joint that slides makes a count, counts and s.
const COUNT_DUE: (f32, f32) = (1.5, 0.1);

/// Lead of a joint over its set point beyond which it has slipped, counts and s.
const SLIPPED: (f32, f32) = (3.0, 0.1);

/// Upper limit of both, and the lag that ends inching, counts.
const MOST: f32 = 6.0;

/// Error beyond which an attempt has thrown the joint, counts.
const THROWN: f32 = 16.0;

/// The rule, prepared for a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inching {
    sample_time: f32,
    count: f32,
    /// v_i, deg/s.
    speed: f32,
    /// v_g, deg/s.
    slow_speed: f32,
    /// Error beyond which an attempt has thrown the joint, deg; infinite: no attempt does.
    thrown: f32,
    on_load: bool,
}

/// State of the rule from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InchingState {
    /// Travel of the set point since the last count w, deg.
    pub travel: f32,
    /// Whether the law inches.
    pub active: bool,
    /// Whether inching is barred: an attempt has thrown the joint, or the encoder is on the load.
    pub barred: bool,
}

/// A tick of a set point that moves.
#[derive(Clone, Copy, Debug)]
pub struct Following {
    /// Velocity of the set point r', deg/s.
    pub velocity: f32,
    /// r - y, deg.
    pub error: f32,
    /// Whether the set point is [slow](Inching::is_slow).
    pub slow: bool,
    /// Whether the law is in MOVE.
    pub in_move: bool,
    /// Whether the joint made a count in this tick.
    pub counted: bool,
    /// Whether the joint is at rest.
    pub rests: bool,
}

/// Start or end of inching in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The law begins to inch.
    Begins,
    /// The law ends inching.
    Ends,
}

impl Inching {
    /// Prepares the rule for a sample time (s) and the angle of a count (deg); `slow`: the loop is
    /// slow; `on_load`: the encoder is on the load.
    pub fn new([sample_time, count]: [f32; 2], slow: bool, on_load: bool) -> Self {
        let count_a_tick = count / sample_time;
        let speed = if slow { 0.2 } else { 0.4 } * count_a_tick;
        let thrown = if slow || on_load { THROWN * count } else { f32::INFINITY };
        Self { sample_time, count, speed, slow_speed: 2.0 * count_a_tick, thrown, on_load }
    }

    /// Returns whether a set point is slow: the profile is on it, and neither faster than `v_g` nor
    /// setting out.
    #[inline]
    pub fn is_slow(&self, profile: &LimitedReference, reference: f32, velocity: f32) -> bool {
        let speed = velocity.abs();
        speed > 0.0
            && profile.position == reference
            && speed <= self.slow_speed
            && STEADY * profile.acceleration.abs() <= speed
    }

    /// Returns whether a speed (deg/s) is low enough to start inching.
    #[inline]
    pub fn is_speed(&self, velocity: f32) -> bool {
        velocity.abs() <= self.speed
    }

    /// Returns whether a joint that slides would have made a count during the present travel.
    #[inline]
    pub fn is_count_overdue(&self, state: &InchingState) -> bool {
        state.travel > COUNT_DUE.0 * self.count
    }

    /// Updates the rule in a tick, and returns whether inching begins or ends.
    #[inline]
    pub fn update(&self, state: &mut InchingState, seen: &Following) -> Option<Change> {
        let Following { velocity, error, slow, in_move, counted, rests } = *seen;
        let speed = velocity.abs();
        let lag = if velocity < 0.0 { -error } else { error };
        if counted || speed == 0.0 || !in_move {
            state.travel = 0.0;
        } else {
            state.travel += self.sample_time * speed;
        }
        if state.active {
            state.barred |= lag.abs() > self.thrown;
            let ends = state.barred || !slow || speed > 1.5 * self.speed || lag > MOST * self.count;
            if ends {
                state.active = false;
                return Some(Change::Ends);
            }
            return None;
        }
        if !slow || speed > self.speed || !in_move || state.barred {
            if speed == 0.0 {
                state.barred = self.on_load;
            } else if speed > self.slow_speed {
                state.barred = false;
            }
            return None;
        }
        let sticks = rests && state.travel > self.within(COUNT_DUE, speed);
        if sticks || lag < -self.within(SLIPPED, speed) {
            state.active = true;
            return Some(Change::Begins);
        }
        None
    }

    /// Returns the travel of a number of counts and of a time (s) at a speed, deg, but no more than
    /// [`MOST`] counts.
    #[inline]
    fn within(&self, (counts, time): (f32, f32), speed: f32) -> f32 {
        let wanted = counts * self.count + time * speed;
        let most = MOST * self.count;
        if wanted < most { wanted } else { most }
    }

    /// Returns the error E that an attempt is for, from the error of a joint at rest, deg.
    #[inline]
    pub fn aim(&self, error: f32, velocity: f32) -> f32 {
        let half = 0.5 * self.count;
        error + (velocity * AHEAD + if velocity < 0.0 { -half } else { half })
    }

    /// Returns whether an error E needs an attempt: from one count on if it is in the direction of
    /// the motion, and from 1.5 counts on if it is against it.
    #[inline]
    pub fn is_due(&self, aimed: f32, velocity: f32) -> bool {
        let ahead = (aimed > 0.0) == (velocity > 0.0);
        aimed.abs() >= if ahead { self.count } else { 1.5 * self.count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 kHz, counts of 0.01 deg: v_i is 4 deg/s, and v_g 20.
    const COUNT: f32 = 0.01;

    fn rule() -> Inching {
        Inching::new([0.001, COUNT], false, false)
    }

    /// A joint at rest on its set point, which moves with a velocity.
    fn at_rest(velocity: f32) -> Following {
        let slow = velocity != 0.0;
        Following { velocity, error: 0.0, slow, in_move: true, counted: false, rests: true }
    }

    /// Returns the tick in which inching begins, of a thousand.
    fn begins(seen: Following) -> Option<u32> {
        let mut state = InchingState::default();
        (1..=1000).find(|_| rule().update(&mut state, &seen) == Some(Change::Begins))
    }

    /// 2 deg/s makes a count in 5 ms, and `1.5 q + 0.1 s v` are 21.5 counts: six are the most. At
    /// 0.1 deg/s they are 2.5, in ticks of a hundredth of a count.
    #[test]
    fn a_joint_at_rest_inches_after_the_travel_in_which_one_that_slides_counts() {
        for velocity in [2.0, -2.0] {
            assert!(matches!(begins(at_rest(velocity)), Some(30..=31)), "{velocity}");
        }
        assert!(matches!(begins(at_rest(0.1)), Some(250..=251)));
        for elsewhere in [
            Following { rests: false, ..at_rest(2.0) },
            Following { counted: true, ..at_rest(2.0) },
            Following { in_move: false, ..at_rest(2.0) },
            Following { slow: false, ..at_rest(2.0) },
            at_rest(0.0),
            at_rest(4.01),
        ] {
            assert_eq!(begins(elsewhere), None, "{elsewhere:?}");
        }
        assert!(begins(at_rest(3.99)).is_some());
    }

    /// It may slide on then, and the set point comes after.
    #[test]
    fn a_joint_ahead_of_a_slow_set_point_inches_at_once() {
        let ahead = |velocity: f32, counts: f32| {
            let error = -counts * COUNT * velocity.signum();
            begins(Following { error, rests: false, ..at_rest(velocity) })
        };
        for velocity in [0.1, -0.1] {
            // 3 q + 0.1 s v = 4 q
            assert_eq!([3.99, 4.01].map(|counts| ahead(velocity, counts)), [None, Some(1)]);
            assert_eq!(ahead(velocity, -100.0), None);
        }
        assert_eq!([5.99, 6.01].map(|counts| ahead(2.0, counts)), [None, Some(1)]);
    }

    #[test]
    fn inching_ends_at_speed_at_rest_and_six_counts_behind() {
        let ends = |seen: Following| {
            let mut state = InchingState { active: true, ..InchingState::default() };
            let change = rule().update(&mut state, &Following { in_move: false, ..seen });
            assert_eq!(state.active, change.is_none());
            change
        };
        let lags = |velocity: f32, counts: f32| {
            ends(Following { error: counts * COUNT * velocity.signum(), ..at_rest(velocity) })
        };
        for velocity in [1.0, -1.0] {
            assert_eq!(
                [5.99, 6.01].map(|counts| lags(velocity, counts)),
                [None, Some(Change::Ends)]
            );
            assert_eq!(lags(velocity, -100.0), None);
        }
        assert_eq!(
            [5.99, 6.01].map(|velocity| ends(at_rest(velocity))),
            [None, Some(Change::Ends)]
        );
        let setting_out = Following { slow: false, ..at_rest(1.0) };
        assert_eq!(ends(setting_out), Some(Change::Ends));
    }

    /// A slow loop: `v_i` is 0.1 deg/s and `v_g` 1. Six counts behind end it, too: the joint inches
    /// again at once then, and after a throw only when the set point has rested or was fast.
    #[test]
    fn a_joint_that_was_thrown_does_not_inch_before_the_set_point_rests_or_is_fast() {
        let rule = Inching::new([0.02, COUNT], true, false);
        let inches_again = |behind: f32, between: Option<f32>| {
            let mut state = InchingState { active: true, ..InchingState::default() };
            let thrown = Following { error: behind * COUNT, ..at_rest(0.05) };
            assert_eq!(rule.update(&mut state, &thrown), Some(Change::Ends));
            if let Some(velocity) = between {
                rule.update(&mut state, &at_rest(velocity));
            }
            (0..1000).any(|_| rule.update(&mut state, &at_rest(0.05)) == Some(Change::Begins))
        };
        assert!(inches_again(7.0, None));
        for thrown in [17.0, -17.0] {
            let after = [None, Some(0.99), Some(1.01), Some(0.0)];
            assert_eq!(after.map(|one| inches_again(thrown, one)), [false, false, true, true]);
        }
        let ahead = |counts: f32| {
            let mut state = InchingState { active: true, ..InchingState::default() };
            rule.update(&mut state, &Following { error: -counts * COUNT, ..at_rest(0.05) })
        };
        assert_eq!([15.99, 16.01].map(ahead), [None, Some(Change::Ends)]);
    }

    /// A slow ramp from rest stays without pulses; the slow end of a faster motion has them.
    #[test]
    fn with_the_encoder_on_the_load_only_the_end_of_a_faster_motion_inches() {
        let rule = Inching::new([0.001, COUNT], false, true);
        let begins = |before: f32| {
            let mut state = InchingState::default();
            for velocity in [0.0, before] {
                rule.update(&mut state, &at_rest(velocity));
            }
            (0..1000).any(|_| rule.update(&mut state, &at_rest(1.0)) == Some(Change::Begins))
        };
        assert_eq!([19.9, 20.1].map(begins), [false, true]);
    }

    /// 0.2 s times the profile's acceleration is the change of speed that a slow one may have.
    #[test]
    fn a_set_point_is_slow_on_its_profile_and_once_it_has_set_out() {
        let slow = |velocity: f32, acceleration: f32, behind: f32| {
            let profile = LimitedReference { position: 1.0 - behind, velocity, acceleration };
            rule().is_slow(&profile, 1.0, velocity)
        };
        for sign in [1.0, -1.0] {
            assert!(slow(19.9 * sign, 0.0, 0.0) && !slow(20.1 * sign, 0.0, 0.0));
            assert!(slow(2.0 * sign, -9.9, 0.0) && !slow(2.0 * sign, -10.1, 0.0));
            assert!(!slow(2.0 * sign, 0.0, 0.001));
        }
        assert!(!slow(0.0, 0.0, 0.0));
    }

    /// 6 ms and half a count ahead; an error of a count is due on the way, of 1.5 behind.
    #[test]
    fn attempts_aim_ahead_and_go_back_only_from_one_and_a_half_counts() {
        let due = |velocity: f32, counts: f32| {
            let aimed = rule().aim(counts * COUNT * velocity.signum(), velocity);
            let expected = (counts + 0.5) * COUNT + 0.006 * velocity.abs();
            assert!((aimed * velocity.signum() - expected).abs() < 1e-6, "{aimed}");
            rule().is_due(aimed, velocity)
        };
        for velocity in [1.0, -1.0] {
            // 6 ms are 0.6 counts.
            assert_eq!([-0.11, -0.09].map(|counts| due(velocity, counts)), [false, true]);
            assert_eq!([-2.59, -2.61].map(|counts| due(velocity, counts)), [false, true]);
        }
    }

    #[test]
    fn a_slow_loop_inches_up_to_half_of_the_speed() {
        let slow = Inching::new([0.02, COUNT], true, false);
        assert_eq!([0.099, 0.101].map(|velocity| slow.is_speed(velocity)), [true, false]);
        assert_eq!([-3.99, -4.01].map(|velocity| rule().is_speed(velocity)), [true, false]);
    }
}
