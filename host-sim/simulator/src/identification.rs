//! Friction levels from ramps (thesis section 3.2), on the simulated axis. The ramp is the core's
//! own ([`stiction::identification`]), with its encoder and its drive.
//!
//! Readings are of the effort asked for; what the D/A holds lies within half an LSB of it, on
//! either side. Known biases: *Stick*: the effort goes on rising until a count has been seen; the
//! reading is high by the rate times that delay, and goes to the truth as the rate goes to zero.
//! *Slip*: the joint stops later than the effort passes the dynamic friction, because its velocity
//! lags by the time constant `tau = 1/(kappa b)`. With the velocity steady at the begin of the ramp
//! and `t` since then,
//!
//! ```text
//! velocity = [v(t) - v_slip + r tau (1 - e^(-t/tau))] / b
//! ```
//!
//! so the effort at the halt reads low by `r tau (1 - e^(-t/tau))`, which the corrected value gives
//! back. The term needs `kappa b`, and no friction. Before it, the effort must have been held long
//! enough for the velocity to be steady ([`SETTLED`] time constants); without viscous friction it
//! never is, and there is no corrected value. What is left is the D/A's LSB, and the counts that a
//! creeping joint no longer makes before it halts.

use stiction::Course;
use stiction::identification::RampFindings;

use crate::closed_loop::{ClosedLoop, Delay, LoopSample};
use crate::mechanism::RobotAxis;
use crate::solver::{AxisSolver, Event};
use crate::target::BareLoop;

/// After so many time constants 1/(kappa b) at constant effort the velocity is steady to 1 %.
pub const SETTLED: f64 = 5.0;

/// A ramp up to the motion and down to rest, with what its levels are read by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RampTest {
    /// The ramp that the core runs.
    pub core: stiction::identification::Ramp,
    /// V/s.
    pub rate: f64,
    /// Time at constant effort between the two ramps, s.
    pub hold_s: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
}

/// What a ramp found. `None`: the joint never moved, or never stopped; corrected: its velocity was
/// not steady before the fall.
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
        // The readings are of the effort of the same sample, here as in the image.
        let at_once = ClosedLoop { delay: Delay::None, ..around.clone() };
        let mut plant = at_once.plant(solver);
        let course = Course::Ramp(self.core);
        let (counter, counts) = (plant.counter(), plant.counts());
        let mut target = BareLoop::new(&around.controller, &course, counter, counts);
        at_once.step(&mut target, &mut plant, u32::MAX, on_moment, on_event);
        self.levels(&target.state.ramp().findings(), &around.axis)
    }

    /// The levels behind what the core has found.
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
