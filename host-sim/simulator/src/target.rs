//! What drives a plant, sample by sample: the bare control loop, the servo around it, or the flash
//! image.
//!
//! ```text
//! counter -> Target::tick -> Tick (its code goes to the bridge) -> the plant moves on -> counter
//! ```
//!
//! [`ClosedLoop`](crate::closed_loop::ClosedLoop) steps each of them against a
//! [`Plant`](crate::plant::Plant). The flash image in lockstep is `emulator/side_by_side.rs`.

use stiction::control::encoder::EncoderState;
use stiction::control::reference::Reference;
use stiction::safety::fault::Latched;
use stiction::servo::{Boot, Input, Refusal, State};
use stiction::{Controller, Course, CourseState, Motion, Parameters, Reading, Servo, Tick};

use crate::error::Error;
use crate::hardware::STM32F405;

/// Something that is given the encoder's counter and answers with a duty.
pub trait Target {
    /// One tick; none if there is nothing left to do.
    fn tick(&mut self, counter: u32) -> Option<Tick>;
}

/// The control loop alone: no soft start, no monitors.
#[derive(Clone, Debug)]
pub struct BareLoop<'a> {
    controller: &'a Controller,
    course: Course,
    encoder: EncoderState,
    /// Of the core.
    pub state: CourseState,
}

impl<'a> BareLoop<'a> {
    /// With the joint at rest at `counts`, where its counter reads `counter`.
    pub fn new(controller: &'a Controller, course: &'a Course, counter: u32, counts: i32) -> Self {
        let encoder = EncoderState::start(counter, counts);
        let course = course.clone();
        Self { controller, course, encoder, state: CourseState::start(controller, counts) }
    }

    /// One tick, and whether it was one more than a ramp has.
    #[inline]
    pub fn follow(&mut self, counter: u32) -> (Tick, bool) {
        self.controller.encoder().update(&mut self.encoder, counter);
        let reading = Reading::position(self.encoder.counts());
        let tick = self.course.tick(self.controller, &mut self.state, reading);
        let is_over = self.state.is_over(&self.course);
        (tick, is_over)
    }
}

impl Target for BareLoop<'_> {
    #[inline]
    fn tick(&mut self, counter: u32) -> Option<Tick> {
        let (tick, is_over) = self.follow(counter);
        (!is_over).then_some(tick)
    }
}

/// The servo as a device runs it, with its soft start and all of its monitors, and a supply that is
/// nominal.
#[derive(Clone, Debug)]
pub struct WatchedServo {
    servo: Servo,
    supply: u16,
    /// Where it was armed, in the counts of the host; the servo calls it zero.
    start: i32,
    ticks: u32,
    /// A link has taken over.
    is_led: bool,
    /// The last tick.
    followed: Tick,
    /// The fault that ended the motion, and the number of the tick in which it did.
    pub fault: Option<(Latched, u32)>,
}

/// So many ticks of 0.1 ms are 50 ms and more: the servo has seen its joint at rest.
const LONGEST_REST: u32 = 1000;

impl WatchedServo {
    /// Armed, with the joint at rest at `counts`, where its counter reads `counter`.
    ///
    /// # Errors
    /// If the servo refuses to be armed.
    pub fn new(mut parameters: Parameters, counter: u32, counts: i32) -> Result<Self, Error> {
        parameters.device.autostart = false;
        from_start(&mut parameters.motion, counts);
        let device = &parameters.device;
        // Without a nominal value, the middle of the converter's range.
        let share = device.nominal_supply / device.supply_full_scale;
        let share = if share > 0.0 { share } else { 0.5 };
        let supply = (share * f32::from(STM32F405.supply_top)).round() as u16;
        let mut servo = Servo::new(Ok(&parameters), Boot::default(), &STM32F405);
        for _ in 0..LONGEST_REST {
            servo.tick(Input { counter, supply });
            if servo.is_at_rest() {
                break;
            }
        }
        match servo.arm() {
            Ok(()) => Ok(Self {
                servo,
                supply,
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

    /// Follows another reference from the next tick on, in counts from where it was armed, as a
    /// link asks for it that is never silent.
    ///
    /// # Errors
    /// If the servo refuses it; a servo that has tripped does.
    pub fn follow(&mut self, reference: Reference) -> Result<(), Refusal> {
        self.is_led = true;
        self.servo.follow(reference)
    }

    /// What a ramp has found.
    pub fn levels(&self) -> Option<stiction::servo::Levels> {
        self.servo.levels()
    }
}

impl Target for WatchedServo {
    fn tick(&mut self, counter: u32) -> Option<Tick> {
        let was_armed = self.servo.state() == State::Armed;
        let before = self.servo.position();
        if self.is_led {
            self.servo.heard();
        }
        let mut tick = self.servo.tick(Input { counter, supply: self.supply }).tick;
        if was_armed && let Some(latched) = self.servo.latched() {
            self.fault = Some((latched, self.ticks));
        }
        self.ticks += 1;
        if was_armed {
            tick.counts = tick.counts.wrapping_add(self.start);
            tick.reference_counts = tick.reference_counts.wrapping_add(self.start);
        } else {
            // What was asked for stays asked for, so that the error of a joint that was let go is
            // seen.
            let travel = self.servo.position().wrapping_sub(before);
            tick.counts = self.followed.counts.wrapping_add(travel);
            tick.reference_counts = self.followed.reference_counts;
            tick.reference_fraction = self.followed.reference_fraction;
        }
        self.followed = tick;
        Some(tick)
    }
}

/// A motion in the zero that arming sets, of a joint that is armed at `start` counts.
pub fn from_start(motion: &mut Motion, start: i32) {
    let shift = |counts: &mut i32| *counts = counts.wrapping_sub(start);
    match motion {
        Motion::Hold | Motion::Ramp { .. } => {}
        Motion::Step(to) | Motion::Profiled(to) => shift(&mut to.counts),
        Motion::Trajectory { corners, .. } => {
            corners.iter_mut().for_each(|corner| shift(&mut corner.position.counts));
        }
    }
}
