//! The current loop: PI control of the motor's current at the rate of the PWM, inside the position
//! loop.
//!
//! ```text
//! e = u* - R i                     u*: effort of the position loop, V; R i: measured current
//! u = sat(k_e v + c (e + I))       k_e v: back-EMF at the speed of the last tick
//! I <- I + (1 - a) ((u - k_e v) / c - I)      without a limit: I + (1 - a) e
//! a = exp(-T R / L),  c = g T / (1 - a),  r = sqrt(a)
//! g = w_b / (m (s + sqrt(s^2 + 1))),  s = sin(w_b D),  D = T / 2 + T r / (1 + r)
//! m = 1 - (w_b T / 2)^2 (2 r / (1 + r)^2 - 1 / 6)
//! ```
//!
//! The effort stays in volts: 1 V is the current that 1 V causes through the configured resistance
//! at standstill. So a gain or a limit means the same force with a current loop and without one,
//! and the current does not depend on supply, speed and temperature of the winding.
//!
//! The zero of the PI cancels the pole of the winding `a` (internal model control; Harnefors and
//! Nee, IEEE Trans. Ind. Appl. 34 (1998) 133). What is left is `m g exp(-j w D) / (j w)`: the
//! current is sampled at the upper end of the PWM's count, its duty acts from the lower end on,
//! half a period later, and is held for a period. `g` is the gain at which the closed loop has lost
//! 3 dB at the configured bandwidth `w_b`: `|1 + j w_b / (m g) exp(j w_b D)|^2 = 2`.
//!
//! `c I` is the voltage across the resistance of a model of the winding, which gets the limited
//! voltage. So a limit leaves nothing behind, and there is no other anti-windup.
//!
//! Guarantees: with the configured R and L, the bandwidth is within a tenth of the configured one
//! and a step overshoots by less than a tenth, up to a tenth of the PWM's frequency. Does badly: an
//! L of half the configured one doubles the gain of the loop. Beyond the voltage of the supply, the
//! current is what the voltage allows.

use crate::control::current_sensor::CurrentSensor;
use crate::control::drive::{Drive, DriveConfig, Duty};
use crate::units::saturation::saturate;

/// Highest bandwidth, as a part of the PWM's frequency. Beyond it, the delay lets a step overshoot.
pub const FASTEST: f32 = 0.1;

/// Returns the number of the PWM's periods in a sample time, for a sample time in clocks of the
/// PWM's timer and the compare value of full duty. The control tick is then always at the same
/// phase of the PWM, between the conversion of the current and the next one.
///
/// # Errors
/// If it is no whole number, returns the nearest number for which a frequency exists; zero: none.
pub fn periods(sample_clocks: u32, top: u16) -> Result<u32, u32> {
    let period = 2 * u32::from(top);
    if period > 0 && sample_clocks.is_multiple_of(period) {
        return Ok(sample_clocks / period);
    }
    // A top is even, so a period is a multiple of four clocks.
    let whole = if sample_clocks.is_multiple_of(4) { sample_clocks / 4 } else { 0 };
    let near = sample_clocks.checked_div(period).unwrap_or(0);
    let divides = |number: &u32| period > 0 && whole > 0 && whole.is_multiple_of(*number);
    let fewer = (1..=near).rev().find(divides);
    let more = (near + 1..=2 * near + 1).find(divides);
    let distance = |number: &u32| sample_clocks.abs_diff(number * period);
    Err(fewer.into_iter().chain(more).min_by_key(distance).unwrap_or(0))
}

/// Command of the position loop for the current loop. It fits one word, so that an interrupt takes
/// all of it at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CurrentTarget {
    /// Code of the effort: that of the voltage across the resistance.
    pub effort: i16,
    /// Code of the back-EMF.
    pub induced: i16,
}

impl CurrentTarget {
    /// Returns the target as one word.
    #[inline]
    pub const fn pack(self) -> u32 {
        (self.effort as u16 as u32) << 16 | self.induced as u16 as u32
    }

    /// Returns the target of a word.
    #[inline]
    pub const fn unpack(word: u32) -> Self {
        Self { effort: (word >> 16) as i16, induced: word as i16 }
    }
}

/// A current loop, prepared for its periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentLoop {
    drive: Drive,
    /// Volts of one code.
    lsb: f32,
    /// Largest code that it puts out.
    most: f32,
    /// Voltage across the resistance of a reading, codes.
    codes: f32,
    /// Reading without a current.
    offset: f32,
    /// Gain c of the error, 1 / c, and 1 - a.
    gain: f32,
    per_gain: f32,
    share: f32,
}

/// The state of a current loop from period to period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurrentLoopState {
    /// Integral I, codes.
    integral: f32,
}

impl CurrentLoopState {
    /// State before the first period.
    pub const NONE: Self = Self { integral: 0.0 };
}

impl CurrentLoop {
    /// Prepares the loop of a sensor and a drive, which have been validated. `unit` is the current
    /// of a reading of the converter, A, with the sign of the sensor's direction.
    pub fn new(sensor: &CurrentSensor, unit: f32, drive: &DriveConfig, prepared: Drive) -> Self {
        let CurrentSensor { resistance, inductance, bandwidth, .. } = *sensor;
        let period = 1.0 / drive.pwm_hz;
        let decay = libm::expf(-period * resistance / inductance);
        let angle = core::f32::consts::TAU * bandwidth * period;
        let root = libm::sqrtf(decay);
        let delay = angle * (0.5 + root / (1.0 + root));
        // The sine, to a thousandth of it up to 0.63: a tenth of the PWM's frequency.
        let sine = delay * (1.0 - delay * delay / 6.0);
        let sum = 1.0 + root;
        let held = 1.0 - 0.25 * angle * angle * (2.0 * root / (sum * sum) - 1.0 / 6.0);
        let integrated = angle / (held * (sine + libm::sqrtf(sine * sine + 1.0)));
        let gain = integrated / (1.0 - decay);
        Self {
            drive: prepared,
            lsb: drive.lsb,
            most: libm::floorf(drive.duty_max * f32::from(prepared.max_code())),
            codes: unit * resistance / drive.lsb,
            offset: 0.0,
            gain,
            per_gain: 1.0 / gain,
            share: 1.0 - decay,
        }
    }

    /// Returns the compare value of full duty.
    pub const fn top(&self) -> u16 {
        self.drive.pwm_top()
    }

    /// Returns the voltage of a code, V.
    pub fn volts(&self, code: i16) -> f32 {
        f32::from(code) * self.lsb
    }

    /// Returns the loop for a sensor that has this reading without a current.
    #[must_use]
    pub const fn with_offset(self, offset: f32) -> Self {
        Self { offset, ..self }
    }

    /// Runs one period: returns the code of the voltage for a target and a reading of the current.
    #[inline]
    pub fn step(&self, state: &mut CurrentLoopState, target: CurrentTarget, reading: u16) -> i16 {
        let measured = (f32::from(reading) - self.offset) * self.codes;
        let error = f32::from(target.effort) - measured;
        let induced = f32::from(target.induced);
        let (limited, _) = saturate(induced + self.gain * (error + state.integral), self.most);
        let modelled = (limited - induced) * self.per_gain;
        state.integral += self.share * (modelled - state.integral);
        (limited + if limited < 0.0 { -0.5 } else { 0.5 }) as i16
    }

    /// Returns the PWM setting of a code.
    #[inline]
    pub fn duty(&self, code: i16) -> Duty {
        self.drive.duty_of(code.into())
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;
    use crate::control::drive::PwmMode;
    use crate::control::hardware::Hardware;

    const HARDWARE: Hardware = Hardware {
        pwm_clock_hz: 168e6,
        supply_top: 4095,
        dead_time_max: 6e-6,
        sample_time: [1e-4, 0.02],
    };
    const PWM_HZ: f64 = 21e3;
    const LSB: f64 = 24.0 / 32_000.0;
    /// Current of a reading, A.
    const UNIT: f64 = 2e-3;
    const OHM: f64 = 2.0;

    fn drive() -> DriveConfig {
        DriveConfig {
            full_scale: 24.0,
            lsb: LSB as f32,
            pwm_hz: PWM_HZ as f32,
            mode: PwmMode::LockedAntiphase,
            duty_max: 1.0,
        }
    }

    fn current_loop(tau_s: f64, bandwidth: f32, of: DriveConfig) -> CurrentLoop {
        let winding = [OHM as f32, (OHM * tau_s) as f32];
        let sensor = CurrentSensor { bandwidth, ..CurrentSensor::derived(4.095, winding) };
        let prepared = Drive::new(&of, &HARDWARE).unwrap();
        CurrentLoop::new(&sensor, UNIT as f32, &of, prepared).with_offset(2047.5)
    }

    /// A winding behind a bridge, in closed form from half period to half period.
    struct Winding {
        tau_s: f64,
        ohm: f64,
        induced_v: f64,
        current_a: f64,
        code: i16,
        state: CurrentLoopState,
    }

    impl Winding {
        fn at_rest(tau_s: f64) -> Self {
            let state = CurrentLoopState::default();
            Self { tau_s, ohm: OHM, induced_v: 0.0, current_a: 0.0, code: 0, state }
        }

        fn half(&mut self) {
            let settled = (f64::from(self.code) * LSB - self.induced_v) / self.ohm;
            let decay = (-0.5 / PWM_HZ / self.tau_s).exp();
            self.current_a = settled + (self.current_a - settled) * decay;
        }

        /// Runs one period, from the lower end of the count to the next one. Returns the current at
        /// the upper end, A.
        fn period(&mut self, of: &CurrentLoop, target: CurrentTarget) -> f64 {
            self.half();
            let sampled = self.current_a;
            let reading = (2047.5 + sampled / UNIT).round().clamp(0.0, 4095.0) as u16;
            let code = of.step(&mut self.state, target, reading);
            self.half();
            self.code = code;
            sampled
        }
    }

    /// The response of the current to a step of the target by `effort` codes, as shares of it.
    fn step(of: &CurrentLoop, mut winding: Winding, effort: i16) -> [f64; 1500] {
        let target = CurrentTarget { effort, induced: 0 };
        let full = f64::from(effort) * LSB / OHM;
        [(); 1500].map(|()| winding.period(of, target) / full)
    }

    /// Loss of the closed loop at a frequency, dB: the Fourier sum of its response to an impulse.
    fn loss_db(response: &[f64], hz: f64) -> f64 {
        let (mut re, mut im, mut before) = (0.0, 0.0, 0.0);
        for (n, share) in response.iter().enumerate() {
            let angle = TAU * hz * n as f64 / PWM_HZ;
            re += (share - before) * angle.cos();
            im -= (share - before) * angle.sin();
            before = *share;
        }
        -10.0 * (re * re + im * im).log10()
    }

    #[test]
    fn bandwidth_and_overshoot_are_those_of_the_design_up_to_a_tenth_of_the_pwm() {
        for tau_s in [5e-5, 2e-4, 1e-3, 5e-3] {
            for bandwidth in [200.0, 1000.0, 2100.0f32] {
                let of = current_loop(tau_s, bandwidth, drive());
                let response = step(&of, Winding::at_rest(tau_s), 1000);
                let [low, high] =
                    [0.9, 1.1].map(|share| loss_db(&response, share * f64::from(bandwidth)));
                assert!(
                    low < 3.01 && high > 3.01,
                    "{tau_s} s, {bandwidth} Hz: {low} dB, {high} dB"
                );
                let most = response.iter().copied().fold(0.0, f64::max);
                assert!(most < 1.1, "{tau_s} s, {bandwidth} Hz: {most}");
                let settled = response[1000..].iter().all(|share| (share - 1.0).abs() < 0.01);
                assert!(settled, "{tau_s} s, {bandwidth} Hz");
            }
        }
    }

    /// R of 0.7 to 1.4 and an L of 0.7 to 1.4 of the configured ones, and a supply of 0.8 and 1.2.
    #[test]
    fn the_settled_current_does_not_depend_on_winding_supply_and_speed() {
        for (ohm, henry, supply, induced_v) in [
            (1.4, 1.4, 0.8, 3.0),
            (0.7, 0.7, 1.2, -3.0),
            (1.4, 0.7, 1.2, 0.0),
            (1.0, 1.0, 1.0, 6.0),
        ] {
            // A supply that is off scales the volts of a code, and so does a divided winding.
            let of = current_loop(1e-3, 1000.0, drive());
            let mut winding = Winding::at_rest(1e-3 * henry / ohm);
            (winding.ohm, winding.induced_v) = (OHM * ohm / supply, induced_v / supply);
            let target = CurrentTarget { effort: 2000, induced: (0.7 * induced_v / LSB) as i16 };
            let currents = [(); 600].map(|()| winding.period(&of, target));
            let expected = 2000.0 * LSB / OHM;
            for current in &currents[400..] {
                assert!((current - expected).abs() < 2.0 * UNIT, "{current} A, not {expected}");
            }
            let most = currents.iter().copied().fold(0.0, f64::max);
            assert!(most < 1.3 * expected, "{most} A");
        }
    }

    #[test]
    fn a_speed_that_the_tick_knows_causes_no_current_at_the_start() {
        let of = current_loop(1e-3, 1000.0, drive());
        let mut winding = Winding::at_rest(1e-3);
        winding.induced_v = 12.0;
        // The bridge turns on at the duty of the back-EMF.
        let induced = (12.0 / LSB) as i16;
        winding.code = induced;
        for _ in 0..100 {
            let current = winding.period(&of, CurrentTarget { effort: 0, induced });
            assert!(current.abs() <= UNIT, "{current} A");
        }
    }

    /// The cap of the duty leaves 6 V, 3 A: 4 A are out of reach for 0.5 s.
    #[test]
    fn a_current_out_of_reach_is_left_at_once_when_the_target_comes_back() {
        let capped = DriveConfig { duty_max: 0.25, ..drive() };
        let of = current_loop(1e-3, 1000.0, capped);
        let mut winding = Winding::at_rest(1e-3);
        let code = |ampere: f64| (ampere * OHM / LSB) as i16;
        for ampere in [4.0, -4.0] {
            let far = CurrentTarget { effort: code(ampere), induced: 0 };
            let last = (0..10_500).fold(0.0, |_, _| winding.period(&of, far));
            assert!((last.abs() - 3.0).abs() < 2.0 * UNIT && last * ampere > 0.0, "{last} A");
            let near = CurrentTarget { effort: code(0.5 * ampere), induced: 0 };
            // As long as a step within reach takes: five time constants of 1 kHz, and the delay.
            let last = (0..25).fold(0.0, |_, _| winding.period(&of, near));
            assert!((last - 0.5 * ampere).abs() < 0.05, "{last} A");
        }
    }

    /// 168 MHz: 1 ms are 168 000 clocks, and 21 kHz have a top of 4000.
    #[test]
    fn a_sample_time_has_a_whole_number_of_periods_or_the_nearest_number_is_named() {
        for (clocks, top, expected) in [
            (168_000, 4000, Ok(21)),
            (168_000, 4200, Ok(20)),
            // 22.001 kHz: 42 000 is a multiple of 21, and not of 22.
            (168_000, 3818, Err(21)),
            // 22.3 and 22.9 kHz.
            (168_000, 3766, Err(21)),
            (168_000, 3668, Err(24)),
            (16_800, 3818, Err(2)),
            // No top is even in 1 ms and a clock.
            (168_001, 4000, Err(0)),
            (168_000, 0, Err(0)),
        ] {
            assert_eq!(periods(clocks, top), expected, "{clocks} of {top}");
        }
    }

    #[test]
    fn a_target_survives_its_word_and_codes_are_rounded_half_away_from_zero() {
        for effort in [i16::MIN, -1, 0, 1, i16::MAX] {
            for induced in [i16::MIN, -1, 0, 1, i16::MAX] {
                let target = CurrentTarget { effort, induced };
                assert_eq!(CurrentTarget::unpack(target.pack()), target);
            }
        }
        let mut of = current_loop(1e-3, 1000.0, drive());
        (of.gain, of.codes) = (0.5, 0.0);
        let code = |effort| {
            let target = CurrentTarget { effort, induced: 0 };
            of.step(&mut CurrentLoopState::default(), target, 0)
        };
        assert_eq!([code(1), code(-1), code(2), code(-3)], [1, -1, 1, -2]);
    }
}
