//! A joint with an encoder on its motor and another one on its load, as `stiction new` writes it.

use files::document::Document;
use simulator::draft;
use simulator::experiment::{Experiment, RunPlan};

/// Keys of a joint whose gear is so stiff, and without slack, that both sides move as one.
pub const STIFF: [&str; 2] = ["gear.backlash_deg=0", "gear.stiffness_nm_per_rad=20000"];

/// Plans the runs of a joint with 0.3 deg of slack behind 1000 N m/rad: 100 000 counts a turn of
/// the joint on its motor, 16 384 on its load. Controllers and keys are set as on the command line.
pub fn both_encoders(controllers: &[&str], set: &[&str]) -> Vec<RunPlan> {
    let owned = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    let mut document = Document::parse("both-encoders", &draft::both_encoders().unwrap()).unwrap();
    document.set(&owned(set)).unwrap();
    Experiment::plan(&document, &owned(controllers), &[]).unwrap().runs
}
