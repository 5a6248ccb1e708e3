//! `robust`: what it wants to be told, and nothing else; the law has its own rules for the rest.
//!
//! The gains are set by their names in a machine's file, so that a core without the law builds.

use stiction::compensator::Gains;
use stiction::value::Values as _;

use super::{Rule, Told, Tuned, around_pd};

/// Name of the law.
const NAME: &str = "robust";

/// The rule.
pub const RULE: Rule = Rule {
    law: NAME,
    text: "is told J, B, F_lo, F_hi, the encoder's side, and the largest load where one drives",
    constant: 1.0,
    tried: &[],
    tune: |told, _| told_by_name(told),
};

fn told_by_name(told: &Told) -> Tuned {
    let Some(place) = Gains::NAMES.iter().position(|name| *name == NAME) else {
        return around_pd(told, None);
    };
    let mut law = Gains::EXAMPLES[place];
    let number = |value: f64| (value as f32).to_bits();
    for (name, bits) in [
        ("inertia_v_s2_per_deg", number(told.inertia)),
        ("viscous_v_s_per_deg", number(told.viscous)),
        ("breakaway_low_v", number(told.breakaway[0])),
        ("breakaway_high_v", number(told.breakaway[1])),
        ("encoder_side", told.encoder_at_load.into()),
        ("load_v", number(told.load)),
    ] {
        if let Some(about) = Gains::ABOUT[place].iter().find(|about| about.name == name) {
            // The names are the core's own, and the numbers are within bounds that it checks.
            let _ = law.set(about.key, bits);
        }
    }
    around_pd(told, Some(law))
}
