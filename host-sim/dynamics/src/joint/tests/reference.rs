//! Second method: time stepping at a fixed, very short step. All forces except the set-valued one
//! are those at the start of the step. The method shares only the description with the joints.
//!
//! ```text
//! v* = (J v + h (u + ..))/(J + h B)
//! v+ = sgn(v*) max(|v*| - h g(|v|)/(J + h B), 0)      x+ = x + h v+
//! ```
//!
//! and for a bristle `phi = 1/(1 + h r)`, `K = sigma0 + sigma1/h`,
//! `v+ = (J v + h (u - K phi z + sigma1 z/h))/(J + h^2 K phi + h B)`, `z+ = phi (z + h v+)`.
//! Its error falls like h.

use super::*;

/// Returns the positions of motor and load at the end of each sample of 1 ms.
pub fn positions(
    joint: &Description,
    effort: impl Fn(u32) -> f64,
    samples: u32,
    steps: u32,
) -> Vec<[f64; 2]> {
    let h = 1e-3 / f64::from(steps);
    let mut x = [joint.start; 2];
    let mut v = [0.0_f64; 2];
    let mut bend = 0.0;
    let mut lagged = 0.0;
    let keep = if joint.lag_s > 0.0 { (-h / joint.lag_s).exp() } else { 0.0 };
    let mut rested = [0.0; 2];
    let mut warm = match &joint.train {
        Train::Rigid(body) => body.friction.thermal.map_or(0.0, |thermal| thermal.start_k),
        _ => 0.0,
    };
    let mut out = Vec::new();
    for sample in 0..samples {
        for step in 0..steps {
            let time = (f64::from(sample) + (f64::from(step) + 0.5) / f64::from(steps)) * 1e-3;
            lagged = effort(sample) + (lagged - effort(sample)) * keep;
            let push = joint.push.filter(|push| push.from_s < time && time < push.until_s);
            let gravity = joint.load.gravity.map_or(0.0, |g| g.amplitude * (g.angle + x[1]).sin());
            let load = joint.load.constant - gravity + push.map_or(0.0, |push| push.torque);
            match &joint.train {
                Train::Rigid(body) => {
                    if let Some(thermal) = body.friction.thermal {
                        let power =
                            sliding(body, x[0], v[0].abs(), rested[0], warm, true) * v[0].abs();
                        warm += h * (thermal.heating_k_per_w * power - warm) / thermal.time_s;
                    }
                    let (before, since) = (v[0], rested[0]);
                    v[0] = next(body, h, x[0], v[0], lagged + load, &mut rested[0], warm);
                    x[0] += h * v[0];
                    if wall(&joint.stops, &mut x[0], &mut v[0]) {
                        rested[0] = if before == 0.0 { since + h } else { 0.0 };
                    }
                    x[1] = x[0];
                }
                Train::LuGre { inertia, curve, bristle } => {
                    let speed = v[0].abs();
                    let part = (speed / curve.stribeck_velocity).powi(2);
                    let level = curve.coulomb + (curve.stick - curve.coulomb) * (-part).exp();
                    let phi = 1.0 / (1.0 + h * bristle.stiffness * speed / level);
                    let k = bristle.stiffness + bristle.damping / h;
                    let free = lagged + load - k * phi * bend + bristle.damping * bend / h;
                    v[0] = (inertia * v[0] + h * free)
                        / (inertia + h * h * k * phi + h * curve.viscous);
                    bend = phi * (bend + h * v[0]);
                    x[0] += h * v[0];
                    wall(&joint.stops, &mut x[0], &mut v[0]);
                    x[1] = x[0];
                }
                Train::Flexible { motor, load: far, shaft } => {
                    let twist = x[0] - x[1];
                    let half = 0.5 * shaft.backlash;
                    let e = twist - twist.clamp(-half, half);
                    let mut torque = shaft.stiffness * e + shaft.damping * (v[0] - v[1]);
                    if half > 0.0 && torque * e <= 0.0 {
                        torque = 0.0;
                    }
                    v[0] = next(motor, h, x[0], v[0], lagged - torque, &mut rested[0], 0.0);
                    v[1] = next(far, h, x[1], v[1], torque + load, &mut rested[1], 0.0);
                    x[0] += h * v[0];
                    x[1] += h * v[1];
                    wall(&joint.stops, &mut x[1], &mut v[1]);
                }
            }
        }
        out.push(x);
    }
    out
}

fn wall(stops: &Stops, x: &mut f64, v: &mut f64) -> bool {
    let hits = *x > stops.upper || *x < stops.lower;
    if hits {
        *x = x.clamp(stops.lower, stops.upper);
        *v = 0.0;
    }
    hits
}

/// Friction at a speed, with the viscous part or without.
fn sliding(body: &Body, x: f64, speed: f64, rested: f64, warm: f64, viscous: bool) -> f64 {
    let SetValuedFriction { curve, ripple, dwell, thermal } = &body.friction;
    let [levels, fluid] = thermal.map_or([1.0; 2], |thermal| {
        [(-thermal.levels_per_k * warm).exp(), (-thermal.viscous_per_k * warm).exp()]
    });
    let grown = dwell.map_or(1.0, |d| 1.0 + d.growth * (1.0 - (-rested / d.time_s).exp()));
    let ripple = ripple.map_or(1.0, |r| 1.0 + r.depth * (r.cycles * x + r.phase).sin());
    let over = if speed == 0.0 { 1.0 } else { (-(speed / curve.stribeck_velocity).powi(2)).exp() };
    let level = curve.coulomb + (curve.stick * grown - curve.coulomb) * over;
    levels * ripple * level + if viscous { fluid * curve.viscous * speed } else { 0.0 }
}

fn next(body: &Body, h: f64, x: f64, v: f64, torque: f64, rested: &mut f64, warm: f64) -> f64 {
    let fluid = body.friction.thermal.map_or(1.0, |t| (-t.viscous_per_k * warm).exp());
    let inertia = body.inertia + h * fluid * body.friction.curve.viscous;
    let free = (body.inertia * v + h * torque) / inertia;
    let level = sliding(body, x, v.abs(), *rested, warm, false);
    let end = free.signum() * (free.abs() - h * level / inertia).max(0.0);
    if v != 0.0 && end * v <= 0.0 {
        // A halt begins a new rest, be it the shortest.
        *rested = 0.0;
    } else if end == 0.0 {
        *rested += h;
    }
    end
}
