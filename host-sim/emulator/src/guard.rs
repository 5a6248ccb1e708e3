//! Ends the run of a firmware that hangs.
//!
//! Virtual time always advances, so a limit in virtual time is always reached. But an endless loop
//! around one register costs half a minute of wall time per virtual second; it is detected by its
//! accesses.

use rigless::emulator::{Access, AccessKind};
use rigless::time::VirtualNanos;

use super::image::FirmwareImage;

/// Longest time from power-on to the first tick with the bridge on, ns.
const BOOT_LIMIT_NS: u64 = 3_000_000_000;
/// Number of reads that counts as a hang. They take some 0.5 s of virtual time: longer than any
/// wait that has its own limit.
const POLLING_LIMIT: u32 = 16_000_000;

/// Detector of a firmware that polls one register.
///
/// The register that is polled is found by a majority vote (Boyer and Moore 1981): one that is read
/// more often than everything else happens together wins, however often a control task interrupts
/// the loop around it. A processor that sleeps between its tasks has no such register.
#[derive(Clone, Copy, Debug, Default)]
pub struct Guard {
    /// Address of a register, and of the instruction that reads it.
    candidate: Option<(u64, Option<u64>)>,
    votes: u32,
    /// Polled register, and address of the instruction that reads it.
    polled: Option<(u64, Option<u64>)>,
}

impl Guard {
    /// Records one access.
    pub fn see(&mut self, access: &Access) {
        let this = Some((access.address, access.program_counter));
        let is_read = access.kind == AccessKind::Read;
        if is_read && this == self.candidate {
            self.votes += 1;
            if self.votes >= POLLING_LIMIT {
                self.polled = this;
            }
        } else if self.votes > 0 {
            self.votes -= 1;
        } else if is_read {
            self.candidate = this;
        }
    }

    /// Returns the error message if the same register has been read for too long.
    pub fn polling(&self, image: &FirmwareImage) -> Option<String> {
        let (register, code) = self.polled?;
        let place = code.map_or_else(String::new, |code| {
            let function =
                image.function_at(code).map(|name| format!(" ({name})")).unwrap_or_default();
            format!(" by the instruction at {code:#010x}{function}")
        });
        let count = POLLING_LIMIT / 1_000_000;
        Some(format!(
            "it is stuck: the register at {register:#010x} is read{place} {count} million times, \
             and \
             little else happens"
        ))
    }

    /// Returns the time by which the bridge must be on.
    pub const fn boot_limit() -> VirtualNanos {
        VirtualNanos(BOOT_LIMIT_NS)
    }

    /// Returns the error message if the bridge is not on by then.
    pub fn not_armed() -> String {
        let limit_s = BOOT_LIMIT_NS as f64 * 1e-9;
        format!("it has not turned its bridge on within {limit_s} s of virtual time")
    }
}
