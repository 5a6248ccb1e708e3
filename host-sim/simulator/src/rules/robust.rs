//! Robust: only the known values of the joint; the law derives the rest by its own rules
//! (`src/control/laws/robust/parameters.rs`).
//!
//! ```text
//! J, B, F_lo, F_hi, side and jitter of the encoder, u_L, hold effort
//! ```
//!
//! The law replaces PD, whose gains are zero. If the joint has more friction than F_hi or less than
//! F_lo, nothing is guaranteed.

use stiction::control::laws::robust::EncoderSide;
use stiction::control::laws::{Gains, RobustDualGains, RobustGains};
use stiction::control::pd::PdGains;
use stiction::units::value::Table as _;

use super::pd_loop::VELOCITY_WINDOW;
use super::{ControllerGains, GainRule, JointBounds, MotorEncoder, four_digits_single};

/// Rule that gives the gains of this law from the bounds of a joint.
pub const RULE: GainRule = GainRule {
    law: "robust",
    knows: "inertia, viscous friction, both bounds of the breakaway effort, side and jitter of the \
            encoder; where a load drives the joint, also its bound and, within 20 %, the effort \
            that holds it",
    text: "J, B, F_lo, F_hi, side and jitter of the encoder, the largest load that drives the \
           joint and the effort that holds it as known",
    constant: 1.0,
    tried: &[],
    gains_with: |joint, _| ControllerGains {
        pd: PdGains { kp: 0.0, kd: 0.0 },
        velocity_window: VELOCITY_WINDOW,
        laws: vec![law(joint)],
    },
};

/// Returns the law: `robust` for one encoder, or its variant for two, on motor and load.
fn law(joint: &JointBounds) -> Gains {
    match &joint.motor_encoder {
        Some(motor) => Gains::RobustDual(of_two(joint, motor)),
        None => Gains::Robust(gains(joint)),
    }
}

fn of_two(joint: &JointBounds, motor: &MotorEncoder) -> RobustDualGains {
    let [breakaway_low, breakaway_high] = joint.breakaway.map(four_digits_single);
    RobustDualGains {
        inertia: four_digits_single(joint.inertia),
        viscous: four_digits_single(joint.viscous),
        breakaway_low,
        breakaway_high,
        jitter: joint.jitter as f32,
        motor_jitter: motor.jitter as f32,
        load: four_digits_single(joint.load),
        hold_effort: four_digits_single(joint.hold_effort),
        ..RobustDualGains::EXAMPLE
    }
}

fn gains(joint: &JointBounds) -> RobustGains {
    let mut gains = RobustGains {
        encoder_side: if joint.encoder_at_load { EncoderSide::Load } else { EncoderSide::Motor },
        jitter: joint.jitter as f32,
        load: four_digits_single(joint.load),
        hold_effort: four_digits_single(joint.hold_effort),
        ..RobustGains::EXAMPLE
    };
    set_joint(&mut gains, joint);
    gains
}

/// Sets inertia, viscous friction, bounds of the breakaway effort, and a load that drives the
/// joint. All other gains keep the values of the device.
pub fn set_joint(gains: &mut RobustGains, joint: &JointBounds) {
    gains.inertia = four_digits_single(joint.inertia);
    gains.viscous = four_digits_single(joint.viscous);
    [gains.breakaway_low, gains.breakaway_high] = joint.breakaway.map(four_digits_single);
    if joint.load > 0.0 {
        gains.load = four_digits_single(joint.load);
    }
}
