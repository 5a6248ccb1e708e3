//! Parameters of `robust`, and the rules for those that are not set.
//!
//! A user sets, of the joint: inertia `J`, viscous friction `B`, the range of breakaway efforts
//! `[F_lo, F_hi]`, the encoder's side and its jitter. The sample time `h`, the count `q`, the
//! largest effort `u_m` and its step `u_q` are those of the loop. Each other value has a rule, and
//! can be set instead; zero means the rule.
//!
//! - Bandwidth `w_n`: `min(2 pi 8, 0.14 / h)`, with the encoder on the load `2 pi 2`. A dead time
//!   of 1.5 h costs 12 degrees of phase. 8 Hz is below most transmissions, and 2 Hz below the load
//!   behind one.
//! - Observer `w_e`: `min(110, 0.7 / h)`. One count is `l3 J` V of disturbance; `z` is no less than
//!   1/2, so that the observer tolerates two samples of delay.
//! - Observer in motion `w_e'`: `w_e`, with the encoder on the load `min(15, 0.7 / h)`. That load
//!   swings at 5 Hz and more, and its disturbance drives the swing if it is fed back to the motor
//!   with less delay. A set `observer_rad_per_s` holds for both.
//! - Acceleration `a_m`: `0.25 u_m / J`. The other three quarters are for friction and damping.
//! - Speed `v_m`: `0.15 u_m / B`, and no more than 3 rad/s if `h <= 10 ms` or `B = 0`. Viscous
//!   friction needs 15 % of the limit, and a profile needs a finite speed.
//! - Step of the hold effort `db_0`: `0.15 F_lo`, a seventh of the smallest elastic range.
//! - Least gain `g_min`: 0.1, with the encoder on the load 0.05: a motor of a tenth of the inertia.
//! - Speed up to which friction is learned `v_R`: any up to `h = 10 ms`, above that the larger one
//!   of `0.3 F_lo / B` and `3 a_m h`. At the first, an error of the viscous friction by all of `B`
//!   is no more than the least friction that is learned ([`super::sliding_friction`]). Below the
//!   second, the law's own profile has fewer than three ticks, and nothing would be learned.
//! - Wait `N_c`: 10 ms, with the encoder on the load 60 ms, and at least 3 ticks: a period of the
//!   part that swings behind the encoder.
//!
//! The fixed times are 20 ms before a HOLD (at least 3 ticks), 40 ms before one is left (2), 20 to
//! 100 ms after a step of the hold effort (3 and 6), 0.1 s of the guard's counter (load side 0.25
//! s, at least 10 ticks), and 6 ticks of rest (3 above 10 ms, where 6 would be longer than a pulse
//! takes). The figures were found with a prototype on random joints, and were not found again with
//! this law.

use super::Loop;
use super::sliding_friction::LEAST_LEARNED;
use crate::units::error::HUGE;
use crate::units::value::{choice, table};

choice! {
    /// The side of the transmission on which the encoder sits.
    pub enum EncoderSide {
        /// The encoder turns with the motor.
        Motor = 0 "motor",
        /// The encoder turns with the load, behind the transmission.
        Load = 1 "load",
    }
}

table! {
    /// Parameters of the joint under `robust`. The examples are the thesis's axis.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RobustGains (law) "controller" {
        /// Moment of inertia J, as the effort that an acceleration needs, V s^2/deg.
        inertia: f32 = 0x1701 "inertia_v_s2_per_deg", Above(0.0, HUGE), Needed(0.037_037_037);
        /// Viscous friction B, V s/deg.
        viscous: f32 = 0x1702 "viscous_v_s_per_deg", Between(0.0, HUGE), Needed(0.02);
        /// Lowest breakaway effort of the joint over all positions, F_lo, V.
        breakaway_low: f32 = 0x1703 "breakaway_low_v", Above(0.0, HUGE), Needed(0.19);
        /// Highest breakaway effort of the joint over all positions, F_hi, V.
        breakaway_high: f32 = 0x1704 "breakaway_high_v",
            Between(law.breakaway_low, HUGE), Needed(1.03);
        /// Side of the transmission on which the encoder sits.
        encoder_side: EncoderSide = 0x1705 "encoder_side", Any, Default(EncoderSide::Motor);
        /// Counts n_j by which the encoder changes at rest; 2 for noise of a count to either side.
        jitter: f32 = 0x1706 "jitter_counts", Between(0.0, 100.0), Default(0.0);
        /// Largest load that drives the joint u_L, V. Off: no load does.
        load: f32 = 0x1707 "load_v", OrOff(0.0, HUGE), Default(0.0);
        /// Effort that holds the joint where it is armed, V.
        hold_effort: f32 = 0x1708 "hold_effort_v", Between(-HUGE, HUGE), Default(0.0);
        /// Bandwidth of the loop w_n, rad/s. 0: that of the rule.
        bandwidth: f32 = 0x1709 "bandwidth_rad_per_s", Between(0.0, HUGE), Default(0.0);
        /// Damping ratio of the loop zeta.
        damping: f32 = 0x170A "damping_ratio", Between(0.0, HUGE), Default(0.9);
        /// Bandwidth of the observer w_e, rad/s. 0: that of the rule.
        observer: f32 = 0x170B "observer_rad_per_s", Between(0.0, HUGE), Default(0.0);
        /// Acceleration of the inner profile a_m, deg/s^2. 0: that of the rule.
        acceleration: f32 = 0x170C "acceleration_deg_per_s2", Between(0.0, HUGE), Default(0.0);
        /// Speed of the inner profile v_m, deg/s. 0: that of the rule.
        speed: f32 = 0x170D "speed_deg_per_s", Between(0.0, HUGE), Default(0.0);
        /// Largest error at rest that is left alone, counts.
        stop_band: f32 = 0x170E "stop_band_counts", Between(0.0, HUGE), Default(1.25);
        /// First step of the hold effort db_0, V. 0: that of the rule.
        hold_step: f32 = 0x170F "hold_step_v", Between(0.0, HUGE), Default(0.0);
        /// Least gain of the oscillation guard g_min. 0: that of the rule.
        least_gain: f32 = 0x1710 "least_gain", Between(0.0, 1.0), Default(0.0);
        /// Rest after which an attempt is judged, s. 0: that of the rule.
        coast_time: f32 = 0x1711 "coast_s", Between(0.0, 10.0), Default(0.0);
        /// Attempts without success after which it gives up; eight times as many with the encoder
        /// on the load. 0: it never does.
        attempts: u32 = 0x1712 "give_up_attempts", Between(0.0, 60000.0), Default(50);
        /// Speed of the inner profile up to which sliding friction is learned v_R, deg/s. 0: that
        /// of the rule.
        learned_to: f32 = 0x1713 "friction_learned_to_deg_per_s", Between(0.0, HUGE), Default(0.0);
        /// Bandwidth of the observer while the set point moves w_m, rad/s, with the encoder on the
        /// motor. 0: that of the rule.
        tracking_observer: f32 = 0x1714 "tracking_observer_rad_per_s",
            Between(0.0, HUGE), Default(0.0);
    }
}

impl RobustGains {
    /// Returns the same gains, with bandwidth, observer, acceleration and speed set to the values
    /// of their rules where they are not set. The law stays the same. With the encoder on the load,
    /// the observer therefore stays unset: there its rule has two values, and a set value applies
    /// to both.
    #[must_use]
    pub fn written_out(&self, around: &Loop) -> Self {
        let Rules { bandwidth, observer, acceleration, speed, on_load, .. } =
            Rules::new(self, around);
        let observer = if on_load { self.observer } else { observer };
        Self { bandwidth, observer, acceleration, speed, ..*self }
    }
}

/// The largest speed of the inner profile in a fast loop, deg/s: 3 rad/s.
const SPEED_CAP: f32 = 171.887_34;

/// Sample time above which a loop is slow, s.
pub(in super::super) const SLOW: f32 = 0.01;

/// Values by the rules, or as the user has set them. Angles are degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Rules {
    pub on_load: bool,
    pub bandwidth: f32,
    pub observer: f32,
    pub observer_in_motion: f32,
    pub observer_tracking: f32,
    pub acceleration: f32,
    pub speed: f32,
    /// Speed error of a wide swing, deg/s.
    pub wide_swing: f32,
    pub learned_to: f32,
    pub hold_step: f32,
    pub least_gain: f32,
    /// Ticks: N_z, N_c, N_h, N_r, N_b0 and its cap, N_g.
    pub rest: u16,
    pub coast: u16,
    pub hold: u16,
    pub leave: u16,
    pub first_wait: u16,
    pub longest_wait: u16,
    pub guard: u16,
    /// Ticks to wait after a pulse of inching, and ticks of rest before the pulse is judged.
    pub inching: [u16; 2],
}

impl Rules {
    pub fn new(gains: &RobustGains, around: &Loop) -> Self {
        let h = around.sample_time;
        let on_load = gains.encoder_side == EncoderSide::Load;
        let slow = h > SLOW;
        let or = |set: f32, rule: f32| if set > 0.0 { set } else { rule };
        let on = |motor: f32, load: f32| if on_load { load } else { motor };
        let ticks = |time: f32, least: u16| ((time / h + 0.5) as u16).max(least);
        let hertz = core::f32::consts::TAU;
        // Without viscous friction the quotient is infinite, and the cap alone limits the speed.
        let viscous_speed = 0.15 * around.full_scale / gains.viscous;
        let capped = !slow || gains.viscous == 0.0;
        let speed = if capped { viscous_speed.min(SPEED_CAP) } else { viscous_speed };
        let speed = or(gains.speed, speed.min(HUGE));
        // A load that breaks away behind its transmission is as fast without a swing: with the
        // encoder on the load, no swing counts as wide. In a slow loop a swing has only a few
        // ticks, and is weaker evidence.
        let wide_swing = if on_load || slow { f32::INFINITY } else { 0.5 * speed };
        let acceleration = or(gains.acceleration, 0.25 * around.full_scale / gains.inertia);
        let least_learned = LEAST_LEARNED * gains.breakaway_low;
        let slowly = (least_learned / gains.viscous).max(3.0 * acceleration * h);
        let learned_to = if slow { slowly } else { f32::INFINITY };
        let observer = or(gains.observer, (0.7 / h).min(110.0));
        // Jitter is motion to a faster observer.
        let tracking =
            if gains.jitter > 0.0 { observer } else { observer.max((0.35 / h).min(300.0)) };
        Self {
            on_load,
            bandwidth: or(gains.bandwidth, (hertz * on(8.0, 2.0)).min(0.14 / h)),
            observer,
            observer_in_motion: or(gains.observer, (0.7 / h).min(on(110.0, 15.0))),
            observer_tracking: or(gains.tracking_observer, tracking),
            acceleration,
            speed,
            wide_swing,
            learned_to: or(gains.learned_to, learned_to),
            hold_step: or(gains.hold_step, 0.15 * gains.breakaway_low),
            least_gain: or(gains.least_gain, on(0.1, 0.05)),
            rest: if slow { 3 } else { 6 },
            coast: ticks(or(gains.coast_time, on(0.01, 0.06)), 3),
            hold: ticks(0.02, 3),
            leave: ticks(0.04, 2),
            first_wait: ticks(0.02, 3),
            longest_wait: ticks(0.1, 6),
            guard: ticks(on(0.1, 0.25), 10),
            inching: if slow { [2, 3] } else { [3, 6] },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::value::Table;

    #[test]
    fn gains_that_are_written_out_are_the_same_law() {
        for (sample_time, encoder_side) in [
            (0.001, EncoderSide::Motor),
            (0.001, EncoderSide::Load),
            (0.02, EncoderSide::Motor),
            (0.02, EncoderSide::Load),
        ] {
            let around = Loop { sample_time, ..Loop::EXAMPLE };
            let gains = RobustGains { encoder_side, ..RobustGains::EXAMPLE };
            let written = gains.written_out(&around);
            assert!(written.bandwidth > 0.0 && written.speed > 0.0, "{written:?}");
            assert_eq!(Rules::new(&written, &around), Rules::new(&gains, &around));
        }
    }

    #[test]
    fn slow_loop_learns_friction_up_to_a_speed_and_a_fast_one_at_any() {
        let of = |sample_time, viscous, learned_to| {
            let gains = RobustGains { viscous, learned_to, ..RobustGains::EXAMPLE };
            Rules::new(&gains, &Loop { sample_time, ..Loop::EXAMPLE }).learned_to
        };
        // 0.3 * 0.19 V / (0.02 V s/deg)
        assert!((of(0.02, 0.02, 0.0) - 2.85).abs() < 1e-6);
        // 3 * 33.75 deg/s^2 * 0.1 s, where that is more
        assert!((of(0.1, 0.02, 0.0) - 10.125).abs() < 1e-4);
        assert_eq!([of(0.01, 0.02, 0.0), of(0.02, 0.0, 0.0)], [f32::INFINITY; 2]);
        assert_eq!([of(0.01, 0.02, 7.0), of(0.02, 0.02, 7.0)], [7.0; 2]);
    }

    #[test]
    fn observer_is_slower_in_motion_with_the_encoder_on_the_load_unless_configured() {
        let of = |sample_time, encoder_side, observer| {
            let gains = RobustGains { encoder_side, observer, ..RobustGains::EXAMPLE };
            let rules = Rules::new(&gains, &Loop { sample_time, ..Loop::EXAMPLE });
            [rules.observer, rules.observer_in_motion]
        };
        use EncoderSide::{Load, Motor};
        assert_eq!(of(0.001, Motor, 0.0), [110.0, 110.0]);
        assert_eq!(of(0.001, Load, 0.0), [110.0, 15.0]);
        assert_eq!(of(0.001, Load, 80.0), [80.0, 80.0]);
        // 0.7 / h is 35 rad/s at 20 ms, and 7 at 0.1 s.
        assert_eq!([of(0.02, Motor, 0.0), of(0.02, Load, 0.0)], [[35.0, 35.0], [35.0, 15.0]]);
        assert_eq!(of(0.1, Load, 0.0), [7.0, 7.0]);
    }

    /// Jitter is motion to a fast observer.
    #[test]
    fn observer_of_a_moving_set_point_is_faster_unless_the_encoder_jitters() {
        let of = |sample_time, jitter, tracking_observer| {
            let gains = RobustGains { jitter, tracking_observer, ..RobustGains::EXAMPLE };
            Rules::new(&gains, &Loop { sample_time, ..Loop::EXAMPLE }).observer_tracking
        };
        assert_eq!([of(0.001, 0.0, 0.0), of(0.001, 2.0, 0.0)], [300.0, 110.0]);
        // 0.35 / h is 175 rad/s at 2 ms; at 20 ms it is less than 0.7 / h.
        assert!((of(0.002, 0.0, 0.0) - 175.0).abs() < 1e-4);
        assert_eq!(of(0.02, 0.0, 0.0), 35.0);
        assert_eq!(of(0.001, 2.0, 200.0), 200.0);
    }
}
