//! One tick, from the encoder's counter to the drive's duty.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::compensator::{Compensator, CompensatorState, Gains, Loop, MAX_TERMS, Sample};
use crate::drive::{Drive, DriveConfig, Duty};
use crate::encoder::{Encoder, EncoderState};
use crate::error::{Error, above};
use crate::pd::PdGains;
use crate::position::Position;
use crate::reference::{Reference, Setpoint};
use crate::saturation::saturate;
use crate::velocity::{Velocity, VelocityState};

/// Everything that a controller is configured with, in a user's units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControllerConfig {
    /// Time between samples, s.
    pub sample_time: f32,
    /// The encoder.
    pub encoder: Encoder,
    /// Number of positions in the velocity regression; 5 in the thesis.
    pub velocity_window: usize,
    /// The PD loop.
    pub pd: PdGains,
    /// The laws whose sum is the compensator; empty is plain PD.
    pub compensator: Vec<Gains, MAX_TERMS>,
    /// The drive.
    pub drive: DriveConfig,
}

/// A controller, ready to be used; shared by any number of joints of the same kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    encoder: Encoder,
    velocity: Velocity,
    pd: PdGains,
    compensator: Compensator,
    full_scale: f32,
    drive: Drive,
}

/// What one joint's controller remembers from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ControllerState {
    encoder: EncoderState,
    velocity: VelocityState,
    compensator: CompensatorState,
    /// Ticks since the motion began; stops at its largest value, so that no motion ever begins anew by itself.
    tick: u32,
}

/// Every term of one tick. Laid out as in C: a host reads it from the memory of a running image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Tick {
    /// Ticks since the motion began.
    pub tick: u32,
    /// theta_a, counts.
    pub counts: i32,
    /// theta_d and its derivatives.
    pub setpoint: Setpoint,
    /// theta_e, deg.
    pub error: f32,
    /// theta_a', measured, deg/s.
    pub velocity: f32,
    /// Output of the PD loop, V.
    pub v_pd: f32,
    /// Output of the compensator, V.
    pub v_c: f32,
    /// Their sum, limited to the full scale, V.
    pub v: f32,
    /// The drive's code of `v`.
    pub code: i16,
    /// The PWM setting of `code`.
    pub duty: Duty,
    /// The sum was beyond the full scale.
    pub saturated: bool,
    /// A term was not a finite number: the output is zero and the compensator starts afresh.
    pub non_finite: bool,
}

impl ControllerState {
    /// theta_a as of the last tick, counts.
    pub const fn counts(&self) -> i32 {
        self.encoder.counts()
    }

    /// A motion begins at the next tick; everything else goes on.
    pub const fn begin_motion(&mut self) {
        self.tick = 0;
    }
}

impl Controller {
    /// Validates a configuration and prepares everything that a tick needs.
    ///
    /// # Errors
    /// Names the first value that is not allowed.
    pub fn new(config: &ControllerConfig) -> Result<Self, Error> {
        above("sample_time_s", config.sample_time, 0.0, 1.0)?;
        config.encoder.validate()?;
        config.pd.validate()?;
        let drive = Drive::new(&config.drive)?;
        let full_scale = config.drive.full_scale;
        let around = Loop { sample_time: config.sample_time, full_scale, kp: config.pd.kp };
        Ok(Self {
            encoder: config.encoder,
            velocity: Velocity::new(config.velocity_window, config.encoder.resolution, config.sample_time)?,
            pd: config.pd,
            compensator: Compensator::new(&config.compensator, &around)?,
            full_scale,
            drive,
        })
    }

    /// A joint at rest whose counter reads `counter` now, which is position `counts`; a motion begins.
    pub fn start(&self, counter: u32, counts: i32) -> ControllerState {
        ControllerState {
            encoder: EncoderState::start(counter, counts),
            velocity: VelocityState::default(),
            compensator: self.compensator.rest(),
            tick: 0,
        }
    }

    /// The largest output, V.
    pub const fn full_scale(&self) -> f32 {
        self.full_scale
    }

    /// The drive, to convert codes.
    pub const fn drive(&self) -> &Drive {
        &self.drive
    }

    /// One tick: `counter` is what the hardware counter reads now, and the returned [`Tick::duty`] is to be
    /// applied at once.
    #[inline]
    pub fn tick(&self, state: &mut ControllerState, counter: u32, reference: &Reference) -> Tick {
        let travel = self.encoder.update(&mut state.encoder, counter);
        let velocity = self.velocity.update(&mut state.velocity, travel);
        let setpoint = reference.at(state.tick);

        let counts = state.encoder.counts();
        let error = setpoint.position.ahead_of(counts) * self.encoder.resolution;
        let velocity_error = setpoint.velocity - velocity;

        let v_pd = self.pd.update(error, velocity_error);
        let reference_velocity = setpoint.velocity;
        let sample = Sample { error, velocity, reference_velocity, velocity_error, v_pd };
        let v_c = self.compensator.update(&mut state.compensator, &sample);

        let sum = v_pd + v_c;
        // A law may hide an infinity (tanh, a comparison), so the set point is asked as well as the sum.
        let non_finite = !(sum.is_finite() && setpoint.is_finite());
        if non_finite {
            state.compensator = self.compensator.rest();
        }
        let (v, saturated) = if non_finite { (0.0, false) } else { saturate(sum, self.full_scale) };

        let code = self.drive.code(v);
        let duty = self.drive.duty(code);
        let tick = state.tick;
        state.tick = tick.saturating_add(1);
        Tick { tick, counts, setpoint, error, velocity, v_pd, v_c, v, code, duty, saturated, non_finite }
    }

    /// One tick with the loop open: `effort` gives the output (V) at a position in counts. The set point goes along
    /// with the joint, so there is no error; the laws rest.
    #[inline]
    pub fn open_loop(
        &self,
        state: &mut ControllerState,
        counter: u32,
        effort: impl FnOnce(i32) -> f32,
    ) -> Tick {
        let travel = self.encoder.update(&mut state.encoder, counter);
        let velocity = self.velocity.update(&mut state.velocity, travel);
        let counts = state.encoder.counts();
        let setpoint = Setpoint::at_rest(Position::from_counts(counts));

        let asked = effort(counts);
        let non_finite = !asked.is_finite();
        let (v, saturated) = if non_finite { (0.0, false) } else { saturate(asked, self.full_scale) };
        let code = self.drive.code(v);
        let duty = self.drive.duty(code);
        let tick = state.tick;
        state.tick = tick.saturating_add(1);
        let (error, v_pd, v_c) = (0.0, 0.0, 0.0);
        Tick { tick, counts, setpoint, error, velocity, v_pd, v_c, v, code, duty, saturated, non_finite }
    }
}
