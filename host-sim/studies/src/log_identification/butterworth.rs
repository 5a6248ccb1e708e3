//! A low-pass without phase: Butterworth of the fourth order, forward and backward.
//!
//! ```text
//! |H(f)|^2 of one pass = 1/(1 + (tan(pi f/fs)/tan(pi fc/fs))^8)   both passes: gain |H|^2, phase 0
//! ```
//!
//! Source: S. Butterworth, *Wireless Engineer* 7 (1930), 536; the bilinear transformation with its
//! frequency prewarped; both ways as in F. Gustafsson, *IEEE Trans. Signal Processing* 44 (1996),
//! 988. At the cut-off the gain is 1/2. The ends are continued by their mirror image through the
//! last point, so that a straight line passes unchanged. Limits: inaccurate within about `1/fc` of
//! an end.

/// Sections of the second order.
const SECTIONS: usize = 2;

/// Length of the mirror images at the ends, in periods of the cut-off.
const MIRRORED: f64 = 6.0;

/// Low-pass filter without phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    sections: [Section; SECTIONS],
    mirrored: usize,
}

/// A section: `b (1 + 2 z^-1 + z^-2)/(1 + a_1 z^-1 + a_2 z^-2)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Section {
    b: f64,
    a: [f64; 2],
}

impl LowPass {
    /// Creates a low-pass; the cut-off is a share of the sampling frequency, above 0 and below 0.5.
    pub fn new(cut_off: f64) -> Self {
        let k = (std::f64::consts::PI * cut_off).tan();
        let mut sections = [Section::default(); SECTIONS];
        for (i, section) in sections.iter_mut().enumerate() {
            // 1/Q of the poles: 2 cos of their angles from the real axis.
            let angle = std::f64::consts::PI * (2 * i + 1) as f64 / (4 * SECTIONS) as f64;
            let damping = 2.0 * angle.cos();
            let a0 = 1.0 + damping * k + k * k;
            *section = Section {
                b: k * k / a0,
                a: [2.0 * (k * k - 1.0) / a0, (1.0 - damping * k + k * k) / a0],
            };
        }
        Self { sections, mirrored: (MIRRORED / cut_off).ceil() as usize }
    }

    /// Returns the filtered series.
    pub fn apply(&self, series: &[f64]) -> Vec<f64> {
        let (Some(first), Some(last)) = (series.first().copied(), series.last().copied()) else {
            return Vec::new();
        };
        let mirrored = self.mirrored.min(series.len() - 1);
        let mut all = Vec::with_capacity(series.len() + 2 * mirrored);
        all.extend((1..=mirrored).rev().map(|i| 2.0 * first - series[i]));
        all.extend_from_slice(series);
        all.extend((1..=mirrored).map(|i| 2.0 * last - series[series.len() - 1 - i]));
        self.pass(&mut all);
        all.reverse();
        self.pass(&mut all);
        all.reverse();
        all.drain(..mirrored);
        all.truncate(series.len());
        all
    }

    /// Filters once, starting from a steady state at the first value.
    fn pass(&self, series: &mut [f64]) {
        let Some(first) = series.first().copied() else { return };
        for Section { b, a } in self.sections {
            // At rest the output is the input.
            let mut state = [first * (1.0 - b), first * (b - a[1])];
            for value in series.iter_mut() {
                let input = *value;
                let output = b * input + state[0];
                state = [2.0 * b * input - a[0] * output + state[1], b * input - a[1] * output];
                *value = output;
            }
        }
    }
}
