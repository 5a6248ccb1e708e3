//! The rest detector: the joint rests while its counts stay at an anchor.
//!
//! With the anchor `y_a`, the ticks at rest `n_z` and their mean `y_b`:
//!
//! ```text
//! |y - y_a| > (n_j + 0.1) q: y_a = y_b = y,   n_z = 0
//! otherwise:                 n_z += 1,        y_b += (y - y_b) / min(n_z + 1, 32)
//! ```
//!
//! Why this form: a speed that is computed from counts is a difference of whole numbers, and shows
//! nothing below a count per tick. Counts that stay show rest. The jitter `n_j` is the number of
//! counts that the encoder changes by although the joint rests. The tenth of a count is for
//! positions that are rounded. The mean over the rest removes most of the jitter from the position:
//! it is the mean of the last ticks, with a memory of 32.
//!
//! Guarantees: `n_z` is zero in every tick in which the joint left its anchor. The mean is within
//! `n_j + 0.1` counts of the anchor. Does badly: a joint that creeps by a count in more than `N_z`
//! ticks seems to rest between two counts.

/// Ticks that the mean remembers.
const MEMORY: u16 = 32;

/// Rest detector, with the largest distance from the anchor at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestDetector {
    band: f32,
}

/// The rest as of the last tick; positions are from the law's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rest {
    /// Anchor y_a.
    pub anchor: f32,
    /// Mean of the positions since the joint came to rest, y_b.
    pub mean: f32,
    /// Ticks since the joint came to rest, n_z.
    pub ticks: u16,
}

impl RestDetector {
    /// Makes a detector for an encoder with a jitter in counts, and the angle of a count.
    pub fn new(jitter: f32, count: f32) -> Self {
        Self { band: (jitter + 0.1) * count }
    }

    /// Updates the rest with the position of a tick, from the origin.
    #[inline]
    pub fn update(&self, rest: &mut Rest, position: f32) {
        if (position - rest.anchor).abs() > self.band {
            *rest = Rest { anchor: position, mean: position, ticks: 0 };
        } else {
            rest.ticks = rest.ticks.saturating_add(1);
            let ticks = rest.ticks.saturating_add(1).min(MEMORY);
            rest.mean += (position - rest.mean) / f32::from(ticks);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(jitter: f32, positions: &[f32]) -> Rest {
        let (detector, mut rest) = (RestDetector::new(jitter, 1.0), Rest::default());
        positions.iter().for_each(|position| detector.update(&mut rest, *position));
        rest
    }

    #[test]
    fn a_count_ends_the_rest_and_becomes_the_anchor() {
        assert_eq!(after(0.0, &[0.0; 5]).ticks, 5);
        let moved = after(0.0, &[0.0, 0.0, 0.0, 1.0]);
        assert_eq!(moved, Rest { anchor: 1.0, mean: 1.0, ticks: 0 });
        assert_eq!(after(0.0, &[1.0, 1.0, 1.0]).ticks, 2);
    }

    #[test]
    fn jitter_of_as_many_counts_as_declared_is_rest_and_one_more_is_not() {
        assert_eq!(after(2.0, &[0.0, 2.0, -2.0, 1.0]).ticks, 4);
        assert_eq!(after(2.0, &[0.0, 2.0, -2.0, 3.0]).ticks, 0);
    }

    #[test]
    fn mean_is_that_of_all_positions_since_the_anchor() {
        // The anchor counts as one of them: (0 + 1 + 2 + 1) / 4.
        assert!((after(2.0, &[1.0, 2.0, 1.0]).mean - 1.0).abs() < 1e-6);
        // After a long rest, old positions fade: ten ticks later their weight is (31/32)^10.
        let mut positions = [0.0; 60];
        positions[50..].fill(1.0);
        let expected = 1.0 - (31f32 / 32.0).powi(10);
        assert!((after(2.0, &positions).mean - expected).abs() < 1e-5);
    }

    #[test]
    fn the_count_of_ticks_does_not_wrap() {
        let (detector, mut rest) = (RestDetector::new(0.0, 1.0), Rest::default());
        rest.ticks = u16::MAX;
        detector.update(&mut rest, 0.0);
        assert_eq!(rest.ticks, u16::MAX);
    }
}
