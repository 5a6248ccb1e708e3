//! Sentences for a person about what a device says.

use stiction::Fault;
use stiction::link::{Refused, StateCode, Status, Told, WireErrors};
use stiction::parameters::names::{Named, Path};
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
            let since = format!("the motor is off since {}", name(*code));
            match Fault::from_code(*code).map(End::of) {
                Some(End::Parameters) => {
                    format!("{since}; it ends with `params push FILE.toml --save`")
                }
                Some(End::Reset) => {
                    format!("{since}; mend the cause (docs/faults.md): it ends with a reset")
                }
                Some(End::Command) | None => {
                    format!("{since}; mend the cause (docs/faults.md), then {CLEAR}")
                }
            }
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
            Named(stiction::Error { key: *key, found: *found, allowed: *allowed }).to_string()
        }
        Refused::UnknownValue(key) => {
            format!(
                "it does not know `{}`: a gain of a law that is not in use, or its firmware is \
                 older than this program",
                Path(*key)
            )
        }
        Refused::MissingValue(key) => format!("`{}` is missing in what it was sent", Path(*key)),
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
    let ends = fault.map(|fault| match End::of(fault) {
        End::Command => "command",
        End::Parameters => "parameters",
        End::Reset => "reset",
    });
    serde_json::json!({
        "code": of.code,
        "said": told(of, sample_time),
        "section": fault.map(Fault::section),
        "ends": ends,
    })
}

/// What ends a fault.
#[derive(Clone, Copy)]
enum End {
    Command,
    Parameters,
    Reset,
}

impl End {
    const fn of(fault: Fault) -> Self {
        match (fault.is_clearable(), fault.ends_with_parameters()) {
            (true, _) => Self::Command,
            (false, true) => Self::Parameters,
            (false, false) => Self::Reset,
        }
    }
}

/// The command that clears a fault.
const CLEAR: &str = "`faults --clear`";

/// Says what to do about a fault. `clear` is what clears one where this is read.
pub fn remedy(code: u8, clear: &str) -> String {
    match Fault::from_code(code) {
        Some(_) => format!("what to do: {}", what_to_do(code, clear)),
        None => what_to_do(code, clear),
    }
}

/// Says the same without an introduction.
fn what_to_do(code: u8, clear: &str) -> String {
    let Some(fault) = Fault::from_code(code) else {
        return "this program is older than the firmware, and does not know it".into();
    };
    let then = match End::of(fault) {
        End::Command => format!("then {clear}"),
        End::Parameters => "it ends with `params push FILE.toml --save`".into(),
        End::Reset => "it ends with a reset".into(),
    };
    format!("docs/faults.md, \"{}\"; {then}", fault.section())
}

/// Says the same to a program, which clears a fault by a command.
pub fn advice(code: u8) -> String {
    what_to_do(code, CLEAR)
}

/// Says of a motor that a fault has turned off when it can be driven again.
fn stays_off(code: u8) -> &'static str {
    match Fault::from_code(code).map(End::of) {
        Some(End::Command) => "the motor is off, and stays off until the fault is cleared",
        Some(End::Parameters) => "the motor is off, and stays off until parameters are valid",
        Some(End::Reset) => "the motor is off, and stays off until the next reset",
        None => "the motor is off, and stays off",
    }
}

/// Writes the faults that a device remembers, the oldest first, and what to do about the one that
/// is latched.
pub fn faults(remembered: &[Told], status: &Status) -> String {
    if remembered.is_empty() && status.fault.code == 0 {
        return "no fault since power-on\n".into();
    }
    let mut lines: Vec<String> =
        remembered.iter().map(|one| told(one, status.sample_time)).collect();
    if let code @ 1.. = status.fault.code {
        lines.push(format!("latched    {}", name(code)));
        lines.push(format!("           {}", stays_off(code)));
        lines.push(format!("           {}", remedy(code, CLEAR)));
    }
    lines.join("\n") + "\n"
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
        StateCode::Faulted(code) => stays_off(code),
    };
    let mut lines = vec![format!("state      {}: {what}", state(status.state))];
    if status.fault.code != 0 {
        lines.push(format!("fault      {}", told(&status.fault, status.sample_time)));
        lines.push(format!("           {}", remedy(status.fault.code, CLEAR)));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn latched(code: u8) -> Status {
        let fault = Told { code, tick: 320, value: 0.805 };
        Status {
            state: StateCode::Faulted(code),
            fault,
            faults: 1,
            clock: 5000,
            sample_time: 0.01,
            position: 0,
            resolution: 0.01,
            at_rest: true,
            wound_up: false,
            thermal_effort: 0.5,
            unsaved: false,
            is_damaged: false,
            bad_frames: 0,
            dropped: 0,
            has_brown_out: true,
            wire: WireErrors::default(),
            crystal_not_measured: false,
            gave_up: false,
        }
    }

    /// A command that is refused is no way out.
    #[test]
    fn only_a_fault_that_a_command_clears_is_said_to_end_by_one() {
        for fault in Fault::ALL {
            let code = *fault as u8;
            let end = if fault.is_clearable() {
                "until the fault is cleared\n"
            } else if fault.ends_with_parameters() {
                "until parameters are valid\n"
            } else {
                "until the next reset\n"
            };
            let told = [status(&latched(code)), faults(&[latched(code).fault], &latched(code))];
            for said in &told {
                assert!(said.contains(end), "{code}: {said}");
                assert!(said.contains(&format!("docs/faults.md, \"{}\"", fault.section())));
            }
            for said in told.iter().chain([&refused(&Refused::Faulted(code))]) {
                assert_eq!(said.contains("--clear"), fault.is_clearable(), "{code}: {said}");
            }
        }
    }

    #[test]
    fn what_to_do_stands_below_the_faults_while_one_is_latched() {
        let mut of = latched(14);
        let remembered = [Told { code: 17, tick: 100, value: 60.0 }, of.fault];
        let said = faults(&remembered, &of);
        let lines: Vec<&str> = said.lines().collect();
        assert!(lines[0].starts_with("fault 17") && lines[1].starts_with("fault 14"), "{said}");
        assert!(lines[2].starts_with("latched    fault 14") && lines[4].contains("14 Stall"));
        assert_eq!(lines.len(), 5);
        // Nothing is to be done about faults that are over.
        (of.state, of.fault) = (StateCode::Stopped, Told::default());
        assert_eq!(faults(&remembered, &of).lines().collect::<Vec<_>>(), lines[..2]);
        assert_eq!(faults(&[], &of), "no fault since power-on\n");
    }
}
