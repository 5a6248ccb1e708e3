//! Sines: how closely a joint follows a set point that goes to and fro.
//!
//! ```text
//! r(t) = a (1 - cos 2 pi f t),   a = min(0.1 rad, 0.5 rad/s / (2 pi f))
//! ```
//!
//! A joint is armed, follows for 20 s, and is judged in the last 10 s, which are whole periods of
//! every frequency: by the root mean square of its true error at the encoder, and by its largest
//! error at a reversal, where the set point has less than a fifth of its largest speed.
//!
//! Does badly: the default limits of speed are not those of this motion. A law whose limit is lower
//! trips, and its error is infinite.

use serde::Serialize;
use stiction::control::reference::{Reference, Sine};
use stiction::units::position::Position;

use super::drawn_case::Case;
use super::follow::over_joints;
use super::measures::TrackingJudge;
use super::rig::Rig;
use super::run::Ensemble;
use super::statistics::SortedValues;
use files::error::Error;
use simulator::metrics::REVERSES;
use simulator::progress::Progress;
use simulator::rules::ControllerGains;

/// Frequencies of the sines, Hz.
pub const SINES: [f64; 5] = [0.1, 0.5, 1.0, 2.0, 5.0];

/// Largest amplitude, rad, and largest speed, rad/s.
const MOST: [f64; 2] = [0.1, 0.5];

/// Length of a sine, and the time from which it is judged, s.
const LASTS_S: f64 = 20.0;
const JUDGED_FROM_S: f64 = 10.0;

/// Result of one joint on one sine under one law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FollowedSine {
    /// Name of the family.
    pub family: String,
    /// Name of the law.
    pub law: String,
    /// Number of the joint.
    pub case: u64,
    /// Frequency of the set point, Hz.
    pub hz: f64,
    /// Root mean square of the error, mrad; none if a fault ended the sine.
    pub rms_mrad: Option<f64>,
    /// Largest error at a reversal, mrad; none if a fault ended the sine.
    pub reversal_mrad: Option<f64>,
    /// Fault that ended the sine.
    pub fault: Option<String>,
}

/// Results of a law on one sine, over all joints of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct SineSummary {
    /// Frequency of the set point, Hz.
    pub hz: f64,
    /// Root mean squares of the error, mrad; infinite if a fault ended the sine.
    pub rms_mrad: SortedValues,
    /// Largest errors at a reversal, mrad; infinite if a fault ended the sine.
    pub reversal_mrad: SortedValues,
    /// Number of joints.
    pub joints: usize,
}

/// Results of a law on the sines, over all joints of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct SinesSummary {
    /// Name of the family.
    pub family: String,
    /// Name of the law.
    pub law: String,
    /// Each sine, from the slowest on.
    pub sines: Vec<SineSummary>,
}

/// Runs every sine on every joint under every law of an ensemble, and returns the rows in order.
///
/// # Errors
/// If a family has two joints or a wall, or the core refuses gains.
pub fn follow_sines(
    ensemble: &Ensemble,
    progress: &impl Progress,
) -> Result<Vec<FollowedSine>, Error> {
    over_joints(ensemble, progress, |case, law, gains| {
        SINES.into_iter().map(|hz| sine(case, law, gains, hz)).collect()
    })
}

fn sine(case: &Case, law: &str, gains: &ControllerGains, hz: f64) -> Result<FollowedSine, Error> {
    let (h, count) = (case.bounds.sampled.sample_time, case.bounds.sampled.count);
    let angular = std::f64::consts::TAU * hz;
    let amplitude = MOST[0].min(MOST[1] / angular);
    let counts = amplitude.to_degrees() / count;
    let reference =
        Sine::new(Position::default(), counts as f32, hz as f32, h as f32, count as f32);
    let reference = reference.map_err(|error| {
        Error::Input(format!("--rate {}: the sine does not fit it: {error:?}", 1.0 / h))
    })?;
    let [from, last] = [JUDGED_FROM_S, LASTS_S].map(|time_s| (time_s / h).round() as u32);
    let top = counts * angular * h;
    let mut judge = TrackingJudge::new([from, last - 1], top);
    let mut rig = Rig::armed(case, gains)?;
    let follows = rig.follow(Reference::Sine(reference));
    let mut reversal = 0.0f64;
    for k in (0..last).take_while(|_| follows) {
        let sample = rig.step();
        if rig.fault().is_some() {
            break;
        }
        judge.see(&sample);
        if k >= from && sample.speed.abs() < REVERSES * top {
            reversal = reversal.max(sample.error.abs());
        }
    }
    let rms_counts = judge.measures(h).rms_counts;
    let mrad = |counts: f64| 1e3 * (counts * count).to_radians();
    Ok(FollowedSine {
        family: case.family.name().into(),
        law: law.into(),
        case: case.number,
        hz,
        rms_mrad: rms_counts.map(mrad),
        reversal_mrad: rms_counts.map(|_| mrad(reversal)),
        fault: rig.failure(),
    })
}

/// Summarises the rows of each law on each family.
pub fn sine_summaries(rows: &[FollowedSine]) -> Vec<SinesSummary> {
    let of = |of_law: &[FollowedSine], hz: f64| {
        let sines: Vec<&FollowedSine> = of_law.iter().filter(|row| row.hz == hz).collect();
        let values = |value: fn(&FollowedSine) -> Option<f64>| {
            SortedValues::new(sines.iter().map(|row| value(row).unwrap_or(f64::INFINITY)))
        };
        SineSummary {
            hz,
            rms_mrad: values(|row| row.rms_mrad),
            reversal_mrad: values(|row| row.reversal_mrad),
            joints: sines.len(),
        }
    };
    rows.chunk_by(|a, b| (&a.family, &a.law) == (&b.family, &b.law))
        .filter_map(|of_law| {
            let FollowedSine { family, law, .. } = of_law.first()?.clone();
            Some(SinesSummary { family, law, sines: SINES.map(|hz| of(of_law, hz)).into() })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::drawn_case::DrawOptions;
    use super::super::family::Family;
    use super::*;
    use simulator::rules::{GainRule, rules};

    fn run(law: &str, number: u64, jitter: bool, hz: f64, tracking: f32) -> FollowedSine {
        let family = if jitter { Family::NoisyDeclared } else { Family::Rigid };
        let case = Case::draw(1, family, number, DrawOptions::ORDINARY);
        let rule = rules(&[law.into()]).unwrap()[0];
        let mut gains = case.each(|bounds| GainRule::gains(rule, bounds)).remove(0);
        for law in &mut gains.laws {
            if let stiction::control::laws::Gains::Robust(robust) = law {
                robust.tracking_observer = tracking;
            }
        }
        sine(&case, law, &gains, hz).unwrap()
    }

    /// A PD loop without feedforward lags by `(J a + B v + F) / Kp` at most, with the true values
    /// of the joint. Its rms is below that, and above what the friction alone does at its best.
    #[test]
    fn pd_lags_a_sine_by_what_the_motion_needs_and_no_more() {
        for number in 0..4 {
            let case = Case::draw(1, Family::Rigid, number, DrawOptions::ORDINARY);
            let gains =
                case.each(|bounds| GainRule::gains(rules(&["pd".into()]).unwrap()[0], bounds));
            let kp = f64::from(gains[0].pd.kp);
            for hz in [0.5, 2.0] {
                let row = run("pd", number, false, hz, 0.0);
                let angular = std::f64::consts::TAU * hz;
                let speed = 0.5f64.min(0.1 * angular).to_degrees();
                // Bounds of the draw: J and B to 1.5 times, and friction up to F_hi.
                let most = 1.5 * case.bounds.inertia * angular * speed
                    + (1.5 * case.bounds.viscous) * speed
                    + case.bounds.breakaway[1];
                let lag = 1e3 * (most / kp).to_radians();
                let rms = row.rms_mrad.unwrap();
                assert!(rms < lag && rms > 0.05 * lag, "{row:?}: {lag}");
                assert!(row.reversal_mrad.unwrap() > 0.0 && row.fault.is_none(), "{row:?}");
            }
        }
    }

    /// With jitter the fast observer is off, since a joint follows a sine worse with it: the median
    /// of nine joints at 1 Hz.
    #[test]
    fn a_fast_observer_follows_better_without_jitter_and_worse_with_it() {
        let median = |jitter: bool, tracking: f32| {
            let mut all: Vec<f64> = (0..9)
                .map(|number| run("robust", number, jitter, 1.0, tracking))
                .map(|row| row.rms_mrad.unwrap_or(f64::INFINITY))
                .collect();
            all.sort_by(f64::total_cmp);
            all[4]
        };
        let [fast, slow] = [300.0, 110.0].map(|tracking| median(false, tracking));
        assert!(fast < 0.7 * slow, "{fast} {slow}");
        let [fast, slow] = [300.0, 110.0].map(|tracking| median(true, tracking));
        assert!(fast > 1.2 * slow, "{fast} {slow}");
    }
}
