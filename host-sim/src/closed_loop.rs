//! The control core around a simulated axis.
//!
//! Order within a sample, as in the thesis (section 3.2): read the encoder, regress including this reading, compute,
//! output at once. With one sample of computation delay the output waits for the next sample. Between
//! samples the D/A holds its value.

use stiction::{Controller, Course, Tick};

use crate::encoder::EncoderModel;
use crate::mechanism::RobotAxis;
use crate::solver::{AxisSolver, Event};
use crate::target::{BareLoop, Target};

/// Whether an output takes effect at its own sample or at the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Delay {
    /// At once.
    #[default]
    None,
    /// One sample later.
    OneSample,
}

/// A controller wired to an axis.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// The core.
    pub controller: Controller,
    /// The motion.
    pub course: Course,
    /// The encoder on the axis.
    pub encoder: EncoderModel,
    /// Volts of one drive code.
    pub lsb_v: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Computation delay.
    pub delay: Delay,
    /// The axis, for its friction over time.
    pub axis: RobotAxis,
}

/// The loop at one sampling instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time, s.
    pub time_s: f64,
    /// What the core computed.
    pub tick: Tick,
    /// theta_d, deg.
    pub reference_deg: f64,
    /// True joint position, deg.
    pub position_deg: f64,
    /// True joint velocity, deg/s.
    pub velocity_deg_per_s: f64,
    /// What the D/A holds from now on, V.
    pub applied_v: f64,
    /// Whether the joint is stuck.
    pub stuck: bool,
}

impl Moment {
    /// Reference minus true position, deg.
    pub fn error_deg(&self) -> f64 {
        self.reference_deg - self.position_deg
    }
}

impl ClosedLoop {
    /// Runs the bare loop from rest for `samples` samples after the first, and shows every instant and every event.
    ///
    /// Returns the time at which a state was no longer finite, if that happened; the run ends there.
    pub fn run<S: AxisSolver>(
        &self,
        solver: &mut S,
        samples: u32,
        on_moment: impl FnMut(&Moment),
        on_event: impl FnMut(Event),
    ) -> Option<f64> {
        let (counter, counts) = self.at_rest(solver);
        let mut target = BareLoop::new(&self.controller, &self.course, counter, counts);
        self.step(&mut target, solver, samples, on_moment, on_event)
    }

    /// What the counter reads, and the counts that it stands for.
    pub fn at_rest(&self, solver: &impl AxisSolver) -> (u32, i32) {
        let position = solver.position();
        (self.encoder.counter(position), self.encoder.counts(position) as i32)
    }

    /// Steps a target against the joint, as [`run`](Self::run), or until the target has ended.
    #[inline]
    pub fn step<S: AxisSolver>(
        &self,
        target: &mut impl Target,
        solver: &mut S,
        samples: u32,
        mut on_moment: impl FnMut(&Moment),
        mut on_event: impl FnMut(Event),
    ) -> Option<f64> {
        let mut previous_code = 0;
        for k in 0..=samples {
            let time_s = f64::from(k) * self.sample_time_s;
            let (position, velocity) = (solver.position(), solver.velocity());
            if !(position.is_finite() && velocity.is_finite()) {
                return Some(time_s);
            }
            let Some(tick) = target.tick(self.encoder.counter(position)) else { break };
            let code = match self.delay {
                Delay::None => tick.code,
                Delay::OneSample => std::mem::replace(&mut previous_code, tick.code),
            };
            let moment = self.moment(time_s, tick, code, solver);
            on_moment(&moment);
            if k < samples {
                hold(solver, &self.axis, moment.applied_v, [time_s, self.sample_time_s], &mut on_event);
            }
        }
        None
    }

    /// The loop at the instant of a tick, with `code` on the D/A from now on.
    #[inline]
    pub(crate) fn moment(&self, time_s: f64, tick: Tick, code: i16, solver: &impl AxisSolver) -> Moment {
        let setpoint = tick.setpoint().position;
        Moment {
            time_s,
            tick,
            reference_deg: (f64::from(setpoint.counts) + f64::from(setpoint.fraction))
                * self.encoder.resolution,
            position_deg: solver.position(),
            velocity_deg_per_s: solver.velocity(),
            applied_v: f64::from(code) * self.lsb_v,
            stuck: solver.stuck(),
        }
    }
}

/// Moves an axis on under a held effort; the time is split where the friction changes.
#[inline]
pub fn hold(
    solver: &mut impl AxisSolver,
    axis: &RobotAxis,
    v: f64,
    [time_s, duration_s]: [f64; 2],
    on_event: &mut impl FnMut(Event),
) {
    // A change closer to a sample than this is at the sample: k h is not always the decimal that was written.
    const SAME_TIME_S: f64 = 1e-9;
    let end_s = time_s + duration_s;
    let mut from_s = time_s;
    let mut stretch = |from_s: f64, duration_s: f64| {
        // In the middle, so that no rounding of the ends decides on which side of a change it is.
        let friction = axis.friction_at(from_s + 0.5 * duration_s);
        solver.advance(v, duration_s, &friction, &mut |event| {
            on_event(Event { time_s: from_s + event.time_s, ..event });
        });
    };
    while let Some(change_s) = axis.added.next_change(from_s + SAME_TIME_S, end_s - SAME_TIME_S) {
        stretch(from_s, change_s - from_s);
        from_s = change_s;
    }
    // The whole sample in the usual case, to the bit: the solver knows that interval.
    stretch(from_s, if from_s == time_s { duration_s } else { end_s - from_s });
}
