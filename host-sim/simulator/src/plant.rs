//! The plant: a joint behind an amplifier, with an encoder's disc on its shaft.
//!
//! If the winding of the motor is known, the back-EMF brakes the joint only while a current can
//! flow: with the bridge on, at whatever voltage, or with the wires shorted. With the bridge off,
//! without a supply or with an open wire the joint coasts on its mechanical friction. The diodes of
//! a bridge that is off, which would conduct at a back-EMF above the supply, are not simulated.
//! Without a known winding the viscous friction of the joint is always the same.
//!
//! A winding with a heat path ([`HeatPath`]) heats up by its current, and its resistance with it:
//! with r = R(T) / R, an effort u acts as u / r, and the back-EMF brakes by 1 / r. The lag that the
//! solver of a data sheet's joint has itself stays L / R.
//!
//! In each sample the driver of the plant reads the counter, puts out a code, and advances the time
//! to the next sample. The bare loop, the servo, a simulated device and the emulated board use the
//! same plant.

use stiction::control::encoder::Direction;

use crate::counters::Counters;
use crate::winding_heat::{HeatPath, Temperatures};
use dynamics::joint::RunJoint;
use dynamics::mechanism::RobotAxis;
use dynamics::solver::{AxisSolver, Event};
use files::data_sheet::shrink;
use files::encoder::EncoderModel;

/// Computation delay of an output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Delay {
    /// The output takes effect at its own sample.
    #[default]
    None,
    /// The output takes effect one sample later.
    OneSample,
    /// The output takes effect two samples later.
    TwoSamples,
}

/// Delay of the outputs by the computation time of a run.
#[derive(Clone, Copy, Debug)]
pub struct DelayLine<T = i16> {
    delay: Delay,
    /// Last output, and the one before it.
    before: [T; 2],
}

impl DelayLine {
    /// Creates a line with zero as the previous output.
    pub const fn new(delay: Delay) -> Self {
        Self::after(delay, 0)
    }
}

impl<T: Copy> DelayLine<T> {
    /// Creates a line with a previous output.
    pub const fn after(delay: Delay, before: T) -> Self {
        Self { delay, before: [before; 2] }
    }

    /// Stores the output of this sample, and returns the one that takes effect now.
    ///
    /// ```
    /// use simulator::plant::{Delay, DelayLine};
    /// let puts = |delay| {
    ///     let mut line = DelayLine::new(delay);
    ///     [1, 2, 3].map(|code| line.put(code))
    /// };
    /// assert_eq!(puts(Delay::None), [1, 2, 3]);
    /// assert_eq!(puts(Delay::OneSample), [0, 1, 2]);
    /// assert_eq!(puts(Delay::TwoSamples), [0, 0, 1]);
    /// ```
    #[inline]
    pub const fn put(&mut self, output: T) -> T {
        let [last, oldest] = self.before;
        self.before = [output, last];
        match self.delay {
            Delay::None => output,
            Delay::OneSample => last,
            Delay::TwoSamples => oldest,
        }
    }
}

/// Positions of the discs of a joint's encoders, in counts of counters that do not wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Discs {
    /// Disc whose counter is [`Input::counter`](stiction::servo::Input::counter): of two, that of
    /// the motor.
    pub first: i64,
    /// Disc of the load, if there are two. That of an absolute encoder has the angle in its low
    /// bits.
    pub load: Option<i64>,
    /// Whether the load's encoder is an absolute one on a bus.
    pub is_absolute: bool,
}

/// Winding of a motor on a bridge: `i = (u - k_e q') / R`, behind the lag of its inductance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winding {
    /// Resistance R, ohm.
    pub resistance_ohm: f64,
    /// Back-EMF k_e at the joint, V s/deg.
    pub back_emf_v_per_deg_per_s: f64,
    /// Time constant L/R, s, by which the plant delays the effort; 0 if its solver does.
    pub lag_s: f64,
    /// Voltage that the dead time of the bridge loses at the nominal supply, V, against the
    /// current.
    pub dead_time_v: f64,
    /// Heat path to the ambient air; `None`: the resistance is constant.
    pub heat: Option<HeatPath>,
}

impl Winding {
    /// Returns the winding as one of the resistance R whose efforts count 1 / r each, for a
    /// resistance of r R.
    fn heated(self, ratio: f64) -> Self {
        Self {
            back_emf_v_per_deg_per_s: self.back_emf_v_per_deg_per_s / ratio,
            lag_s: self.lag_s / ratio,
            ..self
        }
    }

    /// Returns the current (A) under an effort (V), at a speed of the joint (deg/s).
    fn current_a(&self, effort_v: f64, speed: f64) -> f64 {
        (effort_v - self.back_emf_v_per_deg_per_s * speed) / self.resistance_ohm
    }
}

/// Effort that a bridge puts out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EffortState {
    /// Effort, V at the supply of the plan.
    pub volts: f64,
    /// Whether the bridge is on.
    pub is_on: bool,
}

/// Temperatures of a winding with its heat path.
#[derive(Clone, Copy, Debug)]
struct Heat {
    path: HeatPath,
    temperatures: Temperatures,
    /// Copper loss (J) and time (s) since the last update.
    loss_j: f64,
    since_s: f64,
}

impl Heat {
    fn at_start(path: HeatPath) -> Self {
        Self { path, temperatures: path.start(), loss_j: 0.0, since_s: 0.0 }
    }
}

/// State of the wires between bridge and motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotorWires {
    /// Both wires are intact.
    #[default]
    Sound,
    /// A wire is open.
    Open,
    /// The wires touch each other behind the sensor of the current.
    Shorted,
}

/// Resistance of a short, ohm: two wires and the contact.
const SHORT_OHM: f64 = 0.1;

/// A joint that moves sample by sample. The solver `S` computes its motion between two samples.
#[derive(Clone, Debug)]
pub struct Plant<S> {
    /// Solver, which has position and velocity of the joint.
    pub solver: S,
    /// Friction in addition to that of the machine, V: a hand on the joint, a hard stop.
    pub brake_v: f64,
    /// Whether the amplifier has no supply.
    pub is_unpowered: bool,
    /// External load on the joint, V: a spring, a bumper.
    pub load_v: f64,
    /// Ratio of the supply to that for which a code has its volts.
    pub supply_ratio: f64,
    /// State of the wires between bridge and motor.
    pub motor_wires: MotorWires,
    /// Winding of the motor, if its resistance is known.
    winding: Option<Winding>,
    /// Whether that winding loses effort by heat or dead time, also under a bare loop.
    is_winding_driven: bool,
    /// Temperatures of that winding, if it has a heat path.
    heat: Option<Heat>,
    /// Resistance of the winding over that of the file.
    resistance_ratio: f64,
    /// Current of the motor at the end of the last held effort, A.
    current_a: f64,
    /// Electrical energy that the motor has drawn from the bridge since it was last taken, J.
    drawn_j: f64,
    /// Effort behind the lag of the winding, V.
    lagged_v: f64,
    axis: RobotAxis,
    encoder: EncoderModel,
    /// Encoder of the motor, if `encoder` is a second one on the load.
    motor_encoder: Option<EncoderModel>,
    /// Reading of an absolute encoder on the load where the joint is at zero.
    absolute_zero: Option<u32>,
    lsb_v: f64,
    sample_time_s: f64,
    delay: DelayLine,
    /// Elapsed time: whole samples, and the rest, s.
    samples: u64,
    time_s: f64,
}

impl Plant<RunJoint> {
    /// Sets position (deg) and velocity (deg/s) of the joint, as if it was moved by hand.
    pub fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.solver.put(position_deg, velocity_deg_per_s);
    }
}

impl<S: AxisSolver> Plant<S> {
    /// Creates the plant of an axis with its encoder; `lsb_v` is the voltage of one code (V),
    /// `sample_time_s` the time between two samples (s).
    pub const fn new(
        solver: S,
        axis: RobotAxis,
        encoder: EncoderModel,
        [lsb_v, sample_time_s]: [f64; 2],
        delay: Delay,
    ) -> Self {
        let delay = DelayLine::new(delay);
        Self {
            solver,
            brake_v: 0.0,
            is_unpowered: false,
            load_v: 0.0,
            supply_ratio: 1.0,
            motor_wires: MotorWires::Sound,
            winding: None,
            is_winding_driven: false,
            heat: None,
            resistance_ratio: 1.0,
            current_a: 0.0,
            drawn_j: 0.0,
            lagged_v: 0.0,
            axis,
            encoder,
            motor_encoder: None,
            absolute_zero: None,
            lsb_v,
            sample_time_s,
            delay,
            samples: 0,
            time_s: 0.0,
        }
    }

    /// Adds an encoder on the motor to a joint whose encoder is on the load.
    #[must_use]
    pub fn with_motor_encoder(self, motor_encoder: Option<EncoderModel>) -> Self {
        Self { motor_encoder, ..self }
    }

    /// Sets the reading of the load's encoder where the joint is at zero, if it is an absolute one.
    #[must_use]
    pub fn with_absolute_zero(self, absolute_zero: Option<u32>) -> Self {
        Self { absolute_zero, ..self }
    }

    /// Adds the winding of the motor, which has a current. A solver that has the drive of a data
    /// sheet itself needs none: the dead time would count twice.
    #[must_use]
    pub fn with_winding(self, winding: Option<Winding>) -> Self {
        let heat = winding.and_then(|winding| winding.heat).map(Heat::at_start);
        let ratio = |heat: Heat| heat.temperatures.resistance_ratio();
        let has_dead_time = winding.is_some_and(|winding| winding.dead_time_v > 0.0);
        Self {
            winding,
            is_winding_driven: heat.is_some() || has_dead_time,
            heat,
            resistance_ratio: heat.map_or(1.0, ratio),
            ..self
        }
    }

    /// Returns the temperatures of the motor; `None` without a heat path of its winding.
    pub fn temperatures(&self) -> Option<Temperatures> {
        self.heat.map(|heat| heat.temperatures)
    }

    /// Holds the effort of a bare loop until the next sample. Without heat path and dead time, the
    /// effort is held as the supply makes it.
    #[inline]
    pub fn hold_effort(&mut self, volts: f64, on_event: &mut impl FnMut(Event)) {
        let sample_time_s = self.sample_time_s;
        if self.is_winding_driven {
            let effort = EffortState { volts, is_on: true };
            self.hold_driven_and_report(effort, sample_time_s, on_event);
        } else {
            self.hold(self.supply_ratio * volts, sample_time_s, on_event);
        }
    }

    /// Returns the current of the motor at the end of the last held effort, A; zero without a known
    /// winding.
    pub const fn current_a(&self) -> f64 {
        self.current_a
    }

    /// Returns the electrical energy that the motor has drawn from the bridge since the last call,
    /// J; negative if it has returned energy. Zero without a known winding.
    pub const fn take_drawn_j(&mut self) -> f64 {
        std::mem::replace(&mut self.drawn_j, 0.0)
    }

    /// Returns the position of the motor in counts of its own encoder; `None` with one encoder.
    #[inline]
    pub fn motor_counts(&self) -> Option<i32> {
        let encoder = self.motor_encoder.as_ref()?;
        Some(encoder.counts(self.solver.measured_at_motor()) as i32)
    }

    /// Returns the reading of the counter of the encoder that measures the position, with intact
    /// wires.
    #[inline]
    pub fn counter(&self) -> u32 {
        let counter = self.encoder.counter(self.solver.measured());
        match self.absolute_zero {
            Some(zero) => counter.wrapping_add(zero),
            None => counter,
        }
    }

    /// Returns the readings of the counters of all encoders, with intact wires.
    #[inline]
    pub fn counters(&self) -> Counters {
        let of_motor = |motor: &EncoderModel| motor.counter(self.solver.measured_at_motor());
        Counters { position: self.counter(), motor: self.motor_encoder.as_ref().map(of_motor) }
    }

    /// Returns the positions of the discs of all encoders.
    pub fn discs(&self) -> Discs {
        self.discs_of(&self.solver)
    }

    /// Returns the positions of the discs of a joint in the state of `solver`.
    fn discs_of(&self, solver: &S) -> Discs {
        let zero = i64::from(self.absolute_zero.unwrap_or(0));
        let position = disc_at(&self.encoder, solver.measured()) + zero;
        let is_absolute = self.absolute_zero.is_some();
        match &self.motor_encoder {
            Some(motor) => Discs {
                first: disc_at(motor, solver.measured_at_motor()),
                load: Some(position),
                is_absolute,
            },
            None => Discs { first: position, load: None, is_absolute },
        }
    }

    /// Returns the position in counts, in the direction of the joint.
    pub fn counts(&self) -> i32 {
        self.encoder.counts(self.solver.measured()) as i32
    }

    /// Returns the true position of the joint, deg.
    #[inline]
    pub fn position_deg(&self) -> f64 {
        self.solver.position()
    }

    /// Returns the true velocity of the joint, deg/s.
    #[inline]
    pub fn velocity_deg_per_s(&self) -> f64 {
        self.solver.velocity()
    }

    /// Returns whether position and velocity are finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.position_deg().is_finite() && self.velocity_deg_per_s().is_finite()
    }

    /// Returns the time between two samples, s.
    pub const fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// Returns the effort of a code, V.
    pub fn volts(&self, code: i16) -> f64 {
        f64::from(code) * self.lsb_v
    }

    /// Returns the code of an effort, V.
    pub fn code(&self, effort_v: f64) -> i16 {
        (effort_v / self.lsb_v).round() as i16
    }

    /// Puts out the code of a sample, and returns the effort that takes effect now, V.
    #[inline]
    pub fn put_out(&mut self, code: i16) -> f64 {
        f64::from(self.delay.put(code)) * self.lsb_v
    }

    /// Puts out a code and holds its effort for a time (s), as [`hold_driven`](Self::hold_driven)
    /// does.
    pub fn put_out_and_hold(&mut self, code: i16, is_on: bool, duration_s: f64) {
        let volts = self.put_out(code);
        // The enable pin turns the output off without delay.
        self.hold_driven(EffortState { volts, is_on }, duration_s);
    }

    /// Holds an effort for a time (s), with the external load. There is no effort if the output is
    /// off or the amplifier has no supply.
    pub fn hold_driven(&mut self, effort: EffortState, duration_s: f64) {
        self.hold_driven_and_report(effort, duration_s, &mut |_| {});
    }

    /// Holds an effort as [`hold_driven`](Self::hold_driven) does, and reports each event.
    pub fn hold_driven_and_report(
        &mut self,
        effort: EffortState,
        duration_s: f64,
        on_event: &mut impl FnMut(Event),
    ) {
        let put_out_v = self.behind_dead_time(self.supply_ratio * effort.volts);
        let is_driven = effort.is_on && !self.is_unpowered;
        let reaches = is_driven && self.motor_wires == MotorWires::Sound;
        let effort_v = if reaches { put_out_v / self.resistance_ratio } else { 0.0 };
        self.open_or_close(is_driven);
        let [held_v, lag_left_v] = self.lagged(effort_v, duration_s);
        let before = (self.current_a, self.solver.motor_velocity());
        self.hold(held_v + self.load_v, duration_s, on_event);
        let Some(winding) = self.heated_winding() else { return };
        let left_v = self.solver.effort_left() + lag_left_v;
        let speed = self.solver.motor_velocity();
        self.current_a = match self.motor_wires {
            MotorWires::Open => 0.0,
            MotorWires::Shorted if is_driven => put_out_v / SHORT_OHM,
            MotorWires::Sound if is_driven => winding.current_a(effort_v + left_v, speed),
            // The diodes of the bridge conduct until the current has ended.
            MotorWires::Sound | MotorWires::Shorted => left_v / winding.resistance_ohm,
        };
        if is_driven {
            let mean_a = if reaches && self.solver.effort_left() == 0.0 {
                winding.current_a(held_v, 0.5 * (before.1 + speed))
            } else {
                0.5 * (before.0 + self.current_a)
            };
            self.drawn_j += put_out_v * mean_a * duration_s;
        }
        self.heat_up([before.0, self.current_a], winding.resistance_ohm, duration_s);
    }

    /// Returns the winding at its present temperature.
    fn heated_winding(&self) -> Option<Winding> {
        self.winding.map(|winding| winding.heated(self.resistance_ratio))
    }

    /// Adds the copper loss of a time (s) in which the current has gone from one value to another,
    /// A; once a sample, computes temperatures and resistance anew.
    fn heat_up(&mut self, [from_a, to_a]: [f64; 2], resistance_ohm: f64, duration_s: f64) {
        let Some(heat) = &mut self.heat else { return };
        // A current through a short behind the sensor is not that of the winding.
        if self.motor_wires != MotorWires::Shorted {
            let mean_square = (from_a * from_a + from_a * to_a + to_a * to_a) / 3.0;
            heat.loss_j += mean_square * resistance_ohm * self.resistance_ratio * duration_s;
        }
        heat.since_s += duration_s;
        // The periods of the PWM add up to a sample except for rounding.
        if heat.since_s < self.sample_time_s * (1.0 - 1e-6) {
            return;
        }
        heat.temperatures.advance(&heat.path, heat.loss_j, heat.since_s);
        (heat.loss_j, heat.since_s) = (0.0, 0.0);
        self.resistance_ratio = heat.temperatures.resistance_ratio();
    }

    /// Returns the mean voltage of a bridge for a duty of this voltage (V): less by the dead time,
    /// against the current. A current that the loss would reverse is zero. At a duty of zero volts
    /// the current ripples through zero, and nothing is lost. That holds below half the ripple,
    /// 0.5 A for 48 V, 20 kHz and 1.26 mH; a short brake of a larger current loses the voltage as
    /// well, which this plant leaves out, so a joint stops after less travel here.
    fn behind_dead_time(&self, volts: f64) -> f64 {
        let Some(winding) = self.winding.filter(|winding| winding.dead_time_v > 0.0) else {
            return volts;
        };
        let lost_v = self.supply_ratio * winding.dead_time_v;
        let induced_v = winding.back_emf_v_per_deg_per_s * self.solver.motor_velocity();
        let drives_v = volts - induced_v;
        // Behind an inductance, a current flows on against a voltage that has changed its sign.
        let has_lag = winding.lag_s > 0.0 || self.solver.effort_left() != 0.0;
        if volts == 0.0 {
            volts
        } else if has_lag && self.current_a * drives_v < 0.0 {
            volts - lost_v.copysign(self.current_a)
        } else {
            induced_v + shrink(drives_v, lost_v)
        }
    }

    /// Opens the winding if no current can flow, and closes it otherwise.
    fn open_or_close(&mut self, is_driven: bool) {
        let Some(winding) = &self.winding else { return };
        let is_open = match self.motor_wires {
            MotorWires::Sound => !is_driven,
            MotorWires::Open => true,
            MotorWires::Shorted => false,
        };
        // A closed winding that is hot brakes by the back-EMF over r.
        let share = if is_open { 1.0 } else { 1.0 - 1.0 / self.resistance_ratio };
        let back_emf = winding.back_emf_v_per_deg_per_s * share;
        self.solver.open_winding(back_emf);
    }

    /// Returns the mean over a time (s) of an effort (V) behind the lag of the winding, and what is
    /// left of the former effort at its end, V.
    fn lagged(&mut self, effort_v: f64, duration_s: f64) -> [f64; 2] {
        let lag_s = self.heated_winding().map_or(0.0, |winding| winding.lag_s);
        if lag_s <= 0.0 || duration_s <= 0.0 {
            return [effort_v, 0.0];
        }
        let left_v = self.lagged_v - effort_v;
        let keeps = (-duration_s / lag_s).exp();
        self.lagged_v = effort_v + left_v * keeps;
        [effort_v + left_v * lag_s / duration_s * (1.0 - keeps), left_v * keeps]
    }

    /// Moves the joint for a time (s) under a held effort (V), which includes any load.
    #[inline]
    pub fn hold(&mut self, effort_v: f64, duration_s: f64, on_event: &mut impl FnMut(Event)) {
        // Whole samples are counted, so that rounding errors do not accumulate.
        let time_s = self.time_s + self.samples as f64 * self.sample_time_s;
        self.hold_from(effort_v, [time_s, duration_s], on_event);
        if duration_s == self.sample_time_s {
            self.samples += 1;
        } else {
            self.time_s += duration_s;
        }
    }

    /// Moves the joint under a held effort (V); `span_s` is the start and the length, s.
    #[inline]
    pub fn hold_from(&mut self, effort_v: f64, span_s: [f64; 2], on_event: &mut impl FnMut(Event)) {
        hold(&mut self.solver, &self.axis, [effort_v, self.brake_v], span_s, on_event);
    }
}

impl<S: AxisSolver + Clone> Plant<S> {
    /// Returns the positions of the discs after an effort (V) is held; `span_s` is the start and
    /// the length, s.
    pub fn discs_after(&self, effort_v: f64, span_s: [f64; 2]) -> Discs {
        let mut ahead = self.solver.clone();
        hold(&mut ahead, &self.axis, [effort_v, self.brake_v], span_s, &mut |_| {});
        self.discs_of(&ahead)
    }
}

/// Moves an axis under a held effort; the time is split where the friction changes.
#[inline]
fn hold(
    solver: &mut impl AxisSolver,
    axis: &RobotAxis,
    [effort_v, brake_v]: [f64; 2],
    [time_s, duration_s]: [f64; 2],
    on_event: &mut impl FnMut(Event),
) {
    // A change this close to a sample is at the sample: k h can differ from the written decimal.
    const SAME_TIME_S: f64 = 1e-9;
    let end_s = time_s + duration_s;
    let mut from_s = time_s;
    while let Some(change_s) = axis.added.next_change(from_s + SAME_TIME_S, end_s - SAME_TIME_S) {
        stretch(solver, axis, [effort_v, brake_v], [from_s, change_s - from_s], on_event);
        from_s = change_s;
    }
    // Usually the whole sample, bit for bit: the solver has prepared that interval.
    let rest_s = if from_s == time_s { duration_s } else { end_s - from_s };
    stretch(solver, axis, [effort_v, brake_v], [from_s, rest_s], on_event);
}

/// Moves an axis under a held effort while its friction stays the same.
// Called out of line it costs an eighth of the closed loop.
#[inline(always)]
fn stretch(
    solver: &mut impl AxisSolver,
    axis: &RobotAxis,
    [effort_v, brake_v]: [f64; 2],
    [from_s, duration_s]: [f64; 2],
    on_event: &mut impl FnMut(Event),
) {
    // In the middle, so that the rounding of the ends does not affect the friction.
    let friction = axis.friction_at(from_s + 0.5 * duration_s).raised(brake_v);
    solver.advance(effort_v, duration_s, &friction, &mut |event| {
        on_event(Event { time_s: from_s + event.time_s, ..event });
    });
}

/// Returns the counts of a disc at a position (deg), in the direction of its counter.
fn disc_at(encoder: &EncoderModel, position_deg: f64) -> i64 {
    let counts = encoder.counts(position_deg);
    match encoder.direction {
        Direction::Forward => counts,
        Direction::Reverse => -counts,
    }
}
