//! `robust`: what it wants to be told, and nothing else; the law has its own rules for the rest.

use stiction::compensator::robust::EncoderSide;
use stiction::compensator::{Gains, RobustGains};
use stiction::value::Table as _;

use super::{Rule, around_pd};

/// The rule.
pub const RULE: Rule = Rule {
    law: "robust",
    text: "is told J, B, F_lo, F_hi, the encoder's side, and the largest load where one drives",
    constant: 1.0,
    tried: &[],
    tune: |told, _| {
        let gains = RobustGains {
            inertia: told.inertia as f32,
            viscous: told.viscous as f32,
            breakaway_low: told.breakaway[0] as f32,
            breakaway_high: told.breakaway[1] as f32,
            encoder_side: if told.encoder_at_load { EncoderSide::Load } else { EncoderSide::Motor },
            load: told.load as f32,
            ..RobustGains::EXAMPLE
        };
        around_pd(told, Some(Gains::Robust(gains)))
    },
};
