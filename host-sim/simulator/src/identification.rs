//! Friction levels from ramps (thesis section 3.2), on the simulated axis. The ramp is the core's
//! own ([`stiction::identification`]), with its encoder and its drive.
//!
//! Readings are of the requested effort; the D/A's output is within half an LSB of it. Known
//! biases: *Stick*: the effort rises until the first count; the reading is high by the rate times
//! that delay, and converges to the true value as the rate goes to zero. *Slip*: the joint stops
//! after the effort has passed the dynamic friction, because its velocity lags by the time constant
//! `tau = 1/(kappa b)`. If the velocity is steady at the start of the ramp, then at the time `t`
//!
//! ```text
//! velocity = [v(t) - v_slip + r tau (1 - e^(-t/tau))] / b
//! ```
//!
//! so the effort at the halt reads low by `r tau (1 - e^(-t/tau))`, which the corrected value adds.
//! The term needs `kappa b`, but no friction level. The effort must have been held until the
//! velocity is steady ([`SETTLED`] time constants); without viscous friction it never is, and there
//! is no corrected value. The remaining errors are the D/A's LSB, and the missing counts of a
//! creeping joint before it halts.

use stiction::Course;
use stiction::identification::RampFindings;

use crate::closed_loop::{ClosedLoop, Delay, LoopSample};
use crate::target::BareLoop;
use dynamics::mechanism::RobotAxis;
use dynamics::solver::{AxisSolver, Event};

/// Number of time constants 1/(kappa b) at constant effort until the velocity is steady to 1 %.
pub const SETTLED: f64 = 5.0;

/// Test with a ramp up to motion and down to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RampTest {
    /// The ramp that the core runs.
    pub core: stiction::identification::Ramp,
    /// Rate of the ramp, V/s.
    pub rate: f64,
    /// Time at constant effort between the two ramps, s.
    pub hold_s: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
}

/// Friction levels found by a ramp. `None`: the joint never moved, or never stopped. The corrected
/// level is `None` if the velocity was not steady before the ramp down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RampFriction {
    /// Effort at the first count of the motion, V.
    pub stick_v: Option<f64>,
    /// Effort at the last count before rest, V.
    pub slip_v: Option<f64>,
    /// `slip_v` without the lag of the axis, V.
    pub slip_corrected_v: Option<f64>,
}

impl RampTest {
    /// Runs the ramp on a joint at rest, with the encoder and the drive of `around`; no law runs.
    pub fn run<S: AxisSolver>(
        &self,
        solver: &mut S,
        around: &ClosedLoop,
        on_moment: impl FnMut(&LoopSample),
        on_event: impl FnMut(Event),
    ) -> RampFriction {
        // The readings are of the effort of the same sample, as in the image.
        let at_once = ClosedLoop { delay: Delay::None, ..around.clone() };
        let mut plant = at_once.plant(solver);
        let course = Course::Ramp(self.core);
        let (counter, counts) = (plant.counter(), plant.counts());
        let mut target = BareLoop::new(&around.controller, &course, counter, counts);
        at_once.step(&mut target, &mut plant, u32::MAX, on_moment, on_event);
        self.levels(&target.state.ramp().findings(), &around.axis)
    }

    /// Returns the levels from the findings of the core.
    pub fn levels(&self, found: &RampFindings, axis: &RobotAxis) -> RampFriction {
        let tau = axis.time_constant_s();
        let volts = |rung: u32| f64::from(rung) * self.rate * self.sample_time_s;
        let slip_v = found.slip.map(volts);
        let lag_s = tau * -libm::expm1(-f64::from(found.fall) * self.sample_time_s / tau);
        let steady = self.hold_s >= SETTLED * tau;
        let slip_corrected_v = slip_v.filter(|_| steady).map(|slip_v| slip_v + self.rate * lag_s);
        RampFriction { stick_v: found.stick.map(volts), slip_v, slip_corrected_v }
    }
}
