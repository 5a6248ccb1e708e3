//! A motion of the joint, from data to set points.
//!
//! ```text
//! machine's file -> Motion (parameters, link) -> Course --> Reference   set points, loop closed
//!                   data                         prepared +-> Profile   the same, with a state
//!                                                         +-> Ramp      efforts, loop open
//!                                   a link, arming -------+-> Jog
//!                                                         +-> WindingTest   pulses of the board
//!                                             Home ---------> Profile   watched until a hard stop
//! ```
//!
//! The positions of a [`Motion`] count from the place where the joint was armed. [`Motion::Hold`]
//! has no position: the joint stays where it is when the motion begins, both at arming (which makes
//! that place zero) and later.

pub mod arming_test;
mod course;
pub mod home;
pub mod jog;
pub mod winding;

pub use course::{Course, CourseState};

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::control::controller::ControllerConfig;
use crate::control::profile::{Profile, ProfileLimits};
use crate::control::reference::{
    AMPLITUDE, CORNER_TIMES, Corner, FREQUENCY, HALF_BLEND, MAX_CORNERS, Reference, Sine, Step,
    Trajectory,
};
use crate::identification::{self, Ramp};
use crate::units::error::{Allowed, InvalidValue, between};
use crate::units::position::Position;
use crate::units::value::{About, Absent, InvalidBits, Key, Kind, Values};

/// A motion as data.
// The difference in size is a trajectory's corners: there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// The joint stays where it is.
    Hold,
    /// The set point jumps to a position at the first tick.
    Step(Position),
    /// The joint goes through corners, blended for `half_blend` (s) on either side of each.
    Trajectory {
        /// Corners of the path: the points where its straight lines meet before they are blended.
        corners: Vec<Corner, MAX_CORNERS>,
        /// Half the time of a blend, s.
        half_blend: f32,
    },
    /// The loop is open. The effort rises until the joint moves, and falls until it rests.
    Ramp {
        /// Rate of the effort, V/s.
        rate: f32,
        /// Time between the rise and the fall of the effort, s.
        hold: f32,
    },
    /// The set point goes to a position within the limits of a profile.
    Profiled(Position),
    /// The set point goes to and fro, and has no end.
    Sine {
        /// Position from which the set point sets out.
        from: Position,
        /// Amplitude a, counts: the set point turns at `from` and at `from + 2 a`.
        amplitude: f32,
        /// Frequency, Hz.
        frequency: f32,
    },
}

const KIND: Key = Key(0x0600);
const STEP_COUNTS: Key = Key(0x0601);
const STEP_FRACTION: Key = Key(0x0602);
pub(crate) const RAMP_RATE: Key = identification::RATE;
pub(crate) const RAMP_HOLD: Key = identification::HOLD;
/// The first value number of the corners.
const CORNERS: u16 = CORNER_TIMES.0;

/// The declarations of a motion's values, for hosts. A machine's file can have many motions, in
/// another form.
pub(crate) const ABOUT: &[About] = &[
    about(
        KIND,
        "reference",
        "motion",
        Kind::Whole,
        "0 hold, 1 step, 2 trajectory, 3 ramp, 4 profiled, 5 sine.",
    ),
    about(
        STEP_COUNTS,
        "reference",
        "steps_deg",
        Kind::Whole,
        "Where the step or the profiled move leads, or the sine sets out, whole counts.",
    ),
    about(
        STEP_FRACTION,
        "reference",
        "steps_deg",
        Kind::Number,
        "The rest of it in [0, 1) counts.",
    ),
    about(
        AMPLITUDE,
        "reference.sines",
        "amplitude_deg",
        Kind::Number,
        "Amplitude of a sine, counts.",
    ),
    about(FREQUENCY, "reference.sines", "frequency_hz", Kind::Number, "Frequency of a sine, Hz."),
    about(
        HALF_BLEND,
        "reference.trajectories",
        "half_blend_s",
        Kind::Number,
        "Half the time of a blend, s.",
    ),
    about(RAMP_RATE, "identification", "ramp_rates_v_per_s", Kind::Number, "Rate of a ramp, V/s."),
    about(
        RAMP_HOLD,
        "identification",
        "hold_s",
        Kind::Number,
        "Time between rise and fall of a ramp, s.",
    ),
    about(
        identification::EFFORT,
        "identification",
        "effort_v",
        Kind::Number,
        "Largest effort of an identification, V.",
    ),
    about(
        identification::TRAVEL,
        "identification",
        "travel_deg",
        Kind::Number,
        "Largest travel of an identification, deg.",
    ),
    about(
        identification::SPEED,
        "identification",
        "speed_deg_per_s",
        Kind::Number,
        "Largest speed of an identification, deg/s.",
    ),
    about(
        identification::TIME,
        "identification",
        "time_s",
        Kind::Number,
        "Longest time of an identification, s.",
    ),
    about(home::EFFORT, "home", "effort_v", Kind::Number, "Largest effort of a homing, V."),
    about(home::TRAVEL, "home", "travel_deg", Kind::Number, "Largest travel of a homing, deg."),
    about(home::SPEED, "home", "speed_deg_per_s", Kind::Number, "Speed of a homing, deg/s."),
    about(home::TIME, "home", "time_s", Kind::Number, "Longest time of a homing, s."),
    about(
        winding::PERIODS,
        "winding",
        "periods",
        Kind::Whole,
        "Periods of the PWM in a group of readings of a measurement of the winding.",
    ),
    about(
        winding::CYCLES,
        "winding",
        "cycles",
        Kind::Whole,
        "Cycles of a measurement of the winding.",
    ),
    about(
        Key(CORNERS),
        "reference.trajectories",
        "corner_times_s",
        Kind::Whole,
        "Time of a corner, ticks.",
    ),
    about(
        Key(CORNERS + 1),
        "reference.trajectories",
        "corner_positions_deg",
        Kind::Whole,
        "Position of a corner, whole counts.",
    ),
    about(
        Key(CORNERS + 2),
        "reference.trajectories",
        "corner_positions_deg",
        Kind::Number,
        "The rest of it in [0, 1) counts.",
    ),
];

const fn about(
    key: Key,
    table: &'static str,
    name: &'static str,
    kind: Kind,
    text: &'static str,
) -> About {
    About { key, table, name, field: "", text, bounds: "", kind, absent: Absent::Needed }
}

/// The range of a fraction, `[0, 1)`.
const FRACTION: Allowed = Allowed::Between(0.0, 1.0 - f32::EPSILON / 2.0);

impl Motion {
    /// Validates the motion for a loop and prepares it. [`Motion::Hold`] is prepared as staying at
    /// zero, which is where arming begins; [`Servo::hold`](crate::Servo::hold) holds elsewhere.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn course(
        &self,
        config: &ControllerConfig,
        profile: &ProfileLimits,
    ) -> Result<Course, InvalidValue> {
        self.check(config)?;
        let mut course = Course::default();
        self.prepare(config, profile, &mut course)?;
        Ok(course)
    }

    /// Validates the motion as [`course`](Self::course) does, without preparing it.
    pub(crate) fn check(&self, config: &ControllerConfig) -> Result<(), InvalidValue> {
        let ControllerConfig { sample_time, encoder, drive, .. } = config;
        self.validate()?;
        match self {
            Self::Hold | Self::Step(_) | Self::Profiled(_) => Ok(()),
            Self::Trajectory { corners, half_blend } => {
                Trajectory::validate(corners, *half_blend, *sample_time, encoder.resolution)
            }
            Self::Ramp { rate, hold } => {
                Ramp::new(*rate, *hold, *sample_time, drive.full_scale).map(|_| ())
            }
            Self::Sine { from, amplitude, frequency } => {
                Sine::new(*from, *amplitude, *frequency, *sample_time, encoder.resolution)
                    .map(|_| ())
            }
        }
    }

    /// Prepares a motion that has been validated, in `course` itself, so that half a kilobyte is
    /// not copied.
    #[inline(never)]
    pub(crate) fn prepare(
        &self,
        config: &ControllerConfig,
        profile: &ProfileLimits,
        course: &mut Course,
    ) -> Result<(), InvalidValue> {
        let ControllerConfig { sample_time, encoder, drive, .. } = config;
        match self {
            Self::Hold => *course = Course::default(),
            Self::Step(to) => {
                let step = Step { from: Position::default(), to: *to, at_tick: 0 };
                *course = Course::Follow(Reference::Step(step));
            }
            Self::Trajectory { corners, half_blend } => {
                *course = Course::Follow(Reference::Trajectory(Trajectory::EMPTY));
                if let Course::Follow(Reference::Trajectory(trajectory)) = course {
                    trajectory.set(corners, *half_blend, *sample_time, encoder.resolution);
                }
            }
            Self::Ramp { rate, hold } => {
                *course = Course::Ramp(Ramp::new(*rate, *hold, *sample_time, drive.full_scale)?);
            }
            Self::Profiled(to) => {
                let move_to = Profile::new(*to, profile, *sample_time, encoder.resolution)?;
                *course = Course::Profile(move_to);
            }
            Self::Sine { from, amplitude, frequency } => {
                let sine =
                    Sine::new(*from, *amplitude, *frequency, *sample_time, encoder.resolution)?;
                *course = Course::Follow(Reference::Sine(sine));
            }
        }
        Ok(())
    }

    /// Rejects a ramp that rises faster than the output's limit does after arming. The soft start
    /// would cut such a ramp, and the ramp would find the levels of another effort.
    pub(crate) fn is_soft(&self, soft_start: f32, full_scale: f32) -> Result<(), InvalidValue> {
        match self {
            Self::Ramp { rate, .. } if soft_start > 0.0 => {
                between(RAMP_RATE, *rate, 0.0, full_scale / soft_start)
            }
            _ => Ok(()),
        }
    }
}

/// Returns the index of the corner that a value belongs to, and the index of the value in that
/// corner.
fn corner(key: Key) -> Option<(usize, u16)> {
    let at = key.0.checked_sub(CORNERS)?;
    let index = usize::from(at / 4);
    (index < MAX_CORNERS && at % 4 < 3).then_some((index, at % 4))
}

/// Returns the number under which a value is declared: for a value of any corner, that of the first
/// corner.
pub(crate) fn declared(key: Key) -> Key {
    corner(key).map_or(key, |(_, part)| Key(CORNERS + part))
}

impl Values for Motion {
    fn nth(&self, place: &mut usize) -> Option<(Key, Absent)> {
        let values: &[Key] = match self {
            Self::Hold => &[KIND],
            Self::Step(_) | Self::Profiled(_) => &[KIND, STEP_COUNTS, STEP_FRACTION],
            Self::Trajectory { .. } => &[KIND, HALF_BLEND],
            Self::Ramp { .. } => &[KIND, RAMP_RATE, RAMP_HOLD],
            Self::Sine { .. } => &[KIND, STEP_COUNTS, STEP_FRACTION, AMPLITUDE, FREQUENCY],
        };
        if let Some(key) = values.get(*place) {
            return Some((*key, Absent::Needed));
        }
        *place -= values.len();
        let Self::Trajectory { corners, .. } = self else { return None };
        let (index, part) = (*place / 3, *place % 3);
        if index < corners.len() {
            return Some((Key(CORNERS + (4 * index + part) as u16), Absent::Needed));
        }
        *place -= 3 * corners.len();
        None
    }

    fn get(&self, key: Key) -> Option<u32> {
        let value = match (self, key) {
            (Self::Hold, KIND) => 0,
            (Self::Step(_), KIND) => 1,
            (Self::Trajectory { .. }, KIND) => 2,
            (Self::Ramp { .. }, KIND) => 3,
            (Self::Profiled(_), KIND) => 4,
            (Self::Sine { .. }, KIND) => 5,
            (Self::Step(at) | Self::Profiled(at) | Self::Sine { from: at, .. }, STEP_COUNTS) => {
                at.counts as u32
            }
            (Self::Step(at) | Self::Profiled(at) | Self::Sine { from: at, .. }, STEP_FRACTION) => {
                at.fraction.to_bits()
            }
            (Self::Sine { amplitude, .. }, AMPLITUDE) => amplitude.to_bits(),
            (Self::Sine { frequency, .. }, FREQUENCY) => frequency.to_bits(),
            (Self::Trajectory { half_blend, .. }, HALF_BLEND) => half_blend.to_bits(),
            (Self::Ramp { rate, .. }, RAMP_RATE) => rate.to_bits(),
            (Self::Ramp { hold, .. }, RAMP_HOLD) => hold.to_bits(),
            (Self::Trajectory { corners, .. }, _) => {
                let (index, part) = corner(key)?;
                let corner = corners.as_slice().get(index)?;
                match part {
                    0 => corner.tick,
                    1 => corner.position.counts as u32,
                    _ => corner.position.fraction.to_bits(),
                }
            }
            _ => return None,
        };
        Some(value)
    }

    /// Returns a value with its bounds. Times and rates have none here: `Motion::check` validates
    /// them for the loop.
    fn with_bounds(&self, key: Key) -> Option<(f32, Allowed)> {
        let bits = self.get(key)?;
        let part = corner(key).map(|(_, part)| part);
        let is_whole = matches!(key, KIND | STEP_COUNTS) || part.is_some_and(|part| part < 2);
        let is_fraction = key == STEP_FRACTION || part == Some(2);
        let number = if is_whole { bits as i32 as f32 } else { f32::from_bits(bits) };
        Some((number, if is_fraction { FRACTION } else { Allowed::Any }))
    }

    /// Sets a value of the motion. The kind has to be set first, since a new kind resets all other
    /// values. Of a corner, the time has to be set first, since it adds the corner.
    fn set(&mut self, key: Key, bits: u32) -> Result<bool, InvalidBits> {
        let number = f32::from_bits(bits);
        let is_same_kind = key == KIND && self.get(KIND) == Some(bits);
        match (&mut *self, key) {
            (_, KIND) if is_same_kind => {}
            (_, KIND) => {
                *self = match bits {
                    0 => Self::Hold,
                    1 => Self::Step(Position::default()),
                    2 => Self::Trajectory { corners: Vec::new(), half_blend: 0.0 },
                    3 => Self::Ramp { rate: 0.0, hold: 0.0 },
                    4 => Self::Profiled(Position::default()),
                    5 => Self::Sine { from: Position::default(), amplitude: 0.0, frequency: 0.0 },
                    _ => return Err(InvalidBits),
                }
            }
            (Self::Step(at) | Self::Profiled(at) | Self::Sine { from: at, .. }, STEP_COUNTS) => {
                at.counts = bits as i32;
            }
            (Self::Step(at) | Self::Profiled(at) | Self::Sine { from: at, .. }, STEP_FRACTION) => {
                at.fraction = number;
            }
            (Self::Sine { amplitude, .. }, AMPLITUDE) => *amplitude = number,
            (Self::Sine { frequency, .. }, FREQUENCY) => *frequency = number,
            (Self::Trajectory { half_blend, .. }, HALF_BLEND) => *half_blend = number,
            (Self::Ramp { rate, .. }, RAMP_RATE) => *rate = number,
            (Self::Ramp { hold, .. }, RAMP_HOLD) => *hold = number,
            (Self::Trajectory { corners, .. }, _) => {
                let Some((index, part)) = corner(key) else { return Ok(false) };
                if part == 0 && index == corners.len() {
                    corners.push(Corner::default()).map_err(|_| InvalidBits)?;
                }
                let corner = corners.as_mut_slice().get_mut(index).ok_or(InvalidBits)?;
                match part {
                    0 => corner.tick = bits,
                    1 => corner.position.counts = bits as i32,
                    _ => corner.position.fraction = number,
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }
}
