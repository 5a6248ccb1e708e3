//! Thresholds of the monitors: `[limits]` of a machine's file.

use crate::control::controller::ControllerConfig;
use crate::control::device_config::DeviceConfig;
use crate::control::encoder::CounterBits;
use crate::units::error::HUGE;
use crate::units::value::{Key, Table, key, table};

/// A turn, deg: the limit of the following error if Kp is zero.
const TURN: f32 = 360.0;

/// If Kd is zero, the limit of the speed is that of the following error divided by this time, s. It
/// equals that of Kd = 0.15 s Kp, the thesis's ratio.
const UNDAMPED: f32 = 0.06;

/// Largest speed in a tick, in overspeed limits, if the law ends swings itself. In simulated swings
/// whose mean speed was within the limit, the fastest ticks were up to five times as fast. If the
/// period of a swing divides the averaging time, nothing else limits its speed.
const SWING: f32 = 6.0;

/// Time at the breakaway effort that makes the derived limit of the impulse without a count, s.
const IMPULSE_TIME: f32 = 0.5;

/// Part of the file's friction from which an effort may already start the joint: the friction of a
/// joint changes with temperature and wear, and data sheets err.
pub const CERTAIN: f32 = 0.5;

/// Ratio of the largest gain of a stable loop to the gain of the weakest joint. A quarter of the
/// weakest joint's travel is required, so a joint of unknown gain trips with less than a 256th of
/// the largest gain. In a loop of 1 kHz that regresses over 5 ms, this is a bandwidth of the
/// damping below 0.4 Hz.
const SLOWEST_LOOP: f32 = 64.0;

/// Part of the converter's full scale up to which a supply is distinguished from a higher one: the
/// last four of 4096 readings are left out.
const MEASURED: f32 = 1.0 - 4.0 / 4096.0;

/// Largest derived limit of the travel in one tick, as a part of the counter's half range: travel
/// beyond the half range is read as travel the other way.
const COUNTED: f32 = 0.9;

/// The longest time of a monitor, s: its ticks and their sums stay far within 32 bits.
const LONGEST: f32 = 600.0;

table! {
    /// Thresholds in a user's units. `"off"`, which is zero, turns a monitor off; nothing else
    /// does, and no threshold is derived as off but those of a supply that is not measured.
    ///
    /// The examples are those of the thesis's loop under PD (5 V, Kp 1 V/deg, Kd 0.15 V s/deg, 20
    /// ms).
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Limits (limits) "limits" {
        /// Travel in one tick, deg; half of the counter's range and more never trips. Derived: that
        /// of a tick at twice the overspeed, and 4 counts; at six times under `robust`.
        encoder_jump: f32 = 0x0901 "encoder_jump_deg", OrOff(0.0, HUGE), Derived(3.343_013);
        /// Effort beyond any friction, V. Derived: twice `breakaway_v`, and no more than `duty_max`
        /// lets through. Off turns `stall_impulse_vs` off as well.
        stall_effort: f32 = 0x0902 "stall_v", OrOff(0.0, HUGE), Derived(0.8);
        /// Time without a count under that effort, s.
        stall_time: f32 = 0x0903 "stall_s", Between(0.0, LONGEST), Default(0.2);
        /// Travel against the effort in the first move after arming, deg. Derived: 8 counts,
        /// twice the noise that standstill allows. Travel of the push before is set off.
        reversal: f32 = 0x0904 "reversal_deg", OrOff(0.0, HUGE), Derived(0.019_36);
        /// Error beyond a jump of the set point, deg. Derived: full scale / Kp; beyond it more
        /// error gives no more effort. Without Kp, a turn. `robust` has its own rule.
        following_error: f32 = 0x0905 "following_error_deg", OrOff(0.0, HUGE), Derived(5.0);
        /// Measured speed, deg/s. Derived: 2.5 full scale / Kd, at least 16 counts a tick. Without
        /// Kd, that of Kd = 0.15 s Kp. Under `robust`, twice the speed of its profile, judged by
        /// the mean over 50 ms up to 10 ms of sample time (100 ms with the encoder on the load). It
        /// is no more than the counter distinguishes in a tick, nor than the speed of the joint's
        /// gain, if the file has it, after a turn under the largest effort. On the thesis's joint a
        /// step of 25 deg passes under every law, and an unstable loop is detected within a second
        /// under PD and the laws of the thesis. A swing of four ticks is measured too slow.
        overspeed: f32 = 0x0906 "overspeed_deg_per_s", OrOff(0.0, HUGE), Derived(83.333_336);
        /// Lowest position, deg from the reference (`device.reference`). Both limits zero: no
        /// limits.
        position_min: f32 = 0x0907 "position_min_deg", Between(-HUGE, HUGE), Default(0.0);
        /// Highest position, deg, not below `position_min_deg`.
        position_max: f32 =
            0x0908 "position_max_deg", Between(limits.position_min, HUGE), Default(0.0);
        /// Lowest supply, V. Derived: 0.7 of the nominal supply.
        supply_min: f32 = 0x0909 "supply_min_v", OrOff(0.0, HUGE), Derived(0.0);
        /// Highest supply, V; the converter's full scale and more never trips. Derived: 1.3 of the
        /// nominal supply, and no more than the converter distinguishes.
        supply_max: f32 = 0x090A "supply_max_v", OrOff(0.0, HUGE), Derived(0.0);
        /// Effort that the motor tolerates forever at standstill, V. Derived: that of
        /// `motor.rated_current_a`, or of a tenth of the stall current but at least `breakaway_v`,
        /// if the file has the motor; else three quarters of what `duty_max` lets through, which
        /// tolerates full effort for 8.3 s.
        continuous_effort: f32 = 0x090B "continuous_v", OrOff(0.0, HUGE), Derived(3.75);
        /// Time constant of the motor's winding, s.
        thermal_time: f32 = 0x090C "thermal_s", Between(0.1, 100.0), Default(10.0);
        /// Silence of the client that armed the servo, s.
        link_timeout: f32 = 0x090D "link_timeout_s", OrOff(0.0, LONGEST), Default(0.5);
        /// Effort of the compensator at standstill that is reported, V. Derived:
        /// `breakaway_v`.
        wind_up_effort: f32 = 0x090E "wind_up_v", OrOff(0.0, HUGE), Derived(0.4);
        /// How long the compensator has to hold that effort, s.
        wind_up_time: f32 = 0x090F "wind_up_s", Between(0.0, LONGEST), Default(1.0);
        /// Effort that starts the joint, V. Derived: half of `stall_v` if the file has that, else
        /// `stick_v` and the load of its joint, else a quarter of what `duty_max` lets through.
        /// Off turns `stall_impulse_vs` and `reversal_deg` off.
        breakaway_effort: f32 = 0x0910 "breakaway_v", OrOff(0.0, HUGE), Derived(0.4);
        /// Effort beyond `breakaway_v` times its time, added up until a count comes, V s. Derived:
        /// `breakaway_v` for half a second.
        stall_impulse: f32 = 0x0911 "stall_impulse_vs", OrOff(0.0, HUGE), Derived(0.2);
        /// Acceleration for a volt, deg/s^2 per V. Counts that stop faster than this and `stall_v`
        /// allow are a stall. Derived: twice the joint's gain, if the file has it; else pi /
        /// (`kd_v_per_deg_per_s` `velocity_window` `sample_time_s`), beyond which no loop is
        /// stable.
        stop_gain: f32 = 0x0912 "stop_gain_deg_per_s2_per_v", OrOff(0.0, HUGE), Derived(209.439_51);
        /// Acceleration for a volt of the weakest joint, deg/s^2 per V. Effort beyond `stall_v`
        /// that is not followed by a quarter of its travel is a stall. Derived: a quarter of the
        /// joint's gain, if the file has it; else a 64th of what the loop allows
        /// (`stop_gain_deg_per_s2_per_v`).
        progress_gain: f32 =
            0x0913 "progress_gain_deg_per_s2_per_v", OrOff(0.0, HUGE), Derived(3.272_492_4);
        /// Time of swings to and fro around a set point that rests, s. Swings are more than 16
        /// counts, a second apart at most. A tenth of the default is reported as a warning.
        oscillation_time: f32 = 0x0914 "oscillation_s", OrOff(0.0, LONGEST), Default(30.0);
        /// Lowest effort that may start the joint, V. Zero beside a `breakaway_v`: the friction is
        /// unknown, and no closed loop is armed. Derived: half of the lowest friction of the file's
        /// joint; half of `breakaway_v` if the file has only that. Set to `breakaway_v` or more, it
        /// turns the probe of the encoder off.
        breakaway_min: f32 = 0x0915 "breakaway_min_v", Between(0.0, HUGE), Derived(0.2);
        /// Error up to which no probe of the encoder begins, deg. Derived: `tolerance_deg` of the
        /// file's goal, if it has one, else 16 counts: an integral does the rest.
        probe_error: f32 = 0x0916 "probe_error_deg", Between(0.0, HUGE), Derived(0.038_72);
        /// Voltage that the motor induces for each deg/s of the joint, V s/deg: only the effort
        /// beyond it heats the motor. Derived: from the file's motor, if a bridge drives it; else
        /// 0, and all effort counts.
        back_emf: f32 = 0x0917 "back_emf_v_per_deg_per_s", Between(0.0, HUGE), Derived(0.0);
        /// Play between the motor and the encoder, whole width, deg: the motor crosses it without a
        /// count. Effort without a count is no stall before the joint of the file has crossed it,
        /// and counts that stop abruptly are none. Derived: the backlash of the file's gear, if the
        /// encoder is on the load. With an encoder on either side: the twist within which the gear
        /// holds the motor, derived of a gear with stiffness.
        play: f32 = 0x0918 "play_deg", Between(0.0, TURN), Derived(0.0);
    }
}

const SUPPLY_MAX: Key = key(Limits::ABOUT, "supply_max");
const ENCODER_JUMP: Key = key(Limits::ABOUT, "encoder_jump");

impl Limits {
    /// All monitors off, for tests of the code around them.
    pub const OFF: Self = Self {
        encoder_jump: 0.0,
        stall_effort: 0.0,
        stall_time: 0.2,
        reversal: 0.0,
        following_error: 0.0,
        overspeed: 0.0,
        position_min: 0.0,
        position_max: 0.0,
        supply_min: 0.0,
        supply_max: 0.0,
        continuous_effort: 0.0,
        thermal_time: 10.0,
        link_timeout: 0.0,
        wind_up_effort: 0.0,
        wind_up_time: 1.0,
        breakaway_effort: 0.0,
        stall_impulse: 0.0,
        stop_gain: 0.0,
        progress_gain: 0.0,
        oscillation_time: 0.0,
        breakaway_min: 0.0,
        probe_error: 0.0,
        back_emf: 0.0,
        play: 0.0,
    };

    /// Derives the limits from the loop itself, for machines that do not set them; the doc of each
    /// limit has the rule and the reason. `breakaway` is the effort that starts the joint (V), or
    /// zero if it is unknown. A law may define its own limits of speed and error in place of those
    /// of PD's gains.
    pub fn derived(controller: &ControllerConfig, device: &DeviceConfig, breakaway: f32) -> Self {
        let around = controller.around();
        let (full_scale, count, sample_time) =
            (around.full_scale, around.resolution, around.sample_time);
        let laws = &controller.compensator;
        let following_error = laws
            .iter()
            .find_map(|law| law.following_error(&around))
            .unwrap_or_else(|| Self::saturating_error(controller));
        let damped = match controller.pd.kd {
            kd if kd > 0.0 => 2.5 * full_scale / kd,
            _ => following_error / UNDAMPED,
        };
        let of_pd = damped.max(16.0 * count / sample_time).min(HUGE);
        let faster = if Self::swing_time(controller) > 0.0 { SWING } else { 2.0 };
        let counted = (COUNTED * Self::half_range(controller) - 4.0 * count) / faster / sample_time;
        let overspeed =
            laws.iter().find_map(|law| law.overspeed(&around)).unwrap_or(of_pd).min(counted);
        // A speed loop with a gain k and a delay d, v' = -k v(t - d), is stable below k d = pi / 2.
        // The slope of a window is (N - 1) / 2 samples late, and a held output half a sample.
        let damping = 2.5 * full_scale / damped;
        let late = 0.5 * controller.velocity_window as f32 * sample_time;
        let stop_gain = (core::f32::consts::FRAC_PI_2 / (damping * late)).min(HUGE);
        let encoder_jump = (faster * overspeed * sample_time + 4.0 * count).min(HUGE);
        // What the output stage lets through: beyond it nothing trips.
        let largest = full_scale * controller.drive.duty_max;
        let breakaway_min = CERTAIN * breakaway.min(largest);
        let breakaway = if breakaway > 0.0 { breakaway.min(largest) } else { 0.25 * largest };
        Self {
            encoder_jump,
            stall_effort: (2.0 * breakaway).min(largest),
            reversal: (8.0 * count).min(HUGE),
            following_error,
            overspeed,
            supply_min: 0.7 * device.nominal_supply,
            supply_max: (1.3 * device.nominal_supply)
                .min((MEASURED * device.supply_full_scale).max(device.nominal_supply)),
            continuous_effort: 0.75 * largest,
            wind_up_effort: breakaway,
            breakaway_effort: breakaway,
            stall_impulse: breakaway * IMPULSE_TIME,
            stop_gain,
            progress_gain: stop_gain / SLOWEST_LOOP,
            breakaway_min,
            probe_error: (16.0 * count).min(HUGE),
            ..Self::EXAMPLE
        }
    }

    /// Returns the same limits for a joint of a known gain (deg/s^2 per V); zero: the gain is
    /// unknown.
    ///
    /// The joint may have from half to four times the inertia of its file. After a turn under the
    /// largest effort `V`, without any friction, its speed is `sqrt(2 gain V 360 deg)` at most: a
    /// higher limit of the speed would never trip within a turn.
    #[must_use]
    pub fn of_gain(self, gain: f32, controller: &ControllerConfig) -> Self {
        if gain > 0.0 {
            let largest = controller.drive.full_scale * controller.drive.duty_max;
            let after_a_turn = libm::sqrtf(2.0 * gain * largest * TURN);
            let overspeed = self.overspeed.min(after_a_turn);
            Self { overspeed, stop_gain: 2.0 * gain, progress_gain: 0.25 * gain, ..self }
        } else {
            self
        }
    }

    /// Returns whether the friction is unknown, so that no closed loop may be armed.
    pub(super) const fn is_friction_unknown(&self) -> bool {
        self.breakaway_effort > 0.0 && self.breakaway_min == 0.0
    }

    /// Returns the travel in one tick (deg) beyond which the counter reads travel the other way.
    fn half_range(controller: &ControllerConfig) -> f32 {
        let counts = match controller.encoder.counter_bits {
            CounterBits::Sixteen => i16::MAX as f32,
            CounterBits::ThirtyTwo => i32::MAX as f32,
        };
        (counts * controller.encoder.resolution).min(HUGE)
    }

    /// Returns whether the limit with this key is beyond what the hardware can read, so that it
    /// never trips.
    pub fn is_out_of_reach(
        &self,
        key: Key,
        controller: &ControllerConfig,
        device: &DeviceConfig,
    ) -> bool {
        match key {
            SUPPLY_MAX => {
                device.supply_full_scale > 0.0
                    && self.supply_max > MEASURED * device.supply_full_scale
            }
            ENCODER_JUMP => self.encoder_jump >= Self::half_range(controller),
            _ => false,
        }
    }

    /// Returns the averaging time of the speed if the law ends swings itself, s; zero if the
    /// monitors judge all swings. A regression over at least this time averages the swings already.
    pub(super) fn swing_time(controller: &ControllerConfig) -> f32 {
        let around = controller.around();
        let window = controller.velocity_window.saturating_sub(1) as f32 * around.sample_time;
        let laws = &controller.compensator;
        let time = laws.iter().find_map(|law| law.swing_time(&around)).unwrap_or(0.0);
        if time > window { time } else { 0.0 }
    }

    /// Returns the error at which the law reaches the full scale, deg: beyond it, more error causes
    /// no more effort. A law may define its own value in place of that of Kp; without both it is a
    /// turn.
    pub(super) fn saturating_error(controller: &ControllerConfig) -> f32 {
        let around = controller.around();
        let of_pd = match controller.pd.kp {
            kp if kp > 0.0 => (around.full_scale / kp).min(HUGE),
            _ => TURN,
        };
        let laws = &controller.compensator;
        laws.iter().find_map(|law| law.saturating_error(&around)).unwrap_or(of_pd)
    }
}

/// Conversion factors from a user's units to those of a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Units {
    /// Angle of a count, deg.
    pub count: f32,
    /// Effort of a code, V.
    pub code: f32,
    /// Time of a tick, s.
    pub tick: f32,
    /// Supply voltage of a unit of the converter, V; zero if the supply is not measured.
    pub supply: f32,
}

impl Units {
    /// Returns a positive amount in whole units, at least one: a threshold that is on stays on.
    #[inline(never)]
    pub fn whole(amount: f32, unit: f32) -> u32 {
        (libm::roundf(amount / unit) as u32).max(1)
    }

    /// Returns a threshold in whole units. A threshold of zero is off: the result is never reached.
    #[inline(never)]
    pub fn threshold(amount: f32, unit: f32) -> u32 {
        if amount > 0.0 && unit > 0.0 { Self::whole(amount, unit) } else { u32::MAX }
    }

    /// Returns the whole code nearest to an effort (V). A tick calls it: `libm::roundf` takes four
    /// times as many instructions, and differs only where f32 rounds a sum with a half up.
    #[inline]
    pub fn codes(&self, effort: f32) -> i32 {
        let codes = effort / self.code;
        (codes + 0.5_f32.copysign(codes)) as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::drive::DriveConfig;
    use crate::control::encoder::Encoder;
    use crate::control::laws::robust::EncoderSide;
    use crate::control::laws::{Gains, RobustGains};
    use crate::control::pd::PdGains;
    use crate::units::value::Values;

    fn derived(kp: f32, kd: f32, duty_max: f32, breakaway: f32) -> Limits {
        let drive = DriveConfig { full_scale: 5.0, duty_max, ..DriveConfig::EXAMPLE };
        let pd = PdGains { kp, kd };
        let controller = ControllerConfig { drive, pd, ..ControllerConfig::EXAMPLE };
        Limits::derived(&controller, &DeviceConfig::EXAMPLE, breakaway)
    }

    #[test]
    fn nothing_that_can_be_derived_is_off_whatever_the_gains_are() {
        for [kp, kd] in [[1.0, 0.15], [0.1, 0.0], [0.0, 0.15], [0.0, 0.0]] {
            let limits = derived(kp, kd, 1.0, 0.0);
            let Limits { encoder_jump, stall_effort, reversal, following_error, .. } = limits;
            let Limits {
                overspeed,
                continuous_effort,
                breakaway_effort,
                stall_impulse,
                stop_gain,
                ..
            } = limits;
            let all = [
                encoder_jump,
                stall_effort,
                reversal,
                following_error,
                overspeed,
                continuous_effort,
                breakaway_effort,
                stall_impulse,
                stop_gain,
            ];
            assert!(all.iter().all(|limit| *limit > 0.0 && limit.is_finite()), "{limits:?}");
            // So is every value that can be off, also one that is declared later. The supply of
            // this device is not measured.
            for about in Limits::ABOUT.iter().filter(|about| about.may_be_off()) {
                let found = limits.get(about.key).map(f32::from_bits).unwrap();
                assert_eq!(found > 0.0, !about.name.starts_with("supply_"), "{about:?}");
            }
        }
        // Without Kd the speed is that of Kd = 0.15 s Kp.
        let [without, with] = [derived(0.5, 0.0, 1.0, 0.0), derived(0.5, 0.075, 1.0, 0.0)];
        assert!((without.overspeed / with.overspeed - 1.0).abs() < 1e-6, "{without:?}");
    }

    /// A joint of 2022 deg/s^2 per V under `robust`, whose largest breakaway is 1 V of 5 V.
    #[test]
    fn limits_under_robust_know_its_swings_in_fast_loops_only() {
        let of = |sample_time: f32, encoder_side: EncoderSide| {
            let gains = RobustGains {
                inertia: 4.945e-4,
                viscous: 1.89e-3,
                breakaway_high: 1.0,
                encoder_side,
                ..RobustGains::EXAMPLE
            };
            let compensator = [Gains::Robust(gains)].into_iter().collect();
            let controller =
                ControllerConfig { compensator, sample_time, ..ControllerConfig::EXAMPLE };
            let limits = Limits::derived(&controller, &DeviceConfig::EXAMPLE, 0.4);
            let jump = limits.encoder_jump - 4.0 * controller.encoder.resolution;
            [
                limits.overspeed,
                jump / sample_time / limits.overspeed,
                limits.following_error,
                Limits::saturating_error(&controller),
                Limits::swing_time(&controller),
            ]
        };
        use EncoderSide::{Load, Motor};
        // The profile's speed is 3 rad/s up to 10 ms, and 0.15 of 5 V / B beyond. The bandwidth is
        // 16 pi, 14, 7 and 4 pi rad/s; 5 V ask for 1.25 V / J = 2528 deg/s^2. So the error is twice
        // 5 V / (J w^2) at 1 kHz, and else 1 V / (J w^2), twice and once: the way v^2 / 2 a is
        // less, 5.84 deg and 31.1 deg at 20 ms.
        let slow = 0.15f32 * 5.0 / 1.89e-3;
        for (tick, side, [overspeed, jump, error, saturating, swing]) in [
            (0.001, Motor, [343.8, 6.0, 2.0 * 4.002, 4.002, 0.05]),
            (0.001, Load, [343.8, 6.0, 12.81, 64.03, 0.1]),
            (0.01, Motor, [343.8, 6.0, 2.0 * 10.32, 51.59, 0.05]),
            (0.02, Motor, [2.0 * slow, 2.0, 41.27, 206.4, 0.0]),
            (0.02, Load, [2.0 * slow, 2.0, 41.27, 206.4, 0.0]),
        ] {
            let found = of(tick, side);
            let expected = [overspeed, jump, error, saturating, swing];
            for (found, expected) in found.iter().zip(expected) {
                let off = (found - expected).abs();
                assert!(off <= 1e-3 * expected, "{tick} {side:?}: {found:?}, not {expected:?}");
            }
        }
    }

    /// Without a cap, 2.5 times 5 V / Kd would be 12 500 deg/s.
    #[test]
    fn a_derived_speed_is_one_that_the_counter_distinguishes_and_the_joint_reaches() {
        let of = |kd: f32, counter_bits: CounterBits, gain: f32| {
            let encoder = Encoder { counter_bits, ..Encoder::EXAMPLE };
            let pd = PdGains { kp: 1.0, kd };
            let controller = ControllerConfig { pd, encoder, ..ControllerConfig::EXAMPLE };
            let limits = Limits::derived(&controller, &DeviceConfig::EXAMPLE, 0.4)
                .of_gain(gain, &controller);
            assert!(!limits.is_out_of_reach(ENCODER_JUMP, &controller, &DeviceConfig::EXAMPLE));
            limits
        };
        use CounterBits::{Sixteen, ThirtyTwo};
        // 16 bits: half of 65 536 counts of 0.00242 deg in 20 ms, and 0.9 of that at twice the
        // speed. A gain of 27 deg/s^2 per V reaches sqrt(2 27 5 360) deg/s after a turn.
        let counted = (0.9 * 32_767.0 - 4.0) * 0.00242 / 0.04;
        let turn = (2.0f32 * 27.0 * 5.0 * 360.0).sqrt();
        for (kd, bits, gain, expected) in [
            (0.001, ThirtyTwo, 0.0, 12_500.0),
            (0.001, Sixteen, 0.0, counted),
            (0.001, Sixteen, 27.0, turn),
            (0.001, ThirtyTwo, 27.0, turn),
            (0.15, Sixteen, 27.0, 250.0 / 3.0),
        ] {
            let found = of(kd, bits, gain);
            let off = (found.overspeed - expected).abs();
            assert!(off < 1e-4 * expected, "{kd}, {bits:?}, {gain}: {found:?}, not {expected}");
            let half = if bits == Sixteen { 32_767.0 * 0.00242 } else { HUGE };
            assert!(found.encoder_jump < half, "{found:?}");
        }
    }

    /// A converter reads its full scale for every supply beyond it.
    #[test]
    fn a_derived_highest_supply_is_one_that_the_converter_measures() {
        let controller = ControllerConfig::EXAMPLE;
        for (nominal_supply, expected) in [(12.0, 15.6), (20.0, 23.976_56)] {
            let device =
                DeviceConfig { nominal_supply, supply_full_scale: 24.0, ..DeviceConfig::EXAMPLE };
            let limits = Limits::derived(&controller, &device, 0.4);
            assert!((limits.supply_max - expected).abs() < 1e-4, "{limits:?}");
            let out = |limits: Limits, key| limits.is_out_of_reach(key, &controller, &device);
            assert!(!out(limits, SUPPLY_MAX) && !out(limits, ENCODER_JUMP));
            assert!(out(Limits { supply_max: 24.0, ..limits }, SUPPLY_MAX));
            assert!(out(Limits { encoder_jump: 80.0, ..limits }, ENCODER_JUMP));
        }
    }

    #[test]
    fn every_effort_that_trips_is_one_that_the_drive_lets_through() {
        for (duty_max, breakaway) in [(1.0, 0.4), (1.0, 3.0), (0.25, 0.0), (0.25, 0.4), (0.1, 3.0)]
        {
            let limits = derived(1.0, 0.15, duty_max, breakaway);
            let largest = 5.0 * duty_max;
            assert!(limits.stall_effort <= largest && limits.continuous_effort < largest);
            assert!(limits.breakaway_effort <= largest, "{limits:?}");
            let known = if breakaway > 0.0 { breakaway.min(largest) } else { 0.25 * largest };
            assert_eq!(limits.breakaway_effort, known, "PD rests with less than that for ever");
            assert_eq!(limits.stall_effort, (2.0 * known).min(largest));
        }
    }
}
