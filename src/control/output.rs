//! The output stage: from the effort that the loop requests to the duty of the bridge. The closed
//! loop and the open one share this stage.
//!
//! ```text
//! asked -> full scale -> supply scaling -> full scale -> code -> soft start and cap -> compare
//!            v                                                       code                duty
//! ```
//!
//! `v` is limited to the full scale, or to less in a motion with its own bound
//! ([`OutputStage::bound_effort`]). A [limit of the current](super::current_limit) makes it less in
//! single ticks. If the supply is measured and has a nominal value, the duty is
//! scaled by nominal over measured, so that the motor gets the requested volts. After arming, the
//! limit of the code rises in a straight line from zero to the largest code (soft start). The cap
//! (`duty_max`) limits the code at all times.
//!
//! The effort that is [applied](Applied::v_applied) is reported in volts at the nominal supply: the
//! code's volts, divided by the ratio of nominal to measured supply. Without scaling, it is the
//! code's volts.

use crate::control::drive::{Drive, DriveConfig, Duty};
use crate::units::saturation::{bounded, saturate, saturate_between};

/// The output stage of a loop: it turns volts into the bridge's duty.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputStage {
    /// Largest output, V.
    pub(crate) full_scale: f32,
    /// Volts of one code.
    lsb: f32,
    pub(crate) drive: Drive,
    /// Nominal supply in the converter's units; 0: the duty is not scaled.
    nominal_supply: f32,
    /// Length of the soft start, ticks.
    soft_start: u32,
    /// Largest code that the stage passes on: the cap.
    cap: i32,
    /// Largest output of the present motion, V.
    most: f32,
    /// Lowest and highest output of the next tick, V: those of the motion, or less if the motor's
    /// current limits them.
    bounds: [f32; 2],
}

/// The state of the output stage from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutputState {
    /// Ticks since arming, up to the end of the soft start.
    elapsed: u32,
    /// Effort that the joint has had since the last tick, V.
    pub(crate) applied: f32,
    /// Whether that effort was less than requested.
    pub(crate) saturated: bool,
    /// Least code of the next tick, with the sign of its direction; zero: none. A probe of the
    /// encoder sets it.
    pub(crate) least: i32,
}

/// Result of the output stage for one effort.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Applied {
    /// Requested effort, limited to the full scale or to the bound of the motion, V.
    pub v: f32,
    /// Effort that the joint gets, V at the nominal supply.
    pub v_applied: f32,
    pub code: i16,
    pub duty: Duty,
    pub saturated: bool,
}

/// Limit of the code that applies to an effort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rise {
    /// The limit of the soft start, and the cap.
    Soft,
    /// The cap alone: a ramp is its own soft start.
    Own,
}

impl OutputStage {
    /// Makes a stage without a soft start, whose duty does not depend on the supply.
    pub(crate) fn new(config: &DriveConfig, drive: Drive) -> Self {
        let &DriveConfig { full_scale, lsb, duty_max, .. } = config;
        // Rounded towards zero: the cap never exceeds the configured share. A share of less than
        // one code is a cap of zero.
        let cap = (duty_max * f32::from(drive.max_code())) as i32;
        Self {
            full_scale,
            lsb,
            nominal_supply: 0.0,
            soft_start: 0,
            cap,
            most: full_scale,
            drive,
            bounds: [-full_scale, full_scale],
        }
    }

    /// Sets a soft start (ticks) and the nominal supply by which the duty is scaled (the
    /// converter's units; 0: the duty is not scaled).
    pub(crate) fn on_device(&mut self, soft_start: u32, nominal_supply: f32) {
        (self.soft_start, self.nominal_supply) = (soft_start, nominal_supply);
    }

    /// Sets the largest effort of the motion that starts, V at the nominal supply; infinity: the
    /// full scale alone limits it. The applied effort exceeds this limit by half a code at most.
    pub(crate) fn bound_effort(&mut self, effort: f32) {
        self.most = self.full_scale.min(effort);
        self.bounds = [-self.most, self.most];
    }

    /// Sets the lowest and the highest output of the next tick, V at the nominal supply: those that
    /// the motor's current allows.
    pub(crate) fn bound(&mut self, bounds: [f32; 2]) {
        // Bounds on one side of zero are those of a joint that a load drives fast.
        self.bounds = bounds.map(|bound| bounded(bound, self.most));
    }

    /// Returns the remaining ticks of the soft start.
    pub(crate) const fn soft_start_left(&self, state: &OutputState) -> u32 {
        self.soft_start.saturating_sub(state.elapsed)
    }

    /// Returns the effort, code and duty that are applied for a requested effort `asked` (V,
    /// finite), at a reading of the supply (the converter's units).
    // The image has this code twice, for the closed loop and the open one, as it has the
    // velocity's.
    #[inline(always)]
    pub(crate) fn apply(
        &self,
        state: &mut OutputState,
        asked: f32,
        supply: u16,
        rise: Rise,
    ) -> Applied {
        let asked = if state.least == 0 { asked } else { self.at_least(state, asked) };
        let (v, mut saturated) = saturate_between(asked, self.bounds);
        let (mut scaled, mut volts) = (v, self.lsb);
        if self.nominal_supply > 0.0 {
            let ratio = supply_ratio(self.nominal_supply, supply);
            let (limited, over) = saturate(v * ratio, self.full_scale);
            saturated |= over;
            scaled = limited;
            volts /= ratio;
        }
        let full = self.drive.whole_code(scaled);
        let limit = match rise {
            Rise::Soft => self.soft_start_limit(state),
            Rise::Own => self.cap,
        };
        let code = full.max(-limit).min(limit);
        saturated |= code != full;
        let v_applied = code as f32 * volts;
        (state.applied, state.saturated) = (v_applied, saturated);
        Applied { v, v_applied, code: code as i16, duty: self.drive.duty_of(code), saturated }
    }

    /// Returns the requested effort (V), or the least effort if that is larger and not in the
    /// opposite direction. The least effort is then cleared: it applies to this tick alone.
    #[cold]
    #[inline(never)]
    fn at_least(&self, state: &mut OutputState, asked: f32) -> f32 {
        let least = core::mem::take(&mut state.least) as f32 * self.lsb;
        let is_less = asked * least >= 0.0 && asked.abs() < least.abs();
        if is_less { least } else { asked }
    }

    /// Returns the largest code of this tick, and counts the tick of the soft start.
    #[inline]
    fn soft_start_limit(&self, state: &mut OutputState) -> i32 {
        if state.elapsed >= self.soft_start {
            return self.cap;
        }
        // The product of 10 s at 10 kHz and 32 767 codes fits 32 bits.
        let scaled = state.elapsed.wrapping_mul(self.drive.max_code().unsigned_abs().into());
        state.elapsed += 1;
        (scaled.checked_div(self.soft_start).unwrap_or(0) as i32).min(self.cap)
    }
}

/// Returns the ratio of nominal to measured supply, within a factor of two either way: a broken
/// divider must not turn into full effort.
fn supply_ratio(nominal: f32, measured: u16) -> f32 {
    (nominal / f32::from(measured.max(1))).clamp(0.5, 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::drive::PwmMode;
    use crate::control::hardware::Hardware;

    /// A power of two: every product and quotient below is exact.
    const LSB: f32 = 1.0 / 256.0;
    /// The code of 5 V.
    const MAX: i16 = 1280;
    /// The converter's reading of the nominal supply.
    const NOMINAL: u16 = 2048;

    fn stage(soft_start: u32, nominal: u16) -> OutputStage {
        let config = DriveConfig {
            full_scale: 5.0,
            lsb: LSB,
            pwm_hz: 22e3,
            mode: PwmMode::LockedAntiphase,
            duty_max: 1.0,
        };
        let drive = Drive::new(
            &config,
            &Hardware {
                pwm_clock_hz: 168e6,
                supply_top: 4095,
                dead_time_max: 6e-6,
                sample_time: [1e-4, 0.02],
            },
        )
        .unwrap();
        let mut stage = OutputStage::new(&config, drive);
        stage.on_device(soft_start, f32::from(nominal));
        stage
    }

    /// Runs one tick of a joint that has just been armed.
    fn once(stage: &OutputStage, asked: f32, supply: u16) -> Applied {
        stage.apply(&mut OutputState::default(), asked, supply, Rise::Soft)
    }

    #[test]
    fn the_code_is_the_rounded_effort_within_the_full_scale_and_its_volts_are_applied() {
        let stage = stage(0, 0);
        for k in -7000..=7000i16 {
            let asked = f32::from(k) / 1000.0;
            let mut state = OutputState::default();
            // The reading of the supply has no effect.
            let found = stage.apply(&mut state, asked, 17, Rise::Soft);
            let whole = (i32::from(k.abs()) * 256 + 500) / 1000;
            let code = whole.min(i32::from(MAX)) as i16 * k.signum();
            let expected = Applied {
                v: asked.clamp(-5.0, 5.0),
                v_applied: f32::from(code) * LSB,
                code,
                duty: stage.drive.duty(code),
                saturated: k.abs() > 5000,
            };
            assert_eq!(found, expected, "{asked} V");
            let remembered = OutputState {
                applied: found.v_applied,
                saturated: found.saturated,
                ..OutputState::default()
            };
            assert_eq!(state, remembered, "{asked} V");
        }
    }

    #[test]
    fn the_soft_start_lets_codes_rise_in_a_straight_line_and_tells_what_it_cuts_off() {
        for asked in [5.0, 0.75, 0.0, -0.75, -5.0, -9.0f32] {
            let (stage, mut state) = (stage(7, 0), OutputState::default());
            let full = (asked.clamp(-5.0, 5.0) / LSB) as i16;
            for tick in 0..20i16 {
                // Of 7 ticks, rounded down: 0, 182, 365, 548, 731, 914, 1097, and all of it.
                let limit =
                    if tick < 7 { (i32::from(MAX) * i32::from(tick) / 7) as i16 } else { MAX };
                let code = full.signum() * full.abs().min(limit);
                let found = stage.apply(&mut state, asked, 0, Rise::Soft);
                assert_eq!(
                    (found.code, found.duty),
                    (code, stage.drive.duty(code)),
                    "{asked} V, {tick}"
                );
                assert_eq!(
                    (found.v, found.v_applied),
                    (asked.clamp(-5.0, 5.0), f32::from(code) * LSB)
                );
                assert_eq!(found.saturated, asked.abs() > 5.0 || code != full, "{asked} V, {tick}");
                assert_eq!((state.applied, state.saturated), (found.v_applied, found.saturated));
            }
        }
    }

    #[test]
    fn a_ramp_neither_waits_for_the_soft_start_nor_uses_it_up() {
        let (stage, mut state) = (stage(4, 0), OutputState::default());
        for _ in 0..10 {
            assert_eq!(stage.apply(&mut state, 2.5, 0, Rise::Own).code, MAX / 2);
        }
        assert_eq!(
            [(); 5].map(|()| stage.apply(&mut state, 5.0, 0, Rise::Soft).code),
            [0, 320, 640, 960, MAX]
        );
    }

    #[test]
    fn half_the_supply_gets_twice_the_code_and_the_joint_the_volts_that_were_asked_for() {
        let stage = stage(0, NOMINAL);
        for asked in [0.5, 1.25, 2.5, -0.5, -1.25, -2.5] {
            let code = (asked / LSB) as i16;
            // 6 V, 12 V and 24 V of a nominal supply of 12 V.
            for (supply, scaled) in
                [(NOMINAL / 2, 2 * code), (NOMINAL, code), (2 * NOMINAL, code / 2)]
            {
                let duty = stage.drive.duty(scaled);
                let expected =
                    Applied { v: asked, v_applied: asked, code: scaled, duty, saturated: false };
                assert_eq!(once(&stage, asked, supply), expected, "{asked} V at {supply}");
            }
        }
    }

    /// 0.999 V are 255.7 codes, at any supply that the duty makes up for.
    #[test]
    fn a_motion_bounds_the_effort_at_every_supply_and_the_next_one_is_free_of_it() {
        for (nominal, supply) in
            [(0, 17), (NOMINAL, NOMINAL / 2), (NOMINAL, NOMINAL), (NOMINAL, 2 * NOMINAL - 1)]
        {
            let mut stage = stage(0, nominal);
            let applied = |stage: &OutputStage, asked| {
                let found = once(stage, asked, supply);
                (found.v_applied, found.saturated)
            };
            stage.bound_effort(0.999);
            for asked in [2.0, -2.0f32] {
                let (v, saturated) = applied(&stage, asked);
                let error = (v * asked.signum() - 0.999).abs();
                assert!(error <= 0.5 * LSB && saturated, "{v} V of {asked} at {supply}");
            }
            let (v, saturated) = applied(&stage, 0.5);
            assert!((v - 0.5).abs() <= 0.5 * LSB && !saturated, "{v} V at {supply}");
            for none in [f32::INFINITY, 9.0] {
                stage.bound_effort(none);
                let (v, saturated) = applied(&stage, 2.0);
                assert!((v - 2.0).abs() <= 0.5 * LSB && !saturated, "{v} V at {supply}");
            }
        }
    }

    #[test]
    fn a_broken_divider_is_worth_a_factor_of_two_at_most() {
        let stage = stage(0, NOMINAL);
        for asked in [1.0, -1.0f32] {
            let code = (asked / LSB) as i16;
            for (supply, scaled) in
                [(0, 2 * code), (1, 2 * code), (4095, 128), (u16::MAX, code / 2)]
            {
                let found = once(&stage, asked, supply);
                // The highest reading of the converter is 4095, not quite twice the nominal one.
                assert_eq!(found.code, scaled.abs() * code.signum(), "{supply}");
            }
            assert_eq!(once(&stage, asked, 0).v_applied, asked);
        }
    }

    #[test]
    fn a_supply_too_low_for_the_effort_is_reported_as_saturated_with_what_is_left_of_it() {
        let stage = stage(0, NOMINAL);
        for sign in [1.0, -1.0] {
            let found = once(&stage, 3.0 * sign, NOMINAL / 2);
            let full = (sign * f32::from(MAX)) as i16;
            assert_eq!((found.v, found.v_applied, found.code), (3.0 * sign, 2.5 * sign, full));
            assert!(found.saturated);
            // Beyond the full scale before it is scaled, and within it after that.
            let found = once(&stage, 6.0 * sign, 2 * NOMINAL);
            assert_eq!((found.v, found.v_applied, found.code), (5.0 * sign, 5.0 * sign, full / 2));
            assert!(found.saturated);
        }
    }

    #[test]
    fn the_soft_start_limits_the_code_after_it_was_scaled() {
        for sign in [1.0, -1.0] {
            let (stage, mut state) = (stage(2, NOMINAL), OutputState::default());
            let found =
                [(); 3].map(|()| stage.apply(&mut state, sign * 2.0, NOMINAL / 2, Rise::Soft));
            // The last code is that of 4 V, which at half of the nominal supply are 2 V at the
            // motor.
            let codes = [0, 640, 1024].map(|code| (sign * f32::from(code as i16)) as i16);
            assert_eq!(found.map(|found| found.code), codes);
            assert_eq!(found.map(|found| found.v_applied), [0.0, 1.25, 2.0].map(|v| sign * v));
            assert_eq!(found.map(|found| found.saturated), [true, true, false]);
        }
    }
}
