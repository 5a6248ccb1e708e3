//! State of the moves for the gear, between the sequence of motions and their end.

use std::time::Duration;

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::identification::Summary;
use stiction::link::Sample;

use simulator::device::client::Map;
use studies::device_gear::GearRecorder;

/// Answer to a request while the gear is measured.
pub(super) const MEASURING: &str = "moves measure the gear, and other requests are refused \
                                    meanwhile; stop ends them";

/// Why a stop leaves the gear unknown.
pub(super) const STOPPED: &str = "its moves were ended by a stop";

/// A sequence whose moves for the gear are not over.
#[derive(Debug)]
pub struct PendingGear {
    pub(super) summary: Summary,
    pub(super) map: Map,
    pub(super) parameters: Parameters,
    /// Number of the page that started the identification.
    pub(super) page: u64,
    pub(super) recorder: GearRecorder,
    pub(super) is_armed: bool,
    /// Clock at the end of the sequence, ticks.
    pub(super) since: u32,
    /// Time until which the device must be armed.
    pub(super) until: Duration,
    /// Number of samples that had been lost before.
    pub(super) lost: u64,
}

impl PendingGear {
    /// Returns the signals of the moves as a mask, and the ticks from one sample to the next.
    pub(super) fn subscription(&self) -> (u64, u16) {
        self.recorder.subscription()
    }

    /// Returns the page that must command, if the moves have the motor driven.
    pub(super) fn page(&self) -> Option<u64> {
        self.is_armed.then_some(self.page)
    }

    /// Returns the number of moves that have started and of all moves, for the pages.
    pub(super) fn progress(&self) -> Value {
        let [made, moves] = self.recorder.progress();
        json!({ "made": made, "moves": moves })
    }

    /// Stores a sample of the moves.
    pub(super) fn see(&mut self, sample: &Sample) {
        self.recorder.see(sample.clone());
    }
}

/// Returns the time from the end of a sequence, `since`, to a clock, s. It is zero for a clock
/// before that end: the end is read after the status that shows that the output is off.
pub(super) fn waited_s(since: u32, clock: u32, sample_time: f32) -> f64 {
    f64::from((clock.wrapping_sub(since) as i32).max(0)) * f64::from(sample_time)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wait_for_rest_is_not_over_at_a_clock_before_the_end_of_the_sequence() {
        assert_eq!(waited_s(1000, 997, 0.5), 0.0);
        assert_eq!(waited_s(1000, 1000, 0.5), 0.0);
        assert_eq!(waited_s(1000, 1003, 0.5), 1.5);
        // The clock of 32 bits wraps.
        assert_eq!(waited_s(u32::MAX, 1, 0.5), 1.0);
        assert_eq!(waited_s(1, u32::MAX, 0.5), 0.0);
    }
}
