//! The profile of a move, for a firmware of your own.

use super::config::{COUNTS, RANGE, SAMPLE_TIME, check, refused};
use super::{Position, Refused, Target};
use crate::control::profile::{Profile, ProfileLimits};

/// Limits of a move. Angles are rad of the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoveConfig {
    /// Time between two ticks, s.
    pub sample_time: f32,
    /// Counts of the encoder in a turn of the joint.
    pub counts_per_turn: f32,
    /// Largest velocity, rad/s.
    pub speed: f32,
    /// Largest acceleration, rad/s^2.
    pub acceleration: f32,
    /// Largest jerk, rad/s^3.
    pub jerk: f32,
}

/// Profile of a move with bounded velocity, acceleration and jerk: it generates the target of each
/// tick.
///
/// [`Profile`] has the equations, what it guarantees and what it does badly.
/// [`Positioner`](super::Positioner) has a profile of its own and needs none; beside
/// [`PdPositioner`](super::PdPositioner), or to choose the path of a move, use this one.
///
/// ```
/// use stiction::positioner::{MoveConfig, MoveProfile, Position};
///
/// let limits = MoveConfig {
///     sample_time: 1e-3,
///     counts_per_turn: 100_000.0,
///     speed: 2.0,
///     acceleration: 20.0,
///     jerk: 625.0,
/// };
/// let mut path = MoveProfile::new(&limits, Position::from_counts(0))?;
/// path.aim(Position::from_counts(8000));
/// let (mut ticks, mut fastest) = (0, 0.0f32);
/// while path.is_moving() {
///     // A positioner takes this target.
///     fastest = fastest.max(path.update().velocity);
///     ticks += 1;
/// }
/// // 0.503 rad / 2 rad/s + 2 / 20 s + 2 * 20 / 625 s = 0.415 s.
/// assert!(fastest > 1.98 && fastest <= 2.0, "{fastest}");
/// assert!((415..=417).contains(&ticks), "{ticks}");
/// assert_eq!(path.target().position, Position::from_counts(8000));
/// # Ok::<(), stiction::positioner::Refused>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MoveProfile {
    // In rad: the generator works in any unit of angles.
    profile: Profile,
}

impl MoveProfile {
    /// Validates the limits, and returns a profile that rests at a position.
    ///
    /// # Errors
    /// Returns the first field that is outside its range. The range of a limit depends on the other
    /// fields: the generator counts in whole fractions of a count, and averages over 256 ticks at
    /// most.
    pub fn new(config: &MoveConfig, at: Position) -> Result<Self, Refused> {
        check("sample_time", config.sample_time, SAMPLE_TIME)?;
        check("counts_per_turn", config.counts_per_turn, COUNTS)?;
        check("speed", config.speed, RANGE)?;
        check("acceleration", config.acceleration, RANGE)?;
        let MoveConfig { speed, acceleration, jerk, sample_time, .. } = *config;
        let limits = ProfileLimits { velocity: speed, acceleration, jerk };
        let count = core::f32::consts::TAU / config.counts_per_turn;
        let mut profile = Profile::new(at, &limits, sample_time, count).map_err(|error| {
            let error = refused::<ProfileLimits>(error);
            Refused {
                field: if error.field == "velocity" { "speed" } else { error.field },
                ..error
            }
        })?;
        profile.start_at(at, 0.0);
        Ok(Self { profile })
    }

    /// Sets another end of the move. The path goes on from its present position and velocity.
    pub fn aim(&mut self, end: Position) {
        self.profile.aim(end);
    }

    /// Sets the end of the move to the first whole count on which it can stop within the limits.
    pub fn stop(&mut self) {
        self.profile.stop();
    }

    /// Runs one tick, and returns the target of a positioner.
    pub fn update(&mut self) -> Target {
        self.profile.update();
        self.target()
    }

    /// Returns the target as of the last tick.
    pub fn target(&self) -> Target {
        let setpoint = self.profile.setpoint();
        let (velocity, acceleration) = (setpoint.velocity, setpoint.acceleration);
        Target { position: setpoint.position, velocity, acceleration }
    }

    /// Returns whether the path moves, or will move.
    pub fn is_moving(&self) -> bool {
        self.profile.is_moving()
    }

    /// Sets the path to rest at `at`, the position of the joint. Call it after the output has been
    /// off.
    pub fn restart(&mut self, at: Position) {
        self.profile.aim(at);
        self.profile.start_at(at, 0.0);
    }
}
