//! The input of a tick of the servo, and its output for the board.

use super::{Servo, State};
use crate::control::drive::Duty;
use crate::control::signal::Tick;

/// Readings of the board for one tick of the servo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Input {
    /// The reading of the encoder's counter. Of two encoders, it is the motor's.
    pub counter: u32,
    /// The converter's reading of the supply: for the supply's monitor, and for an output that is
    /// scaled by the supply.
    pub supply: u16,
    /// Present levels of the encoder's lines (bit 0: A, bit 1: B), for the test for open lines. A
    /// board that cannot read them leaves this at zero, which the test accepts as driven lines.
    /// With [`CONTACT`](Self::CONTACT), the level of the emergency stop's input, and with
    /// [`SWITCH`](Self::SWITCH) that of the homing switch.
    pub lines: u8,
    /// The converter's reading of the motor's current; without effect unless the parameters have a
    /// sensor of it.
    pub current: u16,
    /// The load's encoder, if the joint has two. It is not read otherwise.
    #[cfg(feature = "two-encoders")]
    pub load: EncoderReading,
}

impl Input {
    /// Bit of [`lines`](Self::lines): the contact of the emergency stop is closed. Without effect
    /// unless the parameters have such a contact. The board reads it together with the encoder's
    /// lines: it is the number of the pin in their port.
    pub const CONTACT: u8 = 1 << 6;

    /// Bit of [`lines`](Self::lines): the input of the homing switch is high, which its contact
    /// pulls to ground. Without effect unless a homing looks for the switch.
    pub const SWITCH: u8 = 1 << 7;
}

/// Reading of a second encoder.
#[cfg(feature = "two-encoders")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderReading {
    /// The reading of the counter. That of an absolute encoder has the angle in its low bits, and
    /// counts on from there.
    pub counter: u32,
    /// Present levels of the lines (bit 0: A, bit 1: B), as in [`Input::lines`]. Zero for an
    /// encoder on a bus.
    pub lines: u8,
    /// Whether the encoder gave no valid answer in this tick; `counter` is then not read.
    pub is_missing: bool,
}

/// Output of one tick of the servo, for the board. A host reads its first field, the tick, from the
/// memory of a running image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Output {
    /// Every signal of the tick; code and duty are those that are applied. Without a motion only
    /// duty and status are set, except in the tick that ends a ramp or in which a fault trips.
    pub tick: Tick,
    /// Whether the bridge may be on. If not, the duty is neutral. With a latched fault it is a
    /// short brake, whose duty is neutral as well.
    pub enable: bool,
    /// Whether the bridge's driver is enabled without a duty, so that it wakes up.
    pub wakes: bool,
    /// The servo's state after this tick.
    pub state: State,
    /// Whether the compensator holds effort at standstill.
    pub wound_up: bool,
    /// Ticks since power-on, this one included.
    pub clock: u32,
}

/// Command for a holding brake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BrakeCommand {
    /// The brake closes, or is closed.
    Closed,
    /// The brake opens, or is open.
    Open,
}

impl Output {
    /// Returns the PWM setting for the timer.
    pub const fn duty(&self) -> Duty {
        self.tick.duty()
    }

    /// Returns the command for a holding brake, if there is one.
    pub const fn brake(&self) -> BrakeCommand {
        let is_on = self.enable || self.wakes;
        if is_on && self.tick.status & Tick::HELD == 0 {
            BrakeCommand::Open
        } else {
            BrakeCommand::Closed
        }
    }

    /// Returns this output with a command for the holding brake.
    pub(super) const fn with_brake(mut self, brake: BrakeCommand) -> Self {
        if matches!(brake, BrakeCommand::Closed) {
            self.tick.status |= Tick::HELD;
        }
        self
    }
}

impl Servo {
    pub(super) fn neutral(&self) -> Duty {
        self.control_loop
            .as_ref()
            .map_or(Duty::default(), |running| running.controller.drive().duty(0))
    }

    /// Returns the output of a tick with the bridge off: no effort, and a neutral duty.
    pub(super) fn off(&self, tick: Tick) -> Output {
        let Duty { compare, reverse } = self.neutral();
        self.output(Tick { v_applied: 0.0, code: 0, compare, reverse, ..tick }, false, false)
    }

    #[inline]
    pub(super) fn output(&self, mut tick: Tick, enable: bool, wound_up: bool) -> Output {
        let (state, clock) = (self.state, self.clock);
        let gave_up = if enable && self.has_given_up() { Tick::GAVE_UP } else { 0 };
        tick.status = status(state, enable, tick.saturated, wound_up) | gave_up;
        Output { enable, wakes: false, state, tick, clock, wound_up }
    }
}

/// Returns the bits of [`Tick::status`].
#[inline]
fn status(state: State, enable: bool, saturated: bool, wound_up: bool) -> u32 {
    let (state, fault) = match state {
        State::Boot => (0, 0),
        State::Stopped => (1, 0),
        State::Armed => (2, 0),
        State::Faulted(fault) => (3, fault as u32),
    };
    let bit = |set: bool, place: u32| u32::from(set) << place;
    state | fault << 8 | bit(saturated, 16) | bit(wound_up, 17) | bit(enable, 18)
}
