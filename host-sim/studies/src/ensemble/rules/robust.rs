//! Robust: what it wants to be told, and nothing else; the law has its own rules for the rest.

use stiction::control::laws::robust::EncoderSide;
use stiction::control::laws::{Gains, RobustGains};
use stiction::units::value::Table as _;

use super::{Rule, Told, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "robust",
    text: "is told J, B, F_lo, F_hi, the encoder's side and its jitter. If a load drives the \
           joint, it is told the largest load as well, and within 20 % what holds it",
    constant: 1.0,
    tried: &[],
    tune: |told, _| around_pd(told, Some(Gains::Robust(gains(told)))),
};

fn gains(told: &Told) -> RobustGains {
    RobustGains {
        inertia: told.inertia as f32,
        viscous: told.viscous as f32,
        breakaway_low: told.breakaway[0] as f32,
        breakaway_high: told.breakaway[1] as f32,
        encoder_side: if told.encoder_at_load { EncoderSide::Load } else { EncoderSide::Motor },
        jitter: told.jitter as f32,
        load: told.load as f32,
        hold_effort: told.hold_effort as f32,
        ..RobustGains::EXAMPLE
    }
}
