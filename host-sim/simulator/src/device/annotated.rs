//! Parameters of a device as TOML with comments. The comment of a limit is its origin: derived, or
//! set by the file. The comment of the encoder's output is its effect on the test for open lines.
//!
//! A device stores values without their origin. So each limit is compared with the one that the
//! core derives from the device's own loop, its breakaway effort and its gain. Limit: a value that
//! the file sets to the derived one counts as derived.

use stiction::control::device_config::PositionReference;
use stiction::control::encoder::EncoderOutput;
use stiction::safety::monitor::limits::Limits;
use stiction::units::value::{About, Absent, Table, Values};
use stiction::{ControllerConfig, Parameters};

use super::machine_file;
use files::error::Error;
use files::lines::wrapped;

/// Returns the tables of a device's parameters as TOML. The comment above each limit is its origin.
///
/// # Errors
/// Returns an error if a number cannot be written.
pub fn tables(parameters: &Parameters) -> Result<String, Error> {
    let (mut is_limit, mut is_encoder) = (false, false);
    let lines = machine_file::tables(parameters)?;
    let lines = lines.lines().map(|line| {
        if line.starts_with('[') {
            is_limit = line == "[limits]";
            is_encoder = line == "[encoder]";
        }
        if is_encoder && line.starts_with("output = ") {
            return format!("# {}\n{line}", of_output(parameters.controller.encoder.output));
        }
        let name = line.split(" = ").next().unwrap_or_default();
        let about = Limits::ABOUT.iter().find(|about| is_limit && about.name == name);
        about.map_or_else(
            || line.to_owned(),
            |about| {
                let origin = wrapped(&origin(parameters, about), 2);
                let origin = origin.trim().replace("\n  ", "\n# ");
                format!("# {origin}\n{line}")
            },
        )
    });
    Ok(lines.map(|line| line + "\n").collect())
}

/// Returns the effect of an encoder's output on the test for open lines, in words.
const fn of_output(output: EncoderOutput) -> &'static str {
    match output {
        EncoderOutput::PushPull => "an open wire is found at rest",
        EncoderOutput::Unknown => "an open wire is not looked for; \"push-pull\" finds it at rest",
        EncoderOutput::OpenCollector => "an open wire is not looked for: every line looks open",
        EncoderOutput::Receiver => "an open wire is not looked for: the receiver hides it",
    }
}

/// Returns the origin of a limit, in words.
fn origin(parameters: &Parameters, about: &About) -> String {
    let Parameters { controller, device, limits, .. } = parameters;
    let loop_alone = Limits::derived(controller, device, limits.breakaway_effort);
    let gain = gain(limits, &loop_alone);
    let derived = loop_alone.of_gain(gain.unwrap_or(0.0), controller);
    let found = limits.get(about.key);
    if about.may_be_off() && found == Some(0) {
        let is_measured = device.supply_full_scale > 0.0 || !about.field.starts_with("supply_");
        return if is_measured { "off" } else { "off: the supply is not measured" }.into();
    }
    if limits.is_out_of_reach(about.key, controller, device) {
        return "never trips: the hardware reads no value beyond it".into();
    }
    let has_range = limits.position_min != 0.0 || limits.position_max != 0.0;
    match about.field {
        "position_min" | "position_max" if has_range => {
            return match device.reference {
                PositionReference::PowerOn => {
                    "set by the file; from where the joint stands at each reset, since \
                     `device.reference` is \"power-on\""
                }
                PositionReference::Command => {
                    "set by the file; from `device home` or `device reference`"
                }
            }
            .into();
        }
        "continuous_effort" if limits.back_emf > 0.0 => {
            return "set by the file, or by its motor: the rated current, or a tenth of the stall \
                    current, but at least `breakaway_v`"
                .into();
        }
        "back_emf" if limits.back_emf == 0.0 => {
            return "no back-EMF is known: all effort heats the motor".into();
        }
        "play" => return "set by the file, or by the backlash of its gear".into(),
        "back_emf" => return "set by the file, or by its motor".into(),
        "breakaway_min" if limits.breakaway_min == 0.0 => {
            return "unknown friction: no closed loop is armed".into();
        }
        "breakaway_min" => return "set by the file, or half of its joint's lowest friction".into(),
        _ if found != derived.get(about.key) => return "set by the file".into(),
        _ => {}
    }
    if matches!(about.absent, Absent::Default) {
        return "default".into();
    }
    let rule = about.text.split_once("Derived: ").map_or("", |(_, rule)| rule);
    let rule = rule.split(". ").next().unwrap_or_default().trim_end_matches('.');
    match (about.field, gain) {
        ("breakaway_effort", _) if limits.breakaway_effort == unknown_breakaway(controller) => {
            "derived: a quarter of what `duty_max` lets through, since no friction is known".into()
        }
        ("breakaway_effort", _) => "set by the file, or by its joint's friction and load".into(),
        ("stop_gain", Some(_)) => "derived: twice the joint's gain".into(),
        ("stop_gain", None) => "derived: the largest gain of a stable loop".into(),
        ("progress_gain", Some(_)) => "derived: a quarter of the joint's gain".into(),
        ("progress_gain", None) => "derived: a 64th of the largest gain of a stable loop".into(),
        ("overspeed", Some(_)) if limits.overspeed < loop_alone.overspeed => {
            "derived: what the joint's gain reaches after a turn under the largest effort".into()
        }
        ("overspeed", _) if is_of_the_counter(parameters) => {
            "derived: what the encoder's counter distinguishes in a tick".into()
        }
        ("overspeed", _) if !controller.compensator.is_empty() => {
            format!("derived: {rule}, unless the law says more")
        }
        ("supply_max", _) if limits.supply_max < 1.3 * device.nominal_supply => {
            "derived: what the converter measures, less than 1.3 of the nominal supply".into()
        }
        ("continuous_effort", _) => {
            "derived: three quarters of what `duty_max` lets through; the file has no data of the \
             motor"
                .into()
        }
        _ => format!("derived: {rule}"),
    }
}

/// Returns the joint's gain (deg/s^2 per V) that the limits were derived from; `None` if they were
/// derived from the loop alone.
fn gain(limits: &Limits, loop_alone: &Limits) -> Option<f32> {
    let is_known = limits.stop_gain > 0.0 && limits.stop_gain != loop_alone.stop_gain;
    is_known.then_some(0.5 * limits.stop_gain)
}

/// Returns the breakaway effort that is derived if no friction is known, V.
fn unknown_breakaway(controller: &ControllerConfig) -> f32 {
    0.25 * controller.drive.full_scale * controller.drive.duty_max
}

/// Returns whether the counter limits the overspeed threshold: a counter of 32 bits would allow a
/// higher one.
fn is_of_the_counter(parameters: &Parameters) -> bool {
    let mut wider = parameters.controller.clone();
    wider.encoder.counter_bits = stiction::control::encoder::CounterBits::ThirtyTwo;
    let wider = Limits::derived(&wider, &parameters.device, parameters.limits.breakaway_effort);
    parameters.limits.overspeed < wider.overspeed
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::experiment::Experiment;
    use files::document::Document;

    /// Returns the comment above a limit for the thesis's robot under PD, with keys set.
    fn comment(name: &str, set: &[&str]) -> String {
        let mut document = Document::open("step-response").unwrap();
        document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>()).unwrap();
        let plan = Experiment::plan(&document, &["pd".into()], &[]).unwrap();
        let parameters = super::super::parameters(&plan.runs[0]).unwrap();
        let text = tables(&parameters).unwrap();
        // It stays a file that can be read.
        assert!(text.parse::<toml::Table>().is_ok(), "{text}");
        let (before, _) = text.split_once(&format!("\n{name} = ")).unwrap();
        let lines: Vec<&str> =
            before.lines().rev().take_while(|line| line.starts_with("# ")).collect();
        lines.iter().rev().map(|line| line.trim_start_matches('#')).collect()
    }

    #[test]
    fn each_limit_says_where_it_comes_from() {
        let kd = "controller.pd.kd_v_per_deg_per_s=0.001";
        for (name, set, expected) in [
            ("overspeed_deg_per_s", &[][..], "derived: 2.5 full scale / Kd, at least 16 counts"),
            ("overspeed_deg_per_s", &["limits.overspeed_deg_per_s=60"], "set by the file"),
            ("overspeed_deg_per_s", &[kd], "derived: what the joint's gain reaches"),
            ("stall_v", &["limits.stall_v=\"off\""], " off"),
            ("stall_v", &[], "derived: twice `breakaway_v`"),
            ("stall_s", &[], " default"),
            ("breakaway_v", &[], "set by the file, or by its joint's friction"),
            ("stop_gain_deg_per_s2_per_v", &[], "derived: twice the joint's gain"),
            ("encoder_jump_deg", &["limits.encoder_jump_deg=80"], "never trips: the hardware"),
            ("continuous_v", &[], "the file has no data of the motor"),
            (
                "supply_max_v",
                &["device.nominal_supply_v=20", "device.supply_full_scale_v=24"],
                "derived: what the converter measures",
            ),
        ] {
            let found = comment(name, set);
            assert!(found.contains(expected), "{set:?}: {found}");
        }
    }
}
