//! What a law has to turn: its gains, as keys of the file with the values to begin from.

use stiction::control::laws::{Gains, RobustGains};
use stiction::control::pd::PdGains;
use stiction::units::value::{About, Absent, Table, Values as _};

use files::error::Error;
use simulator::experiment::{RunPlan, about_law};

/// A gain that is turned.
#[derive(Clone, Debug, PartialEq)]
pub struct Knob {
    /// Its key in the table of the controller.
    pub key: &'static str,
    /// Where the search begins: the file's value, or what the law's rule gives.
    pub start: f64,
}

/// Gains of `robust`; its other values are figures of the joint. Of the core's
/// declarations these are the ones that a rule gives if they are left out.
const OF_ROBUST: [&str; 3] =
    ["bandwidth_rad_per_s", "acceleration_deg_per_s2", "observer_rad_per_s"];

/// Lists the gains of a run's controller that are above zero: what is off stays off.
///
/// # Errors
/// Names a gain that is not allowed.
pub fn knobs(plan: &RunPlan) -> Result<Vec<Knob>, Error> {
    let config = plan.controller_config()?;
    let mut knobs = Vec::new();
    let mut add = |about: &'static About, bits: Option<u32>| {
        let start = bits.map_or(0.0, |bits| f64::from(f32::from_bits(bits)));
        if start > 0.0 {
            knobs.push(Knob { key: about.name, start });
        }
    };
    let stands_alone = config.compensator.first().is_some_and(Gains::replaces_pd);
    if !stands_alone {
        PdGains::ABOUT.iter().for_each(|about| add(about, config.pd.get(about.key)));
    }
    for law in &config.compensator {
        if let Gains::Robust(robust) = law {
            let gains = Gains::Robust(robust.written_out(&config.around()));
            let turned = RobustGains::ABOUT.iter().filter(|about| OF_ROBUST.contains(&about.name));
            turned.for_each(|about| add(about, gains.get(about.key)));
        } else if matches!(law, Gains::RobustDual(_)) {
            // What is needed are facts of the joint, and the rest follows by rule.
        } else {
            let gains = about_law(law).iter().filter(|about| about.absent == Absent::Needed);
            gains.for_each(|about| add(about, law.get(about.key)));
        }
    }
    Ok(knobs)
}
