//! The wake-up of the bridge's driver: the enable pin goes high some time before the first duty.
//!
//! ```text
//!              fault or stop            armed
//!   enable     ________|_____________________|~~~~~~~~~~~~~~~~~~~~~~~~~~
//!                      |- reset_pulse_s or more -|- wake_up_s -|
//!   duty       ________|_____________________________________ first one ...
//! ```
//!
//! Both times are whole ticks, rounded up. The loop does not run meanwhile, so nothing winds up.
//! The loop begins where the joint rests: if the joint is turned meanwhile, the wake-up lasts until
//! the joint rests again. A silent link, and any condition that forbids arming, are faults
//! meanwhile.

use super::{BrakeCommand, Output, Servo};
use crate::control::signal::Tick;
use crate::parameters::Parameters;
use crate::safety::fault::LatchedFault;

/// The times of a driver, ticks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DriverTimes {
    wake_up: u32,
    reset_pulse: u32,
}

/// Progress of the wake-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct WakeUp {
    /// Ticks for which the enable pin has been low.
    low: u32,
    /// Ticks until the first duty.
    left: u32,
    /// Ticks with the enable pin high before the first duty.
    high: u32,
    /// Ticks before the first duty in which the holding brake opens.
    open: u32,
}

impl DriverTimes {
    pub fn of(parameters: &Parameters) -> Self {
        let device = &parameters.device;
        Self {
            wake_up: parameters.ticks_at_least(device.wake_up),
            reset_pulse: parameters.ticks_at_least(device.reset_pulse),
        }
    }
}

impl WakeUp {
    /// Counts a tick with the enable pin low, which ends a wake-up.
    pub const fn rest(&mut self) {
        self.low = self.low.saturating_add(1);
        self.left = 0;
    }

    /// Restarts the count of ticks with the enable pin low. A count is not valid after the sample
    /// time has changed. The pin is then low for a whole reset pulse again, longer than necessary.
    pub const fn forget(&mut self) {
        *self = Self { low: 0, left: 0, high: 0, open: 0 };
    }

    /// Begins a wake-up.
    pub const fn begin(&mut self, times: &DriverTimes) {
        let low = times.reset_pulse.saturating_sub(self.low);
        let left = low.saturating_add(times.wake_up);
        *self = Self { low: 0, left, high: times.wake_up, open: 0 };
    }

    /// Adds ticks in which the holding brake opens.
    pub const fn open_brake(&mut self, ticks: u32) {
        self.left = self.left.saturating_add(ticks);
        self.high = self.high.saturating_add(ticks);
        self.open = ticks;
    }

    /// Returns whether the holding brake opens in the next tick of the wake-up.
    const fn opens_brake(&self) -> bool {
        self.left <= self.open
    }

    /// Returns whether the wake-up is still going on.
    #[inline]
    pub const fn is_on(&self) -> bool {
        self.left > 0
    }

    /// Counts a tick of the wake-up, and returns whether the enable pin is high in it. The last
    /// tick is repeated until the joint is at rest. A joint that moves while its holding brake
    /// opens ends the wake-up: the motion has bounds, and the wake-up has none.
    pub const fn step(&mut self, at_rest: bool) -> bool {
        let high = self.left <= self.high;
        if self.opens_brake() && !at_rest {
            self.left = 0;
        } else if at_rest || self.left > 1 {
            self.left = self.left.saturating_sub(1);
        }
        high
    }
}

impl Servo {
    /// Runs a tick of the driver's wake-up.
    // Not in the tick, which it would make longer.
    #[inline(never)]
    pub(super) fn wake(&mut self, supply: u16) -> Output {
        let Some(control_loop) = &mut self.control_loop else { return self.off(Tick::default()) };
        let seen = &self.follower.seen;
        let trip = control_loop.monitors.waking(&mut control_loop.watch, seen, supply);
        if let Some(trip) = trip {
            self.latch(LatchedFault { fault: trip.fault, tick: self.clock, value: trip.value });
            return self.off(Tick::default());
        }
        // The joint may be turned meanwhile: the loop begins where it rests.
        control_loop.begin_at(seen.position);
        let at_rest = control_loop.monitors.is_at_rest(seen);
        // A joint without a brake is not held.
        let opens = self.wake_up.opens_brake() || !control_loop.holding_brake.has_brake();
        let brake = if opens { BrakeCommand::Open } else { BrakeCommand::Closed };
        let wakes = self.wake_up.step(at_rest);
        Output { wakes, ..self.off(Tick::default()) }.with_brake(brake)
    }
}
