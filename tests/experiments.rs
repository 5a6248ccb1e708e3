//! Built-in experiments for the tests of the loop, under every law of the core's list.
// What fails here fails the test that asked for it.
#![allow(clippy::unwrap_used, clippy::panic)]

use host_sim::experiment::{Document, Experiment, builtins};
use host_sim::machine::Laws;
use host_sim::written::{AllGains, Scalar, Written};
use stiction::compensator::Gains;
use stiction::pd::PdGains;
use stiction::value::Table;

/// Every controller of a device by its name: plain PD, and each law by itself.
pub fn controllers() -> impl Iterator<Item = &'static str> {
    let laws = Gains::EXAMPLES.iter().filter(|law| law.on_the_device());
    std::iter::once("pd").chain(laws.map(Gains::name))
}

/// Plans an experiment under some of its controllers, none of them for those that its file lists,
/// with keys set as on the command line.
///
/// A law without gains in the file has those of its declaration's example, beside PD's. So a law
/// that is new to the core's list runs in every test, and no experiment of the thesis has to name
/// it.
pub fn experiment(name: &str, controllers: &[&str], set: &[&str]) -> Experiment {
    let mut document = Document::parse(name, &with_every_law(name)).unwrap();
    let owned = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    document.set(&owned(set)).unwrap();
    let fixed: Vec<String> =
        set.iter().filter_map(|text| text.split_once('=')).map(|(key, _)| key.to_owned()).collect();
    Experiment::plan(&document, &owned(controllers), &fixed).unwrap()
}

/// The text of an experiment, with a table for each law that it has no gains for.
fn with_every_law(name: &str) -> String {
    let builtin = builtins().iter().find(|builtin| builtin.name == name);
    let text = builtin.unwrap_or_else(|| panic!("no experiment is called {name}")).toml;
    let has = |law: &str| text.contains(&format!("[controller.{law}]"));
    let new = Gains::EXAMPLES.iter().filter(|law| has("pd") && !has(law.name()));
    [text.to_owned()].into_iter().chain(new.map(example)).collect()
}

/// The table of a law's example.
fn example(law: &Gains) -> String {
    let mut table = Written::<AllGains, Laws>::default();
    table.put(PdGains::ABOUT, &PdGains::EXAMPLE);
    let declared = Gains::NAMES.iter().zip(Gains::ABOUT).find(|(name, _)| **name == law.name());
    table.put(declared.into_iter().flat_map(|(_, about)| about.iter()), law);
    let keys = table.iter().map(|(key, value)| {
        let value = match value {
            Scalar::Number(number) => format!("{number:?}"),
            Scalar::Whole(whole) => whole.to_string(),
            Scalar::Flag(flag) => flag.to_string(),
            Scalar::Choice(word) => format!("{word:?}"),
        };
        format!("{key} = {value}\n")
    });
    [format!("\n[controller.{}]\n", law.name())].into_iter().chain(keys).collect()
}
