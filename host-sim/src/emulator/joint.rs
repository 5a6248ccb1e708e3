//! The simulated joint on the board, and the core that replays what the image does.
//!
//! The joint is driven by what the image put out, never by what the replay says it should have: the replay is there to
//! find a difference at the tick where it happens, and to give the terms of a tick that no pin shows.

use stiction::{ControllerState, Tick};

use super::bridge::{Bridge, code_of};
use super::compare::Difference;
use crate::closed_loop::{ClosedLoop, Delay, Moment, hold};
use crate::solver::{AxisSolver, Event};

/// A joint that is wired to an image.
#[derive(Debug)]
pub struct Joint<S> {
    /// What the host would run.
    pub closed_loop: ClosedLoop,
    /// The motion.
    pub solver: S,
    /// Every tick of the motion so far.
    pub moments: Vec<Moment>,
    /// Breaks, sticks and reversals so far.
    pub events: Vec<Event>,
    /// When a state was no longer finite.
    pub diverged_at_s: Option<f64>,
    samples: u32,
    replay: Option<ControllerState>,
    previous_code: i16,
}

impl<S: AxisSolver> Joint<S> {
    /// A joint at rest, for a motion of `samples` samples after the first.
    pub fn new(closed_loop: ClosedLoop, solver: S, samples: u32) -> Self {
        let moments = Vec::with_capacity(samples as usize + 1);
        Self {
            closed_loop,
            solver,
            moments,
            events: Vec::new(),
            diverged_at_s: None,
            samples,
            replay: None,
            previous_code: 0,
        }
    }

    /// Where the disc is, in counts of the hardware counter before it wraps.
    pub fn disc(&self) -> i64 {
        self.disc_at(self.solver.position())
    }

    /// Where the disc is when the joint is at `position`.
    pub fn disc_at(&self, position: f64) -> i64 {
        let counts = self.closed_loop.encoder.counts(position);
        match self.closed_loop.encoder.direction {
            stiction::encoder::Direction::Forward => counts,
            stiction::encoder::Direction::Reverse => -counts,
        }
    }

    /// Whether the motion has begun.
    pub const fn has_begun(&self) -> bool {
        self.replay.is_some()
    }

    /// Whether there is nothing left to run.
    pub fn has_ended(&self) -> bool {
        self.diverged_at_s.is_some() || self.moments.len() > self.samples as usize
    }

    /// Time of the next tick since the motion began, s, as the host counts it.
    pub fn time_s(&self) -> f64 {
        self.moments.len() as f64 * self.closed_loop.sample_time_s
    }

    /// Takes what the image read and put out in one tick; `at_tick` is the joint at that instant. Returns the code that
    /// the D/A holds from now on.
    ///
    /// # Errors
    /// If the core, given the same counts, puts out something else.
    pub fn tick(&mut self, counter: u32, bridge: &Bridge, at_tick: &S) -> Result<i16, Box<Difference>> {
        let closed_loop = &self.closed_loop;
        let time_s = self.time_s();
        if !(at_tick.position().is_finite() && at_tick.velocity().is_finite()) {
            self.diverged_at_s = Some(time_s);
            return Ok(0);
        }
        let controller = &closed_loop.controller;
        let replay = self.replay.get_or_insert_with(|| {
            controller.start(counter, closed_loop.encoder.counts(at_tick.position()) as i32)
        });
        let host = controller.tick(replay, counter, &closed_loop.reference);
        let drive = controller.drive();
        let duty = bridge.duty(drive.mode());
        let code = code_of(duty, drive, host.code);
        let image = Tick { duty, code: code.unwrap_or(i16::MIN), ..host };
        if image != host && !host.non_finite {
            let index = self.moments.len();
            return Err(Box::new(Difference { index, host: Some(host), image: Some(image) }));
        }
        let code = match closed_loop.delay {
            Delay::None => image.code,
            Delay::OneSample => std::mem::replace(&mut self.previous_code, image.code),
        };
        self.moments.push(closed_loop.moment(time_s, image, code, at_tick));
        Ok(code)
    }

    /// Moves the joint on from `time_s` for `duration_s` under a held effort.
    pub fn drive(&mut self, v: f64, time_s: f64, duration_s: f64) {
        let events = &mut self.events;
        hold(&mut self.solver, &self.closed_loop.axis, v, [time_s, duration_s], &mut |event| {
            events.push(event)
        });
    }
}
