//! Slip friction feedforward: the dynamic friction, in the direction in which the joint should
//! move.
//!
//! Thesis eq. 32:
//!
//! ```text
//! v_c(t) = v_slip sgn(theta_d')    |theta_d'| >  V_ff
//!        = 0                       |theta_d'| <= V_ff
//! ```
//!
//! Why this form: the reference velocity is free of noise, so the signal switches only where the
//! motion does; a law on measured velocity chatters at standstill. Guarantees: bounded by `v_slip`;
//! cannot destabilise the loop, being outside of it. Tracks with an error of `(v_d + b theta_d' -
//! v_slip) / Kp`. Does badly: it gives nothing at rest, so the rest error is that of PD; `v_slip`
//! must be identified, and an overestimate pushes.

use super::{Law, LawInput, Loop};
use crate::error::HUGE;
use crate::value::table;

table! {
    /// Gains of the feedforward.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct FeedforwardGains (law) "controller" {
        /// Dynamic (slip) friction v_slip, V.
        v_slip: f32 = 0x1401 "v_slip_v", Between(0.0, HUGE), Needed(0.37);
        /// Reference speed above which it acts V_ff, deg/s.
        v_ff: f32 = 0x1402 "v_ff_deg_per_s", Between(0.0, HUGE), Needed(0.001);
    }
}

/// The feedforward law, prepared for its ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedforward {
    gains: FeedforwardGains,
}

impl Law for Feedforward {
    type Gains = FeedforwardGains;
    type State = ();

    fn new(gains: &FeedforwardGains, _: &Loop) -> Self {
        Self { gains: *gains }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::compensator::{Feedforward, FeedforwardGains, Law, LawInput, Loop};
    /// use stiction::reference::Setpoint;
    /// let law = Feedforward::new(&FeedforwardGains { v_slip: 0.37, v_ff: 0.001 }, &Loop::EXAMPLE);
    /// let v_c = [-5.0, 0.001].map(|velocity| {
    ///     let setpoint = Setpoint { velocity, ..Setpoint::default() };
    ///     law.update(&mut (), &LawInput { setpoint, ..LawInput::default() })
    /// });
    /// assert_eq!(v_c, [-0.37, 0.0]);
    /// ```
    fn update(&self, (): &mut (), input: &LawInput) -> f32 {
        let FeedforwardGains { v_slip, v_ff } = self.gains;
        if input.setpoint.velocity > v_ff {
            v_slip
        } else if input.setpoint.velocity < -v_ff {
            -v_slip
        } else {
            0.0
        }
    }
}
