//! Built-in experiments for the tests of the loop, under every law of the core's list, and the
//! flash image.
// What fails here fails the test that asked for it.
#![allow(clippy::unwrap_used, clippy::panic)]

pub mod axis_with_play;
pub mod axis_with_stops;
pub mod both_encoders;
pub mod braking;
pub mod current_sensor;
#[cfg(feature = "emulator")]
pub mod flash_image;
pub mod matrix;

use simulator::experiment::{Document, Experiment, builtins, with_every_law};
use stiction::control::laws::Gains;

/// Every controller of a device by its name: plain PD, and each law by itself.
pub fn controllers() -> impl Iterator<Item = &'static str> {
    let laws = Gains::EXAMPLES.iter().filter(|law| law.on_the_device());
    std::iter::once("pd").chain(laws.map(Gains::name))
}

/// Plans an experiment under some of its controllers, none of them for those that its file lists,
/// with keys set as on the command line.
pub fn experiment(name: &str, controllers: &[&str], set: &[&str]) -> Experiment {
    let builtin = builtins().iter().find(|builtin| builtin.name == name);
    let builtin = builtin.unwrap_or_else(|| panic!("no experiment is called {name}"));
    let mut document = Document::parse(name, &with_every_law(builtin)).unwrap();
    let owned = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    document.set(&owned(set)).unwrap();
    let fixed: Vec<String> =
        set.iter().filter_map(|text| text.split_once('=')).map(|(key, _)| key.to_owned()).collect();
    Experiment::plan(&document, &owned(controllers), &fixed).unwrap()
}
