//! Bounds of a joint and data of its loop: the input of a rule.
//!
//! | figure | from a data sheet |
//! |---|---|
//! | J, B | nominal inertia and viscous friction; with the back-EMF unless a current loop feeds it
//! |
//! | F_lo | half of the lowest slip friction, less a load that this friction holds |
//! | F_hi | twice the highest stick friction with that load |
//! | u_L | constant load and unbalance, if the lowest slip friction does not hold them; else 0 |
//! | u_m, u_q | full scale times largest duty, and the volts of a code |
//!
//! A data sheet does not state how the friction varies with position, direction and temperature,
//! and an identification measures it on one day: hence the factors of two. A load that the friction
//! holds acts as a friction that depends on the direction (constant load) and on the position
//! (unbalance).

use std::f64::consts::TAU;

use stiction::ControllerConfig;
use stiction::control::motor_encoder;

use files::data_sheet::tables::EncoderPlace;
use files::data_sheet::{DataSheet, Mapping};

/// Margin of the bounds around the lowest and the highest friction that are known.
const MARGIN: f64 = 2.0;

/// Bounds of a joint and data of its loop, in the core's units: volts, degrees, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointBounds {
    /// Nominal inertia J, V s^2/deg.
    pub inertia: f64,
    /// Nominal viscous friction B, V s/deg.
    pub viscous: f64,
    /// Back-EMF beside it, which a current loop feeds forward: it brakes no joint, but limits the
    /// speed, V s/deg. 0 without a current loop, where the back-EMF is part of B.
    pub induced: f64,
    /// Bounds of the breakaway effort F_lo and F_hi, V.
    pub breakaway: [f64; 2],
    /// Largest load u_L that drives the joint against its friction, V; 0: the friction holds it.
    pub load: f64,
    /// Effort that holds the load where the joint is armed, within 20 %, V; 0: none is needed.
    pub hold_effort: f64,
    /// Whether the encoder sits on the load, behind an elastic gear.
    pub encoder_at_load: bool,
    /// Noise of the encoder at rest from peak to peak, counts.
    pub jitter: f64,
    /// The motor's encoder, if the loop has a second one on the load. Then `jitter` and
    /// `sampled.count` are those of the load's encoder.
    pub motor_encoder: Option<MotorEncoder>,
    /// The loop around the joint.
    pub sampled: SampledLoop,
}

/// Encoder of the motor of a joint that has a second encoder on its load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorEncoder {
    /// Angle of a count, deg of the joint.
    pub count: f64,
    /// Noise at rest from peak to peak, counts.
    pub jitter: f64,
    /// The gear between both encoders; `None` if it is unknown.
    pub gear: Option<GearBounds>,
}

/// Gear between two encoders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearBounds {
    /// Whole width of the slack, deg.
    pub backlash: f64,
    /// Torsional stiffness K, V/deg.
    pub stiffness: f64,
}

impl GearBounds {
    /// Returns the gear that is assumed if nothing is known: a degree of slack, and the lowest
    /// stiffness that `robust` is made for. With the motor held still, a load of a fifth of the
    /// inertia (V s^2/deg) swings on this gear at 5 Hz.
    fn softest(inertia: f64) -> Self {
        let frequency = TAU * 5.0;
        Self { backlash: 1.0, stiffness: 0.2 * inertia * frequency * frequency }
    }
}

/// Sampled loop around a joint: its largest effort, and the steps of effort, angle and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledLoop {
    /// Largest effort u_m, V.
    pub largest_effort: f64,
    /// Step of the effort u_q, V.
    pub lsb: f64,
    /// Angle of a count q, deg.
    pub count: f64,
    /// Time between samples h, s.
    pub sample_time: f64,
}

impl SampledLoop {
    /// Returns the loop of a controller's configuration.
    pub fn of(controller: &ControllerConfig) -> Self {
        let ControllerConfig { sample_time, encoder, drive, .. } = controller;
        Self {
            largest_effort: f64::from(drive.full_scale) * f64::from(drive.duty_max),
            lsb: drive.lsb.into(),
            count: encoder.resolution.into(),
            sample_time: (*sample_time).into(),
        }
    }
}

/// Joint of a data sheet or an identification, in volts, degrees and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointEstimate {
    /// Inertia, V s^2/deg.
    pub inertia: f64,
    /// Viscous friction, V s/deg.
    pub viscous: f64,
    /// Lowest friction in motion and highest friction at rest, over both directions, V.
    pub friction: [f64; 2],
    /// Largest load, V.
    pub load: f64,
    /// Largest load that the friction holds, V.
    pub holds: f64,
}

impl JointEstimate {
    /// Returns the joint of a data sheet.
    pub fn of_sheet(sheet: &DataSheet, mapping: &Mapping) -> Self {
        let load = sheet.load.constant_nm.abs() + sheet.load.unbalance_nm.abs();
        let slip = sheet.slip()[0].min(sheet.slip()[1]);
        let stick = sheet.stick()[0].max(sheet.stick()[1]);
        let held = if load < slip { load } else { 0.0 };
        Self {
            inertia: mapping.units.per_degree(mapping.inertia),
            viscous: mapping.viscous_v(),
            friction: [slip - held, stick + held].map(|level| mapping.volts(level)),
            load: mapping.volts(load),
            holds: mapping.volts(slip),
        }
    }
}

impl JointBounds {
    /// Returns the bounds of a joint in a loop, with the encoder on the motor.
    pub const fn of(joint: &JointEstimate, sampled: SampledLoop) -> Self {
        let [lowest, highest] = joint.friction;
        Self {
            inertia: joint.inertia,
            viscous: joint.viscous,
            induced: 0.0,
            breakaway: [lowest / MARGIN, MARGIN * highest],
            load: if joint.load > joint.holds { joint.load } else { 0.0 },
            hold_effort: 0.0,
            encoder_at_load: false,
            jitter: 0.0,
            motor_encoder: None,
            sampled,
        }
    }

    /// Takes the back-EMF (V s/deg) out of the viscous friction: a current loop feeds it forward.
    #[must_use]
    pub fn with_current_loop(self, back_emf: f64) -> Self {
        let induced = back_emf.min(self.viscous);
        Self { viscous: self.viscous - induced, induced, ..self }
    }

    /// Adds an encoder of the motor without noise, behind an unknown gear; `count_deg` is the angle
    /// of its count, deg of the joint. The other encoder is on the load.
    #[must_use]
    pub const fn with_motor_encoder(self, count_deg: f64) -> Self {
        let motor_encoder = Some(MotorEncoder { count: count_deg, jitter: 0.0, gear: None });
        Self { motor_encoder, ..self }
    }

    /// Adds the sides and the noise of the encoders of a data sheet, and the gear between them;
    /// `count_deg` is the angle of a count of `[encoder]`, deg.
    #[must_use]
    pub fn with_encoders_of(self, sheet: &DataSheet, mapping: &Mapping, count_deg: f64) -> Self {
        // A reading that is a count off either way changes by two.
        let jitter = |noise_counts: u32| 2.0 * f64::from(noise_counts);
        let of_encoder = jitter(sheet.encoder.noise_counts);
        let load = sheet.load_encoder_in_loop();
        Self {
            encoder_at_load: sheet.stiffness().is_some()
                && sheet.position_side() == Some(EncoderPlace::Load),
            jitter: load.map_or(of_encoder, |load| jitter(load.noise_counts)),
            motor_encoder: load.map(|_| MotorEncoder {
                count: count_deg,
                jitter: of_encoder,
                gear: sheet.stiffness().map(|stiffness| GearBounds {
                    backlash: sheet.backlash().unwrap_or(0.0).to_degrees(),
                    stiffness: mapping.units.per_degree(stiffness),
                }),
            }),
            ..self
        }
    }

    /// Returns the configuration of the motor's encoder beside one on the load, with the largest
    /// twists that a device tolerates: twice what the gear allows at rest, and twice what the full
    /// effort winds up after it has driven the motor through the slack.
    ///
    /// ```text
    /// w_max = 2 (bl + (F_hi + u_L) / K + 2 (q + q_m))
    /// w_dyn = 2 (bl + t + sqrt(t^2 + 2 t bl) + 2 (q + q_m)),   t = u_m / K;
    ///         at most w_max of an unknown gear
    /// ```
    ///
    /// with the slack bl, the stiffness K and the counts q and q_m of load and motor. A stiffness
    /// that is configured too high makes both twists too small. An unknown gear counts as a soft
    /// one, and its w_max is used for both.
    pub fn motor_config(&self) -> motor_encoder::MotorEncoder {
        let Some(motor) = &self.motor_encoder else { return motor_encoder::MotorEncoder::NONE };
        let counts = 2.0 * (self.sampled.count + motor.count);
        let at_rest = |gear: &GearBounds| {
            2.0 * (gear.backlash + (self.breakaway[1] + self.load) / gear.stiffness + counts)
        };
        // The full effort drives the motor through the slack; its energy winds the gear up.
        let in_motion = |gear: &GearBounds| {
            let static_twist = self.sampled.largest_effort / gear.stiffness;
            let squared = static_twist * static_twist + 2.0 * static_twist * gear.backlash;
            2.0 * (gear.backlash + static_twist + squared.sqrt() + counts)
        };
        let of_unknown = at_rest(&GearBounds::softest(self.inertia));
        let [twist, swing] = motor.gear.map_or([of_unknown; 2], |gear| {
            let twist = at_rest(&gear);
            [twist, in_motion(&gear).min(of_unknown).max(twist)]
        });
        motor_encoder::MotorEncoder {
            count: motor.count as f32,
            twist: twist as f32,
            swing: swing as f32,
            ..motor_encoder::MotorEncoder::NONE
        }
    }

    /// Returns the largest twist of a known gear between two encoders, deg: within it the motor can
    /// be held or thrown back by its gear. Zero for an unknown gear, and with one encoder.
    pub fn known_twist(&self) -> f32 {
        let is_known = self.motor_encoder.is_some_and(|motor| motor.gear.is_some());
        if is_known { self.motor_config().twist } else { 0.0 }
    }

    /// Returns the geometric middle of both bounds of the breakaway effort, V.
    pub fn middle_breakaway(&self) -> f64 {
        (self.breakaway[0] * self.breakaway[1]).sqrt()
    }
}
