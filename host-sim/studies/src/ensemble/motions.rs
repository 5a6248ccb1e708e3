//! Motions by which a joint of an ensemble is judged.

use serde::{Deserialize, Serialize};
use stiction::control::profile::Profile;
use stiction::control::reference::{Reference, Step};

use files::error::Error;
use simulator::experiment::position;
use simulator::rules::{JointBounds, MoveProfile};
use simulator::target::WatchedServo;

/// How the set point goes to a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "command-line", derive(clap::ValueEnum))]
pub enum Approach {
    /// Within the limits of velocity, acceleration and jerk of the rule book, as `device move`
    /// does.
    #[default]
    Profiled,
    /// At once.
    Step,
}

impl Approach {
    /// Returns the name in options and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Profiled => "profiled",
            Self::Step => "step",
        }
    }

    /// Commands a servo to go to a target, in counts from its position at arming. Returns whether
    /// it does: a servo that has tripped refuses.
    ///
    /// # Errors
    /// If the core refuses the limits of the profile.
    pub fn start(
        self,
        servo: &mut WatchedServo,
        to: f64,
        joint: &JointBounds,
    ) -> Result<bool, Error> {
        match self {
            Self::Step => {
                let step = Step { to: position(to), ..Step::default() };
                Ok(servo.follow(Reference::Step(step)).is_ok())
            }
            Self::Profiled => Ok(servo.go_to(profile(to, joint)?).is_ok()),
        }
    }

    /// Returns the ticks in which the set point moves, from rest to a target that is `way` counts
    /// away.
    ///
    /// # Errors
    /// If the core refuses the limits of the profile.
    pub fn ticks(self, way: f64, joint: &JointBounds) -> Result<u32, Error> {
        if self == Self::Step {
            return Ok(0);
        }
        let mut profile = profile(way, joint)?;
        let mut ticks = 0;
        while profile.is_moving() {
            profile.update();
            ticks += 1;
        }
        Ok(ticks)
    }
}

fn profile(to: f64, joint: &JointBounds) -> Result<Profile, Error> {
    let limits = MoveProfile::of(joint).limits;
    let (sample_time, count) = (joint.sampled.sample_time as f32, joint.sampled.count as f32);
    Profile::new(position(to), &limits, sample_time, count).map_err(|error| {
        Error::Input(format!(
            "cannot plan a move: its limits cannot be kept at this sample rate and encoder \
             resolution ({error:?}); use another sample rate"
        ))
    })
}

/// Motions of a case: a move to a target, a trajectory, and moves in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Motions {
    /// How the set point goes to the target.
    pub approach: Approach,
    /// Seed of the moves in a row.
    pub seed: u64,
    /// Number of moves in a row; 0: none.
    pub moves: u32,
}
