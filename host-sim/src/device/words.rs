//! What a device says, in words.

use stiction::compensator::Gains;
use stiction::encoder::CounterBits;
use stiction::link::{Refused, State, Status, Told};
use stiction::servo::Levels;
use stiction::{Fault, Limits, Parameters};

use crate::limits::LimitsTable;

/// Why a request was refused, and what to do.
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
        Refused::WouldTrip(code) => format!("it would end in {} at once (docs/faults.md)", name(*code)),
        Refused::OutOfRange => {
            "the motion leads out of `limits.position_min_deg` to `limits.position_max_deg`".into()
        }
        Refused::NoParameters => "it has no parameters; `params push FILE.toml` first".into(),
        Refused::NoSuch => "there is no such thing".into(),
        Refused::NotWhole => "the record of parameters did not arrive whole".into(),
        Refused::Version(version) => format!("it cannot read version {version} of the parameters"),
        Refused::Value { key, found, allowed } => {
            // As the core would say it: the key is not one that lives for ever.
            let error = stiction::Error { key: "", found: *found, allowed: *allowed };
            error.to_string().replacen("``", &format!("`{key}`"), 1)
        }
        Refused::Flash => "its flash failed; the parameters are in use, but not saved".into(),
    }
}

/// A fault by its code.
pub fn name(code: u8) -> String {
    Fault::from_code(code)
        .map_or_else(|| format!("fault {code}"), |fault| format!("fault {code} ({})", fault.describe()))
}

/// `fault 14 (stall: effort, but no count), 0.805 V, 3.200 s after power-on`.
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

/// `armed`, `faulted`.
pub const fn state(state: State) -> &'static str {
    match state {
        State::Boot => "boot",
        State::Stopped => "stopped",
        State::Armed => "armed",
        State::Faulted(_) => "faulted",
    }
}

/// A status in lines.
pub fn status(status: &Status) -> String {
    let mut lines = vec![format!("state      {}", state(status.state))];
    if status.fault.code != 0 {
        lines.push(format!("fault      {}", told(&status.fault, status.sample_time)));
    }
    let position = f64::from(status.position) * f64::from(status.resolution);
    let rest = if status.at_rest { "at rest" } else { "moving" };
    lines.push(format!("position   {position:.4} deg since power-on ({} counts), {rest}", status.position));
    lines.push(format!("heat       that of {:.3} V for ever", status.thermal_effort));
    if status.wound_up {
        lines.push("warning    the compensator holds effort at standstill: the motor gets warm".into());
    }
    if status.unsaved {
        lines.push("warning    the parameters in use are not saved: `params save`".into());
    }
    let time_s = f64::from(status.clock) * f64::from(status.sample_time);
    lines.push(format!("on for     {time_s:.2} s, {} ticks", status.clock));
    lines.push(format!("faults     {} since power-on", status.faults));
    lines.push(format!("link       {} bad frames, {} messages dropped", status.bad_frames, status.dropped));
    lines.join("\n") + "\n"
}

/// What a ramp of `rate` (V/s) has found.
pub fn levels(levels: &Levels, rate: f32) -> String {
    let stick = match levels.stick {
        Some(v) => format!("stick      {v:.4} V: the effort at which the joint set out"),
        None => "stick      not found: the joint did not move up to the full scale".into(),
    };
    let slip = match (levels.slip, levels.stick) {
        (Some(v), _) => format!("slip       {v:.4} V: the effort at which it came to rest"),
        (None, Some(_)) => "slip       not found: the joint did not come to rest".into(),
        (None, None) => "slip       not found".into(),
    };
    format!("{stick}\n{slip}\nrate       {rate} V/s; a slower ramp reads stick lower and slip higher\n")
}

/// Parameters, with the keys of a machine's file. Only what a device knows: it has no joint and no names.
pub fn parameters(parameters: &Parameters) -> String {
    let Parameters { controller, motion, device, limits } = parameters;
    let (encoder, drive) = (&controller.encoder, &controller.drive);
    let mut lines = Vec::new();
    let mut table = |name: &str, entries: &[(&str, f32)]| {
        lines.push(format!("[{name}]"));
        lines.extend(entries.iter().map(|(key, value)| format!("{key} = {value}")));
        lines.push(String::new());
    };
    let bits = match encoder.counter_bits {
        CounterBits::Sixteen => 16.0,
        CounterBits::ThirtyTwo => 32.0,
    };
    table("encoder", &[("resolution_deg", encoder.resolution), ("counter_bits", bits)]);
    table("drive", &[("full_scale_v", drive.full_scale), ("lsb_v", drive.lsb)]);
    let window = controller.velocity_window as f32;
    table("loop", &[("sample_time_s", controller.sample_time), ("velocity_window", window)]);
    table("controller", &[("kp_v_per_deg", controller.pd.kp), ("kd_v_per_deg_per_s", controller.pd.kd)]);
    for law in &controller.compensator {
        let (name, gains) = gains(law);
        table(&format!("controller: {name}"), &gains);
    }
    let device = [
        ("autostart_delay_s", device.autostart_delay),
        ("soft_start_s", device.soft_start),
        ("dead_time_s", device.dead_time),
        ("nominal_supply_v", device.nominal_supply),
        ("supply_full_scale_v", device.supply_full_scale),
    ];
    table("device", &device);
    table("limits", &LimitsTable::KEYS.into_iter().zip(limits_of(limits)).collect::<Vec<_>>());
    let more = [
        ("autostart", format!("{:?}", parameters.device.autostart)),
        ("direction", format!("{:?}", encoder.direction).to_lowercase()),
        ("mode", format!("{:?}", drive.mode)),
        ("motion", format!("{motion:?}").split(['(', ' ']).next().unwrap_or_default().to_lowercase()),
    ];
    lines.extend(more.map(|(key, value)| format!("{key}: {value}")));
    lines.join("\n") + "\n"
}

/// In the order of [`LimitsTable::KEYS`].
const fn limits_of(limits: &Limits) -> [f32; 15] {
    [
        limits.encoder_jump,
        limits.stall_effort,
        limits.stall_time,
        limits.reversal,
        limits.following_error,
        limits.overspeed,
        limits.position_min,
        limits.position_max,
        limits.supply_min,
        limits.supply_max,
        limits.continuous_effort,
        limits.thermal_time,
        limits.link_timeout,
        limits.wind_up_effort,
        limits.wind_up_time,
    ]
}

fn gains(law: &Gains) -> (&'static str, Vec<(&'static str, f32)>) {
    match law {
        Gains::ResetIntegral(g) => ("ri", vec![("ki_v_per_deg_s", g.ki), ("theta_ri_deg", g.theta_ri)]),
        Gains::RateVariableIntegral(g) => {
            ("rvi", vec![("ki_v_per_deg_s", g.ki), ("gamma_deg2_per_s2", g.gamma)])
        }
        Gains::ResetOffsetIntegral(g) => ("roi", vec![("t_roi_s", g.t_roi), ("v_roi_deg_per_s", g.v_roi)]),
        Gains::Feedforward(g) => ("feedforward", vec![("v_slip_v", g.v_slip), ("v_ff_deg_per_s", g.v_ff)]),
        Gains::DiscontinuousNonlinearProportional(g) => ("dnpf", vec![("theta_b_deg", g.theta_b)]),
        Gains::SmoothRobustNonlinear(g) => ("srnf", vec![("v_ms_v", g.v_ms), ("alpha_per_deg", g.alpha)]),
    }
}
