//! Sentences for a person about what a device says.

use stiction::Fault;
use stiction::link::{Refused, StateCode, Status, Told};
use stiction::servo::Levels;

/// Says why a request was refused, and what to do.
pub fn refused(refused: &Refused) -> String {
    match refused {
        Refused::Unknown => "it does not know this request; its firmware is another".into(),
        Refused::SayHello => "it was reset meanwhile, and waits for a new session".into(),
        Refused::OutOfOrder => "a later request was faster".into(),
        Refused::Booting => "it has not ticked yet; try again".into(),
        Refused::Faulted(code) => {
            format!(
                "{} is latched; see to it and clear it with `faults --clear` (docs/faults.md)",
                name(*code)
            )
        }
        Refused::NotClearable(code) => {
            format!("{} ends with valid parameters or a reset only (docs/faults.md)", name(*code))
        }
        Refused::Armed => "only with the output off; `stop` first".into(),
        Refused::NotArmed => "only while armed; `arm` first".into(),
        Refused::Moving => "the joint has to be at rest for 50 ms".into(),
        Refused::WouldTrip(code) => {
            format!("it would end in {} at once (docs/faults.md)", name(*code))
        }
        Refused::OutOfRange => {
            "the motion leads out of `limits.position_min_deg` to `limits.position_max_deg`".into()
        }
        Refused::FarAway => {
            "the trajectory begins farther from the joint than `limits.following_error_deg`: move to its begin first"
                .into()
        }
        Refused::TooFar => {
            "the position is too far from where the joint is: less than 2^30 counts are allowed"
                .into()
        }
        Refused::NoParameters => "it has no parameters; `params push FILE.toml` first".into(),
        Refused::NoSuch => "there is no such thing".into(),
        Refused::NotWhole => "the record of parameters did not arrive whole".into(),
        Refused::Version(version) => format!("it cannot read version {version} of the parameters"),
        Refused::Value { key, found, allowed } => {
            stiction::Error { key: *key, found: *found, allowed: *allowed }.to_string()
        }
        Refused::UnknownValue(key) => {
            format!(
                "it does not know `{key}`: a gain of a law that is not in use, or its firmware is older than this program"
            )
        }
        Refused::MissingValue(key) => format!("`{key}` is missing in what it was sent"),
        Refused::Flash => "its flash failed; the parameters are in use, but not saved".into(),
        Refused::Watchdog => {
            "its watchdog did not take over another timeout in time; say it again".into()
        }
        Refused::SupplyTooLow => {
            "its 3.3 V supply is below 2.9 V, too low to erase and write its flash; the parameters are in use, but not saved"
                .into()
        }
    }
}

/// Names a fault by its code.
pub fn name(code: u8) -> String {
    Fault::from_code(code).map_or_else(
        || format!("fault {code}"),
        |fault| format!("fault {code} ({})", fault.describe()),
    )
}

/// Describes a fault with its value and time, as in `fault 14 (stall: effort, but no count), 0.805
/// V, 3.200 s after power-on`.
pub fn told(told: &Told, sample_time: f32) -> String {
    let value = match Fault::from_code(told.code).map(Fault::unit) {
        Some(unit) if !unit.is_empty() => format!(", {:.4} {unit}", told.value),
        _ => String::new(),
    };
    let when = match f64::from(told.tick) * f64::from(sample_time) {
        0.0 => String::new(),
        time_s => format!(", {time_s:.3} s after power-on"),
    };
    format!("{}{value}{when}", name(told.code))
}

/// Names a state, as in `armed` or `faulted`.
pub const fn state(state: StateCode) -> &'static str {
    match state {
        StateCode::Boot => "boot",
        StateCode::Stopped => "stopped",
        StateCode::Armed => "armed",
        StateCode::Faulted(_) => "faulted",
    }
}

/// Writes a status, one quantity a line.
pub fn status(status: &Status) -> String {
    let mut lines = vec![format!("state      {}", state(status.state))];
    if status.fault.code != 0 {
        lines.push(format!("fault      {}", told(&status.fault, status.sample_time)));
    }
    let position = f64::from(status.position) * f64::from(status.resolution);
    let rest = if status.at_rest { "at rest" } else { "moving" };
    lines.push(format!(
        "position   {position:.4} deg since power-on ({} counts), {rest}",
        status.position
    ));
    lines.push(format!("heat       that of {:.3} V for ever", status.thermal_effort));
    if status.wound_up {
        lines.push(
            "warning    the compensator holds effort at standstill: the motor gets warm".into(),
        );
    }
    if status.is_damaged {
        let what =
            "warning    one of the two saved sets of parameters is damaged: those in use may be";
        let then =
            "           older ones, and nothing starts by itself. Look at them (`params show`,";
        lines.extend(
            [what, then, "           `params push`), then save them (`params save`)"]
                .map(String::from),
        );
    }
    if !status.has_brown_out {
        let what =
            "warning    its brown-out reset is off: a dip of its supply looks like power-on,";
        let then = "           and autostart waits for a command (docs/wiring.md, \"Brown-out\")";
        lines.extend([what, then].map(String::from));
    }
    if status.unsaved {
        lines.push("warning    the parameters in use are not saved: `params save`".into());
    }
    let time_s = f64::from(status.clock) * f64::from(status.sample_time);
    lines.push(format!("on for     {time_s:.2} s, {} ticks", status.clock));
    lines.push(format!("faults     {} since power-on", status.faults));
    lines.push(format!(
        "link       {} bad frames, {} messages dropped",
        status.bad_frames, status.dropped
    ));
    lines.join("\n") + "\n"
}

/// Writes what a ramp of `rate` (V/s) has found.
pub fn levels(levels: &Levels, rate: f32) -> String {
    let stick = match levels.stick {
        Some(v) => format!("stick      {v:.4} V: the effort at which the joint set out"),
        None => "stick      not found: the joint did not move under the largest effort that the drive lets through".into(),
    };
    let slip = match (levels.slip, levels.stick) {
        (Some(v), _) => format!("slip       {v:.4} V: the effort at which it came to rest"),
        (None, Some(_)) => "slip       not found: the joint did not come to rest".into(),
        (None, None) => "slip       not found".into(),
    };
    format!(
        "{stick}\n{slip}\nrate       {rate} V/s; a slower ramp reads stick lower and slip higher\n"
    )
}
