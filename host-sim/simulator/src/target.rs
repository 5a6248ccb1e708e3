//! Drivers of a plant, sample by sample: the bare control loop, the servo around it, or the flash
//! image.
//!
//! ```text
//! counters -> Target::tick -> Tick (its code goes to the bridge) -> the plant moves on -> counters
//! ```
//!
//! [`ClosedLoop`](crate::closed_loop::ClosedLoop) steps each of them against a
//! [`Plant`]. The flash image in lockstep is `emulator/side_by_side.rs`.

use stiction::control::controller::EffortMode;
use stiction::control::current_loop::CurrentTarget;
use stiction::control::current_sensor::CurrentSensor;
use stiction::control::encoder::EncoderState;
use stiction::control::profile::Profile;
use stiction::control::reference::Reference;
use stiction::safety::fault::LatchedFault;
use stiction::servo::{Boot, Input, Refusal, State};
use stiction::{Controller, Course, CourseState, Motion, Parameters, Reading, Servo, Tick};

use crate::counters::Counters;
use crate::current_periods::{
    BareCurrentLoop, BridgeCommand, CurrentPeriods, PlantMotor, RegulatedTick, SensedMotor,
};
use crate::plant::{DelayLine, Plant};
use crate::shunt::Shunt;
use dynamics::solver::{AxisSolver, Event};
use files::error::Error;
use files::hardware::STM32F405;

/// A driver of a plant: computes a duty from the encoders' counters in each sample.
pub trait Target {
    /// Runs one tick; returns `None` at the end of the motion.
    fn tick(&mut self, counters: Counters) -> Option<Tick>;

    /// Moves the plant to the next sample under the effort of a tick, V: that of the code that
    /// takes effect now.
    #[inline(always)]
    fn drive<S: AxisSolver>(
        &mut self,
        plant: &mut Plant<S>,
        _tick: &Tick,
        effort_v: f64,
        on_event: &mut impl FnMut(Event),
    ) {
        plant.hold_effort(effort_v, on_event);
    }
}

/// The control loop alone: no soft start, no monitors.
#[derive(Clone, Debug)]
pub struct BareLoop<'a> {
    controller: &'a Controller,
    course: Course,
    encoder: EncoderState,
    /// State of the motor's own encoder, from the first tick on.
    motor: Option<EncoderState>,
    /// State of the core.
    pub state: CourseState,
}

impl<'a> BareLoop<'a> {
    /// Creates a loop with the joint at rest at `counts` and its counter at `counter`.
    pub fn new(controller: &'a Controller, course: &'a Course, counter: u32, counts: i32) -> Self {
        let encoder = EncoderState::start(counter, counts);
        let course = course.clone();
        let state = CourseState::start(controller, counts);
        Self { controller, course, encoder, motor: None, state }
    }

    /// Runs one tick; also returns whether a ramp has already ended.
    #[inline(always)]
    pub fn follow(&mut self, counters: Counters) -> (Tick, bool) {
        self.controller.encoder().update(&mut self.encoder, counters.position);
        let mut reading = Reading::position(self.encoder.counts());
        if let (Some(encoder), Some(counter)) = (self.controller.motor_encoder(), counters.motor) {
            let state = self.motor.get_or_insert(EncoderState::start(counter, 0));
            encoder.update(state, counter);
            reading.motor_counts = state.counts();
        }
        let tick = self.course.tick(self.controller, &mut self.state, reading);
        let is_over = self.state.is_over(&self.course);
        (tick, is_over)
    }
}

impl Target for BareLoop<'_> {
    #[inline(always)]
    fn tick(&mut self, counters: Counters) -> Option<Tick> {
        let (tick, is_over) = self.follow(counters);
        (!is_over).then_some(tick)
    }
}

/// The control loop with a current loop behind it: no soft start, no monitors. A type of its own
/// keeps the loop without one fast.
#[derive(Clone, Debug)]
pub struct RegulatedLoop<'a> {
    /// The control loop.
    pub bare: BareLoop<'a>,
    /// The current loop, which makes currents of its efforts.
    pub current_loop: BareCurrentLoop,
}

impl Target for RegulatedLoop<'_> {
    fn tick(&mut self, counters: Counters) -> Option<Tick> {
        let tick = self.bare.tick(counters)?;
        Some(Tick { current: self.current_loop.current(), ..tick })
    }

    fn drive<S: AxisSolver>(
        &mut self,
        plant: &mut Plant<S>,
        tick: &Tick,
        effort_v: f64,
        on_event: &mut impl FnMut(Event),
    ) {
        self.current_loop.drive(plant, tick, plant.code(effort_v), on_event);
    }
}

/// The servo of a device, with soft start, all monitors, and a nominal supply.
#[derive(Clone, Debug)]
pub struct WatchedServo {
    servo: Servo,
    /// Converter's reading of the supply, and of the nominal one.
    supply: u16,
    nominal_supply: u16,
    /// Converter's reading of the motor's current.
    current: u16,
    shunt: Shunt,
    periods: CurrentPeriods,
    /// Command of the last tick for the current loop, if the effort is a current.
    regulated: Option<RegulatedTick>,
    /// Position at arming, in counts of the host; it is zero for the servo.
    start: i32,
    ticks: u32,
    /// Whether a link sends its references.
    is_led: bool,
    /// Last tick.
    followed: Tick,
    /// Fault that ended the motion, and the number of its tick.
    pub fault: Option<(LatchedFault, u32)>,
}

/// Largest number of ticks until the servo detects rest: at least 50 ms with a tick of 0.1 ms or
/// more.
const LONGEST_REST: u32 = 1000;

impl WatchedServo {
    /// Creates an armed servo with the joint at rest at `counts` and its counters at `counters`. It
    /// has a sensor of its motor's current if its efforts are currents.
    ///
    /// # Errors
    /// Returns an error if the servo refuses to be armed.
    pub fn new(mut parameters: Parameters, counters: Counters, counts: i32) -> Result<Self, Error> {
        if parameters.controller.effort == EffortMode::Voltage {
            parameters.current = CurrentSensor::NONE;
        }
        let mut shunt = Shunt::of(&parameters.current);
        let reading = shunt.reading(0.0);
        parameters.device.autostart = false;
        // A run begins with its motion.
        parameters.device.arming_test = 0.0;
        from_start(&mut parameters.motion, counts);
        let device = &parameters.device;
        // Without a nominal value, the middle of the converter's range.
        let share = device.nominal_supply / device.supply_full_scale;
        let share = if share > 0.0 { share } else { 0.5 };
        let supply = (share * f32::from(STM32F405.supply_top)).round() as u16;
        let mut servo = Servo::new(Ok(&parameters), Boot::at_zero(), &STM32F405);
        for _ in 0..LONGEST_REST {
            servo.tick(Input { current: reading, ..counters.input(supply) });
            if servo.is_at_rest() {
                break;
            }
        }
        match servo.arm() {
            Ok(()) => Ok(Self {
                servo,
                supply,
                nominal_supply: supply,
                current: reading,
                shunt,
                periods: CurrentPeriods::default(),
                regulated: None,
                start: counts,
                ticks: 0,
                is_led: false,
                followed: Tick::default(),
                fault: None,
            }),
            Err(refusal) => {
                Err(Error::Input(format!("the servo refuses to be armed: {refusal:?}")))
            }
        }
    }

    /// Sets another reference from the next tick on, in counts from the position at arming, as a
    /// link that never times out would do.
    ///
    /// # Errors
    /// Returns the refusal of the servo, for example if it has tripped.
    pub fn follow(&mut self, reference: Reference) -> Result<(), Refusal> {
        self.is_led = true;
        self.servo.follow(reference)
    }

    /// Moves to the target of a profile from the next tick on, in counts from the position at
    /// arming, as a link that never times out would do.
    ///
    /// # Errors
    /// Returns the refusal of the servo, for example if it has tripped.
    pub fn go_to(&mut self, profile: Profile) -> Result<(), Refusal> {
        self.is_led = true;
        self.servo.go_to(profile)
    }

    /// Drives a motor by the current loop until the next tick, `sample_time_s` later, with a
    /// computation delay of the targets. Does nothing if the effort is a voltage.
    pub fn regulate(
        &mut self,
        motor: &mut impl SensedMotor,
        sample_time_s: f64,
        delay: &mut DelayLine<CurrentTarget>,
    ) {
        let Some(mut regulated) = self.regulated else { return };
        if let BridgeCommand::Regulate(target) = &mut regulated.command {
            *target = delay.put(*target);
        }
        self.periods.pass(motor, sample_time_s, regulated);
        self.current = self.periods.reading();
    }

    /// Returns the friction levels that a ramp has found.
    pub fn levels(&self) -> Option<stiction::servo::FrictionLevels> {
        self.servo.levels()
    }
}

impl Target for WatchedServo {
    fn tick(&mut self, counters: Counters) -> Option<Tick> {
        let was_armed = self.servo.state() == State::Armed;
        let before = self.servo.position();
        if self.is_led {
            self.servo.heard();
        }
        if let Some(reading) = self.periods.take_trip() {
            self.servo.over_current(reading);
        }
        let output =
            self.servo.tick(Input { current: self.current, ..counters.input(self.supply) });
        self.regulated = RegulatedTick::of(&mut self.servo, &output, self.periods.voltage());
        let mut tick = output.tick;
        if was_armed && let Some(latched) = self.servo.latched() {
            self.fault = Some((latched, self.ticks));
        }
        self.ticks += 1;
        if was_armed {
            tick.counts = tick.counts.wrapping_add(self.start);
            tick.reference_counts = tick.reference_counts.wrapping_add(self.start);
        } else {
            // The last reference stays, so that the error of a released joint is visible.
            let travel = self.servo.position().wrapping_sub(before);
            tick.counts = self.followed.counts.wrapping_add(travel);
            tick.reference_counts = self.followed.reference_counts;
            tick.reference_fraction = self.followed.reference_fraction;
        }
        self.followed = tick;
        Some(tick)
    }

    fn drive<S: AxisSolver>(
        &mut self,
        plant: &mut Plant<S>,
        _tick: &Tick,
        effort_v: f64,
        on_event: &mut impl FnMut(Event),
    ) {
        let sample_time_s = plant.sample_time_s();
        // The next tick reads the conversion that this one has started.
        let supply = (plant.supply_ratio * f64::from(self.nominal_supply)).round();
        self.supply = supply.min(f64::from(STM32F405.supply_top)) as u16;
        let Some(mut regulated) = self.regulated else {
            plant.hold_effort(effort_v, on_event);
            return;
        };
        if let BridgeCommand::Regulate(target) = &mut regulated.command {
            target.effort = plant.code(effort_v);
        }
        let mut motor = PlantMotor { plant, shunt: &mut self.shunt, on_event };
        self.periods.pass(&mut motor, sample_time_s, regulated);
        self.current = self.periods.reading();
    }
}

/// Converts the positions of a motion to counts from the position at arming; `start` is that
/// position, counts.
pub fn from_start(motion: &mut Motion, start: i32) {
    let shift = |counts: &mut i32| *counts = counts.wrapping_sub(start);
    match motion {
        Motion::Hold | Motion::Ramp { .. } => {}
        Motion::Step(at) | Motion::Profiled(at) | Motion::Sine { from: at, .. } => {
            shift(&mut at.counts);
        }
        Motion::Trajectory { corners, .. } => {
            corners.iter_mut().for_each(|corner| shift(&mut corner.position.counts));
        }
    }
}
