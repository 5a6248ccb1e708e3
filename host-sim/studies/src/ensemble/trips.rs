//! False trips of an ensemble by name: which monitor tripped on which joint, in which motion.
//!
//! Nothing is wrong with a drawn joint, so that every trip is false. The number of the joint and
//! the seed draw it again: `stiction ensemble --seed S --case K --plot DIR`.

use std::fmt;

use stiction::safety::fault::Fault;

use super::case::Row;

/// Motion that a fault ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The step.
    Step,
    /// The trajectory.
    Trajectory,
    /// A move of the row, from 1.
    Move(u32),
}

impl Ended {
    /// Returns the name of the motion in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Trajectory => "trajectory",
            Self::Move(_) => "move",
        }
    }
}

/// False trip of a monitor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trip {
    /// Number of the joint.
    pub case: u64,
    /// Motion that it ended.
    pub ended: Ended,
    /// Words of the fault.
    pub fault: String,
    /// Code of the fault; none if this program has no fault of these words.
    pub code: Option<u8>,
}

/// Lists the trips of a row.
pub fn of(row: &Row) -> impl Iterator<Item = Trip> {
    let in_move = row.fault_in_move.unwrap_or(0);
    let motions = [
        (Ended::Step, &row.step_fault),
        (Ended::Trajectory, &row.tracking_fault),
        (Ended::Move(in_move), &row.moves_fault),
    ];
    motions.into_iter().filter_map(|(ended, fault)| {
        let fault = fault.clone()?;
        let code = Fault::ALL.iter().find(|one| one.describe() == fault).map(|one| *one as u8);
        Some(Trip { case: row.case, ended, fault, code })
    })
}

impl fmt::Display for Trip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.fault)?;
        if let Some(code) = self.code {
            write!(f, " ({code})")?;
        }
        write!(f, " in joint {}, {}", self.case, self.ended.name())?;
        match self.ended {
            Ended::Move(number) => write!(f, " {number}"),
            Ended::Step | Ended::Trajectory => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_trip_has_its_fault_its_code_its_joint_and_its_motion() {
        let row = Row {
            case: 17,
            step_fault: Some(Fault::Stall.describe().into()),
            moves_fault: Some(Fault::FollowingError.describe().into()),
            fault_in_move: Some(3),
            ..Row::default()
        };
        let said: Vec<String> = of(&row).map(|trip| trip.to_string()).collect();
        let expected = [
            "stall: effort, but no count (14) in joint 17, step",
            "following error (16) in joint 17, move 3",
        ];
        assert_eq!(said, expected);
        assert_eq!(of(&Row::default()).count(), 0);
        let foreign = Row { tracking_fault: Some("a new one".into()), ..Row::default() };
        assert_eq!(of(&foreign).next().unwrap().to_string(), "a new one in joint 0, trajectory");
    }
}
