//! What a tick needs of the board, in one piece: the control task owns it, and the link borrows it
//! for an instant.

use core::sync::atomic::{AtomicBool, Ordering};

use stiction::deadline::Deadline;
use stiction::servo::{Input, Output, State};
use stiction::{Fault, Servo};

use super::bridge::{self, TimerBridge};
use super::encoder::Quadrature;
use super::stopwatch::Stopwatch;
use super::supply::Supply;
use super::tick::{Period, TickTimer};
use super::traits::{Bridge, Encoder};

/// The bridge's driver pulled the break input: set by its interrupt, ended by
/// [`ControlTask::mend`].
pub static TRIPPED: AtomicBool = AtomicBool::new(false);

/// The servo and the parts of the chip that it works with.
pub struct ControlTask {
    /// The state machine and its controller.
    pub servo: &'static mut Servo,
    /// Times the control task.
    pub deadline: Deadline,
    /// The counter of edges.
    pub encoder: Quadrature,
    /// PWM and enable.
    pub bridge: TimerBridge,
    /// Supply voltage.
    pub supply: Supply,
    /// The control tick.
    pub timer: TickTimer,
    /// The deadline's clock.
    pub stopwatch: Stopwatch,
    /// From one tick to the next.
    pub period: Period,
}

impl ControlTask {
    /// A tick begins.
    #[inline]
    pub fn enter(&mut self) {
        let in_time = self.deadline.enter(self.stopwatch.now());
        self.timer.acknowledge();
        if !in_time {
            self.servo.fault(Fault::Overrun);
        }
        self.latch_break();
    }

    /// A pulse may be over before the next tick, and a request may come before it: whoever is first
    /// latches the fault.
    // Once in the image, not in everything that the link may ask of the servo.
    #[inline(never)]
    pub fn latch_break(&mut self) {
        if TRIPPED.load(Ordering::Relaxed) {
            self.servo.fault(Fault::BreakInput);
        }
    }

    /// From the encoder to the bridge.
    #[inline]
    pub fn tick(&mut self) -> Output {
        let input = Input { counter: self.encoder.counter(), supply: self.supply.read() };
        let output = self.servo.tick(input);
        if output.enable {
            self.bridge.drive(output.duty());
        } else {
            self.bridge.off(output.duty());
        }
        output
    }

    /// It ends.
    #[inline]
    pub fn leave(&mut self) {
        if !self.deadline.leave(self.stopwatch.now()) {
            self.servo.fault(Fault::Overrun);
        }
    }

    /// Lets the break input trip again, once its fault has been cleared and the input has been let
    /// go. One that is still pulled trips at once.
    pub fn mend(&mut self) {
        if !TRIPPED.load(Ordering::Relaxed) || self.servo.state() == State::Faulted(Fault::BreakInput) {
            return;
        }
        if self.bridge.break_is_over() {
            // The hardware has turned the outputs off, of which the bridge knows nothing if there
            // was no tick since: it would not turn them on again for one that is armed before the
            // next.
            self.bridge.rest();
            TRIPPED.store(false, Ordering::Relaxed);
            bridge::hear_break();
        } else {
            self.servo.fault(Fault::BreakInput);
        }
    }

    /// Another sample time, PWM and dead time; the output is off. The next tick comes a whole
    /// sample time from now.
    pub fn reconfigure(&mut self, bridge: &bridge::Settings, period: &Period) {
        self.bridge.reconfigure(bridge);
        self.period = *period;
        self.resume();
    }

    /// No more ticks, and the output off: a stop that was told since the last tick may not have
    /// reached the bridge yet.
    pub fn pause(&mut self) {
        self.bridge.rest();
        self.timer.stop();
    }

    /// Ticks again; the next one comes a whole sample time from now, and has nothing to be late
    /// for.
    pub fn resume(&mut self) {
        self.timer.set(&self.period);
        self.deadline = Deadline::new(self.period.clocks);
    }
}
