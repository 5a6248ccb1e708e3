//! What the control task needs of a board, where embedded-hal 1.0 has no trait for it.

use stiction::drive::Duty;

/// A counter of encoder edges that runs by itself.
pub trait Encoder {
    /// What it reads now. Wraps.
    fn counter(&self) -> u32;
}

/// The bridge that drives the motor.
pub trait Bridge {
    /// Lets `duty` through, and turns the outputs on if they are off.
    fn drive(&mut self, duty: Duty);

    /// Turns the outputs off; `neutral` is what they begin with when they are turned on again.
    fn off(&mut self, neutral: Duty);
}

/// Resets the part unless it is fed in time.
pub trait Watchdog {
    /// The program is alive.
    fn feed(&mut self);
}
