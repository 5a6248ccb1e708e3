//! Parameters of a board for a run, validated as on the board, and their record for its flash.

use stiction::control::brake_resistor::BrakeResistor;
use stiction::control::current_sensor::CurrentSensor;
use stiction::control::drive::{DriveConfig, PwmMode};
use stiction::control::motor_ntc::MotorNtc;
use stiction::motion::jog::JogBounds;
use stiction::parameters::{DeviceConfig, ROOM};
use stiction::safety::monitor::limits::CERTAIN;
use stiction::units::value::Table as _;
use stiction::{Limits, Parameters, ProfileLimits};

use super::plan::RunPlan;
use crate::flash::SECTOR;
use files::error::Error;
use files::hardware::STM32F405;

/// Returns the parameters of a board for this run, validated as on the board.
///
/// # Errors
/// Returns an error with the key, the value found and the allowed values.
pub fn parameters(plan: &RunPlan) -> Result<Parameters, Error> {
    let parameters = assembled(plan)?;
    validate(&parameters, plan)?;
    Ok(parameters)
}

/// Returns the parameters of a device for this run, as [`parameters()`] does.
///
/// # Errors
/// As [`parameters()`]; also if a law is in no device's image.
pub fn for_a_device(plan: &RunPlan) -> Result<Parameters, Error> {
    check_laws(plan)?;
    parameters(plan)
}

/// Checks that the laws of a run are in a device's image.
///
/// # Errors
/// Returns an error with the controller and its law.
pub fn check_laws(plan: &RunPlan) -> Result<(), Error> {
    let on_the_host = plan.laws_in_use().into_iter().find(|law| !law.on_the_device());
    on_the_host.map_or(Ok(()), |law| {
        let controller = plan.controller.as_deref().unwrap_or_default();
        Err(Error::Input(format!(
            "{}: the controller {controller} cannot run on a device: its law {} is not in the \
             firmware; use that law in simulations only",
            plan.origin,
            law.name()
        )))
    })
}

/// Validates parameters as on a board.
///
/// # Errors
/// Returns an error with the key, the value found and the allowed values.
pub fn validate(parameters: &Parameters, plan: &RunPlan) -> Result<(), Error> {
    parameters.prepare(&STM32F405).map(|_| ()).map_err(|error| plan.explain(&error))
}

/// Returns the parameters of a board for this run; only the loop and its motion are validated.
///
/// # Errors
/// Returns an error with the key, the value found and the allowed values.
pub fn assembled(plan: &RunPlan) -> Result<Parameters, Error> {
    // The loop of the simulation.
    plan.closed_loop()?;
    let motion = plan.motion()?;
    let device = plan.machine.device.core(DeviceConfig::CAUTIOUS);
    let controller = plan.controller_config()?;
    let breakaway = breakaway(plan)?;
    let gain = plan.machine.joint.gain_deg_per_s2_per_v as f32;
    let mut derived = Limits::derived(&controller, &device, breakaway).of_gain(gain, &controller);
    if let Some(lowest) = lowest_friction(plan)? {
        derived.breakaway_min = derived.breakaway_min.min(CERTAIN * lowest);
    }
    let sheet = plan.sheet()?;
    if let Some(heat) = sheet.as_ref().and_then(|(sheet, _)| sheet.motor_heat()) {
        let continuous = heat.continuous_v as f32;
        // A guess must not keep the joint of the file from resting against its load.
        derived.continuous_effort = if heat.is_rated {
            continuous
        } else {
            continuous.max(breakaway).min(derived.continuous_effort.max(continuous))
        };
        derived.back_emf = heat.back_emf.to_radians() as f32;
    }
    if let Some((sheet, _)) = &sheet {
        let of_one_encoder = sheet.backlash_to_encoder().to_degrees() as f32;
        derived.play = of_one_encoder.max(plan.joint_bounds()?.known_twist());
    }
    if let Some(tolerance_deg) = plan.machine.goal.tolerance_deg {
        derived.probe_error = tolerance_deg as f32;
    }
    let current = current_sensor(plan)?;
    if let Some(winding) = plan.winding()? {
        derived.back_emf = winding.back_emf_v_per_deg_per_s as f32;
        if current.is_there() {
            // The heat is that of the measured current, through the resistance of the sensor.
            derived.continuous_effort *= current.resistance / winding.resistance_ohm as f32;
        }
    }
    if current.is_there() && current.peak > 0.0 {
        // The effort has to reach the threshold of a blocked joint.
        let most = UNDER_THE_LIMIT * current.peak * current.resistance;
        derived.stall_effort = derived.stall_effort.min(most);
    }
    let limits = plan.machine.limits.core(derived);
    let profile =
        plan.machine.profile.core(ProfileLimits::derived(&controller, limits.overspeed, gain));
    let jog = plan.machine.jog.core(JogBounds::derived(&controller, &device, breakaway));
    let brake_resistor = plan
        .machine
        .brake_resistor
        .as_ref()
        .map_or(BrakeResistor::NONE, |table| table.core(BrakeResistor::NONE));
    let motor_ntc =
        plan.machine.motor_ntc.as_ref().map_or(MotorNtc::NONE, |table| table.core(MotorNtc::NONE));
    Ok(Parameters {
        controller,
        motion,
        device,
        limits,
        profile,
        jog,
        current,
        brake_resistor,
        motor_ntc,
    })
}

/// Derived stall threshold at most, as a part of the effort that the limit of the current allows.
const UNDER_THE_LIMIT: f32 = 0.9;

/// Returns the sensor of the motor's current, with the resistance of the file's motor if the
/// sensor's table lacks it.
fn current_sensor(plan: &RunPlan) -> Result<CurrentSensor, Error> {
    let Some(table) = &plan.machine.current_sensor else { return Ok(CurrentSensor::NONE) };
    let full_scale = table.number("full_scale_a").unwrap_or_default() as f32;
    if full_scale.is_nan() || full_scale <= 0.0 {
        let found = full_scale.to_string();
        return Err(plan.refuse("current_sensor.full_scale_a", &found, "a number above 0"));
    }
    if plan.machine.drive.core(DriveConfig::EXAMPLE).mode == PwmMode::Analog {
        return Err(Error::Input(format!(
            "{}: `[current_sensor]` needs a bridge; remove the table, or set `drive.mode` to \
             \"locked-antiphase\" or \"sign-magnitude\"",
            plan.origin
        )));
    }
    let written = table.number("resistance_ohm");
    let Some(resistance) = written.or(plan.winding()?.map(|winding| winding.resistance_ohm)) else {
        return Err(Error::Input(format!(
            "{}: `[current_sensor]` needs the resistance of the winding: set \
             `current_sensor.resistance_ohm`, or `motor.resistance_ohm` of a motor that a bridge \
             drives",
            plan.origin
        )));
    };
    let inductance_h = plan.inductance_h()?.unwrap_or(0.0);
    Ok(table.core(CurrentSensor::derived(full_scale, [resistance as f32, inductance_h as f32])))
}

/// Returns the effort that starts the joint, V: `limits.breakaway_v` of the file, or else the
/// largest effort under which the joint of the file can rest
/// ([`DataSheet::resting_torque`](files::data_sheet::DataSheet::resting_torque)).
fn breakaway(plan: &RunPlan) -> Result<f32, Error> {
    // Zero if the file does not set the limit, or turns it off.
    let Limits { breakaway_effort, stall_effort, .. } = plan.machine.limits.core(Limits::OFF);
    let said = [breakaway_effort, 0.5 * stall_effort].into_iter().find(|effort| *effort > 0.0);
    if let Some(effort) = said {
        return Ok(effort);
    }
    let friction = &plan.machine.joint.friction;
    let rests_v = match plan.sheet()? {
        Some((sheet, mapping)) => mapping.volts(sheet.resting_torque()),
        None => friction.stick_v,
    };
    Ok((rests_v + friction.added_v.max(0.0)) as f32)
}

/// Returns the lowest static friction of the joint of the file in either direction, V; `None` if
/// the file has no static friction.
fn lowest_friction(plan: &RunPlan) -> Result<Option<f32>, Error> {
    let lowest_v = match plan.sheet()? {
        Some((sheet, mapping)) => mapping.volts(sheet.stick().into_iter().fold(f64::MAX, f64::min)),
        None => plan.machine.joint.friction.stick_v,
    };
    Ok((lowest_v > 0.0).then_some(lowest_v as f32))
}

/// Returns the content of both parameter sectors, each with the same record at its start.
///
/// A board can have saved a record with a higher sequence number, which would override a record in
/// one sector. So both sectors are overwritten.
///
/// # Errors
/// As [`parameters()`].
pub fn sectors(plan: &RunPlan) -> Result<Vec<u8>, Error> {
    let record = record(plan)?;
    let mut bytes = record.clone();
    bytes.resize(SECTOR as usize, 0xFF);
    bytes.extend(record);
    Ok(bytes)
}

/// Returns the record for a parameter sector, with the first sequence number.
///
/// # Errors
/// As [`parameters()`].
pub fn record(plan: &RunPlan) -> Result<Vec<u8>, Error> {
    let mut room = [0; ROOM];
    let parameters = for_a_device(plan)?;
    let record = parameters.encode(1, &mut room).map(<[u8]>::to_vec);
    record.ok_or_else(|| {
        Error::Input(format!("{}: the parameters do not fit in {ROOM} bytes", plan.origin))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Experiment;
    use files::document::Document;

    fn plan(name: &str, set: &[&str]) -> Result<RunPlan, Error> {
        let mut document = Document::open(name)?;
        document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>())?;
        Ok(Experiment::plan(&document, &[], &[])?.runs.remove(0))
    }

    #[test]
    fn a_board_builds_the_same_controller_and_course() {
        for name in ["step-response", "trajectory", "srnf-robustness", "friction-identification"] {
            let plan = plan(name, &[]).unwrap();
            let closed_loop = plan.closed_loop().unwrap();
            let (found, sequence) = Parameters::decode(&record(&plan).unwrap()).unwrap();
            assert_eq!(sequence, 1);
            assert!(!found.device.autostart && found.device.soft_start > 0.0);
            // The additions of a device are in its output stage; here they are switched off.
            let device = DeviceConfig { soft_start: 0.0, nominal_supply: 0.0, ..found.device };
            let at_once = Parameters { device, ..found };
            let expected = (closed_loop.controller, plan.course().unwrap());
            assert_eq!(at_once.prepare(&STM32F405).unwrap(), expected, "{name}");
        }
    }

    #[test]
    fn a_law_that_lives_on_the_host_runs_there_and_goes_to_no_device() {
        let with = |law: &str| {
            let document = format!(
                "{}[controller.mine]\nlaws = [\"{law}\"]\nkp_v_per_deg = 1.0\n\
                 kd_v_per_deg_per_s = 0.17\nki_v_per_deg_s = 1.0\ntheta_ri_deg = 0.5\n",
                crate::experiment::builtins()
                    .iter()
                    .find(|b| b.name == "step-response")
                    .unwrap()
                    .toml
            );
            let document = Document::parse("mine.toml", &document).unwrap();
            Experiment::plan(&document, &["mine".into()], &[]).unwrap().runs.remove(0)
        };
        assert!(record(&with("ri")).is_ok() && sectors(&with("ri")).is_ok());
        let plan = with("pid");
        assert!(parameters(&plan).is_ok() && plan.closed_loop().is_ok());
        for refused in [for_a_device(&plan).err(), record(&plan).err(), sectors(&plan).err()] {
            let message = refused.unwrap().to_string();
            let expected = "mine.toml: the controller mine cannot run on a device: its law pid is \
                not in the firmware; use that law in simulations only";
            assert_eq!(message, expected);
        }
    }

    #[test]
    fn a_wrong_value_names_its_key() {
        let refusals = [
            ("device.dead_time_s=1", "`device.dead_time_s` is 1;"),
            ("device.nominal_supply_v=24", "`device.nominal_supply_v` is 24;"),
            ("loop.sample_time_s=0.05", "`loop.sample_time_s` is 0.05;"),
            ("device.autostrat=true", "unknown key `device.autostrat`; did you mean `autostart`?"),
        ];
        for (set, expected) in refusals {
            let message = plan("step-response", &[set])
                .and_then(|plan| record(&plan))
                .unwrap_err()
                .to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn off_is_a_word_and_zero_still_means_it() {
        let limits =
            |set: &[&str]| parameters(&plan("step-response", set).unwrap()).unwrap().limits;
        let given = ["limits.stall_v=0.5", "limits.following_error_deg=1"];
        assert_ne!(limits(&given).stall_effort, 0.0);
        for off in ["off", "\"off\"", "0", "0.0"] {
            let set =
                [format!("limits.stall_v={off}"), format!("limits.overspeed_deg_per_s={off}")];
            let found = limits(&[&set[0], &set[1]]);
            assert_eq!((found.stall_effort, found.overspeed), (0.0, 0.0), "{off}");
        }
        // A value that is no limit, or another word, is refused with the allowed values.
        for (set, expected) in [
            ("limits.stall_v=of", "`limits.stall_v` is \"of\"; must be a number or \"off\""),
            ("limits.stall_v=true", "`limits.stall_v` is true; must be a number or \"off\""),
            ("limits.stall_v=-1", "is -1; must be a number from 0 to 1000000, or \"off\""),
            ("limits.stall_s=off", "`limits.stall_s` is \"off\"; must be a number"),
            ("jog.effort_v=off", "`jog.effort_v` is \"off\"; must be a number"),
            ("jog.effort_v=0", "`jog.effort_v` is 0; must be a number above 0"),
        ] {
            let found = plan("step-response", &[set]).and_then(|plan| record(&plan));
            let message = found.unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn a_ramp_is_no_steeper_than_the_soft_start() {
        let rate = |rate: &str| format!("identification.ramp_rates_v_per_s=[{rate}]");
        let record = |rate: &str, soft_start: &str| {
            let set = [rate, soft_start];
            plan("friction-identification", &set).and_then(|plan| record(&plan))
        };
        assert!(record(&rate("10"), "device.soft_start_s=0.5").is_ok());
        assert!(record(&rate("10.1"), "device.soft_start_s=0").is_ok());
        let message = record(&rate("10.1"), "device.soft_start_s=0.5").unwrap_err().to_string();
        let expected = "`identification.ramp_rates_v_per_s[0]` is 10.1; must be a number from 0 \
            to 10";
        assert!(message.contains(expected), "{message}");
    }
}
