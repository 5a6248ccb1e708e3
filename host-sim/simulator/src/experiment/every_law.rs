//! Extends a built-in experiment to every law of the core's list.

use stiction::control::laws::Gains;
use stiction::control::pd::PdGains;
use stiction::units::value::{Absent, Table};

use super::controller::about_law;
use files::document::Builtin;
use files::machine::{Laws, PD};
use files::written::{AllGains, FileScalar, ParameterTable};

/// Returns the names of all controllers of a device: plain PD, and each law alone.
pub fn every_controller() -> Vec<String> {
    let laws = Gains::EXAMPLES.iter().filter(|law| law.on_the_device());
    [PD].into_iter().chain(laws.map(Gains::name)).map(str::to_owned).collect()
}

/// Returns the text of an experiment, with a table added for each law that it lacks. An experiment
/// without PD stays as it is.
///
/// These tables have the example gains of the law's declaration, and PD's. So every test runs and
/// measures a law as soon as it is in the core's list, and the experiments of the thesis need not
/// name it.
pub fn with_every_law(builtin: &Builtin) -> String {
    let text = builtin.toml;
    let has = |law: &str| text.contains(&format!("[controller.{law}]"));
    let new = Gains::EXAMPLES.iter().filter(|law| has(PD) && !has(law.name()));
    [text.to_owned()].into_iter().chain(new.map(example)).collect()
}

/// Returns the table of a law's example gains, without those that have a default.
fn example(law: &Gains) -> String {
    let mut table = ParameterTable::<AllGains, Laws>::default();
    table.put(PdGains::ABOUT, &PdGains::EXAMPLE);
    table.put(about_law(law).iter().filter(|about| about.absent == Absent::Needed), law);
    let keys = table.iter().filter_map(|(key, value)| {
        let value = match value {
            FileScalar::Number(number) => format!("{number:?}"),
            FileScalar::Whole(whole) => whole.to_string(),
            FileScalar::Flag(flag) => flag.to_string(),
            // A choice has a default.
            FileScalar::Choice(_) => return None,
        };
        Some(format!("{key} = {value}\n"))
    });
    [format!("\n[controller.{}]\n", law.name())].into_iter().chain(keys).collect()
}
