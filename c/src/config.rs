//! Structs that the caller fills, and the one that says why they are refused.

use stiction::positioner::{
    EncoderSide, MonitorConfig, Position, PositionerConfig, Refused, Target,
};

use crate::owned;
use crate::{STICTION_ENCODER_AT_LOAD, STICTION_ENCODER_AT_MOTOR, STICTION_REFUSED};

/// Configuration of a joint and of the loop around it.
///
/// Angles are rad of the joint. The effort is in any unit: volts, amperes, N m, a share of the
/// duty. Inertia, friction, load and limits are in the same unit.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct StictionConfig {
    /// `sizeof(StictionConfig)`.
    pub size: u32,
    /// Time between two ticks, s.
    pub sample_time: f32,
    /// Counts of the encoder in a turn of the joint: lines x 4 x gear.
    pub counts_per_turn: f32,
    /// Largest effort.
    pub largest_effort: f32,
    /// Step of the effort: that of the PWM, of a D/A converter, or of a message.
    pub effort_step: f32,
    /// Moment of inertia, as the effort of an acceleration of 1 rad/s^2.
    pub inertia: f32,
    /// Viscous friction with back-EMF, as the effort of a speed of 1 rad/s.
    pub viscous: f32,
    /// Lowest breakaway effort of the joint over all positions, in the unit of the effort.
    pub breakaway_low: f32,
    /// Highest breakaway effort of the joint over all positions, in the unit of the effort.
    pub breakaway_high: f32,
    /// Largest load that drives the joint, as an effort. 0: none does.
    pub load: f32,
    /// Effort that holds the joint where it starts.
    pub hold_effort: f32,
    /// Counts by which the encoder changes at rest: 2 for noise of one count to either side.
    pub jitter: f32,
    /// Largest speed, rad/s. 0: a rule of the law.
    pub speed: f32,
    /// Largest acceleration, rad/s^2. 0: a rule of the law.
    pub acceleration: f32,
    /// `STICTION_ENCODER_AT_MOTOR` or `STICTION_ENCODER_AT_LOAD`.
    pub encoder_side: u32,
}

/// Configuration of the monitors, beside that of the joint.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct StictionMonitorConfig {
    /// `sizeof(StictionMonitorConfig)`.
    pub size: u32,
    /// Lowest position from the counter's zero, rad. With both zero there is no range.
    pub range_low: f32,
    /// Highest position, rad.
    pub range_high: f32,
    /// Effort that the motor tolerates forever at standstill.
    pub continuous_effort: f32,
    /// Time constant of the motor's winding, s.
    pub thermal_time: f32,
}

/// Position that the joint should have at one tick, and the velocity with which it moves on.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct StictionTarget {
    /// Whole counts. They wrap.
    pub counts: i32,
    /// Fraction of a count beyond the whole ones, from 0 to below 1.
    pub fraction: f32,
    /// Velocity, rad/s. 0: the target rests, and the joint moves there by a profile of its own.
    pub velocity: f32,
    /// Acceleration, rad/s^2.
    pub acceleration: f32,
}

/// Reason why a configuration is refused: a field that is outside its range.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct StictionRefusal {
    /// Name of the field, with a zero at its end.
    pub field: [u8; 24],
    /// Value found.
    pub found: f32,
    /// Lowest value allowed.
    pub low: f32,
    /// Highest value allowed.
    pub high: f32,
}

impl StictionConfig {
    /// Reads a configuration, once its size is that of this library.
    ///
    /// # Safety
    /// The pointer is null, or its first field can be read; and all of it, if that field is the
    /// size of this struct.
    pub(crate) unsafe fn read(at: *const Self) -> Option<Result<PositionerConfig, Refused>> {
        // SAFETY: as the caller promises.
        let config = match unsafe { owned::sized(at) }? {
            Ok(config) => config,
            Err(refused) => return Some(Err(refused)),
        };
        let encoder_side = match config.encoder_side {
            STICTION_ENCODER_AT_MOTOR => EncoderSide::Motor,
            STICTION_ENCODER_AT_LOAD => EncoderSide::Load,
            other => {
                let found = other as f32;
                return Some(Err(Refused { field: "encoder_side", found, low: 0.0, high: 1.0 }));
            }
        };
        Some(Ok(PositionerConfig {
            sample_time: config.sample_time,
            counts_per_turn: config.counts_per_turn,
            largest_effort: config.largest_effort,
            effort_step: config.effort_step,
            inertia: config.inertia,
            viscous: config.viscous,
            breakaway: [config.breakaway_low, config.breakaway_high],
            load: config.load,
            hold_effort: config.hold_effort,
            jitter: config.jitter,
            speed: config.speed,
            acceleration: config.acceleration,
            encoder_side,
        }))
    }
}

impl StictionMonitorConfig {
    /// Reads a configuration, once its size is that of this library.
    ///
    /// # Safety
    /// As of [`StictionConfig::read`].
    pub(crate) unsafe fn read(at: *const Self) -> Option<Result<MonitorConfig, Refused>> {
        // SAFETY: as the caller promises.
        Some(unsafe { owned::sized(at) }?.map(|config| MonitorConfig {
            range: [config.range_low, config.range_high],
            continuous_effort: config.continuous_effort,
            thermal_time: config.thermal_time,
        }))
    }
}

impl StictionTarget {
    pub(crate) fn of(position: Position) -> Self {
        let Position { counts, fraction } = position;
        Self { counts, fraction, velocity: 0.0, acceleration: 0.0 }
    }

    pub(crate) fn target(&self) -> Target {
        let position = Position { counts: self.counts, fraction: self.fraction };
        Target { position, velocity: self.velocity, acceleration: self.acceleration }
    }
}

/// Returns the code of a refusal, and writes its reason where the caller wants one.
///
/// # Safety
/// The pointer is null, or can be written.
pub(crate) unsafe fn refuse(refused: &Refused, why: *mut StictionRefusal) -> i32 {
    // Two fields of the configuration are one of the core.
    let name = match refused.field {
        "breakaway[0]" => "breakaway_low",
        "breakaway[1]" => "breakaway_high",
        "range[0]" => "range_low",
        "range[1]" => "range_high",
        other => other,
    };
    let mut field = [0; 24];
    // The last one stays zero.
    for (to, from) in field.iter_mut().take(23).zip(name.bytes()) {
        *to = from;
    }
    if owned::is_usable(why) {
        let Refused { found, low, high, .. } = *refused;
        // SAFETY: it is not null, and can be written as the caller promises.
        unsafe { why.write(StictionRefusal { field, found, low, high }) };
    }
    STICTION_REFUSED
}
