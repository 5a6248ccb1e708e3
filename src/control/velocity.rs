//! The velocity, by least squares over the last `N` positions.
//!
//! The slope of the regression line through `N` equally spaced samples `x_0 .. x_(N-1)` (the
//! thesis: `N` = 5, section 3.2) is, written in the increments `d_j = x_j - x_(j-1)`,
//!
//! ```text
//! velocity = 6 / (N (N^2 - 1) h) * sum_{j = 1}^{N - 1} j (N - j) d_j
//! ```
//!
//! that is, a mean of the increments with parabolic weights. In this form the sum is a sum of
//! integers, exact and independent of where the joint is; it needs no division per tick, and a
//! window of zeros is a joint that has been at rest.
//!
//! Guarantees: exact for constant velocity; for a joint at rest on a count, the velocity is exactly
//! zero. Does badly: it answers `(N - 1)/2` samples late, and its resolution at low speed is no
//! finer than `6 (N - 1) / (N (N^2 - 1))` counts per sample (0.2 for `N` = 5).

/// The number of positions in the longest window.
pub const MAX_WINDOW: usize = 16;

/// Limit of an increment, counts per tick. The weights of the longest window add up to `N (N^2 -
/// 1)/6` = 680, and 680 * 2^21 is the largest such product below 2^31: the sum cannot overflow.
const MAX_INCREMENT: i32 = 1 << 21;

/// The least-squares velocity of an `N`-sample window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Velocity {
    /// The weights `j (N - j)`, then zeros. They are symmetric, so the newest increment may come
    /// first.
    weights: [i32; MAX_WINDOW - 1],
    /// Factor from weighted counts to deg/s.
    scale: f32,
}

/// The state of a window: its last increments, counts, the newest first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VelocityState {
    increments: [i32; MAX_WINDOW - 1],
}

impl Velocity {
    /// Prepares a window of `samples` positions (2 to [`MAX_WINDOW`]), `sample_time` (s) apart, for
    /// an encoder of `resolution` (deg per count).
    pub fn new(samples: u32, resolution: f32, sample_time: f32) -> Self {
        let n = samples.clamp(2, MAX_WINDOW as u32) as i32;
        let mut weights = [0; MAX_WINDOW - 1];
        for (j, weight) in (1..n).zip(&mut weights) {
            *weight = j * (n - j);
        }
        let scale = 6.0 * resolution / ((n * (n * n - 1)) as f32 * sample_time);
        Self { weights, scale }
    }

    /// Adds the travel of one tick (counts) to the window, and returns the velocity, deg/s.
    ///
    /// ```
    /// use stiction::control::velocity::{Velocity, VelocityState};
    /// let velocity = Velocity::new(5, 0.5, 0.25);
    /// let mut state = VelocityState::default();
    /// for _ in 0..3 {
    ///     velocity.update(&mut state, 3);
    /// }
    /// assert_eq!(velocity.update(&mut state, 3), 6.0); // 3 counts of 0.5 deg each 0.25 s
    /// ```
    // The image has this code twice, for the closed loop and the open one: a call would cost as
    // much as half of it.
    #[inline(always)]
    pub fn update(&self, state: &mut VelocityState, travel: i32) -> f32 {
        let mut carried = travel.clamp(-MAX_INCREMENT, MAX_INCREMENT);
        let mut sum = 0i32;
        for (slot, &weight) in state.increments.iter_mut().zip(&self.weights) {
            if weight == 0 {
                break;
            }
            sum = sum.wrapping_add(carried.wrapping_mul(weight));
            core::mem::swap(slot, &mut carried);
        }
        sum as f32 * self.scale
    }
}
