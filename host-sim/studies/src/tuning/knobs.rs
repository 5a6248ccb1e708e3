//! Gains of a law that a tuning varies: keys of the file, with their start values.

use stiction::control::laws::{Gains, RobustGains};
use stiction::control::pd::PdGains;
use stiction::units::value::{About, Absent, Table, Values as _};

use files::error::Error;
use simulator::experiment::{RunPlan, about_law};

/// A gain that the search varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Knob {
    /// Key in the table of the controller.
    pub key: &'static str,
    /// Start value of the search: that of the file, or of the law's rule.
    pub start: f64,
}

/// Gains of `robust`; its other values describe the joint. In the core's declarations, these gains
/// follow by a rule if they are left out.
const OF_ROBUST: [&str; 3] =
    ["bandwidth_rad_per_s", "acceleration_deg_per_s2", "observer_rad_per_s"];

/// Returns the gains of a run's controller that are above zero. A gain of zero stays off.
///
/// # Errors
/// Returns an error that names an invalid gain.
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
            // Its required values describe the joint, and the others follow by rule.
        } else {
            let gains = about_law(law).iter().filter(|about| about.absent == Absent::Needed);
            gains.for_each(|about| add(about, law.get(about.key)));
        }
    }
    Ok(knobs)
}
