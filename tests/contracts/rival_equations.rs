//! The equations of the laws that live on the host, a second time, in `f64`.

use super::fixture::*;

/// What the laws remember from tick to tick.
#[derive(Default)]
pub struct RivalEquation {
    /// The last tick, and the counts of the one before.
    last: Option<Tick>,
    /// The integral, or the lead of the proxy.
    integral: f64,
    /// What is summed up beside it: the estimate of the load, or the proxy's own integral.
    second: f64,
    /// Which of the two resets is due.
    crossed: bool,
    pulses: Pulses,
}

/// The pulses, as a list of what is still to be applied.
#[derive(Default)]
struct Pulses {
    still: u32,
    pending: Vec<f64>,
    begun_at: Option<f32>,
    /// How often the reach grew and shrank, forwards and backwards, as its logarithm to be.
    reach: [Option<f64>; 2],
    content: bool,
}

const FULL_SCALE: f64 = 5.0;

impl RivalEquation {
    pub fn evaluate(&mut self, law: &Gains, tick: &Tick, h: f64) -> f64 {
        let last = self.last.replace(*tick);
        match law {
            Gains::Pid(gains) => {
                let stops =
                    last.is_some_and(|last| last.saturated && last.v_applied * tick.error >= 0.0);
                if !stops {
                    self.integral = limited(self.integral + f64::from(gains.ki) * h * error(tick));
                }
                self.integral
            }
            Gains::TwoResetPid(gains) => {
                let last = last.unwrap_or_default();
                // At rest, the first tick has no velocity.
                let crosses = |a: f32, b: f32| (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0);
                match self.crossed {
                    false if crosses(tick.error, last.error) => {
                        (self.integral, self.crossed) = (-self.integral, true);
                    }
                    true if tick.velocity == 0.0 || crosses(tick.velocity, last.velocity) => {
                        (self.integral, self.crossed) = (0.0, false);
                    }
                    _ => {}
                }
                if tick.velocity != 0.0 && !self.crossed {
                    let share = (h / f64::from(gains.load_time)).min(1.0);
                    self.second = limited(self.second + share * self.integral);
                }
                self.integral = limited(self.integral + f64::from(gains.ki) * h * error(tick));
                limited(self.integral + self.second)
            }
            Gains::Impulsive(gains) => {
                let travelled = last.is_some_and(|last| last.counts != tick.counts);
                self.pulses.evaluate(gains, tick, travelled, h)
            }
            Gains::ProxySlidingMode(gains) => {
                // The proxy's lead is sought, not solved for: the sliding surface and PID say what
                // it is together, and the surface's function falls steadily with it.
                let [k, d, l, surface] =
                    [gains.stiffness, gains.damping, gains.integral, gains.surface_time]
                        .map(f64::from);
                let (before, area) = (self.integral, self.second);
                let effort = |w: f64| l * (area + h * w) + k * w + d * (w - before) / h;
                let velocity_error = f64::from(tick.reference_velocity) - f64::from(tick.velocity);
                let sliding =
                    |w: f64| error(tick) - w + surface * (velocity_error - (w - before) / h);
                let (mut low, mut high) = (-1e6, 1e6);
                for _ in 0..200 {
                    let w = 0.5 * (low + high);
                    // U sgn(s) = PID, as an inclusion.
                    let lags = if effort(w) >= FULL_SCALE {
                        true
                    } else if effort(w) <= -FULL_SCALE {
                        false
                    } else {
                        sliding(w) < 0.0
                    };
                    *(if lags { &mut high } else { &mut low }) = w;
                }
                let w = 0.5 * (low + high);
                (self.integral, self.second) = (w, area + h * w);
                effort(w)
            }
            other => unreachable!("{other:?} is a law of the thesis"),
        }
    }
}

impl Pulses {
    fn evaluate(&mut self, gains: &ImpulsiveGains, tick: &Tick, travelled: bool, h: f64) -> f64 {
        self.still = if travelled { 0 } else { self.still + 1 };
        if tick.reference_velocity != 0.0 {
            self.pending.clear();
            (self.begun_at, self.content) = (None, false);
            return 0.0;
        }
        if self.pending.is_empty() {
            if self.still < if h > 0.01 { 3 } else { 6 } {
                return 0.0;
            }
            if let Some(begun_at) = self.begun_at.take() {
                let reach = self.reach[usize::from(begun_at < 0.0)].get_or_insert(1.0);
                // What lies at a threshold is decided as the law decides it, in single precision.
                let moved = (begun_at - tick.error) / begun_at;
                *reach *= if moved < 0.3 {
                    1.25
                } else if moved > 1.2 {
                    0.8
                } else {
                    1.0
                };
                *reach = reach.clamp(0.2, 5.0);
            }
            let counts = tick.error.abs() / RESOLUTION;
            self.content = counts <= 1.25 || (self.content && counts <= 1.5);
            if self.content || gains.largest == 0.0 {
                return 0.0;
            }
            let reach = self.reach[usize::from(tick.error < 0.0)].unwrap_or(1.0);
            let pulse = pulse(gains, reach * error(tick).abs(), h);
            self.pending = pulse.into_iter().map(|effort| effort * error(tick).signum()).collect();
            self.begun_at = Some(tick.error);
        }
        self.still = 0;
        self.pending.pop().unwrap_or_default() - f64::from(tick.v_pd)
    }
}

/// The efforts of a pulse, tick by tick: the first length from which the amplitude is within the
/// drive.
fn pulse(gains: &ImpulsiveGains, distance: f64, h: f64) -> Vec<f64> {
    let [j, low, high] = [gains.inertia, gains.low, gains.high].map(f64::from);
    let largest = f64::from(gains.largest).min(FULL_SCALE);
    let f = 2.0 * low * high.max(low) / (low + high.max(low));
    let amplitude = |n: f64| {
        let t = n * h;
        0.5 * (f + (f * f + 8.0 * j * f * distance / (t * t)).sqrt())
    };
    // A length that fits but for a rounding counts as one that fits.
    let n = (1..40).find(|n| amplitude(f64::from(*n) + 1e-4) <= largest).unwrap_or(40);
    vec![amplitude(n.into()).max(1.05 * low).min(largest); n as usize]
}

fn error(tick: &Tick) -> f64 {
    f64::from(tick.error)
}

fn limited(v: f64) -> f64 {
    v.clamp(-FULL_SCALE, FULL_SCALE)
}
