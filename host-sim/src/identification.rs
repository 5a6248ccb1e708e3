//! Friction levels from ramps (thesis section 3.2): the effort rises slowly until the joint moves, is held, and falls
//! slowly until the joint rests.
//!
//! Readings are of the effort asked for; what the D/A holds lies within half an LSB of it, on either side. Known biases:
//! *Stick*: the effort goes on rising until a count has been seen; the reading is high by the rate times that
//! delay, and goes to the truth as the rate goes to zero. *Slip*: the joint stops later than the
//! effort passes the dynamic friction, because its velocity lags by the time constant `tau = 1/(kappa b)`. With the
//! velocity steady at the begin of the ramp and `t` since then,
//!
//! ```text
//! velocity = [v(t) - v_slip + r tau (1 - e^(-t/tau))] / b
//! ```
//!
//! so the effort at the halt reads low by `r tau (1 - e^(-t/tau))`, which the corrected value gives back. The term
//! needs `kappa b`, and no friction. Before it, the effort must have been held long enough for the velocity to be steady
//! ([`SETTLED`] time constants); without viscous friction it never is, and there is no corrected value. What is left is the D/A's LSB, and the counts that a creeping joint no longer
//! makes before it halts.

use stiction::drive::Drive;

use crate::closed_loop::hold;
use crate::encoder::EncoderModel;
use crate::mechanism::RobotAxis;
use crate::solver::{AxisSolver, Event};

/// So many counts from its rest, a joint has moved: one more than a disc that stands on an edge can flicker.
const MOVED_COUNTS: u64 = 2;

/// After so many time constants 1/(kappa b) at constant effort the velocity is steady to 1 %.
pub const SETTLED: f64 = 5.0;

/// Without a count for this long, a joint rests, s.
const QUIET_S: f64 = 1.0;

/// A ramp up to the motion and down to rest.
#[derive(Clone, Debug)]
pub struct Ramp {
    /// V/s.
    pub rate: f64,
    /// Time at constant effort between the two ramps, s.
    pub hold_s: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// The effort at which to give up, V.
    pub full_scale_v: f64,
    /// Volts of one code.
    pub lsb_v: f64,
}

/// What a ramp found. `None`: the joint never moved, or never stopped; corrected: its velocity was not steady before the fall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Levels {
    /// Effort at the first count of the motion, V.
    pub stick_v: Option<f64>,
    /// Effort at the last count before rest, V.
    pub slip_v: Option<f64>,
    /// `slip_v` without the lag of the axis, V.
    pub slip_corrected_v: Option<f64>,
}

/// The joint at one sample of a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RampMoment {
    /// Time, s.
    pub time_s: f64,
    /// Effort asked for, V.
    pub v: f64,
    /// Code of the D/A.
    pub code: i16,
    /// True position, deg.
    pub position_deg: f64,
    /// True velocity, deg/s.
    pub velocity_deg_per_s: f64,
    /// Whether the joint is stuck.
    pub stuck: bool,
}

#[derive(Clone, Copy)]
enum Phase {
    Up,
    Hold { until_s: f64 },
    Down { since_s: f64 },
}

impl Ramp {
    /// Runs the ramp on an axis at rest.
    pub fn run<S: AxisSolver>(
        &self,
        solver: &mut S,
        axis: &RobotAxis,
        encoder: &EncoderModel,
        drive: &Drive,
        mut on_moment: impl FnMut(&RampMoment),
        mut on_event: impl FnMut(Event),
    ) -> Levels {
        let tau = axis.time_constant_s();
        let mut levels = Levels::default();
        let mut phase = Phase::Up;
        let (mut v, mut last_count) = (0.0, (0.0, 0.0));
        let start = encoder.counts(solver.position());
        let mut counts = start;
        for k in 0u32.. {
            let time_s = f64::from(k) * self.sample_time_s;
            let now = encoder.counts(solver.position());
            if now != counts {
                counts = now;
                last_count = (time_s, v);
                if now.abs_diff(start) == 1 && matches!(phase, Phase::Up) {
                    levels.stick_v = Some(v);
                }
            }
            match phase {
                Phase::Up if now.abs_diff(start) >= MOVED_COUNTS => {
                    levels.stick_v = levels.stick_v.or(Some(v));
                    phase = Phase::Hold { until_s: time_s + self.hold_s };
                }
                Phase::Up if v >= self.full_scale_v => return Levels::default(),
                Phase::Up => v = (v + self.rate * self.sample_time_s).min(self.full_scale_v),
                Phase::Hold { until_s } if time_s < until_s => {}
                Phase::Hold { .. } => phase = Phase::Down { since_s: time_s },
                Phase::Down { since_s } => {
                    let (count_s, count_v) = last_count;
                    if time_s - count_s.max(since_s) > QUIET_S {
                        let falling_s = (count_s - since_s).max(0.0);
                        let lag_s = tau * -libm::expm1(-falling_s / tau);
                        let steady = self.hold_s >= SETTLED * tau;
                        levels.slip_v = Some(count_v);
                        levels.slip_corrected_v = steady.then_some(count_v + self.rate * lag_s);
                        return levels;
                    }
                    // Without friction it coasts for ever.
                    if time_s - since_s > 2.0 * self.full_scale_v / self.rate + QUIET_S {
                        return levels;
                    }
                    // Not below zero: there the joint would be driven backwards before it was seen to rest.
                    v = (v - self.rate * self.sample_time_s).max(0.0);
                }
            }
            let code = drive.code(v as f32);
            on_moment(&RampMoment {
                time_s,
                v,
                code,
                position_deg: solver.position(),
                velocity_deg_per_s: solver.velocity(),
                stuck: solver.stuck(),
            });
            hold(solver, axis, f64::from(code) * self.lsb_v, [time_s, self.sample_time_s], &mut on_event);
        }
        levels
    }
}
