//! Velocity and acceleration of an even series, by central differences of the fourth order.
//!
//! ```text
//! q'  = (-q_2 + 8 q_1 - 8 q_-1 + q_-2)/12h            short by (w h)^4/30
//! q'' = (-q_2 + 16 q_1 - 30 q_0 + 16 q_-1 - q_-2)/12h^2    short by (w h)^4/90
//! ```
//!
//! At an eighth of the sampling frequency, the highest cut-off that is chosen, these errors are 1.3
//! and 0.4 %. The two samples at either end have the value of the sample next to them.

/// Returns the first and the second derivative of a series in steps of h.
pub fn derivatives(series: &[f64], h: f64) -> [Vec<f64>; 2] {
    let n = series.len();
    let mut velocity = vec![0.0; n];
    let mut acceleration = vec![0.0; n];
    for (i, five) in series.windows(5).enumerate() {
        velocity[i + 2] = (five[0] - five[4] + 8.0 * (five[3] - five[1])) / (12.0 * h);
        acceleration[i + 2] =
            (16.0 * (five[1] + five[3]) - five[0] - five[4] - 30.0 * five[2]) / (12.0 * h * h);
    }
    for all in [&mut velocity, &mut acceleration] {
        if n >= 5 {
            let (first, last) = (all[2], all[n - 3]);
            all[..2].fill(first);
            all[n - 2..].fill(last);
        }
    }
    [velocity, acceleration]
}
