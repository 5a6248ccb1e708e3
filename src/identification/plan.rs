//! The steps of an identification, in their order.

/// Number of places at which the breakaway is found.
pub const PLACES: usize = 5;
/// Number of speeds of the map.
pub const SPEEDS: usize = 6;

/// Ratio of each speed of the map to the next faster one: six speeds span a factor of 54.
const PER_SPEED: f32 = 0.45;

/// A step of the sequence. Each begins and ends with the joint at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// A first ramp of the effort from zero, to a rough breakaway effort.
    Try { reverse: bool },
    /// A pulse, the stronger or the weaker one.
    Pulse { strong: bool, reverse: bool },
    /// A stretch at a constant speed; 0 is the fastest.
    Leg { speed: usize, reverse: bool },
    /// A stretch at a speed that swings.
    Swing { reverse: bool },
    /// A motion to a place.
    Go { place: usize },
    /// The return to the start of the sequence, in which a broken encoder shows no progress.
    Return,
    /// A ramp of the effort to the breakaway at a place.
    Push { place: usize, reverse: bool, slow: bool },
}

/// Number of steps before the map, of the swings, and of a place.
const BEFORE: usize = 6;
const SWINGS: usize = 4;
const OF_PLACE: usize = 5;

/// Number of the step after the legs: the first swing.
pub(super) const FIRST_SWING: u8 = (BEFORE + 2 * SPEEDS) as u8;

impl Task {
    /// Returns the task of a step; none after the last one.
    pub fn of(step: usize) -> Option<Self> {
        let reverse = step % 2 == 1;
        let Some(leg) = step.checked_sub(BEFORE) else {
            return Some(match step {
                0 | 1 => Self::Try { reverse },
                _ => Self::Pulse { strong: step >= 4, reverse },
            });
        };
        let Some(swing) = leg.checked_sub(2 * SPEEDS) else {
            return Some(Self::Leg { speed: leg / 2, reverse });
        };
        let Some(rest) = swing.checked_sub(SWINGS) else {
            return Some(Self::Swing { reverse });
        };
        let (place, part) = (rest / OF_PLACE, rest % OF_PLACE);
        match part {
            0 if place == PLACES => Some(Self::Return),
            _ if place >= PLACES => None,
            0 => Some(Self::Go { place }),
            // The fast one comes after a reversal, the slow one in the same sense as before.
            _ => Some(Self::Push { place, reverse: part > 2, slow: part % 2 == 0 }),
        }
    }
}

/// Returns the speed of a leg as a share of the fastest one.
pub(super) fn share(speed: usize) -> f32 {
    (0..speed).fold(1.0, |share, _| share * PER_SPEED)
}

/// Returns the position of a place, as a share of the room on either side of the start.
pub(super) fn at(place: usize) -> f32 {
    // From -0.8 to 0.8.
    0.4 * place as f32 - 0.8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_has_its_task_and_both_senses_come_equally_often() {
        let tasks = || (0..).map_while(Task::of);
        assert_eq!(tasks().count(), 6 + 12 + 4 + 25 + 1);
        let backwards = |task: &Task| match *task {
            Task::Try { reverse }
            | Task::Pulse { reverse, .. }
            | Task::Leg { reverse, .. }
            | Task::Swing { reverse }
            | Task::Push { reverse, .. } => reverse,
            Task::Go { .. } | Task::Return => false,
        };
        assert_eq!(tasks().filter(backwards).count(), (6 + 12 + 4 + 20) / 2);
        assert_eq!(Task::of(2), Some(Task::Pulse { strong: false, reverse: false }));
        assert_eq!(Task::of(5), Some(Task::Pulse { strong: true, reverse: true }));
        assert_eq!(Task::of(17), Some(Task::Leg { speed: 5, reverse: true }));
        assert_eq!(Task::of(22), Some(Task::Go { place: 0 }));
        assert_eq!(Task::of(24), Some(Task::Push { place: 0, reverse: false, slow: true }));
        assert_eq!(Task::of(46), Some(Task::Push { place: 4, reverse: true, slow: true }));
        assert_eq!((Task::of(47), Task::of(48)), (Some(Task::Return), None));
        assert_eq!((at(0), at(2)), (-0.8, 0.0));
        assert_eq!(Task::of(FIRST_SWING.into()), Some(Task::Swing { reverse: false }));
        // 0.45^5
        assert!((share(5) - 0.018_45).abs() < 1e-5);
    }
}
