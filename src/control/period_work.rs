//! Work of the board in each period of the PWM, after the conversion of the current.

use crate::control::current_loop::{CurrentLoop, CurrentLoopState, CurrentTarget};
use crate::control::drive::Duty;
use crate::control::winding_pulses::{GroupSums, PulseState, WindingPulses};

/// Work of a motion in each period of the PWM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PeriodWork {
    /// The current is regulated.
    Regulate(CurrentLoop),
    /// Pulses show the winding.
    Pulse(WindingPulses),
}

/// State of that work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodState {
    /// That of a current loop.
    pub regulated: CurrentLoopState,
    /// That of pulses.
    pub pulsed: PulseState,
}

impl PeriodState {
    /// State before the first period.
    pub const NONE: Self = Self { regulated: CurrentLoopState::NONE, pulsed: PulseState::NONE };

    /// Begins anew.
    #[inline]
    pub const fn restart(&mut self) {
        self.regulated = CurrentLoopState::NONE;
        self.pulsed.restart();
    }
}

impl PeriodWork {
    /// Runs one period: returns the code of the voltage for a target and a reading of the current.
    #[inline]
    pub fn step(&self, state: &mut PeriodState, target: CurrentTarget, reading: u16) -> i16 {
        match self {
            Self::Regulate(of) => of.step(&mut state.regulated, target, reading),
            Self::Pulse(pulses) => pulses.step(&mut state.pulsed, reading),
        }
    }

    /// Returns the PWM setting of a code.
    #[inline]
    pub fn duty(&self, code: i16) -> Duty {
        match self {
            Self::Regulate(of) => of.duty(code),
            Self::Pulse(pulses) => pulses.duty(code),
        }
    }

    /// Returns the compare value of full duty.
    pub const fn top(&self) -> u16 {
        match self {
            Self::Regulate(of) => of.top(),
            Self::Pulse(pulses) => pulses.top(),
        }
    }

    /// Returns the readings of pulses that are over.
    #[inline]
    pub fn sums<'a>(&self, state: &'a PeriodState) -> Option<&'a GroupSums> {
        match self {
            Self::Regulate(_) => None,
            Self::Pulse(pulses) => pulses.sums(&state.pulsed),
        }
    }
}
