//! The faults of a servo: the first one is latched until a command clears it.

use super::{Input, Refusal, Servo, State};
use crate::safety::fault::{Fault, FaultLog, LatchedFault, Reaction};

impl Servo {
    /// Returns the fault that is latched, if there is one.
    pub const fn latched(&self) -> Option<LatchedFault> {
        self.latched
    }

    /// Returns the log of the last faults.
    pub const fn log(&self) -> &FaultLog {
        &self.log
    }

    /// Latches a fault that has no value; see [`latch`](Self::latch).
    pub fn fault(&mut self, fault: Fault) {
        self.latch(LatchedFault { tick: self.clock, ..LatchedFault::from(fault) });
    }

    /// Latches a fault, unless one is latched already. The next tick's output is off, or that of a
    /// short brake, and the loop forgets its state. A fault without a short brake ends that of the
    /// fault before. An emergency stop behind another fault is latched once that one is cleared.
    pub fn latch(&mut self, latched: LatchedFault) {
        if let State::Faulted(before) = self.state {
            if latched.fault.reaction() == Reaction::Off {
                self.end_transition();
            }
            self.is_stop_behind |=
                latched.fault == Fault::EmergencyStop && before != Fault::EmergencyStop;
            return;
        }
        let short_brake = self.short_brake_of(latched.fault);
        self.state = State::Faulted(latched.fault);
        self.latched = Some(latched);
        self.log.push(latched);
        self.countdown = None;
        self.fail_transition();
        self.begin_short_brake(short_brake);
        self.encoder_proof = self.encoder_proof.after(latched.fault);
        if latched.fault.doubts_encoder() {
            self.lose_reference();
        }
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.rest();
        }
    }

    /// Latches the fault of open lines of the encoder (1: A, 2: B, 3: both). With two encoders,
    /// these are the motor's, and those of the load's are 4 and 8. An open contact of the emergency
    /// stop comes first.
    #[cold]
    #[inline(never)]
    pub(super) fn latch_open(&mut self, lines: u8) {
        if lines & Input::CONTACT != 0 {
            self.latch_emergency_stop();
            return;
        }
        let value = f32::from(lines);
        self.latch(LatchedFault { fault: Fault::EncoderOpen, tick: self.clock, value });
    }

    /// Clears the latched fault, which leaves the servo stopped, or with the fault of an emergency
    /// stop that came meanwhile. Without a fault, nothing happens.
    ///
    /// # Errors
    /// Refuses if only valid parameters or a reset end the fault, and an emergency stop whose
    /// contact is open.
    pub fn clear(&mut self) -> Result<(), Refusal> {
        let State::Faulted(fault) = self.state else { return Ok(()) };
        if !fault.is_clearable() || self.control_loop.is_none() {
            return Err(Refusal::NotClearable(fault));
        }
        if fault == Fault::EmergencyStop {
            self.check_contact()?;
        }
        self.has_failed_test = false;
        self.end_transition();
        self.retest_lines();
        self.end_fault();
        Ok(())
    }

    /// Ends the latched fault. The servo is stopped, or has the fault of an emergency stop that
    /// came meanwhile.
    pub(super) fn end_fault(&mut self) {
        self.state = State::Stopped;
        self.latched = None;
        if core::mem::take(&mut self.is_stop_behind) {
            self.fault(Fault::EmergencyStop);
        }
    }
}
