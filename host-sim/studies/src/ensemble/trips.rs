//! False trips of an ensemble by name: which monitor tripped on which joint, in which motion.
//!
//! No drawn joint is defective, so every trip is false. The seed and the number of the joint
//! reproduce it: `stiction ensemble --seed S --case K --plot DIR`.

use std::fmt;

use stiction::safety::fault::Fault;

use super::case_result::CaseResult;
use super::motions::Approach;

/// Motion that a fault ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndedMotion {
    /// The move to the target.
    Positioning(Approach),
    /// The trajectory.
    Trajectory,
    /// A move of the row, from 1.
    Move(u32),
}

impl EndedMotion {
    /// Returns the name of the motion in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Positioning(approach) => approach.name(),
            Self::Trajectory => "trajectory",
            Self::Move(_) => "move",
        }
    }
}

/// False trip of a monitor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FalseTrip {
    /// Number of the joint.
    pub case: u64,
    /// Motion that the trip ended.
    pub ended: EndedMotion,
    /// Description of the fault.
    pub fault: String,
    /// Code of the fault; `None` if this program has no fault of this description.
    pub code: Option<u8>,
}

/// Lists the false trips in the result of a law on a joint. `approach`: how the set point went to
/// the target.
pub fn of(row: &CaseResult, approach: Approach) -> impl Iterator<Item = FalseTrip> {
    let in_move = row.fault_in_move.unwrap_or(0);
    let motions = [
        (EndedMotion::Positioning(approach), &row.step_fault),
        (EndedMotion::Trajectory, &row.tracking_fault),
        (EndedMotion::Move(in_move), &row.moves_fault),
    ];
    motions.into_iter().filter_map(|(ended, fault)| {
        let fault = fault.clone()?;
        let code = Fault::ALL.iter().find(|one| one.describe() == fault).map(|one| *one as u8);
        Some(FalseTrip { case: row.case, ended, fault, code })
    })
}

impl fmt::Display for FalseTrip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.fault)?;
        if let Some(code) = self.code {
            write!(f, " ({code})")?;
        }
        write!(f, " in joint {}, {}", self.case, self.ended.name())?;
        match self.ended {
            EndedMotion::Move(number) => write!(f, " {number}"),
            EndedMotion::Positioning(_) | EndedMotion::Trajectory => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_trip_has_its_fault_its_code_its_joint_and_its_motion() {
        let row = CaseResult {
            case: 17,
            step_fault: Some(Fault::Stall.describe().into()),
            moves_fault: Some(Fault::FollowingError.describe().into()),
            fault_in_move: Some(3),
            ..CaseResult::default()
        };
        let said: Vec<String> = of(&row, Approach::Step).map(|trip| trip.to_string()).collect();
        let expected = [
            "stall: effort, but no count (14) in joint 17, step",
            "following error (16) in joint 17, move 3",
        ];
        assert_eq!(said, expected);
        assert_eq!(of(&CaseResult::default(), Approach::Step).count(), 0);
        let foreign =
            CaseResult { tracking_fault: Some("a new one".into()), ..CaseResult::default() };
        assert_eq!(
            of(&foreign, Approach::Step).next().unwrap().to_string(),
            "a new one in joint 0, trajectory"
        );
    }
}
