//! The short brake: after a fault, the bridge stays on at zero volts for a bounded time, so that
//! the back-EMF brakes the joint.
//!
//! ```text
//!           a fault of a tick             short_brake_s
//!  bridge   ~~~~|~~~~~ neutral duty ~~~~~~~~~~|____ off
//!  state    armed|faulted ...
//!  current       i = -k_e v / R, which decays with the speed
//!
//!  J v' = -F sgn(v) - (b + k_e) v       short brake;  b: mechanical friction, V s/deg
//!  J v' = -F sgn(v) - b v               the bridge is off: the joint coasts
//! ```
//!
//! The neutral duty turns both low sides on (sign-magnitude), or is half (locked antiphase). The
//! loop does not run. No encoder and no law takes part, so the brake is for their faults, too.
//! [`Fault::reaction`] has the faults with a short brake, and the reasons. The fault is latched and
//! reported at its start, and the holding brake closes at its start.
//!
//! It ends after `short_brake_s`, counted in ticks, whether the joint rests or not: an encoder that
//! has failed reads as rest. It ends at once with a stop, a fault that has no short brake, the
//! clearing of the fault, other parameters, a measured current beyond `peak_a` by a quarter, and a
//! supply outside its limits. Of the monitors, only that of the supply goes on. The watchdog of
//! the converter stays on. Under a current loop the duty is neutral and the loop does not regulate.
//!
//! Guarantees: the effort is zero, and the bridge is off after `short_brake_s`. Does badly: without
//! a sensor, only the resistance of the winding limits the current; at a speed whose back-EMF
//! exceeds `1.25 R peak_a` a joint with a sensor is braked for a tick and then coasts. A load that
//! drives the joint is slowed down, not held.
//!
//! The current heats the winding, and the heat counts as that of any other current: `(R i)^2` of
//! the measured current, or `(k_e v)^2` of the travel without a sensor. It trips nothing while it
//! brakes, and forbids arming if it is beyond `continuous_v`. Without a sensor, an encoder that has
//! failed counts no heat, and a travel of few counts a tick counts up to twice its heat.

use super::stopping::{Phase, Transition};
use super::{BrakeCommand, Input, Output, Servo, State};
use crate::control::signal::Tick;
use crate::safety::fault::{Fault, Reaction};

impl Servo {
    /// Returns the number of ticks of short brake that a fault starts now; 0: the output goes off.
    pub(super) fn short_brake_of(&self, fault: Fault) -> u32 {
        let brakes = match fault.reaction() {
            Reaction::Off => false,
            Reaction::ShortBrake => true,
            // A joint that the loop has braked needs nothing else.
            Reaction::Stop => !self.is_stopping(),
        };
        let is_driven = self.state == State::Armed && !self.wake_up.is_on();
        match &self.control_loop {
            Some(control_loop) if brakes && is_driven => control_loop.holding_brake.short(),
            _ => 0,
        }
    }

    /// Begins a short brake of this number of ticks, if it is not 0.
    pub(super) fn begin_short_brake(&mut self, left: u32) {
        if left > 0 {
            self.transition = Some(Transition { phase: Phase::ShortBrake, left, fault: None });
        }
    }

    /// Returns the output of the tick in which a fault has been latched.
    #[cold]
    #[inline(never)]
    pub(super) fn tripped(&mut self, tick: &Tick) -> Output {
        let off = self.off(*tick);
        let Some(Transition { phase: Phase::ShortBrake, left, .. }) = &mut self.transition else {
            return off;
        };
        *left = left.saturating_sub(1);
        if *left == 0 {
            // The next tick is the first one with the output off.
            self.transition = None;
        }
        let output = self.output(off.tick, true, false);
        output.with_brake(BrakeCommand::Closed)
    }

    /// Runs a tick of the short brake: all that a tick with the output off does, but what needs a
    /// winding without current and an enable pin that is low.
    #[cold]
    #[inline(never)]
    pub(super) fn brake_short(&mut self, input: Input) -> Output {
        // The motor has moved the joint, and not a hand.
        self.encoder_proof = self.encoder_proof.after_drive();
        let mut tick = Tick::default();
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.monitors.idle(&mut control_loop.watch, &self.follower.seen);
            if control_loop.monitors.is_supply_out(input.supply) {
                self.transition = None;
            }
            let mut heats = None;
            if let Some(path) = &mut control_loop.current {
                let is_beyond = path.brakes_beyond(input.current);
                tick.current = path.current();
                heats = Some(path.brake_volts());
                if is_beyond {
                    self.transition = None;
                }
            }
            control_loop.monitors.brake(&mut control_loop.watch, &self.follower.seen, heats);
        }
        self.tripped(&tick)
    }
}
