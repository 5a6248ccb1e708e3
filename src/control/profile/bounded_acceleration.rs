//! A generator that follows a reference with bounded acceleration and speed, for use inside a law.
//!
//! With `d = r - p - r' h` and `D = a_m h`, a tick is
//!
//! ```text
//! |d| <= 1.01 D h and |p' - r'| <= 1.01 D:
//!              p''  = (r' - p') / h  (0 if r' = 0),   p = r,   p' = r'
//! otherwise:   t    = sgn(d) (sqrt(2 a_m |d| + D^2 / 4) - D / 2) + r'
//!              step = clamp(clamp(t, v_m) - p', D)
//!              p'  += step,   p += h p',   p'' = step / h
//! ```
//!
//! The root is the speed from which steps of `D` come to rest within `|d|`: from there the speed
//! falls by `D` in each tick. The caller chooses the units, and the origin from which `p` and `r`
//! count. If the caller moves the origin by the same whole number of counts for both, at a rest, no
//! precision is lost far from zero.
//!
//! Guarantees: it follows an `r` that moves no faster than `v_m`, and lands on it exactly. The
//! speed never changes by more than `D` in a tick, except in the landing. Does badly: it passes an
//! `r` at rest by up to `a_m h^2 / 8` and comes back in the next tick; an `r` that jumps behind it
//! while it moves by `D` makes it land backwards, with twice `a_m`. The jerk has no bound. So the
//! moves of a drive have a generator of their own, [`Profile`](super::Profile), whose references
//! rest.

use crate::units::saturation::bounded;

/// The limits, prepared for the ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedAcceleration {
    sample_time: f32,
    per_sample_time: f32,
    velocity: f32,
    acceleration: f32,
    /// D, the largest change of the speed in a tick.
    step: f32,
    /// Largest distance and largest difference of speeds at which it lands on the reference.
    lands_within: f32,
    lands_from: f32,
}

/// State from tick to tick: the limited reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimitedReference {
    /// Position p, from the caller's origin.
    pub position: f32,
    /// Velocity p'.
    pub velocity: f32,
    /// Acceleration p''.
    pub acceleration: f32,
}

impl BoundedAcceleration {
    /// Prepares the limits for ticks of `sample_time` (s). All three must be above zero.
    pub fn new(velocity: f32, acceleration: f32, sample_time: f32) -> Self {
        Self {
            sample_time,
            per_sample_time: 1.0 / sample_time,
            velocity,
            acceleration,
            step: acceleration * sample_time,
            lands_within: acceleration * sample_time * sample_time * 1.01,
            lands_from: acceleration * sample_time * 1.01,
        }
    }

    /// Runs a tick towards the reference `r` with its velocity `r'`.
    ///
    /// ```
    /// use stiction::control::profile::{BoundedAcceleration, LimitedReference};
    /// // 1 unit in steps of 1/2: up, and down again.
    /// let (limits, mut state) = (BoundedAcceleration::new(2.0, 0.5, 1.0), LimitedReference::default());
    /// let positions = [(); 3].map(|()| { limits.update(&mut state, 1.0, 0.0); state.position });
    /// assert_eq!(positions, [0.5, 1.0, 1.0]);
    /// ```
    #[inline]
    pub fn update(&self, state: &mut LimitedReference, reference: f32, velocity: f32) {
        let distance = reference - state.position - self.sample_time * velocity;
        let ahead = state.velocity - velocity;
        if distance.abs() <= self.lands_within && ahead.abs() <= self.lands_from {
            state.acceleration = if velocity == 0.0 { 0.0 } else { ahead * -self.per_sample_time };
            state.velocity = velocity;
            state.position = reference;
            return;
        }
        let root =
            libm::sqrtf(2.0 * self.acceleration * distance.abs() + 0.25 * self.step * self.step)
                - 0.5 * self.step;
        let wanted = if distance > 0.0 { root } else { -root } + velocity;
        let step = bounded(bounded(wanted, self.velocity) - state.velocity, self.step);
        state.acceleration = step * self.per_sample_time;
        state.velocity += step;
        state.position += self.sample_time * state.velocity;
    }
}
