//! The limit of the motor's current by the effort: the duty is folded back before the current trips
//! the drive.
//!
//! ```text
//! -g_- R i_peak <= u - e <= g_+ R i_peak       the efforts that can cause i_peak; e = k_e v
//! g_+ <- g_+ i_peak / i        if i > i_peak   measured: the winding is colder than configured
//! g_+ <- g_+ + (1 - g_+) h / T else            T = 0.5 s; 0.1 <= g_+ <= 1; g_- alike for -i
//! ```
//!
//! The effort is limited around the back-EMF k_e v, so a braking motor has the same limit: full
//! reverse effort at speed would cause up to twice the stall current. At a speed with `k_e v > R
//! i_peak` even no effort brakes too hard, and both bounds are on one side of zero. Such a bound
//! drives the motor if k_e or the speed is wrong, so the measured current has to confirm it: `e` is
//! then `u - R i` of the last tick, where that allows more.
//!
//! Guarantees: the settled current of a motor with the configured resistance or more is within
//! i_peak. Does badly: a winding of less resistance exceeds the limit for some milliseconds, and
//! once or twice a second again, by a fiftieth at 10 ms. Behind a winding of 5 ms it falls by a
//! quarter at first, since the current follows late. The limit acts once a tick: it does not see a
//! current that rises and falls between two ticks, for which the converter's watchdog is. If k_e v
//! is off by more than twice R i_peak, no effort within the bounds has a current within the limit.

use crate::control::current_sensor::{CurrentSensor, Driven};

/// Largest current beside the limited effort, as a part of the limit: the overshoot of a current
/// loop is below a tenth, and noise adds to it.
const BEYOND: f32 = 1.25;

/// Time in which a limit that was lowered by the measured current rises again, s.
const RISE: f32 = 0.5;

/// Smallest factor of the limit: that of a winding with a tenth of the configured resistance. A
/// sensor that reads too much must not take all effort.
const LEAST: f32 = 0.1;

/// The limit of the effort by the current.
#[derive(Clone, Copy, Debug)]
pub struct CurrentLimit {
    /// Largest current, A.
    peak: f32,
    /// Resistance, ohm, and the voltage across it at that current, V.
    resistance: f32,
    volts: f32,
    /// Back-EMF of a speed of one deg/s, V.
    back_emf: f32,
    /// Part of the way back to the whole limit in a tick.
    share: f32,
    /// Smallest factor of the limit.
    least: f32,
}

/// The state of the limit from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentLimitState {
    /// Factors g_- and g_+ of the limit.
    factors: [f32; 2],
}

impl Default for CurrentLimitState {
    fn default() -> Self {
        Self { factors: [1.0; 2] }
    }
}

impl CurrentLimit {
    /// Returns the limit of a sensor, for a back-EMF (V s/deg) and a sample time (s); none if the
    /// current is not limited.
    pub fn of(sensor: &CurrentSensor, back_emf: f32, sample_time: f32) -> Option<Self> {
        (sensor.is_there() && sensor.peak > 0.0).then(|| Self {
            peak: sensor.peak,
            resistance: sensor.resistance,
            volts: sensor.peak * sensor.resistance,
            back_emf,
            share: (sample_time / RISE).min(1.0),
            least: LEAST,
        })
    }

    /// Returns the limit of the target of a current loop, which holds it by itself: it depends on
    /// neither speed nor measured current.
    #[must_use]
    pub fn of_target(self) -> Self {
        Self { back_emf: 0.0, least: 1.0, ..self }
    }

    /// Returns whether a current, A, is beyond what the limit lets through, either way.
    pub fn is_beyond(&self, current: f32) -> bool {
        current.abs() > BEYOND * self.peak
    }

    /// Returns the lowest and the highest effort of a tick, V, at a measured current (A), after
    /// what the last tick has done.
    #[inline]
    pub fn bounds(&self, state: &mut CurrentLimitState, current: f32, driven: &Driven) -> [f32; 2] {
        let [back, forth] = state.factors;
        state.factors = [self.next(back, -current), self.next(forth, current)];
        let induced = self.back_emf * driven.speed;
        let [back, forth] = state.factors.map(|factor| factor * self.volts);
        let confirmed = driven.effort - current * self.resistance;
        let (mut low, mut high) = (induced - back, induced + forth);
        if low > 0.0 && confirmed < induced {
            low = confirmed - back;
        }
        if high < 0.0 && confirmed > induced {
            high = confirmed + forth;
        }
        [low, high]
    }

    /// Returns the factor of a tick after `factor`, for a current (A) in its direction.
    fn next(&self, factor: f32, current: f32) -> f32 {
        if current > self.peak {
            (factor * self.peak / current).max(self.least)
        } else {
            factor + (1.0 - factor) * self.share
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4 A through 2 ohm; 0.05 V s/deg, 1 ms.
    fn limit() -> CurrentLimit {
        let sensor = CurrentSensor { peak: 4.0, ..CurrentSensor::derived(10.0, [2.0, 0.0]) };
        CurrentLimit::of(&sensor, 0.05, 0.001).unwrap()
    }

    /// What a tick with an effort (V) has done, at a speed of the joint (deg/s).
    fn after(effort: f32, speed: f32) -> Driven {
        Driven { effort, target: effort, speed, supply: 1.0, travel: 0 }
    }

    const STANDS: Driven = Driven { effort: 0.0, target: 0.0, speed: 0.0, supply: 1.0, travel: 0 };

    #[test]
    fn an_effort_at_its_bound_causes_the_limit_of_the_current_at_every_speed() {
        for speed in [-200.0, -10.0, 0.0, 10.0, 200.0f32] {
            let driven = after(0.05 * speed, speed);
            let bounds = limit().bounds(&mut CurrentLimitState::default(), 0.0, &driven);
            let currents = bounds.map(|u| (u - 0.05 * speed) / 2.0);
            assert!((currents[0] + 4.0).abs() < 1e-5 && (currents[1] - 4.0).abs() < 1e-5);
        }
    }

    /// The winding has 0.7 of its resistance: the settled current is u / 1.4 ohm.
    #[test]
    fn the_measured_current_corrects_a_resistance_that_is_too_high() {
        for sign in [1.0, -1.0f32] {
            let (limit, mut state) = (limit(), CurrentLimitState::default());
            let (mut current, mut over) = (0.0f32, 0);
            for tick in 0..2000 {
                let [low, high] = limit.bounds(&mut state, current, &STANDS);
                current = if sign > 0.0 { high } else { low } / 1.4;
                if tick == 0 {
                    assert!((current.abs() - 4.0 / 0.7).abs() < 1e-4, "{current}");
                } else {
                    over += u32::from(current.abs() > 4.0);
                    // It rises by (1 - 0.7) / 500 of itself in a tick.
                    assert!(current.abs() < 4.0 * 1.001, "{tick}: {current}");
                    assert!(current.abs() > 4.0 * 0.998, "{tick}: {current}");
                }
            }
            assert!(over < 1200, "{over}");
        }
    }

    /// At 100 deg/s 5 V are induced, and 6.25 V are configured: without measured current the lowest
    /// effort is -1.75 V, and the highest 14.25 V, 4.6 A.
    #[test]
    fn a_back_emf_that_is_too_high_leaves_a_current_within_the_limit() {
        let sensor = CurrentSensor { peak: 4.0, ..CurrentSensor::derived(10.0, [2.0, 0.0]) };
        let limit = CurrentLimit::of(&sensor, 0.0625, 0.001).unwrap();
        let (mut state, mut current, mut effort) = (CurrentLimitState::default(), 0.0, 5.0);
        for tick in 0..1000 {
            let driven = after(effort, 100.0);
            let [low, high] = limit.bounds(&mut state, current, &driven);
            assert!(low < 0.0, "a law can still brake");
            (current, effort) = ((high - 5.0) / 2.0, high);
            assert!(tick < 3 || current < 4.01, "{tick}: {current} A");
        }
    }

    /// At 400 deg/s 20 V are induced, and 30 V are configured: 8 V across the resistance would
    /// leave a lowest effort of 22 V, which drives the motor on by 1 A.
    #[test]
    fn a_back_emf_that_is_far_too_high_leaves_the_brake() {
        for sign in [1.0, -1.0f32] {
            let sensor = CurrentSensor { peak: 4.0, ..CurrentSensor::derived(10.0, [2.0, 0.0]) };
            let limit = CurrentLimit::of(&sensor, 0.075, 0.001).unwrap();
            let (mut state, mut effort) = (CurrentLimitState::default(), sign * 20.0);
            // The law asks for the largest brake.
            for tick in 0..1000 {
                let current = (effort - sign * 20.0) / 2.0;
                let driven = after(effort, sign * 400.0);
                let [low, high] = limit.bounds(&mut state, current, &driven);
                effort = if sign > 0.0 { low } else { high };
                // The settled current is the limit, within its rise of a thousandth a tick.
                let brakes = sign * (sign * 20.0 - effort) / 2.0;
                assert!((3.9..4.01).contains(&brakes), "{tick}: {effort} V, {brakes} A");
            }
        }
    }

    /// Noise of the encoder looks like 400 deg/s of a joint that stands: 20 V would be induced.
    #[test]
    fn a_speed_that_is_none_does_not_drive_the_motor() {
        let (limit, mut state) = (limit(), CurrentLimitState::default());
        let mut effort = 0.0;
        for _ in 0..1000 {
            let [low, _] = limit.bounds(&mut state, effort / 2.0, &after(effort, 400.0));
            effort = low;
            assert!((-8.01..=-7.9).contains(&effort), "{effort} V");
        }
    }

    /// The time constant of the winding is 5 ms, and it has 0.7 of its resistance.
    #[test]
    fn behind_a_slow_winding_the_limit_falls_by_a_quarter_at_most_and_comes_back() {
        for sample_time in [1e-4, 1e-3] {
            let sensor = CurrentSensor { peak: 4.0, ..CurrentSensor::derived(10.0, [2.0, 0.0]) };
            let limit = CurrentLimit::of(&sensor, 0.05, sample_time).unwrap();
            let (mut state, mut current) = (CurrentLimitState::default(), 0.0f32);
            let decay = (-sample_time / 0.005).exp();
            let (mut most, mut least) = (0.0f32, f32::INFINITY);
            for tick in 0..(0.5 / sample_time) as u32 {
                let [_, high] = limit.bounds(&mut state, current, &STANDS);
                current = high / 1.4 + (current - high / 1.4) * decay;
                most = most.max(current);
                if tick as f32 * sample_time > 0.02 {
                    least = least.min(current);
                }
            }
            assert!(most < 4.6 && least > 3.0, "{sample_time} s: {most} A, {least} A");
            assert!((3.9..4.1).contains(&current), "{sample_time} s: {current} A");
        }
    }

    #[test]
    fn a_sensor_that_reads_too_much_leaves_a_tenth_of_the_effort_and_the_rest_comes_back() {
        let (limit, mut state) = (limit(), CurrentLimitState::default());
        for _ in 0..100 {
            limit.bounds(&mut state, 1e6, &STANDS);
        }
        let [low, high] = limit.bounds(&mut state, 1e6, &STANDS);
        // A current one way does not limit the effort the other way.
        assert!(low == -8.0 && (high - 0.8).abs() < 1e-6, "{low}, {high}");
        // 1 - 0.9 exp(-t / 0.5 s) after 1 s.
        for _ in 0..1000 {
            limit.bounds(&mut state, 0.0, &STANDS);
        }
        let expected = 8.0 * (1.0 - 0.9 * (-2.0f32).exp());
        let [_, high] = limit.bounds(&mut state, 0.0, &STANDS);
        assert!((high / expected - 1.0).abs() < 2e-3, "{high}, not {expected}");
    }

    #[test]
    fn the_target_of_a_current_loop_has_a_limit_that_neither_speed_nor_current_change() {
        let (limit, mut state) = (limit().of_target(), CurrentLimitState::default());
        for (current, speed) in [(0.0, 0.0), (9.0, 0.0), (-9.0, 400.0), (4.0, -400.0)] {
            let bounds = limit.bounds(&mut state, current, &after(8.0, speed));
            assert_eq!(bounds, [-8.0, 8.0], "{current} A, {speed} deg/s");
        }
    }

    #[test]
    fn a_current_without_a_limit_or_a_sensor_bounds_no_effort() {
        let off = CurrentSensor { peak: 0.0, ..CurrentSensor::derived(10.0, [2.0, 0.0]) };
        assert!(CurrentLimit::of(&off, 0.05, 0.001).is_none());
        assert!(CurrentLimit::of(&CurrentSensor::NONE, 0.05, 0.001).is_none());
    }
}
