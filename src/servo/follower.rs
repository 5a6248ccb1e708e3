//! The follower: it keeps the position and standstill of the joint, whether or not the loop is
//! closed.

#[cfg(feature = "two-encoders")]
use super::ControlLoop;
use super::Input;
use crate::control::controller::Controller;
#[cfg(feature = "two-encoders")]
use crate::control::encoder::Encoder;
use crate::control::encoder::EncoderState;
#[cfg(feature = "two-encoders")]
use crate::safety::monitor::SeenMotor;
use crate::safety::monitor::{Seen, Standstill};

/// Position and standstill of the joint, and reading of the supply, in the last tick, armed or not.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Follower {
    /// State of the encoder that measures the position: of two, that of the load. None before the
    /// first tick.
    pub encoder: Option<EncoderState>,
    standstill: Standstill,
    pub seen: Seen,
    pub supply: u16,
    /// Position of the motor, if it has its own encoder.
    #[cfg(feature = "two-encoders")]
    motor: Option<MotorFollower>,
    /// Ticks in a row without a valid answer of the load's encoder.
    #[cfg(feature = "two-encoders")]
    pub missing: u32,
}

/// Position and standstill of a motor with its own encoder.
#[cfg(feature = "two-encoders")]
#[derive(Clone, Copy, Debug)]
struct MotorFollower {
    encoder: EncoderState,
    standstill: Standstill,
}

#[cfg(feature = "two-encoders")]
impl MotorFollower {
    /// Returns the readings of the motor's encoder, given a reading of its counter.
    fn update(&mut self, encoder: &Encoder, counter: u32) -> SeenMotor {
        let travel = encoder.update(&mut self.encoder, counter);
        let position = self.encoder.counts();
        SeenMotor { travel, position, standstill: self.standstill.update(position) }
    }
}

impl Follower {
    #[inline]
    pub fn update(&mut self, controller: &Controller, input: Input) {
        let counter = input.counter;
        #[cfg(feature = "two-encoders")]
        let (counter, motor, missed) = match controller.motor_encoder() {
            Some(encoder) => {
                // Both sides begin at the position of the joint with one encoder: the monitors of
                // the effort must not take the change of the counter for travel.
                let first = MotorFollower {
                    encoder: EncoderState::start(counter, self.seen.position),
                    standstill: Standstill::default(),
                };
                let of_motor = self.motor.get_or_insert(first);
                let of_motor = of_motor.update(encoder, counter);
                if input.load.is_missing {
                    self.keep(of_motor, input.supply);
                    return;
                }
                let missed = core::mem::take(&mut self.missing);
                (input.load.counter, Some(of_motor), missed)
            }
            None => (counter, None, 0),
        };
        let state = self.encoder.get_or_insert(EncoderState::start(counter, self.seen.position));
        let travel = controller.encoder().update(state, counter);
        let position = state.counts();
        self.seen = Seen {
            travel,
            position,
            standstill: self.standstill.update(position),
            #[cfg(feature = "two-encoders")]
            motor,
            #[cfg(feature = "two-encoders")]
            missed,
        };
        self.supply = input.supply;
    }

    /// Keeps the position of the load in a tick without its encoder. The travel of the next answer
    /// is then that of all ticks since the last one.
    // Out of line: no tick of a sound encoder comes here.
    #[cfg(feature = "two-encoders")]
    #[cold]
    #[inline(never)]
    fn keep(&mut self, of_motor: SeenMotor, supply: u16) {
        self.missing = self.missing.saturating_add(1);
        (self.seen.travel, self.seen.motor, self.supply) = (0, Some(of_motor), supply);
    }

    /// Returns the position of the encoder with an index in the last tick, and the one at a reading
    /// of its counter since then, counts; without a reading, the first twice. Of two encoders, it
    /// is the motor's. None before the first tick.
    pub fn at(&self, controller: &Controller, counter: Option<u32>) -> Option<[i32; 2]> {
        #[cfg(feature = "two-encoders")]
        let (encoder, state) = match controller.motor_encoder() {
            Some(encoder) => (encoder, self.motor.map(|motor| motor.encoder)),
            None => (controller.encoder(), self.encoder),
        };
        #[cfg(not(feature = "two-encoders"))]
        let (encoder, state) = (controller.encoder(), self.encoder);
        let before = state?;
        let mut after = before;
        encoder.update(&mut after, counter.unwrap_or(before.counter()));
        Some([before.counts(), after.counts()])
    }

    /// Returns the position of the joint that its own encoder shows, and the one after a travel of
    /// the encoder with an index since the last tick, counts. Of two encoders, the load's has its
    /// count of the last tick and goes on with the motor: its twist changes little in a tick. `None`
    /// if the load's encoder has not answered in the last tick.
    pub fn joint_after(&self, controller: &Controller, way: i32) -> Option<[i32; 2]> {
        #[cfg(feature = "two-encoders")]
        if let Some(motor) = controller.motor_encoder() {
            let way_deg = way as f32 * motor.resolution;
            let way = libm::roundf(way_deg / controller.encoder().resolution);
            let position = self.seen.position;
            return (self.missing == 0).then_some([position, position.wrapping_add(way as i32)]);
        }
        #[cfg(not(feature = "two-encoders"))]
        let _ = controller;
        Some([self.seen.position.wrapping_add(way); 2])
    }

    /// Restarts the count of ticks at standstill.
    pub fn unsettle(&mut self) {
        self.standstill = Standstill::default();
        self.seen.standstill = 0;
        #[cfg(feature = "two-encoders")]
        if let (Some(of_motor), Some(seen)) = (&mut self.motor, &mut self.seen.motor) {
            of_motor.standstill = Standstill::default();
            seen.standstill = 0;
        }
    }

    /// Forgets the readings of the counters if another encoder measures the position with the new
    /// parameters, or another one the motor, and returns whether that is so: the difference of two
    /// counters is no travel.
    #[cfg(feature = "two-encoders")]
    pub fn change(&mut self, before: &ControlLoop, after: &ControlLoop) -> bool {
        let has_two = |of: &ControlLoop| of.controller.motor_encoder().is_some();
        let has_other_kind = before.absolute.is_some() != after.absolute.is_some();
        let changes = has_two(before) != has_two(after) || has_other_kind;
        if changes {
            if has_two(before) != has_two(after) {
                self.seen.position = self.seen.driven().position;
            }
            self.encoder = None;
            (self.motor, self.seen.motor, self.missing) = (None, None, 0);
        }
        changes
    }
}
