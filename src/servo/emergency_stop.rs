//! The emergency stop: the contact acts in hardware, and the servo reports it.
//!
//! ```text
//!   contact   closed ~~~~|________________________|~~~~~~~~~~~~~~~~~~~
//!   bridge    on ~~~~~~~~|____ off: the break input and the enable pin
//!   fault                |32 emergency stop ---------------|clear
//! ```
//!
//! The contact is normally closed and lifts its input. An open contact, a cut wire and a lost
//! supply of the contact read alike: as a stop. The hardware turns the bridge off without the
//! program (docs/reference/wiring.md). Each tick reads the input, and an open contact latches
//! [`Fault::EmergencyStop`] in whatever state the servo is. Until the contact is closed, no command
//! clears the fault. If another fault is latched when the contact opens, the
//! emergency stop follows once that one is cleared or new parameters have ended it, also if the
//! contact is closed by then.
//!
//! The contact pulls the break input as the bridge's driver does, and its input at the port is
//! filtered. So the fault of a break input that is latched before the open contact is read becomes
//! that of the emergency stop, within 50 ms.
//!
//! Does badly: a contact that a short bridges is not detected. One input is no redundant channel. A
//! reset forgets a stop behind another fault.

use super::{Refusal, Servo, State};
use crate::safety::fault::{Fault, LatchedFault};

/// Time within which a break input that was pulled turns out to be the contact's, s: its input is
/// filtered, and the contact bounces.
const BOUNCE: f32 = 0.05;

impl Servo {
    /// Latches the fault of a break input that was pulled: that of the emergency stop if `lines`
    /// ([`Input::lines`](super::Input::lines)) show an open contact, otherwise that of the bridge's
    /// driver.
    pub fn break_input(&mut self, lines: u8) {
        let contact = self.control_loop.as_ref().map_or(0, |control_loop| control_loop.contact);
        let is_open = contact & !lines != 0;
        self.fault(if is_open { Fault::EmergencyStop } else { Fault::BreakInput });
    }

    /// Latches the emergency stop, in the place of a break input that has just been latched.
    pub(super) fn latch_emergency_stop(&mut self) {
        let tick = self.control_loop.as_ref().map_or(1.0, |control_loop| control_loop.brakes.tick);
        let bounce = libm::ceilf(BOUNCE / tick) as u32;
        if let Some(LatchedFault { fault: Fault::BreakInput, tick, .. }) = self.latched
            && self.clock.wrapping_sub(tick) <= bounce
        {
            self.state = State::Stopped;
        }
        self.fault(Fault::EmergencyStop);
    }

    /// Refuses while the contact of the emergency stop is open.
    pub(super) const fn check_contact(&self) -> Result<(), Refusal> {
        if self.is_contact_open {
            return Err(Refusal::WouldTrip(Fault::EmergencyStop));
        }
        Ok(())
    }
}
