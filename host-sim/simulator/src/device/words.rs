//! Text for users: refusals, faults, status and ramp results of a device.

use stiction::Fault;
use stiction::control::motor_encoder::MotorEncoder;
use stiction::link::{FaultReport, RequestRefusal, StateCode, Status, WireErrors};
use stiction::parameters::names::{NamedError, ValuePath};
use stiction::servo::FrictionLevels;
use stiction::units::value::Table as _;

/// Returns why a request was refused, and what to do.
pub fn refused(refused: &RequestRefusal) -> String {
    match refused {
        RequestRefusal::Unknown => {
            "its firmware does not have this request; flash the firmware of this \
                             program (`cargo xtask flash`)"
                .into()
        }
        RequestRefusal::SayHello => "this session has ended: the device was reset, or another \
                                     client opened a session or took over; check `status` and \
                                     `faults`, then start again"
            .into(),
        RequestRefusal::NotOwner => "another client has the motor driven; `status`, `faults` and \
                                     `stop` work, and `take-over` stops the motor and ends the \
                                     other client's session"
            .into(),
        RequestRefusal::OutOfOrder => "a later request arrived first; repeat it".into(),
        RequestRefusal::Booting => "it has just been switched on; try again in a second".into(),
        RequestRefusal::Faulted(code) => {
            let since = format!("the motor is off since {}", name(*code));
            match Fault::from_code(*code).map(FaultEnd::of) {
                Some(FaultEnd::Parameters) => {
                    format!("{since}; clear it with `params push FILE.toml --save`")
                }
                Some(FaultEnd::Reset) => {
                    format!(
                        "{since}; fix the cause (docs/reference/faults.md), then reset the device"
                    )
                }
                Some(FaultEnd::Command) | None => {
                    format!("{since}; fix the cause (docs/reference/faults.md), then {CLEAR}")
                }
            }
        }
        RequestRefusal::NotClearable(code) => {
            format!(
                "no command clears {}: only valid parameters or a reset end it \
                 (docs/reference/faults.md)",
                name(*code)
            )
        }
        RequestRefusal::Armed => "the motor is driven; `stop` first".into(),
        RequestRefusal::NotArmed => "the motor is off; `arm` first".into(),
        RequestRefusal::Moving => "the joint moves; it must be at rest for 50 ms first".into(),
        RequestRefusal::WouldTrip(code) => {
            format!(
                "{} would turn the motor off at once; fix its cause first \
                 (docs/reference/faults.md)",
                name(*code)
            )
        }
        RequestRefusal::OutOfRange => {
            "the motion leaves the range `limits.position_min_deg` to `limits.position_max_deg`"
                .into()
        }
        RequestRefusal::FarAway => {
            "the start of the trajectory is too far from the joint (`limits.following_error_deg`, \
             or the error at which the controller outputs the full effort): move to its start \
             first"
                .into()
        }
        RequestRefusal::TooFar => {
            "the position is too far away; it must be less than 2^30 counts from the joint".into()
        }
        RequestRefusal::TooFast => {
            "the joint moves too fast to brake within `limits.position_min_deg` \
             to `limits.position_max_deg` (`profile.acceleration_deg_per_s2`); move when it is \
             slower"
                .into()
        }
        RequestRefusal::SaveLater(seconds) => format!(
            "parameters were saved too often, and each save wears the flash: save again in {} min; \
             those in use stay in use until power-off",
            seconds.div_ceil(60)
        ),
        RequestRefusal::Stopping => {
            "a stop is under way (`device.stop_s`); the output is off at its end".into()
        }
        RequestRefusal::EncoderInDoubt => {
            "the encoder is in doubt since a stall, a jump or a reversal: turn the joint by hand \
             by 16 counts or more, or let `jog` find that encoder and motor agree"
                .into()
        }
        RequestRefusal::FrictionUnknown => {
            "the friction of the joint is unknown, so a dead encoder would look like a joint at \
             rest: run `jog`, then `identify --into FILE.toml` and `params push`; or set \
             `limits.breakaway_min_v` and `limits.breakaway_v`"
                .into()
        }
        RequestRefusal::NotReferenced => {
            "position limits are set (`limits.position_min_deg`, `limits.position_max_deg`), but \
             the joint's position is unknown since a reset, a fault of the encoder, another \
             `[encoder]`, or a homing that found no stop: run `home`, or bring the joint to a \
             known position, by hand or by `jog`, and set that position with \
             `reference --at DEG`"
                .into()
        }
        RequestRefusal::Testing => {
            "the test at arming runs (`device.arming_test_deg`), and accepts only `stop`; wait for \
             its end"
                .into()
        }
        RequestRefusal::NoParameters => {
            "it has no parameters; `params push FILE.toml` first".into()
        }
        RequestRefusal::NoSuch => "it has no such signal, fault or motion".into(),
        RequestRefusal::NotWhole => {
            "the parameters arrived incomplete, and the old ones stay in use; \
                              push them again"
                .into()
        }
        RequestRefusal::Version(version) => format!(
            "its firmware cannot read version {version} of the parameters; the old ones stay in use"
        ),
        RequestRefusal::Value { key, found, allowed } => {
            NamedError(stiction::InvalidValue { key: *key, found: *found, allowed: *allowed })
                .to_string()
        }
        RequestRefusal::UnknownValue(key)
            if MotorEncoder::ABOUT.iter().any(|about| about.key == *key) =>
        {
            "its firmware reads one encoder, and the file has a `[load_encoder]`; flash the image \
             for two encoders (`cargo xtask flash --two-encoders`), or set `loop.position` to \
             \"motor\""
                .into()
        }
        RequestRefusal::UnknownValue(key) => {
            format!(
                "it does not have `{}`: the law of this gain is not in use, or the firmware is \
                 older than this program",
                ValuePath(*key)
            )
        }
        RequestRefusal::MissingValue(key) => {
            format!("`{}` is missing in the parameters sent", ValuePath(*key))
        }
        RequestRefusal::Flash => {
            "a write to its flash failed: nothing was saved. Parameters that were not saved before \
             are lost when it is switched off"
                .into()
        }
        RequestRefusal::Watchdog => {
            "its watchdog did not accept the new timeout in time; repeat the command".into()
        }
        RequestRefusal::SupplyTooLow => {
            "its 3.3 V supply is below 2.9 V, too low to write its flash; the parameters stay in \
             use, but are not saved"
                .into()
        }
        RequestRefusal::NoOptionBytes => {
            "it is not a microcontroller, so it has no brown-out reset to turn on".into()
        }
        RequestRefusal::Untouchable => {
            "its option bytes cannot be changed: the microcontroller is permanently protected (RDP \
             level 2), or they are not those of an STM32F405"
                .into()
        }
    }
}

/// Message after the brown-out reset was turned on.
pub const BROWN_OUT_SET: &str = "\
brown-out reset: on, at level 3 (2.7 V), in the option bytes of the microcontroller
it takes effect at the next reset: press the reset button or switch the device off and on, and look
at `status`, which warns while it is off
";

/// Returns code and description of a fault.
pub fn name(code: u8) -> String {
    Fault::from_code(code).map_or_else(
        || format!("fault {code}"),
        |fault| format!("fault {code} ({})", fault.describe()),
    )
}

/// Describes a fault with its value and time, as in `fault 14 (stall: effort, but no count), effort
/// 0.8050 V, 3.200 s after power-on`.
pub fn fault(report: &FaultReport, sample_time: f32) -> String {
    let value = match Fault::from_code(report.code).map(|fault| (fault.value(), fault.unit())) {
        Some((what, unit)) if !unit.is_empty() => format!(", {what} {:.4} {unit}", report.value),
        _ => String::new(),
    };
    let when = match f64::from(report.tick) * f64::from(sample_time) {
        0.0 => String::new(),
        time_s => format!(", {time_s:.3} s after power-on"),
    };
    format!("{}{value}{when}", name(report.code))
}

/// Returns the JSON object of a fault, with its section of docs/reference/faults.md and what ends
/// it: `command`, `parameters` or `reset`.
pub fn fault_json(report: &FaultReport, sample_time: f32) -> serde_json::Value {
    let known = Fault::from_code(report.code);
    let ends = known.map(|fault| match FaultEnd::of(fault) {
        FaultEnd::Command => "command",
        FaultEnd::Parameters => "parameters",
        FaultEnd::Reset => "reset",
    });
    serde_json::json!({
        "code": report.code,
        "said": fault(report, sample_time),
        "section": known.map(Fault::section),
        "ends": ends,
    })
}

/// Way in which a fault is cleared.
#[derive(Clone, Copy)]
enum FaultEnd {
    Command,
    Parameters,
    Reset,
}

impl FaultEnd {
    const fn of(fault: Fault) -> Self {
        match (fault.is_clearable(), fault.ends_with_parameters()) {
            (true, _) => Self::Command,
            (false, true) => Self::Parameters,
            (false, false) => Self::Reset,
        }
    }
}

/// Command that clears a fault.
pub const CLEAR: &str = "`faults --clear`";

/// Returns what to do about a fault; for a known fault the text starts with `what to do:`. `clear`
/// names the command or button that clears a fault.
pub fn remedy(code: u8, clear: &str) -> String {
    match Fault::from_code(code) {
        Some(_) => format!("what to do: {}", what_to_do(code, clear)),
        None => what_to_do(code, clear),
    }
}

/// Returns what to do about a fault.
fn what_to_do(code: u8, clear: &str) -> String {
    let Some(fault) = Fault::from_code(code) else {
        return "this program is older than the firmware, and does not know this fault".into();
    };
    let then = match FaultEnd::of(fault) {
        FaultEnd::Command => format!("then {clear}"),
        FaultEnd::Parameters => "it ends with `params push FILE.toml --save`".into(),
        FaultEnd::Reset => "it ends with a reset".into(),
    };
    format!("docs/reference/faults.md, \"{}\"; {then}", fault.section())
}

/// Returns what to do about a fault, for a user of the command line.
pub fn advice(code: u8) -> String {
    what_to_do(code, CLEAR)
}

/// Returns the half sentence on how long a fault keeps the motor off.
fn stays_off(code: u8) -> &'static str {
    match Fault::from_code(code).map(FaultEnd::of) {
        Some(FaultEnd::Command) => "the motor is off, and stays off until the fault is cleared",
        Some(FaultEnd::Parameters) => "the motor is off, and stays off until parameters are valid",
        Some(FaultEnd::Reset) => "the motor is off, and stays off until the next reset",
        None => "the motor is off, and stays off",
    }
}

/// Lists the faults that a device has stored, the oldest first, and what to do about the latched
/// one.
pub fn faults(remembered: &[FaultReport], status: &Status) -> String {
    if remembered.is_empty() && status.fault.code == 0 {
        return "no fault since power-on\n".into();
    }
    let mut lines: Vec<String> =
        remembered.iter().map(|one| fault(one, status.sample_time)).collect();
    if let code @ 1.. = status.fault.code {
        lines.push(format!("latched    {}", name(code)));
        lines.push(format!("           {}", stays_off(code)));
        lines.push(format!("           {}", remedy(code, CLEAR)));
    }
    lines.join("\n") + "\n"
}

/// Remark on a fault that came during the test at arming.
pub const IN_THE_TEST: &str =
    "it came during the test at arming (`device.arming_test_deg`), before the loop closed";

/// Returns the name of a state, such as `armed` or `faulted`.
pub const fn state(state: StateCode) -> &'static str {
    match state {
        StateCode::Boot => "boot",
        StateCode::Stopped => "stopped",
        StateCode::Armed => "armed",
        StateCode::Faulted(_) => "faulted",
    }
}

/// Returns a status as text, one quantity a line.
pub fn status(status: &Status) -> String {
    let what = match status.state {
        StateCode::Boot => "it has just been switched on; the motor is off",
        StateCode::Stopped => "the motor is off",
        StateCode::Armed => "the motor is driven",
        StateCode::Faulted(code) => stays_off(code),
    };
    let mut lines = vec![format!("state      {}: {what}", state(status.state))];
    if status.fault.code != 0 {
        lines.push(format!("fault      {}", fault(&status.fault, status.sample_time)));
        if status.has_failed_test {
            lines.push(format!("           {IN_THE_TEST}"));
        }
        lines.push(format!("           {}", remedy(status.fault.code, CLEAR)));
    }
    if status.is_testing {
        lines.push("test       the test at arming runs; the motion starts after it".into());
    }
    let position = f64::from(status.position) * f64::from(status.resolution);
    let rest = if status.at_rest { "at rest" } else { "moving" };
    let zero = if status.is_referenced { "from the reference" } else { "since power-on" };
    lines.push(format!("position   {position:.4} deg {zero} ({} counts), {rest}", status.position));
    if status.index_passes > 0 {
        let (passes, deviation) = (status.index_passes, status.index_deviation);
        lines.push(format!("index      {passes} passes, the last one {deviation:+} counts off"));
    }
    lines.push(format!(
        "heat       as at a steady {:.3} V at standstill (a model: `limits.continuous_v`)",
        status.thermal_effort
    ));
    if let Some(celsius) = status.motor_temperature {
        lines.push(format!("motor      {celsius:.0} deg C (`[motor_ntc]`)"));
    }
    if status.wound_up {
        let what = "warning    the law pushes a joint that does not move; the motor heats up:";
        let then = "           if it lasts, `stop`, and see docs/reference/faults.md";
        lines.extend([what, then].map(String::from));
    }
    if status.oscillates {
        let what =
            "warning    the joint swings around its target: `stop`, and check gains and inertia";
        let then = "           (docs/reference/faults.md, 24)";
        lines.extend([what, then].map(String::from));
    }
    if status.gave_up {
        let what = "warning    the law has ended its attempts: the joint is not at its target. An";
        let why =
            "           obstacle holds it, or behind a soft gear its load jumps too far. A new";
        let then = "           move tries again; see docs/reference/faults.md";
        lines.extend([what, why, then].map(String::from));
    }
    if status.is_encoder_in_doubt {
        let what =
            "warning    the encoder is in doubt since a stall, a jump or a reversal: turn the";
        let then =
            "           joint by hand by 16 counts or more, or `jog`, before it is armed again";
        lines.extend([what, then].map(String::from));
    }
    if !status.is_referenced {
        let what = "warning    the position is unknown (`device.reference`): with position limits,";
        let then =
            "           only `jog` and `home` are allowed until `home` or `reference` sets it";
        lines.extend([what, then].map(String::from));
    }
    if status.is_damaged {
        let what =
            "warning    one of the two saved sets of parameters is damaged: those in use can be";
        let then =
            "           older ones, and autostart is off. Check them (`params show`), push others";
        lines.extend(
            [what, then, "           if needed (`params push`), then save them (`params save`)"]
                .map(String::from),
        );
    }
    if !status.has_brown_out {
        let what =
            "warning    its brown-out reset is off: a dip of its supply looks like power-on,";
        let then =
            "           and autostart waits for a command. `set-brown-out` turns it on permanently";
        lines.extend([what, then].map(String::from));
    }
    if status.crystal_not_measured {
        let what = "warning    the device could not measure its crystal: all times are right only";
        let then = "           with a crystal of 8 MHz (docs/reference/wiring.md, \"Pins\")";
        lines.extend([what, then].map(String::from));
    }
    if status.unsaved {
        lines.push("warning    the parameters in use are lost at power-off: `params save`".into());
    }
    let time_s = f64::from(status.clock) * f64::from(status.sample_time);
    lines.push(format!("on for     {time_s:.2} s, {} ticks", status.clock));
    lines.push(format!("faults     {} since power-on", status.faults));
    lines.push(format!("saves      {} of 20000 that the flash tolerates", status.saves));
    lines.push(format!(
        "link       {} bad frames, {} messages dropped",
        status.bad_frames, status.dropped
    ));
    if status.wire != WireErrors::default() {
        lines.push(format!(
            "           at least {} noise errors on its wire, {} losses of bytes in the device",
            status.wire.noise, status.wire.lost
        ));
    }
    lines.join("\n") + "\n"
}

/// Returns the results of a ramp of `rate` (V/s) as text.
pub fn levels(levels: &FrictionLevels, rate: f32) -> String {
    let stick = match levels.stick {
        Some(v) => format!("stick      {v:.4} V: the effort at which the joint broke away"),
        None => {
            "stick      not found: the joint did not move under the largest effort of the drive"
                .into()
        }
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
        let fault = FaultReport { code, tick: 320, value: 0.805 };
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
            motor_temperature: None,
            unsaved: false,
            is_damaged: false,
            oscillates: false,
            is_referenced: true,
            index_passes: 0,
            index_deviation: 0,
            saves: 1,
            bad_frames: 0,
            dropped: 0,
            has_brown_out: true,
            wire: WireErrors::default(),
            crystal_not_measured: false,
            gave_up: false,
            is_encoder_in_doubt: false,
            is_testing: false,
            has_failed_test: false,
            load_angle: None,
        }
    }

    /// The advice must not name a command that the device would refuse.
    #[test]
    fn only_a_clearable_fault_has_the_clear_command_in_its_advice() {
        for fault in Fault::ALL {
            let code = *fault as u8;
            let end = if fault.is_clearable() {
                "until the fault is cleared\n"
            } else if fault.ends_with_parameters() {
                "until parameters are valid\n"
            } else {
                "until the next reset\n"
            };
            let texts = [status(&latched(code)), faults(&[latched(code).fault], &latched(code))];
            for said in &texts {
                assert!(said.contains(end), "{code}: {said}");
                assert!(
                    said.contains(&format!("docs/reference/faults.md, \"{}\"", fault.section()))
                );
            }
            for said in texts.iter().chain([&refused(&RequestRefusal::Faulted(code))]) {
                assert_eq!(said.contains("--clear"), fault.is_clearable(), "{code}: {said}");
            }
        }
    }

    #[test]
    fn the_fault_list_ends_with_what_to_do_while_a_fault_is_latched() {
        let mut of = latched(14);
        let remembered = [FaultReport { code: 17, tick: 100, value: 60.0 }, of.fault];
        let said = faults(&remembered, &of);
        let lines: Vec<&str> = said.lines().collect();
        assert!(lines[0].starts_with("fault 17") && lines[1].starts_with("fault 14"), "{said}");
        assert!(lines[2].starts_with("latched    fault 14") && lines[4].contains("14 Stall"));
        assert_eq!(lines.len(), 5);
        // Faults that are over need no action.
        (of.state, of.fault) = (StateCode::Stopped, FaultReport::default());
        assert_eq!(faults(&remembered, &of).lines().collect::<Vec<_>>(), lines[..2]);
        assert_eq!(faults(&[], &of), "no fault since power-on\n");
    }
}
