//! The simulated joint on the board, and the core that replays what the image does.
//!
//! The joint is driven by what the image put out, never by what the replay says it should have: the replay is there to
//! find a difference, in any term, at the tick where it happens.

use stiction::drive::Duty;
use stiction::encoder::EncoderState;
use stiction::{Course, CourseState, Reading, Tick};

use super::bridge::Bridge;
use super::compare::{Difference, same_bits};
use crate::closed_loop::{ClosedLoop, Delay, hold};
use crate::run::Trace;
use crate::solver::{AxisSolver, Event};

/// A joint that is wired to an image.
#[derive(Debug)]
pub struct Joint<S> {
    /// What the host would run.
    pub closed_loop: ClosedLoop,
    /// The motion.
    pub solver: S,
    /// Every tick of the motion so far.
    pub trace: Trace,
    /// Breaks, sticks and reversals so far.
    pub events: Vec<Event>,
    /// When a state was no longer finite.
    pub diverged_at_s: Option<f64>,
    course: Course,
    samples: u32,
    replay: Option<Replay>,
    previous_code: i16,
}

/// The core beside the image.
#[derive(Clone, Copy, Debug)]
struct Replay {
    state: CourseState,
    /// The counter, as the image reads it.
    counter: EncoderState,
    /// What the host calls the place where the image was armed; the image calls it zero.
    start: i32,
}

impl Replay {
    fn tick(&mut self, course: &Course, around: &ClosedLoop, counter: u32) -> Tick {
        let travel = around.controller.encoder().update(&mut self.counter, counter);
        course.tick(&around.controller, &mut self.state, Reading::travel(travel))
    }
}

impl<S: AxisSolver> Joint<S> {
    /// A joint at rest, for a motion of `samples` samples after the first. A ramp ends by itself.
    pub fn new(closed_loop: ClosedLoop, course: Course, solver: S, samples: u32) -> Self {
        let trace = match course {
            Course::Follow(_) => Trace::Loop(Vec::with_capacity(samples as usize + 1)),
            Course::Ramp(_) => Trace::Ramp(Vec::new()),
        };
        Self {
            closed_loop,
            solver,
            trace,
            events: Vec::new(),
            diverged_at_s: None,
            course,
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
        match self.trace {
            _ if self.diverged_at_s.is_some() => true,
            Trace::Loop(_) => self.ticks() > self.samples as usize,
            Trace::Ramp(_) => self.ramp().is_some_and(|state| state.is_over()),
        }
    }

    /// Whether a ramp is over with the tick that has read this from the counter.
    pub fn ends_with(&self, counter: u32) -> bool {
        match (&self.course, &self.replay) {
            (Course::Ramp(_), Some(replay)) => {
                let mut replay = *replay;
                replay.tick(&self.course, &self.closed_loop, counter);
                replay.state.ramp().is_over()
            }
            _ => false,
        }
    }

    /// What a ramp has come to.
    pub fn ramp(&self) -> Option<&stiction::identification::RampState> {
        self.replay.as_ref().map(|replay| replay.state.ramp())
    }

    /// Ticks of the motion so far.
    pub const fn ticks(&self) -> usize {
        match &self.trace {
            Trace::Loop(moments) => moments.len(),
            Trace::Ramp(moments) => moments.len(),
        }
    }

    /// Time of the next tick since the motion began, s, as the host counts it.
    pub fn time_s(&self) -> f64 {
        self.ticks() as f64 * self.closed_loop.sample_time_s
    }

    /// Takes what the image read, computed (`image`, from its memory) and put out in one tick; `at_tick` is the joint
    /// at that instant. Returns the code that the D/A holds from now on; none if the tick was the end of a ramp.
    ///
    /// # Errors
    /// If the core, given the same counts, computes something else, or if the pins are not what the image computed.
    pub fn tick(
        &mut self,
        counter: u32,
        bridge: &Bridge,
        image: Tick,
        at_tick: &S,
    ) -> Result<Option<i16>, Box<Difference>> {
        let (closed_loop, time_s, index) = (&self.closed_loop, self.time_s(), self.ticks());
        if !(at_tick.position().is_finite() && at_tick.velocity().is_finite()) {
            self.diverged_at_s = Some(time_s);
            return Ok(None);
        }
        let controller = &closed_loop.controller;
        let replay = self.replay.get_or_insert_with(|| {
            let start = closed_loop.encoder.counts(at_tick.position()) as i32;
            let state = CourseState::start(controller, start);
            Replay { state, counter: EncoderState::start(counter, start), start }
        });
        let host = replay.tick(&self.course, closed_loop, counter);
        let image = shown(from_zero_at(image, replay.start), bridge, closed_loop);
        if !same_bits(&host, &image) {
            return Err(Box::new(Difference { index, host: Some(host), image: Some(image) }));
        }
        let code = match &mut self.trace {
            Trace::Loop(moments) => {
                let code = match closed_loop.delay {
                    Delay::None => image.code,
                    Delay::OneSample => std::mem::replace(&mut self.previous_code, image.code),
                };
                moments.push(closed_loop.moment(time_s, image, code, at_tick));
                code
            }
            Trace::Ramp(_) if replay.state.ramp().is_over() => return Ok(None),
            Trace::Ramp(moments) => {
                moments.push((&closed_loop.moment(time_s, image, image.code, at_tick)).into());
                image.code
            }
        };
        Ok(Some(code))
    }

    /// Moves the joint on from `time_s` for `duration_s` under a held effort.
    pub fn drive(&mut self, v: f64, time_s: f64, duration_s: f64) {
        let events = &mut self.events;
        hold(&mut self.solver, &self.closed_loop.axis, v, [time_s, duration_s], &mut |event| {
            events.push(event)
        });
    }
}

/// A tick of the image with its positions as the host counts them: exact, since positions are whole counts that wrap.
fn from_zero_at(mut image: Tick, start: i32) -> Tick {
    image.counts = image.counts.wrapping_add(start);
    image.reference_counts = image.reference_counts.wrapping_add(start);
    image
}

/// The same with the duty that the pins show: it has to be the one that was computed. The status is the servo's, which
/// the replay has not.
const fn shown(image: Tick, bridge: &Bridge, closed_loop: &ClosedLoop) -> Tick {
    let Duty { compare, reverse } = bridge.duty(closed_loop.controller.drive().mode());
    Tick { compare, reverse, status: 0, ..image }
}
