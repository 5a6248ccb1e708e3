//! Feedforward of slip friction, viscous friction and inertia: the effort that the reference motion
//! needs.
//!
//! Thesis eq. 32 is the first term. The others are those that its section 4.2 recommends, and that
//! inverse dynamics requires (`B` and `J` of the joint in the core's units); without them, the law
//! is eq. 32 to the bit:
//!
//! ```text
//! v_c(t) = v_f + B theta_d' + J theta_d''
//! v_f    = v_slip sgn(theta_d')    |theta_d'| >  V_ff
//!        = 0                       |theta_d'| <= V_ff
//! ```
//!
//! In a sum with ROI, RVI or SRNF, it adds the viscous term that they lack: these laws are all
//! added to PD, and a term of the reference alone has the same effect in each of them.
//!
//! Why this form: the reference velocity is free of noise, so the signal switches only where the
//! motion does; a law on measured velocity chatters at standstill. Guarantees: bounded by `v_slip`
//! and the terms of the reference; cannot destabilise the loop, being outside of it. Tracks with an
//! error of `(v_d + b theta_d' - v_c) / Kp`. Does badly: it is zero at rest, so the rest error is
//! that of PD; `v_slip` must be identified, and an overestimate pushes. A step has no velocity, and
//! so no feedforward.

use super::{Law, LawInput, Loop};
use crate::control::reference::Setpoint;
use crate::units::error::HUGE;
use crate::units::value::table;

table! {
    /// Gains of the feedforward.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct FeedforwardGains (law) "controller" {
        /// Dynamic (slip) friction v_slip, V.
        v_slip: f32 = 0x1401 "v_slip_v", Between(0.0, HUGE), Needed(0.37);
        /// Reference speed above which it acts V_ff, deg/s.
        v_ff: f32 = 0x1402 "v_ff_deg_per_s", Between(0.0, HUGE), Needed(0.001);
        /// Viscous friction B, V/(deg/s). Left out: 0, as in the thesis.
        viscous: f32 = 0x1403 "viscous_v_per_deg_per_s", Between(0.0, HUGE), Default(0.0);
        /// Inertia J, V/(deg/s^2). Left out: 0, as in the thesis.
        inertia: f32 = 0x1404 "inertia_v_per_deg_per_s2", Between(0.0, HUGE), Default(0.0);
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
    /// use stiction::control::laws::{Feedforward, FeedforwardGains, Law, LawInput, Loop};
    /// use stiction::control::reference::Setpoint;
    /// let gains = FeedforwardGains { v_slip: 0.37, v_ff: 0.001, viscous: 0.0, inertia: 0.0 };
    /// let law = Feedforward::new(&gains, &Loop::EXAMPLE);
    /// let v_c = [-5.0, 0.001].map(|velocity| {
    ///     let setpoint = Setpoint { velocity, ..Setpoint::default() };
    ///     law.update(&mut (), &LawInput { setpoint, ..LawInput::default() })
    /// });
    /// assert_eq!(v_c, [-0.37, 0.0]);
    /// let law = Feedforward::new(&FeedforwardGains { viscous: 0.5, ..gains }, &Loop::EXAMPLE);
    /// let setpoint = Setpoint { velocity: 2.0, ..Setpoint::default() };
    /// assert_eq!(law.update(&mut (), &LawInput { setpoint, ..LawInput::default() }), 1.37);
    /// ```
    fn update(&self, (): &mut (), input: &LawInput) -> f32 {
        let FeedforwardGains { v_slip, v_ff, viscous, inertia } = self.gains;
        let Setpoint { velocity, acceleration, .. } = input.setpoint;
        let v_f = if velocity > v_ff {
            v_slip
        } else if velocity < -v_ff {
            -v_slip
        } else {
            0.0
        };
        v_f + viscous * velocity + inertia * acceleration
    }
}
