//! The sequence of motions of an identification, which the moves for the gear follow.

use stiction::Parameters;
use stiction::identification::{IdentificationRequest, Outcome};

use super::moves::{GearBounds, GearMove, moves};

/// Default travel, deg.
const TRAVEL_DEG: f32 = 45.0;

/// Why the gear is not measured within some bounds.
const NO_BOUND: &str = "its moves are made with the loop closed, and --effort and --time bound the \
                        sequence of motions alone; identify again without them (--travel and \
                        --speed bound both)";

/// Sequence of motions that was started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrecedingSequence {
    /// Bounds that the client has set, and the travel that fits between the limits of the position.
    pub bounds: IdentificationRequest,
    /// Position of the joint at its start, counts.
    pub begin: i32,
}

impl PrecedingSequence {
    /// Returns the moves that show the gear after this sequence has ended at a position (counts).
    /// `None` for a device with one encoder. An error is half a sentence: why there are no moves.
    pub fn moves(
        &self,
        outcome: Outcome,
        end: i32,
        parameters: &Parameters,
    ) -> Option<Result<Vec<GearMove>, String>> {
        parameters.controller.motor.count()?;
        let IdentificationRequest { effort, travel, speed, time } = self.bounds;
        if !shows_gear(outcome) {
            return Some(Err("the sequence of motions ended before".into()));
        }
        if effort.is_some() || time.is_some() {
            return Some(Err(NO_BOUND.into()));
        }
        let off = end.wrapping_sub(self.begin).unsigned_abs();
        let off_deg = off as f32 * parameters.controller.encoder.resolution;
        let room_deg = f64::from(travel.unwrap_or(TRAVEL_DEG) - off_deg);
        let bounds = GearBounds { room_deg, speed: speed.unwrap_or(f32::INFINITY) };
        Some(moves(parameters, bounds))
    }
}

/// Returns whether the moves follow a sequence with this outcome: the direction of the effort is
/// right, the joint moves, no load moves it, and there is room left.
const fn shows_gear(outcome: Outcome) -> bool {
    match outcome {
        Outcome::Done | Outcome::Speed | Outcome::Time | Outcome::Capped => true,
        Outcome::Running
        | Outcome::Travel
        | Outcome::Reversed
        | Outcome::Pulled
        | Outcome::Still
        | Outcome::RunsOn
        | Outcome::NoProgress => false,
    }
}
