//! The controller: one tick, from the joint's travel to the drive's duty.

use heapless::Vec;

use crate::control::drive::{Drive, DriveConfig};
use crate::control::encoder::Encoder;
use crate::control::hardware::Hardware;
#[cfg(feature = "two-encoders")]
use crate::control::laws::FIRST_LAW;
use crate::control::laws::{Compensator, CompensatorState, Gains, LawInput, Loop, MAX_TERMS};
use crate::control::motor_encoder::MotorEncoder;
use crate::control::output::{Applied, OutputStage, OutputState, Rise};
use crate::control::pd::PdGains;
use crate::control::reference::{Reference, Setpoint};
use crate::control::signal::{MAX_LAW_SIGNALS, Tick};
use crate::control::velocity::{MAX_WINDOW, Velocity, VelocityState};
#[cfg(feature = "two-encoders")]
use crate::units::error::Allowed;
use crate::units::error::InvalidValue;
use crate::units::position::Position;
use crate::units::value::{Key, Table, Values, choice, key, table};

choice! {
    /// What the bridge makes of an effort.
    pub enum EffortMode {
        /// The effort is the motor's voltage. Its current follows from winding, speed and supply.
        Voltage = 0 "voltage",
        /// A current loop makes the effort the motor's current: that which the effort, as a
        /// voltage, causes at standstill.
        Current = 1 "current",
    }
}

table! {
    /// The configuration of a controller, in a user's units.
    #[derive(Clone, Debug, PartialEq)]
    pub struct ControllerConfig (config) "loop" {
        /// Time between samples, s. A device takes what its timer and its deadline are made for:
        /// 0.0001 to 0.02.
        sample_time: f32 = 0x0101 "sample_time_s", Above(0.0, 1.0), Needed(0.02);
        /// Number of positions in the velocity regression; 5 in the thesis.
        velocity_window: u32 =
            0x0102 "velocity_window", Between(2.0, MAX_WINDOW as f32), Default(5);
        /// What the bridge makes of an effort: the motor's voltage, or by a current loop its
        /// current. Efforts are volts in either case: 1 V is the current that 1 V causes through
        /// `current_sensor.resistance_ohm` at standstill. `current` needs `[current_sensor]` with
        /// an inductance, and a whole number of the PWM's periods in a sample time.
        effort: EffortMode = 0x0103 "effort", Any, Default(EffortMode::Voltage);
    }
    with {
        /// The encoder.
        encoder: Encoder = Encoder::EXAMPLE,
        /// The encoder of the motor, if `encoder` is on the load.
        motor: MotorEncoder = MotorEncoder::NONE,
        /// The drive.
        drive: DriveConfig = DriveConfig::EXAMPLE,
        /// The PD loop; without effect under a law that replaces it.
        pd: PdGains = PdGains::EXAMPLE,
        /// The laws whose sum is the compensator; empty is plain PD.
        compensator: Vec<Gains, MAX_TERMS> = Vec::new(),
    }
}

/// Key of the configured value `sample_time`.
pub(crate) const SAMPLE_TIME: Key = key(ControllerConfig::ABOUT, "sample_time");

/// A controller that is prepared for its ticks. Any number of joints of the same kind may share it.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    encoder: Encoder,
    #[cfg(feature = "two-encoders")]
    motor_encoder: Option<Encoder>,
    velocity: Velocity,
    pd: PdGains,
    compensator: Compensator,
    output: OutputStage,
}

/// The state of one joint's controller from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ControllerState {
    counts: i32,
    #[cfg(feature = "two-encoders")]
    motor_counts: i32,
    /// Whether a tick has read the motor's encoder. Until then, the motor's travel is zero.
    #[cfg(feature = "two-encoders")]
    has_seen_motor: bool,
    velocity: VelocityState,
    compensator: CompensatorState,
    output: OutputState,
    /// Ticks since the motion began. The count stops at its largest value: a wrap to zero would
    /// start the motion again.
    tick: u32,
}

/// Readings of the hardware for one tick of the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Position of the joint, counts. It wraps.
    pub counts: i32,
    /// Position of the motor, counts of its own encoder, for a joint with an encoder on either
    /// side. It wraps. `counts` is then the position of the load.
    #[cfg(feature = "two-encoders")]
    pub motor_counts: i32,
    /// Reading of the supply, the converter's units; without effect unless the output is scaled by
    /// the supply.
    pub supply: u16,
}

impl Reading {
    /// Returns a reading of the position (counts) without a measured supply.
    pub const fn position(counts: i32) -> Self {
        Self::measured(counts, 0)
    }

    /// Returns a reading of the position (counts) and of the supply (the converter's units).
    pub const fn measured(counts: i32, supply: u16) -> Self {
        Self {
            counts,
            #[cfg(feature = "two-encoders")]
            motor_counts: counts,
            supply,
        }
    }
}

impl ControllerConfig {
    /// Returns the properties of the loop that the laws are prepared for.
    pub const fn around(&self) -> Loop {
        Loop {
            sample_time: self.sample_time,
            resolution: self.encoder.resolution,
            full_scale: self.drive.full_scale,
            lsb: self.drive.lsb,
            kp: self.pd.kp,
            motor: self.motor,
        }
    }
}

impl ControllerState {
    /// Returns the position theta_a in the last tick, counts.
    pub const fn counts(&self) -> i32 {
        self.counts
    }

    /// Returns the number of the next tick, counted from the start of the motion.
    pub const fn next_tick(&self) -> u32 {
        self.tick
    }

    /// Returns the effort that the joint has had since the last tick, V.
    pub(crate) const fn applied(&self) -> f32 {
        self.output.applied
    }

    /// Resets the state, in place: it is too large to be made elsewhere and copied while the bridge
    /// waits to be turned off.
    pub(crate) fn forget(&mut self) {
        let Self { counts, velocity, compensator, output, tick, .. } = self;
        (*counts, *tick) = (0, 0);
        *velocity = VelocityState::default();
        *output = OutputState::default();
        compensator.forget();
        #[cfg(feature = "two-encoders")]
        {
            (self.motor_counts, self.has_seen_motor) = (0, false);
        }
    }

    /// Sets the least code of the next tick, with the sign of its direction; zero: none.
    pub(crate) const fn push(&mut self, least: i32) {
        self.output.least = least;
    }

    /// Starts a motion at the next tick: the count of ticks restarts at zero, and a law that has
    /// given up tries again. The rest of the state is kept.
    pub fn begin_motion(&mut self) {
        self.tick = 0;
        self.compensator.begin_motion();
    }
}

#[cfg(feature = "two-encoders")]
impl ControllerConfig {
    /// Refuses the law for two encoders (`robust-dual`) in a loop with one encoder.
    fn has_the_encoders_of_its_laws(&self) -> Result<(), InvalidValue> {
        let is_missing =
            |law: &&Gains| matches!(law, Gains::RobustDual(_)) && self.motor.count().is_none();
        self.compensator.iter().find(is_missing).map_or(Ok(()), |law| {
            Err(InvalidValue {
                key: FIRST_LAW,
                found: law.id().into(),
                allowed: Allowed::AnotherLaw,
            })
        })
    }
}

impl Controller {
    /// Validates a configuration and prepares everything that a tick needs.
    ///
    /// # Errors
    /// Returns an error that names the first invalid value.
    pub fn new(config: &ControllerConfig, hardware: &Hardware) -> Result<Self, InvalidValue> {
        // The drive comes first: the board's bounds of the PWM's frequency are narrower than those
        // of its declaration.
        let drive = Drive::new(&config.drive, hardware)?;
        config.validate()?;
        #[cfg(feature = "two-encoders")]
        config.has_the_encoders_of_its_laws()?;
        let count = config.motor.count().unwrap_or(config.encoder.resolution);
        let velocity = Velocity::new(config.velocity_window, count, config.sample_time);
        Ok(Self {
            encoder: config.encoder,
            #[cfg(feature = "two-encoders")]
            motor_encoder: config.motor.count().map(|_| config.motor.encoder()),
            velocity,
            pd: config.pd,
            compensator: Compensator::new(&config.compensator, &config.around()),
            output: OutputStage::new(&config.drive, drive),
        })
    }

    /// Sets the soft start (ticks) and the nominal supply (the converter's units; 0: none) of a
    /// device.
    pub(crate) fn on_device(&mut self, soft_start: u32, nominal_supply: f32) {
        self.output.on_device(soft_start, nominal_supply);
    }

    /// Sets the largest effort of the motion that starts, V; infinity: the full scale alone limits
    /// it.
    pub(crate) fn bound_effort(&mut self, effort: f32) {
        self.output.bound_effort(effort);
    }

    /// Sets the lowest and the highest effort of the next tick, V: those that the motor's current
    /// allows.
    pub(crate) fn bound(&mut self, bounds: [f32; 2]) {
        self.output.bound(bounds);
    }

    /// Returns the remaining ticks of the soft start.
    pub(crate) const fn soft_start_left(&self, state: &ControllerState) -> u32 {
        self.output.soft_start_left(&state.output)
    }

    /// Returns the state at the start of a motion, for a joint at rest in position `counts`.
    pub fn start(&self, counts: i32) -> ControllerState {
        ControllerState {
            counts,
            compensator: self.compensator.rest(),
            ..ControllerState::default()
        }
    }

    /// Returns the largest output, V.
    pub const fn full_scale(&self) -> f32 {
        self.output.full_scale
    }

    /// Returns the encoder, which turns readings of its counter into travel.
    pub const fn encoder(&self) -> &Encoder {
        &self.encoder
    }

    /// Returns the encoder of the motor, if there is another one on the load; `None` with one
    /// encoder.
    #[cfg(feature = "two-encoders")]
    #[inline]
    pub const fn motor_encoder(&self) -> Option<&Encoder> {
        self.motor_encoder.as_ref()
    }

    /// Returns the drive, which converts volts into codes and codes into PWM settings.
    pub const fn drive(&self) -> &Drive {
        &self.output.drive
    }

    /// Runs one tick with the loop closed. The returned [`Tick::duty`] must be applied at once.
    #[inline]
    pub fn tick(
        &self,
        state: &mut ControllerState,
        reading: Reading,
        reference: &Reference,
    ) -> Tick {
        self.closed_loop(state, reading, |tick| reference.at(tick))
    }

    /// Runs one tick with the loop closed, as [`tick`](Self::tick) does, with a set point instead
    /// of a reference.
    #[inline]
    pub fn follow(
        &self,
        state: &mut ControllerState,
        reading: Reading,
        setpoint: Setpoint,
    ) -> Tick {
        self.closed_loop(state, reading, |_| setpoint)
    }

    // One copy for references and one for profiles: shared code would need the set point in the
    // same place for both, which costs every tick 20 instructions.
    #[inline(always)]
    fn closed_loop(
        &self,
        state: &mut ControllerState,
        reading: Reading,
        reference: impl FnOnce(u32) -> Setpoint,
    ) -> Tick {
        let (travel, velocity) = self.observe(state, reading);
        let counts = state.counts;
        let setpoint = reference(state.tick);

        let error = setpoint.position.ahead_of(counts) * self.encoder.resolution;
        let velocity_error = setpoint.velocity - velocity;

        let replaces_pd = self.compensator.replaces_pd();
        let v_pd = if replaces_pd { 0.0 } else { self.pd.update(error, velocity_error) };
        let OutputState { applied, saturated, .. } = state.output;
        let input = LawInput {
            counts,
            #[cfg(feature = "two-encoders")]
            motor_counts: reading.motor_counts,
            travel,
            setpoint,
            error,
            velocity,
            velocity_error,
            v_pd,
            applied,
            saturated,
        };
        let v_c = self.compensator.update(&mut state.compensator, &input);

        let sum = if replaces_pd { v_c } else { v_pd + v_c };
        // A law can hide an infinity (tanh, a comparison), so the set point is checked as well as
        // the sum.
        let non_finite = !(sum.is_finite() && setpoint.is_finite());
        if non_finite {
            self.compensator.begin_anew(&mut state.compensator);
        }
        let asked = if non_finite { 0.0 } else { sum };
        let output = self.output.apply(&mut state.output, asked, reading.supply, Rise::Soft);
        let terms = Terms { error, v_pd, v_c };
        let mut tick = record(state, &setpoint, velocity, &terms, &output, non_finite);
        // After a reset, the values of the law's state need not be numbers.
        if !non_finite && let Some(law) = self.compensator.signals(&state.compensator) {
            tick.law = law;
        }
        tick
    }

    /// Returns whether the law has ended its attempts to reach the set point.
    #[inline]
    pub fn has_given_up(&self, state: &ControllerState) -> bool {
        self.compensator.has_given_up(&state.compensator)
    }

    /// Runs one tick with the loop open: `effort` returns the output (V) for a position in counts.
    /// The set point is the position of the joint, so the error is zero. The laws do not run.
    #[inline]
    pub fn open_loop(
        &self,
        state: &mut ControllerState,
        reading: Reading,
        effort: impl FnOnce(i32) -> f32,
    ) -> Tick {
        let (_, velocity) = self.observe(state, reading);
        let counts = state.counts;
        let setpoint = Setpoint::at_rest(Position::from_counts(counts));
        let effort = effort(counts);
        let non_finite = !effort.is_finite();
        let asked = if non_finite { 0.0 } else { effort };
        let output = self.output.apply(&mut state.output, asked, reading.supply, Rise::Own);
        record(state, &setpoint, velocity, &Terms::default(), &output, non_finite)
    }

    /// Stores the position, and returns the travel since the last tick (counts) and the velocity
    /// (deg/s). If the motor has an encoder of its own, the velocity is that of the motor.
    #[inline]
    fn observe(&self, state: &mut ControllerState, reading: Reading) -> (i32, f32) {
        let travel = reading.counts.wrapping_sub(state.counts);
        state.counts = reading.counts;
        #[cfg(feature = "two-encoders")]
        if self.motor_encoder.is_some() {
            let of_motor = if state.has_seen_motor {
                reading.motor_counts.wrapping_sub(state.motor_counts)
            } else {
                0
            };
            (state.motor_counts, state.has_seen_motor) = (reading.motor_counts, true);
            return (travel, self.velocity.update(&mut state.velocity, of_motor));
        }
        (travel, self.velocity.update(&mut state.velocity, travel))
    }
}

/// Terms of a tick that only a closed loop computes.
#[derive(Default)]
struct Terms {
    error: f32,
    v_pd: f32,
    v_c: f32,
}

/// Returns the signals of a tick, those of the law at zero, and increments the count of ticks.
// The tick is made in one piece: a tick that is made from another one is copied word by word.
#[inline(always)]
fn record(
    state: &mut ControllerState,
    setpoint: &Setpoint,
    velocity: f32,
    terms: &Terms,
    output: &Applied,
    non_finite: bool,
) -> Tick {
    let tick = state.tick;
    state.tick = tick.saturating_add(1);
    Tick {
        tick,
        counts: state.counts,
        reference_counts: setpoint.position.counts,
        reference_fraction: setpoint.position.fraction,
        reference_velocity: setpoint.velocity,
        reference_acceleration: setpoint.acceleration,
        error: terms.error,
        velocity,
        v_pd: terms.v_pd,
        v_c: terms.v_c,
        v: output.v,
        v_applied: output.v_applied,
        code: output.code,
        compare: output.duty.compare,
        reverse: output.duty.reverse,
        saturated: output.saturated,
        non_finite,
        status: 0,
        current: 0.0,
        #[cfg(feature = "two-encoders")]
        motor_counts: state.motor_counts,
        #[cfg(not(feature = "two-encoders"))]
        motor_counts: 0,
        law: [0.0; MAX_LAW_SIGNALS],
    }
}
