//! Result of an identification: as text, as JSON, and as the joint of a machine's file.

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::identification::{
    BreakawayLevels, Doubts, MapPoint, ModelEstimate, Outcome, Summary,
};

use super::client::Map;
use super::measured_gear::MeasuredGear;
use dynamics::joint::CoreUnits;
use files::error::Error;
use files::machine::{JointFrictionLevels, JointTable};
use files::written::single;

/// Result of an identification, and the machine that it belongs to.
#[derive(Clone, Debug)]
pub struct IdentifiedJoint {
    /// Estimates and doubts.
    pub summary: Summary,
    /// Friction at each speed.
    pub map: Map,
    /// Parameters of the identified device.
    pub parameters: Parameters,
    /// Conversion from volts to N m; `None` without a data sheet.
    pub units: Option<CoreUnits>,
    /// Gear between two encoders, in the unit of `units`; `None` if it was not identified.
    pub gear: Option<MeasuredGear>,
}

/// Returns half a sentence: how the identification has ended, and what to do.
pub const fn ended(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Running => "the identification has not ended",
        Outcome::Done => "the sequence is complete",
        Outcome::Reversed => {
            "the encoder counts AGAINST the effort: run `jog`, which says what to set"
        }
        Outcome::Pulled => {
            "the joint moved the same way under both efforts: a load moves it; take the load off, \
             or balance it, and identify again"
        }
        Outcome::Still => {
            "nothing moved up to the largest effort: look at the wiring (`jog`), or raise the \
             effort"
        }
        Outcome::RunsOn => {
            "the joint moves on without effort: a load moves it; take the load off, or balance it, \
             and identify again"
        }
        Outcome::Travel => {
            "the joint reached its travel limit: raise the travel, or lower the speed"
        }
        Outcome::Speed => "the joint reached its speed limit: lower the effort, or raise the speed",
        Outcome::Time => "the time limit was reached: raise it",
        Outcome::NoProgress => {
            "the encoder counted too little for an effort above the friction: look for an end \
             stop, check the encoder's wires (`jog`), and lower the travel"
        }
        Outcome::Capped => {
            "the motion required more than the largest effort: raise the effort, or lower the speed"
        }
    }
}

/// Returns the doubts, one sentence each.
pub fn doubts(doubts: &Doubts) -> Vec<&'static str> {
    let all = [
        (doubts.no_fit, "the motion does not identify the parameters: there is no fit"),
        (
            doubts.poor_fit,
            "the fit is POOR: the model leaves more than 5 % of the effort; do not trust it",
        ),
        (doubts.few_rows, "there were few stretches of even sliding: raise the travel or the time"),
        (
            doubts.uneven,
            "the breakaway effort differs by more than 15 % from place to place, and gravity does \
             not explain it: the friction or a load depends on the angle",
        ),
        (
            doubts.lost_motion,
            "the joint moves before it breaks away, its breakaway differs after a reversal, or \
             short pulses meet less inertia than long motions: backlash, bristles, or a shaft that \
             winds up",
        ),
        (
            doubts.unphysical,
            "the estimated inertia, friction or damping is impossible (negative or zero): do not \
             use the result",
        ),
    ];
    all.into_iter().filter_map(|(is_so, words)| is_so.then_some(words)).collect()
}

/// Mean range of two, three, four and five normally distributed values, in standard deviations of
/// one value (Tippett, *Biometrika* 17, 1925). A sequence has five places at most.
const RANGES: [f64; 4] = [1.128, 1.693, 2.059, 2.326];
/// Largest error by the delay of a reading, as a share of the effort: 0.1 s at a rate of 1/20 per
/// second.
const LATE: f64 = 0.1 / 20.0;

/// Returns the standard deviation of a median breakaway effort, V, of a drive with a step of `lsb`
/// (V). It has three parts: the spread over the places, where the variance of the median is `pi/2`
/// times that of the mean; the rounding of the drive; and the delay of the readings. Two rates
/// correct most of the delay; the rest counts as uniformly distributed up to its bound. A single
/// place shows no spread, so the result is `None`.
pub fn breakaway_deviation(levels: &BreakawayLevels, lsb: f64) -> Option<f64> {
    let [least, median, largest] = [levels.least, levels.median, levels.largest].map(f64::from);
    let further = usize::from(levels.places).checked_sub(2)?;
    let range = RANGES[further.min(RANGES.len() - 1)];
    let variance_of_median = 0.5 * std::f64::consts::PI / f64::from(levels.places);
    let of_places = (largest - least) / range * variance_of_median.sqrt();
    let of_drive = lsb / 12f64.sqrt();
    Some(of_places.hypot(of_drive).hypot(LATE * median / 3f64.sqrt()))
}

/// Line of the result: name, value with its deviation, unit, and the factor and unit in SI.
type Line = (&'static str, [f64; 2], &'static str, fn(&CoreUnits) -> f64, &'static str);

fn wide(value: [f32; 2]) -> [f64; 2] {
    value.map(f64::from)
}

fn lines(estimate: &ModelEstimate) -> Vec<Line> {
    let torque: fn(&CoreUnits) -> f64 = |units| units.effort(1.0);
    let per_angle: fn(&CoreUnits) -> f64 = |units| 1.0 / units.per_degree(1.0);
    let mut lines: Vec<Line> = vec![
        ("inertia", wide(estimate.inertia), "V s^2/deg", per_angle, "kg m^2"),
        ("viscous", wide(estimate.viscous), "V s/deg", per_angle, "N m s/rad"),
        ("slip", wide(estimate.coulomb), "V", torque, "N m"),
        ("slip +", wide(estimate.coulomb_positive), "V", torque, "N m"),
        ("slip -", wide(estimate.coulomb_negative), "V", torque, "N m"),
        ("load", wide(estimate.offset), "V", torque, "N m"),
    ];
    let [sine, cosine] = estimate.gravity.map(wide);
    if sine[1] > 0.0 {
        lines.push(("gravity sin", sine, "V", torque, "N m"));
        lines.push(("gravity cos", cosine, "V", torque, "N m"));
    }
    if estimate.stribeck_velocity > 0.0 {
        lines.push(("stribeck", wide(estimate.stribeck), "V", torque, "N m"));
    }
    lines
}

impl IdentifiedJoint {
    /// Returns the step of the drive, V.
    fn lsb(&self) -> f64 {
        f64::from(self.parameters.controller.drive.lsb)
    }

    /// Returns the verdict: `good`, `doubtful`, `poor`, `not whole` or `no result`.
    pub fn verdict(&self) -> &'static str {
        let Summary { outcome, doubts, .. } = &self.summary;
        match outcome {
            _ if doubts.no_fit || doubts.unphysical => "no result",
            Outcome::Done if doubts.is_none() => "good",
            _ if doubts.poor_fit => "poor",
            Outcome::Done => "doubtful",
            _ => "not whole",
        }
    }

    /// Returns the table and the verdict as text.
    pub fn words(&self) -> String {
        let Summary { outcome, breakaway, estimate, range, doubts: doubted, steps } = &self.summary;
        let mut text = format!("identify   {}\n", ended(*outcome));
        let si = |value: f64, deviation: Option<f64>, unit: &str, factor: fn(&CoreUnits) -> f64| {
            self.units.map_or(String::new(), |units| {
                let factor = factor(&units);
                let off = deviation.map(|off| format!(" +- {:.1e}", off * factor));
                format!("   {:>11.5}{} {unit}", value * factor, off.unwrap_or_default())
            })
        };
        let torque: fn(&CoreUnits) -> f64 = |units| units.effort(1.0);
        for (levels, sense) in breakaway.iter().zip(["+", "-"]) {
            let BreakawayLevels { least, median, largest, places } = levels;
            if *places > 0 {
                let deviation = breakaway_deviation(levels, self.lsb());
                let si = si(f64::from(*median), deviation, "N m", torque);
                text += &match deviation {
                    Some(deviation) => format!(
                        "breakaway {sense} {median:>10.5} +- {deviation:.1e} V, from {least:.5} to \
                         {largest:.5} V at {places} places{si}\n"
                    ),
                    None => format!("breakaway {sense} {median:>10.5} V, at one place only{si}\n"),
                };
            }
        }
        if let Some(estimate) = estimate {
            for (name, [value, deviation], unit, factor, in_si) in lines(estimate) {
                let both = format!("{value:>10.3e} +- {deviation:.1e} {unit}");
                let si = si(value, Some(deviation), in_si, factor);
                text += &format!("{name:<11} {both:<32}{si}\n");
            }
            if estimate.stribeck_velocity > 0.0 {
                text += &format!("at          {:>10.3} deg/s\n", estimate.stribeck_velocity);
            }
            text += &format!("delay       {:>10.2} ms\n", 1e3 * f64::from(estimate.delay[0]));
            let percent = 100.0 * f64::from(estimate.relative_residual);
            text += &format!(
                "residual    {percent:>10.2} % of the effort, {} stretches, {range:.0} deg, \
                 {steps} steps\n",
                estimate.rows
            );
        }
        for [forward, backward] in &self.map {
            if forward.windows > 0 && backward.windows > 0 {
                let friction = 0.5 * (forward.effort - backward.effort);
                text += &format!(
                    "at {:>8.3} deg/s: friction {friction:.5} V, load {:+.5} V\n",
                    forward.velocity,
                    0.5 * (forward.effort + backward.effort)
                );
            }
        }
        text += &format!("verdict    {}\n", self.verdict());
        doubts(doubted).iter().for_each(|line| text += &format!("           {line}\n"));
        text
    }

    /// Returns the JSON object for scripts.
    pub fn json(&self, warning: Option<&str>) -> Value {
        let Summary { outcome, steps, breakaway, estimate, range, doubts: doubted } = &self.summary;
        let level = |levels: &BreakawayLevels| {
            (levels.places > 0).then(|| {
                json!({
                    "min_v": single(levels.least),
                    "median_v": single(levels.median),
                    "sd_v": breakaway_deviation(levels, self.lsb()),
                    "max_v": single(levels.largest),
                    "places": levels.places,
                })
            })
        };
        let valued = |value: [f32; 2]| json!({"value": single(value[0]), "sd": single(value[1])});
        let parameters = estimate.as_ref().map(|estimate| {
            let [sine, cosine] = estimate.gravity;
            json!({
                "inertia": valued(estimate.inertia),
                "viscous": valued(estimate.viscous),
                "coulomb_positive": valued(estimate.coulomb_positive),
                "coulomb_negative": valued(estimate.coulomb_negative),
                "coulomb": valued(estimate.coulomb),
                "offset": valued(estimate.offset),
                "gravity_sin": (sine[1] > 0.0).then(|| valued(sine)),
                "gravity_cos": (cosine[1] > 0.0).then(|| valued(cosine)),
                "stribeck": (estimate.stribeck_velocity > 0.0).then(|| valued(estimate.stribeck)),
                "stribeck_velocity_deg_per_s":
                    (estimate.stribeck_velocity > 0.0).then(|| single(estimate.stribeck_velocity)),
                "delay_s": valued(estimate.delay),
            })
        });
        let in_si = self.units.map(|units| {
            let lines = estimate.as_ref().map(lines).unwrap_or_default().into_iter();
            let found = lines.map(|(name, [value, deviation], _, factor, unit)| {
                let factor = factor(&units);
                let value = json!({
                    "value": value * factor, "sd": deviation * factor, "unit": unit,
                });
                (name.to_owned(), value)
            });
            let senses = ["breakaway_positive", "breakaway_negative"].into_iter().zip(breakaway);
            let read = senses.filter(|(_, levels)| levels.places > 0).map(|(name, levels)| {
                let torque = |volts: f32| units.effort(f64::from(volts));
                let deviation = breakaway_deviation(levels, self.lsb());
                let value = json!({
                    "value": torque(levels.median),
                    "sd": deviation.map(|deviation| units.effort(deviation)),
                    "min": torque(levels.least),
                    "max": torque(levels.largest),
                    "unit": "N m",
                });
                (name.to_owned(), value)
            });
            found.chain(read).collect::<serde_json::Map<String, Value>>()
        });
        let point = |point: &MapPoint| {
            json!({
                "velocity_deg_per_s": single(point.velocity),
                "effort_v": single(point.effort),
                "windows": point.windows,
            })
        };
        let map: Vec<Value> =
            self.map.iter().flatten().filter(|point| point.windows > 0).map(point).collect();
        json!({
            "schema": 1,
            "warning": warning,
            "outcome": format!("{outcome:?}").to_lowercase(),
            "verdict": self.verdict(),
            "doubts": doubts(doubted),
            "steps": steps,
            "range_deg": single(*range),
            "breakaway_positive": level(&breakaway[0]),
            "breakaway_negative": level(&breakaway[1]),
            "parameters": parameters,
            "si": in_si,
            "relative_residual_percent":
                estimate.as_ref().map(|estimate| 100.0 * f64::from(estimate.relative_residual)),
            "stretches": estimate.as_ref().map(|estimate| estimate.rows),
            "map": map,
        })
    }

    /// Returns the joint of a machine's file.
    ///
    /// # Errors
    /// Returns why the result is not usable.
    pub fn joint(&self) -> Result<JointTable, Error> {
        let refused = |why: &str| Error::Device(why.to_owned());
        let Summary { outcome, breakaway, estimate, doubts: doubted, .. } = &self.summary;
        if *outcome != Outcome::Done {
            return Err(refused(ended(*outcome)));
        }
        let estimate = estimate.as_ref().filter(|_| !doubted.unphysical && !doubted.poor_fit);
        let estimate = estimate.ok_or_else(|| {
            refused(doubts(doubted).first().copied().unwrap_or("there is no fit"))
        })?;
        let slip_v = single(estimate.coulomb[0]);
        let [positive, negative] = breakaway.map(|levels| single(levels.median));
        let stick_v = 0.5 * (positive + negative);
        if positive <= 0.0 || negative <= 0.0 {
            return Err(refused("the breakaway effort is unknown in at least one direction"));
        }
        Ok(JointTable {
            gain_deg_per_s2_per_v: 1.0 / single(estimate.inertia[0]),
            // A negative estimate is noise around zero.
            viscous_v_per_deg_per_s: single(estimate.viscous[0]).max(0.0),
            friction: JointFrictionLevels {
                stick_v: stick_v.max(slip_v),
                slip_v,
                band_deg_per_s: 0.0001,
                added_v: 0.0,
                added_during_s: None,
            },
        })
    }
}
