//! The parts of the board that a control tick needs, in one struct. The control task owns them, and
//! the link borrows them briefly.

use core::sync::atomic::{AtomicU32, Ordering};

use stiction::control::controller::EffortMode;
use stiction::control::current_loop::CurrentTarget;
use stiction::safety::deadline::Deadline;
#[cfg(feature = "two-encoders")]
use stiction::servo::EncoderReading;
use stiction::servo::{Input, Output, State};
use stiction::{Fault, Parameters, Servo};

#[cfg(feature = "two-encoders")]
use super::absolute_encoder::AbsoluteEncoder;
use super::brake_resistor::{BrakeResistorOutput, BrakeResistorSettings};
use super::bridge::{self, TimerBridge};
use super::converter::Converter;
use super::current_loop;
#[cfg(feature = "two-encoders")]
use super::encoder::LoadQuadrature;
use super::encoder::Quadrature;
use super::stopwatch::Stopwatch;
use super::tick::{Period, TickTimer};
use super::traits::{Bridge, EncoderInput, IndexInput};

/// What the hardware has turned the outputs off for; zero: nothing. The interrupts of the break
/// input and of the converter's watchdog set it, with [`BREAK`] or [`OVER_CURRENT`]. In the same
/// words are [`BRAKE_RESISTOR`] and [`INDEX`], so that a tick without any of them looks at one.
pub static TRIPPED: AtomicU32 = AtomicU32::new(0);

/// In [`TRIPPED`]: the bridge's driver or the emergency stop has pulled the break input, until its
/// fault is cleared and the input is released.
pub const BREAK: u32 = 1 << 31;

/// In [`TRIPPED`]: a reading of the motor's current, in the lower half, was beyond its limits. The
/// next control task clears it.
pub const OVER_CURRENT: u32 = 1 << 30;

/// In [`TRIPPED`]: there is a brake resistor, whose pulse each control task starts. It is constant
/// from one configuration to the next.
pub const BRAKE_RESISTOR: u32 = 1 << 29;

/// In [`TRIPPED`]: the encoder has an index, whose captures each control task reads. It is constant
/// from one configuration to the next.
pub const INDEX: u32 = 1 << 28;

/// Use of the motor's current.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurrentUse {
    /// There is no sensor.
    None,
    /// The effort is a voltage; the current is measured and limited.
    Sensed,
    /// The effort is a current.
    Regulated,
}

impl CurrentUse {
    /// Returns the use that validated parameters define.
    pub fn of(parameters: &Parameters) -> Self {
        match parameters.controller.effort {
            EffortMode::Current => Self::Regulated,
            EffortMode::Voltage if parameters.current.is_there() => Self::Sensed,
            EffortMode::Voltage => Self::None,
        }
    }
}

/// The servo and the parts of the chip that it works with.
pub struct ControlTask {
    /// The state machine and its controller.
    pub servo: &'static mut Servo,
    /// The deadline of the control task.
    pub deadline: Deadline,
    /// The counter of the encoder's edges: of two, that of the motor.
    pub encoder: Quadrature,
    /// The counter of the edges of the load's encoder.
    #[cfg(feature = "two-encoders")]
    pub load_encoder: LoadQuadrature,
    /// The absolute encoder on the load, if that is what the joint has.
    #[cfg(feature = "two-encoders")]
    pub absolute_encoder: AbsoluteEncoder,
    /// Reading of the motor's counter where the ticks were stopped.
    #[cfg(feature = "two-encoders")]
    pub paused_at: u32,
    /// The bridge: PWM, direction and enable.
    pub bridge: TimerBridge,
    /// The output of the brake resistor.
    pub brake_resistor: BrakeResistorOutput,
    /// The converter of supply voltage and motor current.
    pub converter: Converter,
    /// Whether the effort is a current, which the current loop makes.
    pub is_regulated: bool,
    /// The timer of the control tick.
    pub timer: TickTimer,
    /// The clock of the deadline.
    pub stopwatch: Stopwatch,
    /// The time from one tick to the next.
    pub period: Period,
}

impl ControlTask {
    /// Begins a tick, and latches a fault if it is late.
    #[inline]
    pub fn enter(&mut self) {
        let in_time = self.deadline.enter(self.stopwatch.now());
        // As early as can be: the frame with the angle takes its time.
        #[cfg(feature = "two-encoders")]
        if self.servo.has_absolute_load() {
            self.absolute_encoder.sample();
        }
        self.timer.acknowledge();
        if !in_time {
            self.servo.fault(Fault::Overrun);
        }
        if TRIPPED.load(Ordering::Relaxed) != 0 {
            self.brake();
        }
    }

    /// Latches faults, and starts the pulse of the brake resistor, if there is one, for the reading
    /// of the supply that this tick reads as well. Reads the capture of an index before the tick
    /// reads the counter.
    #[cold]
    #[inline(never)]
    fn brake(&mut self) {
        self.latch_break();
        self.brake_resistor.tick(self.converter.last_supply());
        if TRIPPED.load(Ordering::Relaxed) & INDEX != 0 {
            self.servo.pass_index(self.encoder.index());
        }
    }

    /// Latches the fault of outputs that the hardware has turned off: a break input that was
    /// pulled, or a current beyond its limits. A pulse may be over before the next tick, and a
    /// request of the link may come before that tick: the first of the two latches the fault.
    #[inline]
    pub fn latch_break(&mut self) {
        let tripped = TRIPPED.load(Ordering::Relaxed);
        if tripped != 0 {
            self.latch_trip(tripped);
        }
    }

    #[cold]
    #[inline(never)]
    fn latch_trip(&mut self, tripped: u32) {
        if tripped & BREAK != 0 {
            self.servo.break_input(self.encoder.lines());
        }
        if tripped & OVER_CURRENT != 0 {
            TRIPPED.fetch_and(BREAK | BRAKE_RESISTOR | INDEX, Ordering::Relaxed);
            // The interrupt has turned the outputs off; the bridge's own state is still on.
            self.bridge.rest();
            self.servo.over_current(tripped as u16);
        }
    }

    /// Runs one tick of the servo, from the encoder to the bridge.
    #[inline]
    pub fn tick(&mut self) -> Output {
        let (supply, current) = (self.converter.supply(), self.converter.current());
        #[cfg(feature = "two-encoders")]
        let is_absolute = self.servo.has_absolute_load();
        let (counter, lines) = (self.encoder.counter(), self.encoder.lines());
        #[cfg(feature = "two-encoders")]
        let load = if is_absolute {
            self.absolute_encoder.read()
        } else {
            EncoderReading {
                counter: self.load_encoder.counter(),
                lines: self.load_encoder.lines(),
                is_missing: false,
            }
        };
        let input = Input {
            counter,
            supply,
            lines,
            current,
            #[cfg(feature = "two-encoders")]
            load,
        };
        let output = self.servo.tick(input);
        self.encoder.pull(self.servo.pulls_down());
        #[cfg(feature = "two-encoders")]
        if is_absolute {
            self.absolute_encoder.select();
        } else {
            self.load_encoder.pull(self.servo.pulls_load_down());
        }
        if output.enable {
            let turns_on = if self.is_regulated {
                self.regulate(&output)
            } else {
                self.bridge.drive(output.duty(), output.tick.status)
            };
            if turns_on {
                self.guard();
            }
        } else if output.wakes {
            self.converter.release();
            self.bridge.wake(output.duty(), output.brake());
        } else {
            // Its interrupt must not set another duty behind this one.
            self.converter.release();
            self.bridge.off(output.duty());
        }
        #[cfg(feature = "two-encoders")]
        if is_absolute {
            self.absolute_encoder.request();
        }
        output
    }

    /// Hands a tick's effort to the current loop. Returns whether the bridge was off.
    #[inline(never)]
    fn regulate(&mut self, output: &Output) -> bool {
        if output.state != State::Armed {
            // A short brake: the watchdog over the current stays on. If the bridge was off, the
            // loop begins and ends in the next tick; its target is not that of a motion before.
            self.converter.end_loop();
            current_loop::aim(CurrentTarget::default());
            return self.bridge.drive(output.duty(), output.tick.status);
        }
        // The voltage of the motion before is none of this one.
        let is_on = self.bridge.is_on();
        let voltage = if is_on { current_loop::voltage() } else { 0 };
        current_loop::aim(self.servo.regulate(&output.tick, voltage));
        // Nor are the readings.
        if is_on && let Some(sums) = current_loop::sums() {
            self.servo.pulsed(&sums);
        }
        self.bridge.drive_regulated(output.tick.status)
    }

    /// Starts the watchdog over the motor's current, and the current loop. The bridge is on
    /// already: an interrupt before that would not have turned it off.
    #[cold]
    #[inline(never)]
    fn guard(&mut self) {
        if let Some(with) = self.servo.period_work() {
            current_loop::begin(with);
        }
        if let Some(window) = self.servo.current_window() {
            self.converter.guard(window, self.is_regulated);
        }
    }

    /// Ends a tick, and latches a fault if it took too long.
    #[inline]
    pub fn leave(&mut self) {
        if !self.deadline.leave(self.stopwatch.now()) {
            self.servo.fault(Fault::Overrun);
        }
    }

    /// Enables the break input again, once its fault has been cleared and the input has been
    /// released. An input that is still pulled trips at once.
    pub fn mend(&mut self) {
        let is_latched =
            matches!(self.servo.state(), State::Faulted(Fault::BreakInput | Fault::EmergencyStop));
        if TRIPPED.load(Ordering::Relaxed) & BREAK == 0 || is_latched {
            return;
        }
        if self.bridge.break_is_over() {
            // The hardware has turned the outputs off. Without a tick since then, the bridge's own
            // state is still on, and the bridge would not turn the outputs on for a servo that is
            // armed before the next tick.
            self.converter.release();
            self.bridge.rest();
            TRIPPED.fetch_and(!BREAK, Ordering::Relaxed);
            bridge::hear_break();
        } else {
            self.servo.break_input(self.encoder.lines());
        }
    }

    /// Sets another sample time, PWM and dead time, with the output off. The next tick comes a
    /// whole sample time from now.
    pub fn reconfigure(
        &mut self,
        bridge: &bridge::BridgeSettings,
        period: &Period,
        current: CurrentUse,
        brake_resistor: &BrakeResistorSettings,
    ) {
        self.converter.release();
        self.bridge.reconfigure(bridge);
        self.sense(current);
        self.set_brake_resistor(brake_resistor);
        self.period = *period;
        self.resume();
    }

    /// Starts or ends the conversions of the motor's current.
    pub fn sense(&mut self, current: CurrentUse) {
        self.is_regulated = current == CurrentUse::Regulated;
        self.converter.sense(current != CurrentUse::None);
    }

    /// Starts or ends the pulses of the brake resistor.
    pub fn set_brake_resistor(&mut self, settings: &BrakeResistorSettings) {
        self.brake_resistor.reconfigure(settings);
        TRIPPED.fetch_and(!BRAKE_RESISTOR, Ordering::Relaxed);
        TRIPPED
            .fetch_or(if settings.law.is_some() { BRAKE_RESISTOR } else { 0 }, Ordering::Relaxed);
    }

    /// Starts or ends the reading of the index's captures, as the servo's parameters say.
    pub fn watch_index(&mut self) {
        if self.servo.has_index() {
            TRIPPED.fetch_or(INDEX, Ordering::Relaxed);
        } else {
            TRIPPED.fetch_and(!INDEX, Ordering::Relaxed);
        }
    }

    /// Stops the ticks and turns the output off: a stop that was commanded since the last tick may
    /// not have reached the bridge yet.
    pub fn pause(&mut self) {
        self.converter.release();
        self.bridge.rest();
        self.timer.stop();
        #[cfg(feature = "two-encoders")]
        {
            self.paused_at = self.encoder.counter();
        }
    }

    /// Ends the reference if the load may have moved by more than its counter of 16 bits holds
    /// since the [pause](Self::pause).
    #[cfg(feature = "two-encoders")]
    pub fn check_pause(&mut self) {
        let travel = self.encoder.counter().wrapping_sub(self.paused_at) as i32;
        self.servo.check_pause(travel);
    }

    /// Restarts the ticks. The next one comes a whole sample time from now, and is never late.
    pub fn resume(&mut self) {
        // The supply may have changed meanwhile: the next tick reads a conversion from now.
        self.converter.supply();
        if self.is_regulated {
            // A sample time is a whole number of periods: each tick is at the lower end of the
            // count, half a period after a conversion of the current and before the next one.
            self.bridge.restart();
        }
        self.timer.set(&self.period);
        self.deadline = Deadline::new(self.period.clocks);
    }
}
