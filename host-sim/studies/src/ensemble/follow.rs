//! Slow set points: whether a joint follows a ramp of a few counts a second without steps.
//!
//! A joint is armed; then the set point moves at a constant speed for 20 s. From 2 s on the joint
//! is judged at the encoder, by the root mean square and the largest value of its true error, and
//! by its stops ([`TrackingJudge`](super::measures::TrackingJudge)). A joint *follows* a ramp if no
//! monitor ends it and its error stays within 2.5 counts, or within what the set point travels in
//! 20 ms if that is more. The *slowest speed without steps* is the lowest of the ramps at which 9
//! of 10 joints follow, here and at each faster ramp.
//!
//! Does badly: a ramp has one speed, so what a law does at a reversal is not seen; a true error of
//! half a count is that of the encoder's resolution.

use std::sync::{Mutex, PoisonError};

use serde::Serialize;
use stiction::control::reference::{Corner, Reference, Trajectory};

use super::drawn_case::Case;
use super::family::Family;
use super::measures::TrackingJudge;
use super::rig::Rig;
use super::run::{Ensemble, each_joint};
use super::statistics::SortedValues;
use files::error::Error;
use simulator::experiment::position;
use simulator::progress::Progress;
use simulator::rules::{ControllerGains, GainRule};

/// Speeds of the ramps, counts a second.
pub const RAMPS: [f64; 7] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];

/// Time at which the set point leaves its rest, and half of the blend there, s.
const LEAVES_S: f64 = 0.1;
const HALF_BLEND_S: f64 = 0.05;

/// Length of a ramp, and the time from which it is judged, s.
pub(super) const LASTS_S: f64 = 20.0;
pub(super) const JUDGED_FROM_S: f64 = 2.0;

/// Error within which a joint follows, counts: two counts and the half that an encoder hides.
pub(super) const BAND_COUNTS: f64 = 2.5;

/// Time by which a joint can lag and still follow, s: to the eye a fiftieth is no step.
pub(super) const BAND_S: f64 = 0.02;

/// Share of the joints that have to follow.
const SHARE: f64 = 0.9;

/// Result of one joint on one ramp under one law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FollowedRamp {
    /// Name of the family.
    pub family: String,
    /// Name of the law.
    pub law: String,
    /// Number of the joint.
    pub case: u64,
    /// Speed of the set point, counts a second.
    pub counts_per_s: f64,
    /// Root mean square of the error, counts; none if a fault ended the ramp.
    pub rms_counts: Option<f64>,
    /// Largest error, counts; none if a fault ended the ramp.
    pub peak_counts: Option<f64>,
    /// Number of stops on the way.
    pub stops: u32,
    /// Fault that ended the ramp.
    pub fault: Option<String>,
}

/// Results of a law on one ramp, over all joints of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct RampSummary {
    /// Speed of the set point, counts a second.
    pub counts_per_s: f64,
    /// Root mean squares of the error, counts; infinite if a fault ended the ramp.
    pub rms_counts: SortedValues,
    /// Largest errors, counts; infinite if a fault ended the ramp.
    pub peak_counts: SortedValues,
    /// Number of stops of each joint.
    pub stops: SortedValues,
    /// Number of joints that follow.
    pub follow: usize,
    /// Number of joints.
    pub joints: usize,
}

/// Results of a law on a family.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowSummary {
    /// Name of the family.
    pub family: String,
    /// Name of the law.
    pub law: String,
    /// Each ramp, from the slowest on.
    pub ramps: Vec<RampSummary>,
}

impl FollowedRamp {
    fn follows(&self) -> bool {
        self.peak_counts.is_some_and(|peak| peak <= band_counts(self.counts_per_s))
    }
}

/// Returns the error within which a joint follows a ramp, counts.
fn band_counts(counts_per_s: f64) -> f64 {
    BAND_COUNTS.max(BAND_S * counts_per_s)
}

impl FollowSummary {
    /// Returns the slowest speed without steps, counts a second; `None` if too few joints follow
    /// the fastest ramp.
    pub fn slowest(&self) -> Option<f64> {
        let is_followed = |ramp: &&RampSummary| ramp.follow as f64 >= SHARE * ramp.joints as f64;
        self.ramps.iter().rev().take_while(is_followed).last().map(|ramp| ramp.counts_per_s)
    }
}

/// Runs every ramp on every joint under every law of an ensemble, and returns the rows in order.
/// The ensemble's approach and moves are ignored.
///
/// # Errors
/// If a family has two joints or a wall, or the core refuses gains.
pub fn follow(ensemble: &Ensemble, progress: &impl Progress) -> Result<Vec<FollowedRamp>, Error> {
    over_joints(ensemble, progress, |case, law, gains| {
        RAMPS.into_iter().map(|speed| ramp(case, law, gains, speed)).collect()
    })
}

/// Runs motions on every joint under every law, and returns their rows by family, law and joint.
///
/// # Errors
/// If a family has two joints or a wall, or a motion fails.
pub(super) fn over_joints<Row: Send>(
    ensemble: &Ensemble,
    progress: &impl Progress,
    motions: impl Fn(&Case, &str, &ControllerGains) -> Result<Vec<Row>, Error> + Sync,
) -> Result<Vec<Row>, Error> {
    let unfit = ensemble.families.iter().find(|family| family.is_arm() || family.has_wall());
    if let Some(family) = unfit {
        return Err(Error::Input(format!(
            "--plant {}: ramps and sines need a family with one joint and without a wall",
            family.name()
        )));
    }
    let all = Mutex::new(Vec::new());
    each_joint(
        ensemble,
        progress,
        |_, _| true,
        |joint| {
            let family = ensemble.families.iter().position(|family| *family == joint.family);
            for (law, rule) in ensemble.rules.iter().enumerate() {
                let [gains] = &joint.each(|bounds| GainRule::gains(rule, bounds))[..] else {
                    continue;
                };
                let rows = motions(joint, rule.law, gains)?;
                let place = (family, law, joint.number);
                all.lock().unwrap_or_else(PoisonError::into_inner).push((place, rows));
            }
            Ok(())
        },
    )?;
    let mut all = all.into_inner().unwrap_or_else(PoisonError::into_inner);
    all.sort_by_key(|(place, _)| *place);
    Ok(all.into_iter().flat_map(|(_, rows)| rows).collect())
}

/// Returns the families that `all` selects here: the usual ones that have one joint.
pub fn followed_families() -> impl Iterator<Item = Family> {
    Family::USUAL.into_iter().filter(|family| !family.is_arm())
}

fn ramp(
    case: &Case,
    law: &str,
    gains: &ControllerGains,
    counts_per_s: f64,
) -> Result<FollowedRamp, Error> {
    let h = case.bounds.sampled.sample_time;
    let tick = |time_s: f64| (time_s / h).round() as u32;
    let end_s = LEAVES_S + LASTS_S;
    let corners = [(LEAVES_S, 0.0), (end_s, LASTS_S * counts_per_s)]
        .map(|(time_s, counts)| Corner { tick: tick(time_s), position: position(counts) });
    let count = case.bounds.sampled.count as f32;
    let trajectory = Trajectory::new(&corners, HALF_BLEND_S as f32, h as f32, count);
    let trajectory = trajectory.map_err(|error| {
        Error::Input(format!("--rate {}: the ramp does not fit it: {error:?}", 1.0 / h))
    })?;
    let window = [tick(LEAVES_S + JUDGED_FROM_S), tick(end_s - HALF_BLEND_S) - 1];
    let mut judge = TrackingJudge::new(window, counts_per_s * h);
    let mut rig = Rig::armed(case, gains)?;
    let follows = rig.follow(Reference::Trajectory(trajectory));
    let mut peak = 0.0f64;
    for k in (0..=window[1]).take_while(|_| follows) {
        let sample = rig.step();
        if rig.fault().is_some() {
            break;
        }
        judge.see(&sample);
        if k >= window[0] {
            peak = peak.max(sample.error.abs());
        }
    }
    let measures = judge.measures(h);
    Ok(FollowedRamp {
        family: case.family.name().into(),
        law: law.into(),
        case: case.number,
        counts_per_s,
        rms_counts: measures.rms_counts,
        peak_counts: measures.rms_counts.map(|_| peak),
        stops: measures.sticks,
        fault: rig.failure(),
    })
}

/// Summarises the rows of each law on each family.
pub fn follow_summaries(rows: &[FollowedRamp]) -> Vec<FollowSummary> {
    let same = |a: &FollowedRamp, b: &FollowedRamp| (&a.family, &a.law) == (&b.family, &b.law);
    let of = |of_law: &[FollowedRamp], speed: f64| {
        let ramps: Vec<&FollowedRamp> =
            of_law.iter().filter(|row| row.counts_per_s == speed).collect();
        let values = |value: fn(&FollowedRamp) -> Option<f64>| {
            SortedValues::new(ramps.iter().map(|row| value(row).unwrap_or(f64::INFINITY)))
        };
        RampSummary {
            counts_per_s: speed,
            rms_counts: values(|row| row.rms_counts),
            peak_counts: values(|row| row.peak_counts),
            stops: values(|row| Some(row.stops.into())),
            follow: ramps.iter().filter(|row| row.follows()).count(),
            joints: ramps.len(),
        }
    };
    rows.chunk_by(same)
        .filter_map(|of_law| {
            let FollowedRamp { family, law, .. } = of_law.first()?.clone();
            Some(FollowSummary { family, law, ramps: RAMPS.map(|speed| of(of_law, speed)).into() })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::{Approach, DrawOptions};
    use simulator::progress::Silent;
    use simulator::rules::rules;

    fn followed(case: u64, counts_per_s: f64, peak_counts: Option<f64>) -> FollowedRamp {
        FollowedRamp {
            family: "rigid".into(),
            law: "pd".into(),
            case,
            counts_per_s,
            rms_counts: peak_counts.map(|peak| 0.5 * peak),
            peak_counts,
            stops: 0,
            fault: None,
        }
    }

    /// Returns the slowest speed of ten joints, of which the first `follow[k]` follow ramp `k`.
    fn slowest(follow: [u64; 7]) -> Option<f64> {
        let rows: Vec<FollowedRamp> = (0..10)
            .flat_map(|case| {
                RAMPS.into_iter().zip(follow).map(move |(speed, good)| {
                    let peak = band_counts(speed) + if case < good { 0.0 } else { 0.1 };
                    followed(case, speed, Some(peak))
                })
            })
            .collect();
        follow_summaries(&rows)[0].slowest()
    }

    #[test]
    fn the_slowest_speed_is_the_lowest_from_which_nine_of_ten_joints_follow_every_ramp() {
        assert_eq!(slowest([9; 7]), Some(1.0));
        assert_eq!(slowest([8, 9, 10, 9, 9, 9, 9]), Some(3.0));
        // A ramp in between is not followed: slower ones do not count.
        assert_eq!(slowest([10, 10, 10, 10, 8, 9, 9]), Some(300.0));
        assert_eq!(slowest([10, 10, 10, 10, 10, 10, 8]), None);
    }

    #[test]
    fn a_ramp_that_a_fault_ends_is_not_followed_and_has_an_infinite_error() {
        let rows: Vec<FollowedRamp> = (0..10)
            .flat_map(|case| RAMPS.map(|speed| followed(case, speed, (case > 1).then_some(1.0))))
            .collect();
        let summary = &follow_summaries(&rows)[0];
        assert_eq!(summary.slowest(), None);
        assert_eq!(summary.ramps[0].peak_counts.quantile(0.9), Some(f64::INFINITY));
        assert_eq!(summary.ramps[0].peak_counts.quantile(0.8), Some(1.0));
    }

    fn of_pd(family: Family, cases: u64) -> Ensemble {
        Ensemble {
            seed: 1,
            cases,
            kind: DrawOptions::ORDINARY,
            approach: Approach::Profiled,
            moves: 0,
            families: vec![family],
            rules: rules(&["pd".into()]).unwrap(),
        }
    }

    /// PD commands `Kp e` and `Kd r'`: a joint that sticks lags by the friction over Kp, and one
    /// that slides fast enough follows within the same. A bound for both is twice the friction.
    #[test]
    fn pd_lags_a_ramp_by_its_friction_and_no_more() {
        let ensemble = of_pd(Family::Rigid, 2);
        let rows = follow(&ensemble, &Silent).unwrap();
        assert_eq!(rows.len(), 2 * RAMPS.len());
        for row in &rows {
            let joint = Case::draw(1, Family::Rigid, row.case, ensemble.kind);
            let gains = &joint.each(|bounds| GainRule::gains(ensemble.rules[0], bounds))[0];
            let lag =
                joint.bounds.breakaway[1] / f64::from(gains.pd.kp) / joint.bounds.sampled.count;
            let rms = row.rms_counts.unwrap();
            assert!(rms > 0.05 * lag && rms < 2.0 * lag, "{row:?}: {lag} counts");
            assert!(row.peak_counts.unwrap() >= rms && row.fault.is_none(), "{row:?}");
        }
    }

    /// With pulses, which throw a load to and fro behind its gear, six of 40 joints tripped.
    #[test]
    fn a_load_behind_a_soft_gear_trips_no_monitor_on_a_slow_ramp() {
        let rules = rules(&["robust".into()]).unwrap();
        let ensemble = Ensemble { rules, ..of_pd(Family::FlexibleLoad, 40) };
        let slow = |case: &Case, law: &str, gains: &ControllerGains| {
            Ok(vec![ramp(case, law, gains, 10.0)?])
        };
        let rows = over_joints(&ensemble, &Silent, slow).unwrap();
        assert_eq!(rows.len(), 40);
        let tripped: Vec<_> = rows.iter().filter(|row| row.fault.is_some()).collect();
        assert!(tripped.is_empty(), "{tripped:?}");
    }

    #[test]
    fn a_family_of_two_joints_or_with_a_wall_is_refused() {
        for family in [Family::Arm, Family::EndStop] {
            let why = follow(&of_pd(family, 1), &Silent).unwrap_err().to_string();
            assert!(why.contains(family.name()), "{why}");
        }
        assert_eq!(followed_families().count(), 9);
    }
}
