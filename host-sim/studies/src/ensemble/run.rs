//! All cases of an ensemble, on every core.

use rayon::prelude::*;

use super::case;
use super::case_result::CaseResult;
use super::drawn_case::{Case, DrawOptions};
use super::family::Family;
use super::motions::{Approach, Motions};
use files::error::Error;
use simulator::progress::Progress;
use simulator::rules::{ControllerGains, GainRule, JointBounds};

/// Joints, motions and laws of an ensemble.
#[derive(Clone)]
pub struct Ensemble {
    /// The seed of every draw.
    pub seed: u64,
    /// Number of joints of each family.
    pub cases: u64,
    /// Options of the draw beside the seed.
    pub kind: DrawOptions,
    /// How the set point goes to the target.
    pub approach: Approach,
    /// Number of moves in a row; 0: none.
    pub moves: u32,
    /// The families.
    pub families: Vec<Family>,
    /// The laws.
    pub rules: Vec<&'static GainRule>,
}

/// Runs the cases for which `wanted` returns true (family, number of the case, law), and passes
/// each row to `take` as soon as it is there, in any order. A joint is a step of `progress`.
///
/// # Errors
/// Returns the first error of a case, of `take` or of `progress`. Other cases can have been run
/// before it.
pub fn run(
    ensemble: &Ensemble,
    progress: &impl Progress,
    wanted: impl Fn(Family, u64, &str) -> bool + Sync,
    take: impl Fn(CaseResult) -> Result<(), Error> + Sync,
) -> Result<(), Error> {
    run_with(ensemble, progress, GainRule::gains, wanted, take)
}

/// Runs cases as [`run`] does, with the gains that `gains` returns for a rule and a joint.
///
/// # Errors
/// As [`run`].
pub(super) fn run_with(
    ensemble: &Ensemble,
    progress: &impl Progress,
    gains: impl Fn(&GainRule, &JointBounds) -> ControllerGains + Sync,
    wanted: impl Fn(Family, u64, &str) -> bool + Sync,
    take: impl Fn(CaseResult) -> Result<(), Error> + Sync,
) -> Result<(), Error> {
    let Ensemble { seed, approach, moves, rules, .. } = ensemble;
    let motions = Motions { approach: *approach, seed: *seed, moves: *moves };
    let is_wanted =
        |family: &Family, number: u64| rules.iter().any(|rule| wanted(*family, number, rule.law));
    each_joint(ensemble, progress, is_wanted, |joint| {
        for rule in rules.iter().filter(|rule| wanted(joint.family, joint.number, rule.law)) {
            take(case::run(joint, rule.law, &joint.each(|bounds| gains(rule, bounds)), motions)?)?;
        }
        Ok(())
    })
}

/// Draws the joints for which `is_wanted` returns true, and calls `act` with each of them, on every
/// core.
///
/// # Errors
/// Returns the first error. Other joints can have been run before it.
pub(super) fn each_joint(
    ensemble: &Ensemble,
    progress: &impl Progress,
    is_wanted: impl Fn(&Family, u64) -> bool,
    act: impl Fn(&Case) -> Result<(), Error> + Sync,
) -> Result<(), Error> {
    let Ensemble { seed, cases, kind, families, .. } = ensemble;
    let of = |family: &Family| (0..*cases).map(|number| (*family, number)).collect::<Vec<_>>();
    let mut joints: Vec<(Family, u64)> = families.iter().flat_map(of).collect();
    joints.retain(|(family, number)| is_wanted(family, *number));
    progress.start(joints.len() as u64, "joints");
    joints.par_iter().try_for_each(|(family, number)| {
        act(&Case::draw(*seed, *family, *number, *kind))?;
        progress.step()
    })
}
