//! Parameters of a device as a machine's file, so that they can be read, changed, pushed and simulated.
//!
//! The device's numbers are in single precision; a file has the shortest decimals that are read as the same ones.
//! Guarantees: [`render`] gives a text that [`read`] turns into the same parameters, bit for bit, or says why there is
//! none. Does badly: what no file can say (a motion that only holds, a ramp together with gains, a law twice) has no
//! text. A device does not know its joint, so that of another machine has to be lent.

use stiction::Parameters;
use stiction::compensator::Gains;
use stiction::drive::{DriveConfig, PwmMode};
use stiction::encoder::{CounterBits, Direction};
use stiction::parameters::Motion;
use stiction::position::Position;
use toml::{Table, Value};

use super::Device;
use crate::encoder::Rounding;
use crate::error::Error;
use crate::experiment::{Document, Experiment, position};
use crate::limits::LimitsTable;
use crate::machine::{self, Controller, Identification, Joint, LawName, Machine, Names, Reference, Run};

/// Clock of the timer that makes the PWM.
const PWM_TIMER_HZ: f32 = 168e6;

/// Of a controller with several laws, or with one twice.
const OF_SEVERAL: &str = "device";

/// The parameters of the first run of a machine's file.
///
/// # Errors
/// Names the key, what was found and what is allowed.
pub fn read(name: &str, text: &str) -> Result<Parameters, Error> {
    let document = Document::parse(name, text)?;
    let mut runs = Experiment::plan(&document, &[], &[])?.runs;
    // A plan without runs has been refused.
    super::parameters(&runs.swap_remove(0))
}

/// A machine's file of these parameters; `joint` is that of `whose`.
///
/// # Errors
/// If there is no file that is read as these parameters.
pub fn render(parameters: &Parameters, joint: &Joint, whose: &str) -> Result<String, Error> {
    let machine = Machine { joint: joint.clone(), ..of(parameters) };
    let body = toml::to_string(&machine).map_err(|error| Error::Input(error.to_string()))?;
    let text = format!(
        "# What a device runs. It does not know its joint: [joint] is that of {whose}, for the\n\
         # simulator only. Thresholds are written out, so nothing of them is derived from it.\n{body}"
    );
    let why = match read("", &text) {
        Ok(again) if again == *parameters => return Ok(text),
        Ok(_) => "a value lies between those that a file can have".into(),
        Err(error) => error.to_string().trim_start_matches([':', ' ']).to_owned(),
    };
    Err(Error::Device(format!(
        "params: no machine's file says what this device runs ({why}); a name that does not end in .toml pulls its record"
    )))
}

/// The tables that a device knows, for people.
///
/// # Errors
/// If a number cannot be written.
pub fn tables(parameters: &Parameters) -> Result<String, Error> {
    toml::to_string(&known(parameters)?).map_err(|error| Error::Input(error.to_string()))
}

/// What is different in `after`: `controller.srnf.kp_v_per_deg: 1.0 -> 2.0`, a line each.
///
/// # Errors
/// If a number cannot be written.
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
        (was.as_ref() != Some(value)).then(|| format!("{key}: {} -> {value}", was.unwrap_or_else(none)))
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
    let mut table = Table::try_from(of(parameters)).map_err(|error| Error::Input(error.to_string()))?;
    for simulated in ["title", "source", "joint", "run"] {
        table.remove(simulated);
    }
    if let Some(Value::Table(encoder)) = table.get_mut("encoder") {
        encoder.remove("rounding");
        encoder.remove("phase");
    }
    Ok(table)
}

/// The machine, with a joint of nothing.
fn of(parameters: &Parameters) -> Machine {
    let Parameters { controller: config, motion, device, limits } = parameters;
    let laws: Vec<LawName> = config.compensator.iter().map(law).collect();
    let (name, laws) = match laws[..] {
        [] => (word(LawName::Pd), None),
        [one] => (word(one), None),
        _ => (OF_SEVERAL.into(), Some(laws)),
    };
    let mut gains = Controller {
        laws,
        kp_v_per_deg: single(config.pd.kp),
        kd_v_per_deg_per_s: single(config.pd.kd),
        ..Controller::default()
    };
    config.compensator.iter().for_each(|law| put(law, &mut gains));
    let resolution_deg = single(config.encoder.resolution);
    let sample_time_s = single(config.sample_time);
    let (reference, identification) = asked(motion, resolution_deg, sample_time_s);
    Machine {
        title: "Parameters of a device".into(),
        source: String::new(),
        figures: vec![],
        joint: Joint {
            gain_deg_per_s2_per_v: 0.0,
            viscous_v_per_deg_per_s: 0.0,
            friction: machine::Friction {
                stick_v: 0.0,
                slip_v: 0.0,
                band_deg_per_s: 0.0,
                added_v: 0.0,
                added_during_s: None,
            },
        },
        encoder: machine::Encoder {
            resolution_deg,
            counter_bits: match config.encoder.counter_bits {
                CounterBits::Sixteen => 16,
                CounterBits::ThirtyTwo => 32,
            },
            direction: match config.encoder.direction {
                Direction::Forward => machine::Direction::Forward,
                Direction::Reverse => machine::Direction::Reverse,
            },
            rounding: Rounding::default(),
            phase: 0.0,
        },
        drive: machine::Drive {
            full_scale_v: single(config.drive.full_scale),
            lsb_v: single(config.drive.lsb),
            pwm_hz: pwm_hz(config.drive.pwm_top),
            mode: match config.drive.mode {
                PwmMode::LockedAntiphase => machine::PwmMode::LockedAntiphase,
                PwmMode::SignMagnitude => machine::PwmMode::SignMagnitude,
            },
        },
        sampling: machine::Loop {
            sample_time_s,
            velocity_window: config.velocity_window,
            controller: Names::One(name.clone()),
        },
        controller: [(name, gains)].into(),
        reference,
        identification,
        device: Device {
            autostart: device.autostart,
            autostart_delay_s: single(device.autostart_delay),
            soft_start_s: single(device.soft_start),
            dead_time_s: single(device.dead_time),
            nominal_supply_v: single(device.nominal_supply),
            supply_full_scale_v: single(device.supply_full_scale),
        },
        limits: LimitsTable::written_out(limits, single),
        run: Run::default(),
        variant: vec![],
    }
}

fn asked(motion: &Motion, resolution_deg: f64, sample_time_s: f64) -> (Reference, Option<Identification>) {
    let deg = |position: &Position| degrees(position, resolution_deg);
    let mut reference = Reference::default();
    match motion {
        Motion::Hold => {}
        Motion::Step(to) => reference.steps_deg.push(deg(to)),
        Motion::Trajectory { corners, half_blend } => {
            let time_s = |tick: u32| {
                let exact = f64::from(tick) * sample_time_s;
                shortest(exact, |time_s| (time_s - exact).abs() <= 1e-12 * exact)
            };
            reference.trajectories.push(machine::Trajectory {
                corner_times_s: corners.iter().map(|corner| time_s(corner.tick)).collect(),
                corner_positions_deg: corners.iter().map(|corner| deg(&corner.position)).collect(),
                half_blend_s: single(*half_blend),
            });
        }
        Motion::Ramp { rate, hold } => {
            let rates = vec![single(*rate)];
            return (reference, Some(Identification { ramp_rates_v_per_s: rates, hold_s: single(*hold) }));
        }
    }
    (reference, None)
}

/// The shortest decimal that is read as this number in single precision.
fn single(value: f32) -> f64 {
    // Shortest by the standard library; a decimal, so that 0.02 is not 0.019999999552965164.
    value.to_string().parse().unwrap_or_else(|_| value.into())
}

/// The decimal with the fewest digits that is accepted, or else a neighbour of `exact` that is.
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

fn pwm_hz(top: u16) -> f64 {
    let exact = f64::from(PWM_TIMER_HZ) / (2.0 * f64::from(top));
    shortest(exact, |hz| DriveConfig::centre_aligned_top(PWM_TIMER_HZ, hz as f32) == top)
}

const fn law(gains: &Gains) -> LawName {
    match gains {
        Gains::ResetIntegral(_) => LawName::Ri,
        Gains::RateVariableIntegral(_) => LawName::Rvi,
        Gains::ResetOffsetIntegral(_) => LawName::Roi,
        Gains::Feedforward(_) => LawName::Feedforward,
        Gains::DiscontinuousNonlinearProportional(_) => LawName::Dnpf,
        Gains::SmoothRobustNonlinear(_) => LawName::Srnf,
    }
}

fn word(law: LawName) -> String {
    format!("{law:?}").to_lowercase()
}

fn put(law: &Gains, table: &mut Controller) {
    let some = |value: f32| Some(single(value));
    match law {
        Gains::ResetIntegral(g) => {
            (table.ki_v_per_deg_s, table.theta_ri_deg) = (some(g.ki), some(g.theta_ri));
        }
        Gains::RateVariableIntegral(g) => {
            (table.ki_v_per_deg_s, table.gamma_deg2_per_s2) = (some(g.ki), some(g.gamma));
        }
        Gains::ResetOffsetIntegral(g) => {
            (table.t_roi_s, table.v_roi_deg_per_s) = (some(g.t_roi), some(g.v_roi));
        }
        Gains::Feedforward(g) => (table.v_slip_v, table.v_ff_deg_per_s) = (some(g.v_slip), some(g.v_ff)),
        Gains::DiscontinuousNonlinearProportional(g) => table.theta_b_deg = some(g.theta_b),
        Gains::SmoothRobustNonlinear(g) => {
            (table.v_ms_v, table.alpha_per_deg) = (some(g.v_ms), some(g.alpha));
        }
    }
}
