//! A holding brake on the joint of a simulated device: friction that follows its command late.

use stiction::servo::BrakeCommand;

/// A brake that is closed without power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldingBrake {
    /// Friction of the closed brake, V.
    pub holding_v: f64,
    /// Time from the command to an open brake, s.
    pub open_s: f64,
    /// Time from the command to a closed brake, s.
    pub close_s: f64,
    is_open: bool,
    command: BrakeCommand,
    /// Time since the last change of the command, s.
    since_s: f64,
}

impl HoldingBrake {
    /// Creates a closed brake.
    pub const fn closed(holding_v: f64, [open_s, close_s]: [f64; 2]) -> Self {
        let command = BrakeCommand::Closed;
        Self { holding_v, open_s, close_s, is_open: false, command, since_s: 0.0 }
    }

    /// Returns whether the brake is open.
    pub const fn is_open(&self) -> bool {
        self.is_open
    }

    /// Applies a command for a tick, s, and returns the friction in that tick, V.
    pub fn update(&mut self, command: BrakeCommand, tick_s: f64) -> f64 {
        if command != self.command {
            (self.command, self.since_s) = (command, 0.0);
        }
        let (opens, time_s) = match command {
            BrakeCommand::Open => (true, self.open_s),
            BrakeCommand::Closed => (false, self.close_s),
        };
        // Sums of ticks are not exact.
        if self.since_s > time_s - 0.01 * tick_s {
            self.is_open = opens;
        }
        self.since_s += tick_s;
        if self.is_open { 0.0 } else { self.holding_v }
    }
}
