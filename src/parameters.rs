//! A whole machine as the device needs it, and its form in the parameter sectors of the flash.
//!
//! ```text
//! byte  0  magic "STIC"
//!       4  format version   u32, little endian, as all of the header
//!       8  sequence         u32, the higher one of two valid records is the newer
//!      12  length of body   u32
//!      16  CRC-32 (ISO-HDLC) of bytes 4 to 15 and of the body
//!      20  body             postcard
//! ```
//!
//! Why this form: the numbers are those of the core's own configuration (`f32`, counts), so that nothing is
//! rounded a second time on the device, and host and device build the same controller from them, bit for bit.
//! Guarantees: decoding is total. Any sequence of bytes either gives parameters of which every value has been
//! validated, or says what is wrong. A body of an older version is converted: [`Parameters::decode`] says how. Does badly:
//! a body of a newer version is refused.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::controller::{Controller, ControllerConfig};
use crate::course::Course;
use crate::error::{Error, between};
use crate::identification::Ramp;
use crate::monitor::Limits;
use crate::position::Position;
use crate::reference::{Corner, MAX_CORNERS, Reference, Step, Trajectory};

/// Of the body; to be raised with every change of [`Parameters`].
///
/// 1: controller, motion, device. 2: a motion may be a ramp. 3: limits after them.
pub const FORMAT_VERSION: u32 = 3;

/// Room that every record fits in, header and all.
pub const ROOM: usize = 512;

/// Largest reading of the converter that measures the supply.
pub const SUPPLY_FULL_SCALE: u16 = 4095;

const MAGIC: [u8; 4] = *b"STIC";
const HEADER: usize = 20;

/// Everything that a device is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// The control loop. The PWM's frequency is [`pwm_top`](crate::drive::DriveConfig::pwm_top) at 168 MHz.
    pub controller: ControllerConfig,
    /// The motion that arming begins.
    pub motion: Motion,
    /// What only the device has.
    pub device: Device,
    /// Thresholds of the faults.
    pub limits: Limits,
}

/// A motion as data, relative to where the joint is when it is armed.
// The difference in size is a trajectory's corners: there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Motion {
    /// Stay there.
    Hold,
    /// A jump by so much, at the first tick.
    Step(Position),
    /// Through corners, blended for `half_blend` (s) on either side of each.
    Trajectory {
        /// Where the lines meet.
        corners: Vec<Corner, MAX_CORNERS>,
        /// Half the time of a blend, s.
        half_blend: f32,
    },
    /// No motion of its own: the effort rises until the joint moves and falls until it rests.
    Ramp {
        /// V/s.
        rate: f32,
        /// Time between the rise and the fall, s.
        hold: f32,
    },
}

/// What only the device has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Device {
    /// Arm without a command, `autostart_delay` after power-on.
    pub autostart: bool,
    /// Time from the first tick to arming, s.
    pub autostart_delay: f32,
    /// Time in which the output's limit rises from zero to the full scale after arming, s; 0 is at once.
    pub soft_start: f32,
    /// Time between the switching of complementary outputs, s.
    pub dead_time: f32,
    /// Supply for which the gains were found, V: the output is scaled by its ratio to the measured supply. 0 leaves
    /// the output alone.
    pub nominal_supply: f32,
    /// Supply at the full scale of the converter, V.
    pub supply_full_scale: f32,
}

/// Why there are no parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DecodeError {
    /// The flash is erased: nothing has been written.
    Blank,
    /// Something else is written there, or a part of a record is missing.
    NotParameters,
    /// Of another format version.
    Version(u32),
    /// A bit has changed, or the record was not written to its end.
    Checksum,
    /// The checksum is right, but the body is not one of this format.
    Malformed,
    /// A value is not allowed.
    Value(Error),
}

impl Motion {
    /// Validates the motion for a loop and prepares it.
    ///
    /// # Errors
    /// Names the key.
    pub fn course(&self, config: &ControllerConfig) -> Result<Course, Error> {
        self.validate(config)?;
        let mut course = Course::default();
        self.set(config, &mut course)?;
        Ok(course)
    }

    /// Says what [`course`](Self::course) would.
    fn validate(&self, config: &ControllerConfig) -> Result<(), Error> {
        let ControllerConfig { sample_time, encoder, drive, .. } = config;
        match self {
            Self::Hold => Ok(()),
            Self::Step(to) => fraction("steps_deg", *to),
            Self::Trajectory { corners, half_blend } => {
                for corner in corners {
                    fraction("corner_positions_deg", corner.position)?;
                }
                Trajectory::validate(corners, *half_blend, *sample_time, encoder.resolution)
            }
            Self::Ramp { rate, hold } => Ramp::new(*rate, *hold, *sample_time, drive.full_scale).map(|_| ()),
        }
    }

    /// [`course`](Self::course) in place, of what has been validated: half a kilobyte is not copied.
    #[inline(never)]
    pub(crate) fn set(&self, config: &ControllerConfig, course: &mut Course) -> Result<(), Error> {
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
        }
        Ok(())
    }

    /// Refuses a ramp that rises faster than the output's limit may after arming: the soft start would cut it, and
    /// the levels that it finds would be those of another effort.
    fn softly(&self, soft_start: f32, full_scale: f32) -> Result<(), Error> {
        match self {
            Self::Ramp { rate, .. } if soft_start > 0.0 => {
                between("ramp_rates_v_per_s", *rate, 0.0, full_scale / soft_start)
            }
            _ => Ok(()),
        }
    }
}

/// Refuses a fraction outside of `[0, 1)`.
fn fraction(key: &'static str, position: Position) -> Result<(), Error> {
    between(key, position.fraction, 0.0, 1.0 - f32::EPSILON / 2.0)
}

impl Device {
    /// Neither starts nor scales anything by itself; half a second of soft start, one microsecond of dead time.
    pub const CAUTIOUS: Self = Self {
        autostart: false,
        autostart_delay: 1.0,
        soft_start: 0.5,
        dead_time: 1e-6,
        nominal_supply: 0.0,
        supply_full_scale: 0.0,
    };

    /// Refuses times that are negative or too long, and a supply that its converter cannot measure.
    ///
    /// # Errors
    /// Names the key.
    pub fn validate(&self) -> Result<(), Error> {
        between("autostart_delay_s", self.autostart_delay, 0.0, 60.0)?;
        // The product of its ticks and codes must fit 32 bits.
        between("soft_start_s", self.soft_start, 0.0, 10.0)?;
        // What the timer's dead-time generator reaches at 168 MHz.
        between("dead_time_s", self.dead_time, 0.0, 6e-6)?;
        between("supply_full_scale_v", self.supply_full_scale, 0.0, 100.0)?;
        between("nominal_supply_v", self.nominal_supply, 0.0, self.supply_full_scale)
    }
}

impl Parameters {
    /// Validates every value, and prepares the controller and its motion.
    ///
    /// # Errors
    /// Names the first key that is not allowed.
    pub fn prepare(&self) -> Result<(Controller, Course), Error> {
        self.validate()?;
        Ok((Controller::new(&self.controller)?, self.motion.course(&self.controller)?))
    }

    /// Says what [`prepare`](Self::prepare) would.
    ///
    /// # Errors
    /// Names the first key that is not allowed.
    #[inline(never)]
    pub fn validate(&self) -> Result<(), Error> {
        // What the tick's timer and the deadline are made for: 50 Hz to 10 kHz.
        between("sample_time_s", self.controller.sample_time, 1e-4, 0.02)?;
        self.device.validate()?;
        self.limits.validate()?;
        let controller = Controller::new(&self.controller)?;
        self.motion.softly(self.device.soft_start, controller.full_scale())?;
        self.motion.validate(&self.controller)
    }

    /// A ramp for this machine that rises by `rate` (V/s) and is held for `hold` (s), as [`Motion::Ramp`].
    ///
    /// # Errors
    /// Names the key.
    pub fn ramp(&self, rate: f32, hold: f32) -> Result<Ramp, Error> {
        let ControllerConfig { sample_time, drive, .. } = &self.controller;
        Motion::Ramp { rate, hold }.softly(self.device.soft_start, drive.full_scale)?;
        Ramp::new(rate, hold, *sample_time, drive.full_scale)
    }

    /// Writes a record, and returns the part of `buffer` that it fills; none if the buffer is too small, which
    /// [`ROOM`] never is.
    #[inline(never)]
    pub fn encode<'a>(&self, sequence: u32, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        let length = postcard::to_slice(self, buffer.get_mut(HEADER..)?).ok()?.len();
        let record = buffer.get_mut(..HEADER + length)?;
        let (header, body) = record.split_at_mut_checked(HEADER)?;
        let fields = [FORMAT_VERSION, sequence, u32::try_from(length).ok()?];
        for (bytes, field) in header.chunks_exact_mut(4).skip(1).zip(fields) {
            bytes.copy_from_slice(&field.to_le_bytes());
        }
        let sum = checksum(header, body);
        header.first_chunk_mut::<4>()?.copy_from_slice(&MAGIC);
        header.last_chunk_mut::<4>()?.copy_from_slice(&sum.to_le_bytes());
        Some(record)
    }

    /// Reads a record at the start of `bytes`, and returns it with its sequence number. One of version 1 or 2 knows
    /// no limits and gets those that can be derived from it ([`Limits::derived`]).
    ///
    /// # Errors
    /// Says what is wrong with it.
    pub fn decode(bytes: &[u8]) -> Result<(Self, u32), DecodeError> {
        let (header, rest) = bytes.split_at_checked(HEADER).ok_or(DecodeError::NotParameters)?;
        if header.iter().all(|&byte| byte == 0xFF) {
            return Err(DecodeError::Blank);
        }
        if !header.starts_with(&MAGIC) {
            return Err(DecodeError::NotParameters);
        }
        let [version, sequence, length, sum] = [4, 8, 12, 16].map(|at| word(header, at));
        if !(1..=FORMAT_VERSION).contains(&version) {
            return Err(DecodeError::Version(version));
        }
        let length = length as usize;
        let body = rest.get(..length).ok_or(DecodeError::NotParameters)?;
        if checksum(header, body) != sum {
            return Err(DecodeError::Checksum);
        }
        let parameters = match version {
            1 | 2 => Self::migrated(body)?,
            _ => whole(body)?,
        };
        parameters.validate().map_err(DecodeError::Value)?;
        Ok((parameters, sequence))
    }

    /// Of a body that knows no limits.
    #[inline(never)]
    fn migrated(body: &[u8]) -> Result<Self, DecodeError> {
        // One after the other: a tuple of all would be copied as a whole.
        let (controller, body): (ControllerConfig, _) = next(body)?;
        let (motion, body): (Motion, _) = next(body)?;
        let device: Device = whole(body)?;
        let limits = Limits::derived(&controller, &device, 0.0);
        Ok(Self { controller, motion, device, limits })
    }

    /// The newest valid record of two sectors, and which one it is in.
    ///
    /// A record that was cut off while it was written gives way to the one before it; if there is none, the error is
    /// that of the sector that holds something.
    ///
    /// # Errors
    /// Says what is wrong if neither is valid.
    pub fn newest(sectors: [&[u8]; 2]) -> Result<(Self, usize), DecodeError> {
        let [first, second] = sectors.map(Self::decode);
        Self::newer(first, second).map(|(parameters, _, which)| (parameters, which))
    }

    /// Of two that were decoded, the newer one with its sequence number and which of the two it is.
    pub(crate) fn newer(
        first: Result<(Self, u32), DecodeError>,
        second: Result<(Self, u32), DecodeError>,
    ) -> Result<(Self, u32, usize), DecodeError> {
        match (first, second) {
            (Ok((_, older)), Ok((second, newer))) if newer.wrapping_sub(older) as i32 > 0 => {
                Ok((second, newer, 1))
            }
            (Ok((first, sequence)), _) => Ok((first, sequence, 0)),
            (Err(_), Ok((second, sequence))) => Ok((second, sequence, 1)),
            (Err(DecodeError::Blank), Err(error)) | (Err(error), Err(_)) => Err(error),
        }
    }
}

/// A value at the begin of some bytes, and those after it.
#[inline(never)]
fn next<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Result<(T, &'a [u8]), DecodeError> {
    postcard::take_from_bytes(body).map_err(|_| DecodeError::Malformed)
}

/// A value that takes up all of its bytes.
#[inline(never)]
fn whole<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Result<T, DecodeError> {
    match postcard::take_from_bytes(body) {
        Ok((value, [])) => Ok(value),
        _ => Err(DecodeError::Malformed),
    }
}

fn checksum(header: &[u8], body: &[u8]) -> u32 {
    crate::checksum::checksum(&[header.get(4..16).unwrap_or_default(), body])
}

fn word(header: &[u8], at: usize) -> u32 {
    let bytes = header.get(at..).and_then(|rest| rest.first_chunk::<4>());
    bytes.map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

#[cfg(test)]
mod tests;
