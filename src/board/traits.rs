//! The traits of the board's parts that the control task needs and for which embedded-hal 1.0 has
//! none.

use stiction::control::drive::Duty;
use stiction::servo::BrakeCommand;

/// Counter of encoder edges that runs in hardware.
pub trait EncoderInput {
    /// Returns the counter's present reading, which wraps at 2^32.
    fn counter(&mut self) -> u32;

    /// Returns the two lines as they are now, and the inputs of emergency stop and homing switch if
    /// they are in their port ([`Input::lines`](stiction::servo::Input::lines)).
    fn lines(&self) -> u8;

    /// Sets whether the resistors of the lines pull down or up.
    fn pull(&mut self, down: bool);
}

/// The index of an encoder, which captures its counter.
pub trait IndexInput {
    /// The pin of the index.
    type Pin;

    /// Starts the capture of the counter by the rising edge of the index.
    fn capture_index(&self, pin: &Self::Pin);

    /// Returns the counter that the index has captured since the last call, if it has. Of two
    /// passes, that is the second one.
    fn index(&self) -> Option<u32>;
}

/// The bridge that drives the motor.
pub trait Bridge {
    /// Applies `duty`, turns the outputs on if they are off, and opens or closes the holding brake
    /// by the `status` of a tick ([`HELD`](stiction::Tick::HELD)). Returns whether the outputs were
    /// off.
    fn drive(&mut self, duty: Duty, status: u32) -> bool;

    /// Enables the bridge's driver with the outputs off, for a tick in which it wakes up.
    fn wake(&mut self, neutral: Duty, brake: BrakeCommand);

    /// Turns the outputs off, and closes the holding brake. The outputs begin with `neutral` when
    /// they are turned on again.
    fn off(&mut self, neutral: Duty);
}

/// A watchdog, which resets the microcontroller unless it is fed in time.
pub trait Watchdog {
    /// Feeds the watchdog: the program is alive.
    fn feed(&mut self);
}
