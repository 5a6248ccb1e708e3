//! The plant: a joint behind an amplifier, with an encoder's disc on its shaft.
//!
//! Whoever drives it reads its counter, puts out a code, and lets the time to the next sample pass.
//! The bare loop, the servo, a simulated device and the emulated board have the same one.

use stiction::control::encoder::Direction;

use crate::encoder::EncoderModel;
use crate::joint::RunJoint;
use crate::mechanism::RobotAxis;
use crate::solver::{AxisSolver, Event};

/// Whether an output takes effect at its own sample or at the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Delay {
    /// The output takes effect at its own sample.
    #[default]
    None,
    /// The output takes effect one sample later.
    OneSample,
}

/// An output on its way to the amplifier, through the computation delay of a run.
#[derive(Clone, Copy, Debug)]
pub struct DelayLine {
    delay: Delay,
    before: i16,
}

impl DelayLine {
    /// Makes a line that has held zero so far.
    pub const fn new(delay: Delay) -> Self {
        Self { delay, before: 0 }
    }

    /// Takes the code of this sample, and gives the one that is in force from now on.
    #[inline]
    pub const fn put(&mut self, code: i16) -> i16 {
        match self.delay {
            Delay::None => code,
            Delay::OneSample => std::mem::replace(&mut self.before, code),
        }
    }
}

/// A joint that is moved sample by sample. `S` finds its motion between two samples.
#[derive(Clone, Debug)]
pub struct Plant<S> {
    /// The solver has the position and the velocity of the joint.
    pub solver: S,
    /// A hand on the joint or a hard stop adds this friction to the machine's own, V.
    pub brake_v: f64,
    axis: RobotAxis,
    encoder: EncoderModel,
    lsb_v: f64,
    sample_time_s: f64,
    delay: DelayLine,
    /// Time that has passed: whole samples, and on top of them what was no whole sample, s.
    samples: u64,
    time_s: f64,
}

impl Plant<RunJoint> {
    /// Puts the joint somewhere (deg, deg/s), by hand.
    pub fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.solver.put(position_deg, velocity_deg_per_s);
    }
}

impl<S: AxisSolver> Plant<S> {
    /// An axis with its encoder; `lsb_v` are the volts of one code, `sample_time_s` is the time
    /// from one sample to the next.
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
            axis,
            encoder,
            lsb_v,
            sample_time_s,
            delay,
            samples: 0,
            time_s: 0.0,
        }
    }

    /// Reads the counter, as sound wires show it.
    #[inline]
    pub fn counter(&self) -> u32 {
        self.encoder.counter(self.solver.measured())
    }

    /// Tells where the disc is, in counts of a counter that does not wrap.
    pub fn disc(&self) -> i64 {
        self.disc_at(self.solver.measured())
    }

    /// Tells where the disc is, in counts, when it is at a position (deg).
    fn disc_at(&self, position_deg: f64) -> i64 {
        let counts = self.encoder.counts(position_deg);
        match self.encoder.direction {
            Direction::Forward => counts,
            Direction::Reverse => -counts,
        }
    }

    /// Gives the position in counts, in the sense of the joint.
    pub fn counts(&self) -> i32 {
        self.encoder.counts(self.solver.measured()) as i32
    }

    /// Gives the true position of the joint, deg.
    #[inline]
    pub fn position_deg(&self) -> f64 {
        self.solver.position()
    }

    /// Gives the true velocity of the joint, deg/s.
    #[inline]
    pub fn velocity_deg_per_s(&self) -> f64 {
        self.solver.velocity()
    }

    /// Says whether position and velocity are finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.position_deg().is_finite() && self.velocity_deg_per_s().is_finite()
    }

    /// Gives the time from one sample to the next, s.
    pub const fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// Gives the effort of a code, V.
    pub fn volts(&self, code: i16) -> f64 {
        f64::from(code) * self.lsb_v
    }

    /// Takes the code that a sample puts out, and gives the effort that is in force from now on, V.
    #[inline]
    pub fn put_out(&mut self, code: i16) -> f64 {
        f64::from(self.delay.put(code)) * self.lsb_v
    }

    /// Takes a code and holds its effort for a time (s), or none if the output is off.
    pub fn put_out_and_hold(&mut self, code: i16, is_on: bool, duration_s: f64) {
        let effort_v = self.put_out(code);
        // Off is off at once: that is the pin, not the computation.
        self.hold(if is_on { effort_v } else { 0.0 }, duration_s, &mut |_| {});
    }

    /// Moves the joint on under a held effort (V) for a time (s), from where the time stands.
    #[inline]
    pub fn hold(&mut self, effort_v: f64, duration_s: f64, on_event: &mut impl FnMut(Event)) {
        // Counted in samples as long as it is samples, so that nothing adds up.
        let time_s = self.time_s + self.samples as f64 * self.sample_time_s;
        self.hold_from(effort_v, [time_s, duration_s], on_event);
        if duration_s == self.sample_time_s {
            self.samples += 1;
        } else {
            self.time_s += duration_s;
        }
    }

    /// Does the same from a time (s) that the caller keeps.
    #[inline]
    pub fn hold_from(&mut self, effort_v: f64, span_s: [f64; 2], on_event: &mut impl FnMut(Event)) {
        hold(&mut self.solver, &self.axis, [effort_v, self.brake_v], span_s, on_event);
    }
}

impl<S: AxisSolver + Clone> Plant<S> {
    /// Where the disc will be after an effort (V) has been held for a time: its begin and length,
    /// s.
    pub fn disc_after(&self, effort_v: f64, span_s: [f64; 2]) -> i64 {
        let mut ahead = self.solver.clone();
        hold(&mut ahead, &self.axis, [effort_v, self.brake_v], span_s, &mut |_| {});
        self.disc_at(ahead.measured())
    }
}

/// Moves an axis on under a held effort; the time is split where the friction changes.
#[inline]
fn hold(
    solver: &mut impl AxisSolver,
    axis: &RobotAxis,
    [effort_v, brake_v]: [f64; 2],
    [time_s, duration_s]: [f64; 2],
    on_event: &mut impl FnMut(Event),
) {
    // A change closer to a sample than this is at the sample: k h is not always the decimal that
    // was written.
    const SAME_TIME_S: f64 = 1e-9;
    let end_s = time_s + duration_s;
    let mut from_s = time_s;
    let mut stretch = |from_s: f64, duration_s: f64| {
        // In the middle, so that no rounding of the ends decides on which side of a change it is.
        let friction = axis.friction_at(from_s + 0.5 * duration_s).raised(brake_v);
        solver.advance(effort_v, duration_s, &friction, &mut |event| {
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
