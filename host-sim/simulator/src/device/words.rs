//! Sentences for a person about what a device says.

use stiction::Fault;
use stiction::link::{Refused, StateCode, Status, Told, WireErrors};
use stiction::servo::Levels;

/// Says why a request was refused, and what to do.
pub fn refused(refused: &Refused) -> String {
    match refused {
        Refused::Unknown => "its firmware does not know this request; flash the one that belongs \
                             to this program (`cargo xtask flash`)"
            .into(),
        Refused::SayHello => "it was reset meanwhile, so the motor is off unless it starts by \
                              itself; look at `status` and `faults`, then begin again"
            .into(),
        Refused::OutOfOrder => "a later request came first; say it again".into(),
        Refused::Booting => "it has just been switched on; try again in a second".into(),
        Refused::Faulted(code) => {
            format!(
                "the motor is off since {}; mend the cause (docs/faults.md), then `faults --clear`",
                name(*code)
            )
        }
        Refused::NotClearable(code) => {
            format!(
                "no command clears {}: it ends with valid parameters or a reset \
                 (docs/faults.md)",
                name(*code)
            )
        }
        Refused::Armed => "the motor is driven; `stop` first".into(),
        Refused::NotArmed => "the motor is off; `arm` first".into(),
        Refused::Moving => "the joint moves; it has to be at rest for 50 ms first".into(),
        Refused::WouldTrip(code) => {
            format!(
                "{} would turn the motor off at once; mend that first (docs/faults.md)",
                name(*code)
            )
        }
        Refused::OutOfRange => {
            "the motion leads out of `limits.position_min_deg` to `limits.position_max_deg`".into()
        }
        Refused::FarAway => {
            "the trajectory begins too far from the joint (`limits.following_error_deg`, or the \
             error that asks for the full effort): move to its begin first"
                .into()
        }
        Refused::TooFar => {
            "the position is too far from where the joint is: less than 2^30 counts are allowed"
                .into()
        }
        Refused::TooFast => "it moves too fast to brake within `limits.position_min_deg` to \
             `limits.position_max_deg` (`profile.acceleration_deg_per_s2`); move when it is slower"
            .into(),
        Refused::NoParameters => "it has no parameters; `params push FILE.toml` first".into(),
        Refused::NoSuch => "there is no such signal, fault or motion on it".into(),
        Refused::NotWhole => "the parameters did not arrive whole, and the old ones are in use; \
                              push them again"
            .into(),
        Refused::Version(version) => format!(
            "its firmware cannot read version {version} of the parameters; the old ones are in use"
        ),
        Refused::Value { key, found, allowed } => {
            stiction::Error { key: *key, found: *found, allowed: *allowed }.to_string()
        }
        Refused::UnknownValue(key) => {
            format!(
                "it does not know `{key}`: a gain of a law that is not in use, or its firmware is \
                 older than this program"
            )
        }
        Refused::MissingValue(key) => format!("`{key}` is missing in what it was sent"),
        Refused::Flash => "its flash failed; the parameters are in use until it is switched off, \
                           but not saved"
            .into(),
        Refused::Watchdog => {
            "its watchdog did not take over another timeout in time; say it again".into()
        }
        Refused::SupplyTooLow => {
            "its 3.3 V supply is below 2.9 V, too low to erase and write its flash; what is in use \
             stays in use, but is not saved"
                .into()
        }
        Refused::NoOptionBytes => {
            "it is no microcontroller, and has no brown-out reset to turn on".into()
        }
        Refused::Untouchable => {
            "its option bytes may not be changed: the part is protected for ever (RDP level 2), or \
             they are not those of an STM32F405"
                .into()
        }
    }
}

/// What has happened when a part's brown-out reset was turned on.
pub const BROWN_OUT_SET: &str = "\
brown-out reset: on, at level 3 (2.7 V), in the part's option bytes
it counts from the next reset on: press the reset button or switch the part off and on, and look at
`status`, which warns as long as it is off
";

/// Names a fault by its code.
pub fn name(code: u8) -> String {
    Fault::from_code(code).map_or_else(
        || format!("fault {code}"),
        |fault| format!("fault {code} ({})", fault.describe()),
    )
}

/// Describes a fault with its value and time, as in `fault 14 (stall: effort, but no count), effort
/// 0.8050 V, 3.200 s after power-on`.
pub fn told(told: &Told, sample_time: f32) -> String {
    let value = match Fault::from_code(told.code).map(|fault| (fault.value(), fault.unit())) {
        Some((what, unit)) if !unit.is_empty() => format!(", {what} {:.4} {unit}", told.value),
        _ => String::new(),
    };
    let when = match f64::from(told.tick) * f64::from(sample_time) {
        0.0 => String::new(),
        time_s => format!(", {time_s:.3} s after power-on"),
    };
    format!("{}{value}{when}", name(told.code))
}

/// The same for a page, with its section of docs/faults.md, and with how it ends.
pub fn fault(of: &Told, sample_time: f32) -> serde_json::Value {
    let fault = Fault::from_code(of.code);
    let ends = fault.map(|fault| match (fault.is_clearable(), fault.ends_with_parameters()) {
        (true, _) => "command",
        (false, true) => "parameters",
        (false, false) => "reset",
    });
    serde_json::json!({
        "code": of.code,
        "said": told(of, sample_time),
        "section": fault.map(Fault::section),
        "ends": ends,
    })
}

/// Says what to do about a fault.
fn remedy(code: u8) -> String {
    let Some(fault) = Fault::from_code(code) else {
        return "this program is older than the firmware, and does not know it".into();
    };
    let then = match (fault.is_clearable(), fault.ends_with_parameters()) {
        (true, _) => "then `faults --clear`",
        (false, true) => "it ends with `params push FILE.toml --save`",
        (false, false) => "it ends with a reset",
    };
    format!("what to do: docs/faults.md, \"{}\"; {then}", fault.section())
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
    let what = match status.state {
        StateCode::Boot => "it has just been switched on; the motor is off",
        StateCode::Stopped => "the motor is off",
        StateCode::Armed => "the motor is driven",
        StateCode::Faulted(_) => "the motor is off, and stays off until the fault is cleared",
    };
    let mut lines = vec![format!("state      {}: {what}", state(status.state))];
    if status.fault.code != 0 {
        lines.push(format!("fault      {}", told(&status.fault, status.sample_time)));
        lines.push(format!("           {}", remedy(status.fault.code)));
    }
    let position = f64::from(status.position) * f64::from(status.resolution);
    let rest = if status.at_rest { "at rest" } else { "moving" };
    lines.push(format!(
        "position   {position:.4} deg since power-on ({} counts), {rest}",
        status.position
    ));
    lines.push(format!(
        "heat       as if driven with {:.3} V for long (a model: `limits.continuous_v`)",
        status.thermal_effort
    ));
    if status.wound_up {
        let what = "warning    the law pushes a joint that does not move, and the motor gets warm:";
        let then = "           if it lasts, `stop`, and see docs/faults.md";
        lines.extend([what, then].map(String::from));
    }
    if status.gave_up {
        let what = "warning    the law has given up: something holds the joint before its target.";
        let then = "           A new move tries again; see docs/faults.md";
        lines.extend([what, then].map(String::from));
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
        let then =
            "           and autostart waits for a command. `set-brown-out` turns it on for good";
        lines.extend([what, then].map(String::from));
    }
    if status.crystal_not_measured {
        let what =
            "warning    the frequency of its crystal could not be measured: it runs from it, and";
        let then =
            "           its times are right only if it is one of 8 MHz (docs/wiring.md, \"Pins\")";
        lines.extend([what, then].map(String::from));
    }
    if status.unsaved {
        lines.push("warning    the parameters in use are lost at power-off: `params save`".into());
    }
    let time_s = f64::from(status.clock) * f64::from(status.sample_time);
    lines.push(format!("on for     {time_s:.2} s, {} ticks", status.clock));
    lines.push(format!("faults     {} since power-on", status.faults));
    lines.push(format!(
        "link       {} bad frames, {} messages dropped",
        status.bad_frames, status.dropped
    ));
    if status.wire != WireErrors::default() {
        lines.push(format!(
            "           noise on its wire {} times, bytes lost in the device {} times, or more",
            status.wire.noise, status.wire.lost
        ));
    }
    lines.join("\n") + "\n"
}

/// Writes what a ramp of `rate` (V/s) has found.
pub fn levels(levels: &Levels, rate: f32) -> String {
    let stick = match levels.stick {
        Some(v) => format!("stick      {v:.4} V: the effort at which the joint set out"),
        None => "stick      not found: the joint did not move under the largest effort that the \
                 drive lets through"
            .into(),
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
