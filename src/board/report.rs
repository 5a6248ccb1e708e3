//! The report: the log of the firmware, by defmt over RTT.
//!
//! While a line is written, interrupts wait, including that of the control task. They wait for a
//! few microseconds, less than a tenth of the shortest sample time. Only this task writes, and only
//! ten lines of trace a second.

use defmt::{error, info, warn};
use defmt_rtt as _;
use stiction::Fault;
use stiction::motion::jog::{JogFindings, Verdict};
use stiction::parameters::DecodeError;
use stiction::servo::{FrictionLevels, Output, State};

use crate::board::crystal::Crystal;
use crate::board::reset_cause::{BrownOut, ResetCause};
use crate::board::retained::RetainedFault;
use crate::board::setup::{Board, BoardSettings};

/// Rate of the trace, lines a second.
const TRACE_HZ: f32 = 10.0;

/// Log of the servo's changes of state, faults and traces.
pub struct Report {
    state: State,
    /// Ticks from one line of the trace to the next.
    every: u32,
    ticks: u32,
}

impl Report {
    /// Makes the report of a servo that boots.
    pub const fn new() -> Self {
        Self { state: State::Boot, every: 1, ticks: 0 }
    }

    /// Writes the first lines after a reset.
    pub fn banner(
        &self,
        board: &Board,
        (cause, brown_out): (ResetCause, BrownOut),
        record: Option<&RetainedFault>,
        last: Option<Fault>,
        settings: &BoardSettings,
    ) {
        let source = match board.crystal {
            Crystal::Measured(_) => "crystal",
            Crystal::NotMeasured => "crystal, whose frequency was not measured",
            Crystal::Wrong(_) => "internal oscillator, crystal of another frequency",
            Crystal::Absent => "internal oscillator, crystal absent",
        };
        info!("stiction {=str} ({=str}) on STM32F405", stiction::VERSION, env!("STICTION_COMMIT"));
        info!("clock {=u32} Hz from {=str}", board.clock, source);
        match board.crystal {
            Crystal::Measured(mhz) => info!("the crystal has {=u8} MHz", mhz),
            Crystal::Wrong(mhz) => {
                error!("the crystal has about {=f32} MHz, not 8, 12, 16 or 25: no motion", mhz);
            }
            Crystal::NotMeasured | Crystal::Absent => {}
        }
        info!(
            "reset by {=str}; last fault: {=str}",
            cause.describe(),
            last.map_or("none", Fault::describe)
        );
        if brown_out.is_on() {
            info!("brown-out reset: {=str}", brown_out.describe());
        } else {
            warn!("brown-out reset is off: a dip of the supply looks like power-on");
        }
        match record.map(|record| (record.fault(), record)) {
            Some((Some(Fault::Panic), record)) => {
                error!("panic in {=str}, line {=u32}", record.text(), record.place);
            }
            Some((Some(Fault::HardFault), record)) if record.place == 0 => {
                error!("hard fault after a stack overflow, status {=u32:#x}", record.status);
            }
            Some((Some(Fault::HardFault), record)) => {
                error!("hard fault at {=u32:#x}, status {=u32:#x}", record.place, record.status);
            }
            _ => {}
        }
        if let Some(latched) =
            record.and_then(RetainedFault::as_latched).filter(|latched| latched.tick > 0)
        {
            let (value, unit) = (latched.value, latched.fault.unit());
            if unit.is_empty() {
                info!("it was at tick {=u32}", latched.tick);
            } else {
                info!("it was at tick {=u32}, by {=f32} {=str}", latched.tick, value, unit);
            }
        }
        if settings.is_damaged {
            error!(
                "a saved set of parameters is damaged: older ones may be in use, nothing starts by itself"
            );
        }
        match settings.parameters() {
            Ok(parameters) => {
                let sector = settings.sector().unwrap_or_default();
                let (sample_time, pwm) =
                    (settings.sample_time(), parameters.controller.drive.pwm_hz);
                info!(
                    "parameters of sector {=u8}: sample time {=f32} s, PWM {=f32} Hz",
                    sector, sample_time, pwm
                );
                let device = &parameters.device;
                let is_unsure = cause.may_be_dip(brown_out) && !device.autostart_after_dip;
                if device.autostart && !settings.is_damaged && is_unsure {
                    warn!("autostart: not after this reset, which may be a dip of the supply");
                } else if device.autostart && !settings.is_damaged {
                    let delay = device.autostart_delay;
                    warn!(
                        "autostart: arms by itself after {=f32} s unless there is a fault",
                        delay
                    );
                }
            }
            Err(error) => refused(error),
        }
    }

    /// Reports a tick of a loop with this sample time (s), and returns the previous state if the
    /// tick has changed it.
    pub fn report_tick(&mut self, output: &Output, sample_time: f32) -> Option<State> {
        let changed = (output.state != self.state).then_some(self.state);
        if changed.is_some() {
            self.state = output.state;
            self.ticks = 0;
            // A link may have set another sample time meanwhile.
            self.every = (libm::roundf(1.0 / (TRACE_HZ * sample_time)) as u32).max(1);
            match output.state {
                State::Boot => info!("boot"),
                State::Stopped => info!("stopped"),
                State::Armed => info!("armed"),
                State::Faulted(fault) => {
                    error!(
                        "faulted: {=str} (code {=u8}); the motor is off, see docs/reference/faults.md",
                        fault.describe(),
                        fault as u8
                    );
                }
            }
        }
        if !output.enable {
            return changed;
        }
        if self.ticks == 0 {
            let tick = &output.tick;
            info!(
                "t {=u32} counts {=i32} error {=f32} velocity {=f32} v_pd {=f32} v_c {=f32} code {=i16}",
                tick.tick, tick.counts, tick.error, tick.velocity, tick.v_pd, tick.v_c, tick.code
            );
        }
        self.ticks = (self.ticks + 1) % self.every;
        changed
    }

    /// Writes that the servo was armed for a jog.
    pub fn jog_begins(&self) {
        info!("jog: pushes the joint each way, open loop, until it moves");
    }

    /// Writes the findings of a ramp or a jog, if it has come to its end.
    pub fn motion_over(&self, levels: Option<FrictionLevels>, found: Option<JogFindings>) {
        if let Some(levels) = levels {
            report_levels(&levels);
        }
        if let Some(found) = found {
            report_jog(&found);
        }
    }
}

fn report_levels(levels: &FrictionLevels) {
    match (levels.stick, levels.slip) {
        (Some(stick), Some(slip)) => {
            info!("friction: stick {=f32} V, slip {=f32} V", stick, slip)
        }
        (Some(stick), None) => {
            warn!("friction: stick {=f32} V; the joint did not come to rest", stick)
        }
        (None, _) => warn!("friction: the joint did not move"),
    }
}

fn report_jog(found: &JogFindings) {
    let [first, second] = &found.ways;
    let verdict = in_words(found.verdict());
    info!(
        "jog: {=i32} counts by {=f32} V, {=i32} counts by -{=f32} V: {=str}",
        first.moved, first.effort, second.moved, second.effort, verdict
    );
    #[cfg(feature = "two-encoders")]
    if let (Some(there), Some(verdict)) = (first.motor_moved, found.motor_verdict()) {
        let back = second.motor_moved.unwrap_or(0);
        info!("jog: of the motor {=i32} and {=i32} counts: {=str}", there, back, in_words(verdict));
    }
}

fn in_words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Agrees => "the encoder counts in the sense of the effort",
        Verdict::Reversed => "the encoder counts AGAINST the effort",
        Verdict::Pulled => "a load moves the joint",
        Verdict::RunsOn => "the joint went on without effort",
        Verdict::Still => "nothing moved",
        Verdict::Noise => "the encoder counts to and fro",
    }
}

fn refused(refusal: DecodeError) {
    match refusal {
        DecodeError::Blank => {
            error!(
                "no parameters: the motor stays off; `params push FILE.toml --save` over the link"
            )
        }
        DecodeError::NotParameters => {
            error!("the parameter sectors hold something else: the motor stays off")
        }
        DecodeError::Version(found) => {
            error!(
                "the parameters have format {=u32}, not {=u32}: the motor stays off",
                found, FORMAT
            );
        }
        DecodeError::Checksum => {
            error!("the parameters are damaged (checksum): the motor stays off")
        }
        DecodeError::Malformed => {
            error!("the parameters are malformed: the motor stays off")
        }
        DecodeError::Unknown(key) => {
            error!("value {=u16:#06x} is not known to this firmware: the motor stays off", key.0);
        }
        DecodeError::Missing(key) => {
            error!(
                "value {=u16:#06x} (docs/reference/parameters.md) is missing: the motor stays off",
                key.0
            );
        }
        DecodeError::Value(error) => {
            let (number, found) = (error.key.0, error.found);
            error!(
                "value {=u16:#06x} (docs/reference/parameters.md) is {=f32}, not allowed: the motor stays off",
                number, found
            );
        }
    }
}

/// The newest format of parameters that this firmware reads.
const FORMAT: u32 = stiction::parameters::FORMAT_VERSION;
