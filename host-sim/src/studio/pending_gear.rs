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
