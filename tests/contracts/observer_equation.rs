//! The equation of the disturbance observer, a second time, in `f64`: the joint's position is
//! absolute, and the estimate is corrected by the textbook's three gains.

use super::fixture::*;

/// What the observer remembers from tick to tick.
#[derive(Default)]
pub struct ObserverEquation {
    last: Option<Tick>,
    /// Position (deg), velocity and disturbance (deg/s^2).
    x: [f64; 3],
    still: u32,
}

impl ObserverEquation {
    pub fn evaluate(&mut self, gains: &DisturbanceObserverGains, tick: &Tick, h: f64) -> f64 {
        let [w, j, b, slip, ramp, largest] =
            [gains.bandwidth, gains.inertia, gains.viscous, gains.slip, gains.ramp, gains.largest]
                .map(f64::from);
        let y = f64::from(tick.counts) * f64::from(RESOLUTION);
        let last = self.last.replace(*tick).unwrap_or_else(|| {
            self.x[0] = y;
            Tick { counts: tick.counts, ..Tick::default() }
        });
        self.still = if last.counts == tick.counts { self.still + 1 } else { 0 };
        let limit = largest.min(5.0) / j;
        let [x1, x2, x3] = self.x;
        let moves = tick.reference_velocity != 0.0;
        self.x = if self.still >= 3 && !moves {
            let rises = tick.error.abs() > gains.band;
            let step = if rises { ramp * h / j * f64::from(tick.error.signum()) } else { 0.0 };
            [y, 0.0, x3 - step]
        } else {
            let z = (-w * h).exp();
            let gains = [
                1.0 - z.powi(3),
                1.5 * (1.0 - z).powi(2) * (1.0 + z) / h,
                (1.0 - z).powi(3) / (h * h),
            ];
            let direction = if moves { f64::from(tick.reference_velocity).signum() } else { 0.0 };
            let u = f64::from(last.v_applied) - slip * direction;
            let a = (u - b * x2) / j + x3;
            let predicted = [x1 + h * x2 + 0.5 * h * h * a, x2 + h * a, x3];
            let error = y - predicted[0];
            [0, 1, 2].map(|i: usize| predicted[i] + gains[i] * error)
        };
        self.x[2] = self.x[2].clamp(-limit, limit);
        -j * self.x[2]
    }
}
