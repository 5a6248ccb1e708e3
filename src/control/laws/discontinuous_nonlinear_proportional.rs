//! Discontinuous nonlinear proportional feedback (DNPF): near the target, always enough to break
//! away.
//!
//! Thesis eq. 33, after Southward, Radcliffe and MacCluer (eq. 33 prints theta_p for theta_b):
//!
//! ```text
//! v_c(t) = 0                                    |theta_e| > theta_b or theta_e = 0
//!        = Kp [theta_b sgn(theta_e) - theta_e]  otherwise
//! theta_b = v_stick / Kp + epsilon                                              (eq. 34)
//! ```
//!
//! Within `theta_b` the position term is thus replaced by the constant `Kp theta_b sgn(theta_e)`,
//! which exceeds the static friction by `Kp epsilon`.
//!
//! Guarantees: |v_c| <= Kp theta_b. Does badly: `epsilon` is a knife edge. With `theta_b` below
//! about `v_stick / Kp` the joint stops short. With the thesis's `theta_b` = 0.40 deg, epsilon is
//! zero, and only the D/A's rounding of 0.40 V to 0.40016 V moves the axis. At the target the law
//! is a relay: it chatters at the sample rate within a count. It does not help in tracking, where
//! the error is outside the band.

use super::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::value::table;

table! {
    /// Gains of DNPF.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct DiscontinuousNonlinearProportionalGains (law) "controller" {
        /// Threshold theta_b, deg.
        theta_b: f32 = 0x1501 "theta_b_deg", Between(0.0, HUGE), Needed(0.4);
    }
}

/// The law DNPF, prepared for a PD loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscontinuousNonlinearProportional {
    kp: f32,
    theta_b: f32,
}

impl Law for DiscontinuousNonlinearProportional {
    type Gains = DiscontinuousNonlinearProportionalGains;
    type State = ();

    fn new(gains: &DiscontinuousNonlinearProportionalGains, around: &Loop) -> Self {
        Self { kp: around.kp, theta_b: gains.theta_b }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::control::laws::{
    ///     DiscontinuousNonlinearProportional, DiscontinuousNonlinearProportionalGains,
    /// };
    /// use stiction::control::laws::{Law, LawInput, Loop};
    /// let around = Loop { kp: 2.0, ..Loop::EXAMPLE };
    /// let gains = DiscontinuousNonlinearProportionalGains { theta_b: 0.5 };
    /// let law = DiscontinuousNonlinearProportional::new(&gains, &around);
    /// let v_c = [-0.125, 0.0, 0.5, 0.625]
    ///     .map(|error| law.update(&mut (), &LawInput { error, ..LawInput::default() }));
    /// assert_eq!(v_c, [-0.75, 0.0, 0.0, 0.0]);
    /// ```
    fn update(&self, (): &mut (), input: &LawInput) -> f32 {
        let error = input.error;
        if error == 0.0 || error.abs() > self.theta_b {
            0.0
        } else {
            self.kp * (self.theta_b.copysign(error) - error)
        }
    }
}
