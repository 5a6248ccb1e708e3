//! Proxy-based sliding mode control (PSMC): PID pulls the joint to a proxy, which a sliding mode
//! pulls to the set point.
//!
//! After Kikuuwe, Yasukouchi, Fujimoto and Yamamoto, "Proxy-based sliding mode control: a safer
//! extension of PID position control", *IEEE Transactions on Robotics* 26(4), 2010, pp. 670-684.
//! The proxy has no mass and is ahead of the joint by `w`; `a` is the integral of `w`. PID acts on
//! the joint, and the largest effort `U` acts on the proxy, towards the sliding surface:
//!
//! ```text
//! v_c = L a + K w + D w'          a' = w
//! v_c = U sgn(s)                  s  = (theta_d - theta_a - w) + H (theta_d' - theta_a' - w')
//! ```
//!
//! The two together are an inclusion for `w`. Backward Euler solves it in closed form, without a
//! switch and so without chatter (derived here, in the order in which it is computed):
//!
//! ```text
//! g = 1 + H/h    al = L h + K + D/h    be = L a - D w/h
//! v_c = sat[al (theta_e + H (theta_d' - theta_a') + H w/h)/g + be, U]
//! w   = (v_c - be)/al
//! a   = a + h w
//! ```
//!
//! In the first line, `s = 0` is solved for `w` and put into PID; where that needs more than `U`,
//! the proxy lags by the second line. `U` is the full scale.
//!
//! Why this form: within the limits it is PID to the letter; from far away it comes back along `s =
//! 0`, overdamped with the time constant `H`, whatever the gains. The integral cannot wind up,
//! since `w` follows from the effort that the drive can apply. Guarantees: |v_c| <= U. Does badly:
//! at rest it is PID, and hunts as PID does on a joint that really sticks (Armstrong and Amin,
//! *Automatica* 32(5), 1996). On a joint with bristles, which creeps under the integral, it settles
//! well, so a test on such joints alone is incomplete.

use crate::control::laws::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::saturation::saturate;
use crate::units::value::table;

table! {
    /// Gains of proxy-based sliding mode control.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ProxySlidingModeGains (law) "controller" {
        /// Stiffness between joint and proxy K, V/deg.
        stiffness: f32 = 0x3301 "proxy_stiffness_v_per_deg", Above(0.0, HUGE), Needed(1.0);
        /// Damping between joint and proxy D, V/(deg/s).
        damping: f32 = 0x3302 "proxy_damping_v_per_deg_per_s", Between(0.0, HUGE), Needed(0.17);
        /// Integral gain between joint and proxy L, V/(deg s).
        integral: f32 = 0x3303 "proxy_integral_v_per_deg_s", Between(0.0, HUGE), Needed(1.0);
        /// Time constant of the sliding surface H, s.
        surface_time: f32 = 0x3304 "proxy_surface_time_s", Between(0.0, HUGE), Needed(0.1);
    }
}

/// The law PSMC, prepared for one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProxySlidingMode {
    sample_time: f32,
    /// L, V/(deg s).
    integral: f32,
    /// D/h, V/deg.
    damping: f32,
    /// H, s.
    surface_time: f32,
    /// H/h.
    surface: f32,
    /// al/g and 1/al.
    gain: f32,
    compliance: f32,
    full_scale: f32,
}

/// The state of the law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProxySlidingModeState {
    /// Lead of the proxy w, deg, and its integral a, deg s.
    lead: f32,
    area: f32,
}

impl Law for ProxySlidingMode {
    type Gains = ProxySlidingModeGains;
    type State = ProxySlidingModeState;

    const REPLACES_PD: bool = true;
    const ON_THE_DEVICE: bool = false;

    fn new(gains: &ProxySlidingModeGains, around: &Loop) -> Self {
        let ProxySlidingModeGains { stiffness, damping, integral, surface_time } = *gains;
        let h = around.sample_time;
        let stiff = integral * h + stiffness + damping / h;
        Self {
            sample_time: h,
            integral,
            damping: damping / h,
            surface_time,
            surface: surface_time / h,
            gain: stiff / (1.0 + surface_time / h),
            compliance: 1.0 / stiff,
            full_scale: around.full_scale,
        }
    }

    /// Runs one tick, and returns the effort v_c of the law, V.
    ///
    /// ```
    /// use stiction::control::laws::rival::proxy_sliding_mode::ProxySlidingModeState;
    /// use stiction::control::laws::{Law, LawInput, Loop, ProxySlidingMode, ProxySlidingModeGains};
    /// let gains = ProxySlidingModeGains {
    ///     stiffness: 2.0,
    ///     damping: 0.0,
    ///     integral: 0.0,
    ///     surface_time: 0.02,
    /// };
    /// let law = ProxySlidingMode::new(&gains, &Loop::EXAMPLE);
    /// let mut state = ProxySlidingModeState::default();
    /// let input = LawInput { error: 1.0, ..LawInput::default() };
    /// // The proxy goes half the way in the first tick, since H is one sample.
    /// assert_eq!(law.update(&mut state, &input), 1.0);
    /// assert_eq!(law.update(&mut state, &input), 1.5);
    /// ```
    fn update(&self, state: &mut ProxySlidingModeState, input: &LawInput) -> f32 {
        let ProxySlidingModeState { lead, area } = *state;
        let past = self.integral * area - self.damping * lead;
        let ahead = input.error + self.surface_time * input.velocity_error + self.surface * lead;
        let (v_c, _) = saturate(self.gain * ahead + past, self.full_scale);
        state.lead = (v_c - past) * self.compliance;
        state.area = area + self.sample_time * state.lead;
        v_c
    }
}
