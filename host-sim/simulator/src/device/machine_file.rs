//! Parameters of a device as a machine's file, which can be edited, pushed and simulated.
//!
//! The device's numbers are in single precision; the file has the shortest decimals that read back
//! as the same numbers. Guarantees: [`render`] returns a text that [`read`] turns into the same
//! parameters, bit for bit, or an error with the reason. Limits: a machine's file cannot hold a
//! motion that only holds, a ramp together with gains, or the same law twice. A device does not
//! store its joint, so the caller provides one.
//!
//! With two encoders the file has both as the device has them: `[encoder]` is that of the load,
//! and `[motor_encoder]` that of the motor, with the twists that the device tolerates.

use std::collections::BTreeMap;

use stiction::control::pd::PdGains;
use stiction::units::position::Position;
use stiction::units::value::Table as _;
use stiction::{ControllerConfig, Motion, Parameters};
use toml::{Table, Value};

use crate::experiment::{Document, Experiment, about_law, position};
use files::error::Error;
use files::goal::PositionGoal;
use files::machine::{
    self, JointTable, LawName, MachineFile, Names, PD, RampTable, ReferenceTable, RunSettings,
};
use files::written::{ParameterTable, single};

/// Name of a controller with several laws, or with one law twice.
const OF_SEVERAL: &str = "device";

/// Returns the parameters of a machine's file: those of its first run, or, if it has variants only,
/// of its first variant.
///
/// # Errors
/// Returns an error with the key, the value found and the allowed values.
pub fn read(name: &str, text: &str) -> Result<Parameters, Error> {
    let document = Document::parse(name, text)?;
    let first = Experiment::plan(&document, &[], &[])?.into_first();
    super::parameters(&first.ok_or_else(|| Error::Input(format!("{name}: the file has no run")))?)
}

/// Returns the text of a machine's file with these parameters and `joint`; `whose` names the owner
/// of that joint in the first comment.
///
/// # Errors
/// Returns an error if no machine's file can hold these parameters.
pub fn render(parameters: &Parameters, joint: &JointTable, whose: &str) -> Result<String, Error> {
    let machine = MachineFile { joint: joint.clone(), ..of(parameters) };
    let body = toml::to_string(&machine).map_err(|error| Error::Input(error.to_string()))?;
    let text = format!(
        "# Parameters of a device. A device does not store its joint: [joint] is that of {whose},\n\
         # for the simulator only. All thresholds are written out; none is derived from it.\n{body}"
    );
    let why = match read("", &text) {
        Ok(again) if again == *parameters => return Ok(text),
        Ok(_) => "a value cannot be written exactly".into(),
        Err(error) => error.to_string().trim_start_matches([':', ' ']).to_owned(),
    };
    Err(Error::Device(format!(
        "params: a machine's file cannot hold the parameters of this device ({why}); use a name \
         that does not end in .toml, to write the binary record of its flash instead"
    )))
}

/// Returns the tables of a device's parameters as TOML. With two encoders, `[encoder]` is that of
/// the load and `[motor_encoder]` that of the motor.
///
/// # Errors
/// Returns an error if a number cannot be written.
pub fn tables(parameters: &Parameters) -> Result<String, Error> {
    toml::to_string(&known(parameters)?).map_err(|error| Error::Input(error.to_string()))
}

/// Lists the differences, one line each: `controller.srnf.kp_v_per_deg: 1.0 -> 2.0`.
///
/// # Errors
/// Returns an error if a number cannot be written.
pub fn changes(before: &Parameters, after: &Parameters) -> Result<Vec<String>, Error> {
    let [before, after] = [before, after].map(known);
    let (mut old, mut new) = (Vec::new(), Vec::new());
    flatten("", &Value::Table(before?), &mut old);
    flatten("", &Value::Table(after?), &mut new);
    let find = |list: &[(String, String)], key: &str| {
        list.iter().find(|(other, _)| other == key).map(|(_, value)| value.clone())
    };
    let none = || "none".to_owned();
    let changed = new.iter().filter_map(|(key, value)| {
        let was = find(&old, key);
        (was.as_ref() != Some(value))
            .then(|| format!("{key}: {} -> {value}", was.unwrap_or_else(none)))
    });
    let gone = old.iter().filter(|(key, _)| find(&new, key).is_none());
    Ok(changed.chain(gone.map(|(key, was)| format!("{key}: {was} -> none"))).collect())
}

fn flatten(path: &str, value: &Value, into: &mut Vec<(String, String)>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                flatten(&path, value, into);
            }
        }
        other => into.push((path.into(), other.to_string())),
    }
}

fn known(parameters: &Parameters) -> Result<Table, Error> {
    let mut table =
        Table::try_from(of(parameters)).map_err(|error| Error::Input(error.to_string()))?;
    for simulated in ["title", "source", "joint", "run"] {
        table.remove(simulated);
    }
    if let Some(Value::Table(encoder)) = table.get_mut("encoder") {
        encoder.remove("rounding");
        encoder.remove("phase");
    }
    Ok(table)
}

/// Returns the machine's file with these parameters and an empty joint.
fn of(parameters: &Parameters) -> MachineFile {
    let Parameters {
        controller: config,
        motion,
        device,
        limits,
        profile,
        jog,
        current,
        brake_resistor,
        motor_ntc,
    } = parameters;
    let laws: Vec<LawName> = config.compensator.iter().map(|law| LawName(Some(*law))).collect();
    let (name, laws) = match laws[..] {
        [] => (PD.to_owned(), None),
        [one] => (one.name().to_owned(), None),
        _ => (OF_SEVERAL.to_owned(), Some(laws)),
    };
    let mut gains = ParameterTable::with(machine::Laws { laws });
    gains.put(PdGains::ABOUT, &config.pd);
    config.compensator.iter().for_each(|law| gains.put(about_law(law), law));
    let encoder = ParameterTable::out(&config.encoder);
    let mut sampling = ParameterTable::with(machine::LoopExtras {
        controller: Some(Names::One(name.clone())),
        position: None,
    });
    sampling.put(ControllerConfig::ABOUT, config);
    let (reference, identification) =
        motion_tables(motion, encoder.resolution_deg(), sampling.sample_time_s());
    MachineFile {
        title: "Parameters of a device".into(),
        source: String::new(),
        figures: vec![],
        motor: None,
        gear: None,
        load: None,
        friction: None,
        supply: None,
        load_encoder: None,
        motor_encoder: config.motor.count().map(|_| ParameterTable::out(&config.motor)),
        joint: JointTable {
            gain_deg_per_s2_per_v: 0.0,
            viscous_v_per_deg_per_s: 0.0,
            friction: machine::JointFrictionLevels {
                stick_v: 0.0,
                slip_v: 0.0,
                band_deg_per_s: 0.0,
                added_v: 0.0,
                added_during_s: None,
            },
        },
        encoder,
        drive: ParameterTable::out(&config.drive),
        sampling,
        controller: [(name, gains)].into(),
        reference,
        identification,
        goal: PositionGoal::default(),
        device: ParameterTable::out(device),
        limits: ParameterTable::out(limits),
        profile: ParameterTable::out(profile),
        jog: ParameterTable::out(jog),
        current_sensor: current.is_there().then(|| ParameterTable::out(current)),
        brake_resistor: brake_resistor.is_there().then(|| ParameterTable::out(brake_resistor)),
        motor_ntc: motor_ntc.is_there().then(|| ParameterTable::out(motor_ntc)),
        identified: None,
        spread: BTreeMap::new(),
        run: RunSettings::default(),
        variant: vec![],
    }
}

/// Returns `[reference]` with the motion, and `[identification]` for a ramp.
fn motion_tables(
    motion: &Motion,
    resolution_deg: f64,
    sample_time_s: f64,
) -> (ReferenceTable, Option<RampTable>) {
    let deg = |position: &Position| degrees(position, resolution_deg);
    let mut reference = ReferenceTable::default();
    match motion {
        // A file has no profiled moves: the moves of an experiment are steps.
        Motion::Hold | Motion::Profiled(_) => {}
        Motion::Step(to) => reference.steps_deg.push(deg(to)),
        Motion::Trajectory { corners, half_blend } => {
            let time_s = |tick: u32| {
                let exact = f64::from(tick) * sample_time_s;
                shortest(exact, |time_s| (time_s - exact).abs() <= 1e-12 * exact)
            };
            reference.trajectories.push(machine::TrajectoryTable {
                corner_times_s: corners.iter().map(|corner| time_s(corner.tick)).collect(),
                corner_positions_deg: corners.iter().map(|corner| deg(&corner.position)).collect(),
                half_blend_s: single(*half_blend),
            });
        }
        // The sines of a file start at zero.
        Motion::Sine { amplitude, frequency, .. } => {
            let exact = f64::from(*amplitude) * resolution_deg;
            let amplitude_deg = shortest(exact, |deg| (deg / resolution_deg) as f32 == *amplitude);
            reference
                .sines
                .push(machine::SineTable { amplitude_deg, frequency_hz: single(*frequency) });
        }
        Motion::Ramp { rate, hold } => {
            let rates = vec![single(*rate)];
            return (
                reference,
                Some(RampTable { ramp_rates_v_per_s: rates, hold_s: single(*hold) }),
            );
        }
    }
    (reference, None)
}

/// Returns the accepted decimal with the fewest digits, or else an accepted floating-point
/// neighbour of `exact`.
fn shortest(exact: f64, accepted: impl Fn(f64) -> bool) -> f64 {
    let decimals = (0..17).filter_map(|digits| format!("{exact:.digits$e}").parse().ok());
    let neighbours = (1..16i64).flat_map(|ulps| [ulps, -ulps]).map(|ulps| {
        let bits = exact.to_bits() as i64;
        f64::from_bits(bits.wrapping_add(ulps) as u64)
    });
    decimals.chain(neighbours).find(|number| accepted(*number)).unwrap_or(exact)
}

fn degrees(of: &Position, resolution_deg: f64) -> f64 {
    let exact = (f64::from(of.counts) + f64::from(of.fraction)) * resolution_deg;
    shortest(exact, |deg| position(deg / resolution_deg) == *of)
}
