//! The PD loop that every law shares: a natural frequency and a damping ratio on the nominal joint.
//!
//! ```text
//! w_n  = min(2 pi 8, 0.1/h), 2 pi 2 instead of 2 pi 8 with the encoder on the load
//! Kp   = J w_n^2,  Kd = max(0, 2 zeta J w_n - B),  zeta = 0.9
//! ```
//!
//! The velocity is (N - 1)/2 = 2 samples late, a held output half a sample, and a computation up to
//! one more. On a joint of half the nominal inertia, the damping crosses over at 4 zeta w_n: at
//! 0.1/h these 3.5 samples turn its phase by 1.26 rad, of an available pi/2. The thesis's own loop
//! has 0.104/h. 8 Hz is below the resonance of most geared joints, and leaves a motor of a quarter
//! of the nominal inertia as much phase at 1 kHz. 2 Hz is below the load behind a transmission.
//!
//! 0.14/h was the other choice. On 100 joints each of four families at 200 Hz, seed 1000001,
//! profiled moves, six laws succeed in 40 % with 0.1/h and in 42 % with 0.14/h, and trip a monitor
//! in 98 and in 221 of 2400 runs: those joints have no fault, so the trips are false, and 0.1/h is
//! used.

use std::f64::consts::TAU;

use stiction::control::laws::Gains;
use stiction::control::pd::PdGains;

use super::{ControllerGains, JointBounds, four_digits_single};

/// Damping ratio on the nominal joint.
pub const DAMPING_RATIO: f64 = 0.9;

/// Largest natural frequency, Hz: with the encoder on the motor, and on the load.
const HERTZ: [f64; 2] = [8.0, 2.0];

/// Largest natural frequency times sample time, rad.
const PHASE_PER_SAMPLE: f64 = 0.1;

/// Default number of positions in the velocity's regression: that of the thesis.
pub(super) const VELOCITY_WINDOW: u32 = 5;

/// PD loop on a nominal joint, not rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdLoop {
    /// Natural frequency w_n, rad/s.
    pub natural_frequency: f64,
    /// Kp, V/deg.
    pub kp: f64,
    /// Kd, V/(deg/s).
    pub kd: f64,
}

impl PdLoop {
    /// Returns the loop of a joint.
    pub fn of(joint: &JointBounds) -> Self {
        let hertz = HERTZ[usize::from(joint.encoder_at_load)];
        let fastest = (TAU * hertz).min(PHASE_PER_SAMPLE / joint.sampled.sample_time);
        Self::with(joint, fastest, DAMPING_RATIO)
    }

    /// Returns the loop of a joint with a natural frequency (rad/s) and a damping ratio.
    pub fn with(joint: &JointBounds, natural_frequency: f64, damping_ratio: f64) -> Self {
        let JointBounds { inertia, viscous, .. } = joint;
        Self {
            natural_frequency,
            kp: inertia * natural_frequency.powi(2),
            kd: (2.0 * damping_ratio * inertia * natural_frequency - viscous).max(0.0),
        }
    }

    /// Returns the gains of this loop with laws that are added to it.
    pub fn with_laws(self, laws: Vec<Gains>) -> ControllerGains {
        let pd = PdGains { kp: four_digits_single(self.kp), kd: four_digits_single(self.kd) };
        ControllerGains { pd, velocity_window: VELOCITY_WINDOW, laws }
    }
}
