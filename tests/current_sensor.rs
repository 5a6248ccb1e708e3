//! A joint whose motor has a sensor of its current.

use files::document::Document;
use simulator::draft::{Typical, text};
use simulator::experiment::{Experiment, RunPlan};

/// Plans the runs of the typical joint `harmonic` (48 V, 2.51 ohm, 4.545 V s/rad at the joint) with
/// a sensor of +-30 A. Controllers and keys are set as on the command line.
pub fn current_sensor(controllers: &[&str], set: &[&str]) -> Vec<RunPlan> {
    let owned = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    let typical = Typical::find("harmonic").unwrap();
    let answers = typical.answers().unwrap();
    let text = text("harmonic", &answers, None).unwrap();
    let mut document = Document::parse("current-sensor", &text).unwrap();
    let sensor = ["current_sensor.full_scale_a=30"];
    document.set(&owned(&[&sensor, set].concat())).unwrap();
    Experiment::plan(&document, &owned(controllers), &[]).unwrap().runs
}
