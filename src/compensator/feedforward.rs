//! Slip friction feedforward: the dynamic friction, in the direction in which the joint should move.
//!
//! Thesis eq. 32:
//!
//! ```text
//! v_c(t) = v_slip sgn(theta_d')    |theta_d'| >  V_ff
//!        = 0                       |theta_d'| <= V_ff
//! ```
//!
//! Why this form: the reference velocity is free of noise, so the signal switches only where the motion does; a law
//! on measured velocity chatters at standstill. Guarantees: bounded by `v_slip`; cannot destabilise the
//! loop, being outside of it. Tracks with an error of `(v_d + b theta_d' - v_slip) / Kp`. Does badly: nothing
//! at rest, so the rest error is that of PD; `v_slip` must be identified, and an overestimate pushes.

use super::Sample;
use crate::error::{Error, HUGE, between};
use serde::{Deserialize, Serialize};

/// Gains of the feedforward.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeedforwardGains {
    /// Dynamic (slip) friction v_slip, V.
    pub v_slip: f32,
    /// Reference speed above which it acts V_ff, deg/s.
    pub v_ff: f32,
}

impl FeedforwardGains {
    /// Refuses gains that are negative or not finite.
    ///
    /// # Errors
    /// Names the gain.
    pub fn validate(&self) -> Result<(), Error> {
        between("v_slip_v", self.v_slip, 0.0, HUGE)?;
        between("v_ff_deg_per_s", self.v_ff, 0.0, HUGE)
    }
}

/// The feedforward law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedforward {
    gains: FeedforwardGains,
}

impl Feedforward {
    /// Validates the gains.
    ///
    /// # Errors
    /// Names the gain.
    pub fn new(gains: &FeedforwardGains) -> Result<Self, Error> {
        gains.validate()?;
        Ok(Self { gains: *gains })
    }

    /// v_c for one sample, V.
    ///
    /// ```
    /// use stiction::compensator::{Feedforward, FeedforwardGains, Sample};
    /// let law = Feedforward::new(&FeedforwardGains { v_slip: 0.37, v_ff: 0.001 }).unwrap();
    /// assert_eq!(law.update(&Sample { reference_velocity: -5.0, ..Sample::default() }), -0.37);
    /// assert_eq!(law.update(&Sample { reference_velocity: 0.001, ..Sample::default() }), 0.0);
    /// ```
    pub fn update(&self, sample: &Sample) -> f32 {
        let FeedforwardGains { v_slip, v_ff } = self.gains;
        if sample.reference_velocity > v_ff {
            v_slip
        } else if sample.reference_velocity < -v_ff {
            -v_slip
        } else {
            0.0
        }
    }
}
