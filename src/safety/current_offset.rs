//! Offset and noise of the current's sensor, measured at rest with the bridge off.
//!
//! ```text
//! m_n = m + (x_n - m) / n                the offset: the mean of the readings x
//! s_n = s + (|x_n - m| - s) / (n - 1)    the noise: mean distance of a reading from that mean
//! ```
//!
//! Units are readings of the converter. Beyond 32 readings, n - 1 and n are 32. Two causes forbid
//! arming: an offset more than a twentieth of the range away from its middle, and a noise of more
//! than a fiftieth of the range, which is the smallest current that
//! [`motor_current`](super::motor_current) judges. Normal noise with a standard deviation of s' has
//! s = 0.8 s'; uniform noise of a either way has s = a / 2. With fewer than 32 readings the limit
//! of the noise is three times as large, so that a single odd reading forbids nothing.
//!
//! Does badly: four ticks at 1 ms suffice for arming, and one reading at a sample time of 4 ms or
//! more, which shows no noise. A joint that is at rest for 32 ticks has the whole of it. Noise of
//! the switching bridge is not there while it is off. In motion the noise is not judged: the
//! current itself changes from tick to tick, by as much as its law and the winding allow, and the
//! expected current is off by the tolerances of resistance and back-EMF. There, noise that has a
//! mean is a fault of [`motor_current`](super::motor_current), and a peak beyond `trip_a` turns the
//! bridge off.

/// Part of the sensor's range: the largest error of the offset.
const OFFSET: f32 = 0.05;

/// Part of the sensor's range: the largest noise.
const NOISE: f32 = 0.02;

/// Factor of that noise while fewer than 32 readings are there: of four readings with normal noise
/// at the limit, the mean distance exceeds it by a factor of 3 once in 4000 times.
const FEW: f32 = 3.0;

/// Readings at rest whose mean is the offset. Later ones replace the older ones.
const READINGS: u16 = 32;

/// Time of readings at rest without which the motor is not armed, s: one reading at least.
const CALIBRATES: f32 = 0.004;

/// Time after a motion in which the current of the winding ends, s: ten time constants of 5 ms.
const ENDS: f32 = 0.05;

/// Measurement of the offset, prepared for its ticks.
#[derive(Clone, Copy, Debug)]
pub struct CurrentOffset {
    /// Middle of the range, readings.
    middle: f32,
    /// Ticks in which the current of the winding ends.
    settles: u16,
    /// Readings at rest without which the motor is not armed.
    calibrates: u16,
}

/// Offset and noise, as far as they are known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurrentOffsetState {
    /// Mean reading without current.
    mean: f32,
    /// Mean distance from it, readings.
    noise: f32,
    /// Number of readings in them.
    readings: u16,
    /// Ticks until a reading with the bridge off counts.
    waits: u16,
}

impl CurrentOffsetState {
    /// Returns the mean reading without a current.
    #[inline]
    pub const fn mean(&self) -> f32 {
        self.mean
    }
}

impl CurrentOffset {
    /// Prepares the measurement, for a sample time in s. `top` is the largest reading of the
    /// converter.
    pub fn of(top: u16, sample_time: f32) -> Self {
        let in_ticks = |time: f32| libm::ceilf(time / sample_time) as u16;
        Self {
            middle: 0.5 * f32::from(top),
            settles: in_ticks(ENDS),
            calibrates: in_ticks(CALIBRATES).clamp(1, READINGS),
        }
    }

    /// Takes a reading with the bridge off. Those at rest count. After a motion, the readings of 50
    /// ms are skipped, in which the current of the winding ends.
    pub fn idle(&self, state: &mut CurrentOffsetState, reading: u16, is_at_rest: bool) {
        let CurrentOffsetState { mean, noise, readings, waits } = *state;
        *state = CurrentOffsetState { mean, ..CurrentOffsetState::default() };
        if waits > 0 {
            state.waits = waits - 1;
        } else if is_at_rest {
            let error = f32::from(reading) - mean;
            state.readings = (readings + 1).min(READINGS);
            state.mean += error / f32::from(state.readings);
            if readings > 0 {
                state.noise = noise + (error.abs() - noise) / f32::from(readings);
            }
        }
    }

    /// Takes a tick with the bridge on, which ends the measurement.
    #[inline]
    pub const fn drive(&self, state: &mut CurrentOffsetState) {
        (state.readings, state.waits) = (0, self.settles);
    }

    /// Returns whether the offset is known: the mean of a few readings at rest.
    pub const fn is_known(&self, state: &CurrentOffsetState) -> bool {
        state.readings >= self.calibrates
    }

    /// Returns whether offset or noise forbid arming.
    pub fn is_off(&self, state: &CurrentOffsetState) -> bool {
        let error = state.mean - self.middle;
        let most = if state.readings < READINGS { FEW * NOISE } else { NOISE };
        error.abs() > OFFSET * self.middle || state.noise > most * self.middle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOP: u16 = 4095;

    fn at_rest(readings: impl IntoIterator<Item = u16>) -> (CurrentOffset, CurrentOffsetState) {
        let (offset, mut state) = (CurrentOffset::of(TOP, 0.001), CurrentOffsetState::default());
        readings.into_iter().for_each(|reading| offset.idle(&mut state, reading, true));
        (offset, state)
    }

    #[test]
    fn the_offset_is_the_mean_of_readings_at_rest_and_none_of_them_has_the_current_of_a_motion() {
        let (offset, mut state) = at_rest([]);
        offset.idle(&mut state, 3000, false);
        for (number, reading) in [(1, 2040), (2, 2060), (3, 2050), (4, 2050)] {
            assert!(!offset.is_known(&state));
            offset.idle(&mut state, reading, true);
            assert_eq!(state.readings, number);
        }
        assert!(state.mean == 2050.0 && offset.is_known(&state));
        // Noise of four readings either way is averaged to less than one.
        for tick in 0..320u16 {
            offset.idle(&mut state, 2046 + tick % 9, true);
        }
        assert!((state.mean - 2050.0).abs() < 1.0, "{}", state.mean);
        // A joint that held a load at rest: the current ends within 50 ms.
        offset.drive(&mut state);
        for tick in 0..50 {
            offset.idle(&mut state, 3500 - 29 * tick, true);
            assert!((state.mean - 2050.0).abs() < 1.0 && !offset.is_known(&state));
        }
        (0..4).for_each(|_| offset.idle(&mut state, 2052, true));
        assert!(state.mean == 2052.0 && offset.is_known(&state));
    }

    #[test]
    fn an_offset_off_the_middle_and_a_reading_at_the_end_forbid_arming() {
        // A twentieth of 2047.5 readings is 102.4.
        for (reading, expected) in
            [(1946, false), (1944, true), (2149, false), (2151, true), (0, true), (4095, true)]
        {
            let (offset, state) = at_rest([reading; 50]);
            assert_eq!(offset.is_off(&state), expected, "{reading}");
        }
    }

    /// A fiftieth of 2047.5 readings is 40.95. Readings of a square wave are its amplitude away
    /// from their mean, with a ripple of a part in 32 of it; those of a ramp over 2 a, a / 2.
    #[test]
    fn noise_of_a_fiftieth_of_the_range_forbids_arming_and_a_smaller_one_does_not() {
        for (amplitude, expected) in [(4, false), (36, false), (44, true), (100, true)] {
            let square = (0..200).map(|tick| 2048 + amplitude - 2 * amplitude * (tick % 2));
            let (offset, state) = at_rest(square);
            assert!((state.noise / f32::from(amplitude) - 1.0).abs() < 0.05, "{}", state.noise);
            assert_eq!(offset.is_off(&state), expected, "{amplitude}");
        }
        for (amplitude, expected) in [(60, false), (105, true)] {
            // 37 has no factor in common with the number of values.
            let scattered = (0..400).map(|tick| 2048 - amplitude + 37 * tick % (2 * amplitude));
            let (offset, state) = at_rest(scattered);
            let noise = state.noise / (0.5 * f32::from(amplitude));
            assert!((noise - 1.0).abs() < 0.15, "{noise}");
            assert_eq!(offset.is_off(&state), expected, "{amplitude}");
        }
    }

    /// 4 ms are 40 readings there, more than the mean has.
    #[test]
    fn the_offset_is_known_at_the_shortest_sample_time() {
        let (offset, mut state) = (CurrentOffset::of(TOP, 1e-4), CurrentOffsetState::default());
        (0..32).for_each(|_| offset.idle(&mut state, 2048, true));
        assert!(offset.is_known(&state) && !offset.is_off(&state));
    }

    /// Two readings at 2 ms are those of an arming: their distance is the noise, up to 122.85.
    #[test]
    fn the_first_readings_after_a_motion_show_the_noise_and_the_old_offset_is_none() {
        let (offset, mut state) = at_rest([2040; 40]);
        offset.drive(&mut state);
        (0..50).for_each(|_| offset.idle(&mut state, 0, true));
        offset.idle(&mut state, 2000, true);
        assert!(!offset.is_off(&state) && state.noise == 0.0);
        offset.idle(&mut state, 2122, true);
        assert!(!offset.is_off(&state) && state.noise == 122.0);
        offset.drive(&mut state);
        (0..50).for_each(|_| offset.idle(&mut state, 0, true));
        offset.idle(&mut state, 2000, true);
        offset.idle(&mut state, 2124, true);
        assert!(offset.is_off(&state) && state.noise == 124.0);
    }
}
