//! The control core around a simulated axis.
//!
//! Order within a sample, as in the thesis (section 3.2): read the encoder, regress including this
//! reading, compute, output at once. With one sample of computation delay the output waits for the
//! next sample. Between samples the D/A holds its value.

use stiction::{Controller, Course, Tick};

pub use crate::plant::Delay;
use crate::plant::Plant;
use crate::supply::SupplyCourse;
use crate::target::{BareLoop, Target};
use dynamics::mechanism::RobotAxis;
use dynamics::solver::{AxisSolver, Event};
use files::encoder::EncoderModel;

/// A controller connected to a simulated axis.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// Controller of the core.
    pub controller: Controller,
    /// Motion.
    pub course: Course,
    /// Encoder on the axis.
    pub encoder: EncoderModel,
    /// Encoder of the motor, if `encoder` is a second one on the load.
    pub motor_encoder: Option<EncoderModel>,
    /// Reading of the load's encoder where the joint is at zero, if it is an absolute one.
    pub absolute_zero: Option<u32>,
    /// Voltage of one drive code, V.
    pub lsb_v: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Computation delay.
    pub delay: Delay,
    /// Supply of the bridge; `None`: the nominal one.
    pub supply: Option<SupplyCourse>,
    /// Axis with its friction over time.
    pub axis: RobotAxis,
}

/// The loop at one sampling instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopSample {
    /// Time, s.
    pub time_s: f64,
    /// Signals of the core in this tick.
    pub tick: Tick,
    /// Set point theta_d, deg.
    pub reference_deg: f64,
    /// True joint position, deg.
    pub position_deg: f64,
    /// True position at the encoder, deg.
    pub at_encoder_deg: f64,
    /// True position at the load, deg.
    pub at_load_deg: f64,
    /// Position of the motor since the start of the run, counts of its own encoder; `None` unless
    /// the joint has an encoder on motor and load.
    pub motor_counts: Option<i32>,
    /// True joint velocity, deg/s.
    pub velocity_deg_per_s: f64,
    /// Output of the D/A until the next sample, V.
    pub applied_v: f64,
    /// Whether the joint is stuck.
    pub stuck: bool,
}

impl LoopSample {
    /// Returns reference minus true position, deg.
    pub fn error_deg(&self) -> f64 {
        self.reference_deg - self.position_deg
    }
}

impl ClosedLoop {
    /// Returns the plant of the loop, moved by `solver`.
    pub fn plant<S: AxisSolver>(&self, solver: S) -> Plant<S> {
        let scale = [self.lsb_v, self.sample_time_s];
        Plant::new(solver, self.axis.clone(), self.encoder, scale, self.delay)
            .with_motor_encoder(self.motor_encoder)
            .with_absolute_zero(self.absolute_zero)
    }

    /// Runs the bare loop from rest for `samples` samples after the first, and passes every sample
    /// and every event to the callbacks.
    ///
    /// Returns the time at which a state was no longer finite, s; the run ends there.
    pub fn run<S: AxisSolver>(
        &self,
        solver: &mut S,
        samples: u32,
        on_moment: impl FnMut(&LoopSample),
        on_event: impl FnMut(Event),
    ) -> Option<f64> {
        let mut plant = self.plant(solver);
        let (counter, counts) = (plant.counter(), plant.counts());
        let mut target = BareLoop::new(&self.controller, &self.course, counter, counts);
        self.step(&mut target, &mut plant, samples, on_moment, on_event)
    }

    /// Runs a target with a plant as [`run`](Self::run) does, or until the target ends.
    #[inline]
    pub fn step<S: AxisSolver>(
        &self,
        target: &mut impl Target,
        plant: &mut Plant<S>,
        samples: u32,
        mut on_moment: impl FnMut(&LoopSample),
        mut on_event: impl FnMut(Event),
    ) -> Option<f64> {
        for k in 0..=samples {
            let time_s = f64::from(k) * self.sample_time_s;
            if !plant.is_finite() {
                return Some(time_s);
            }
            let Some(tick) = target.tick(plant.counters()) else { break };
            let effort_v = plant.put_out(tick.code);
            let moment = self.moment(time_s, tick, effort_v, &plant.solver);
            on_moment(&LoopSample { motor_counts: plant.motor_counts(), ..moment });
            if k < samples {
                if let Some(supply) = &self.supply {
                    plant.supply_ratio = supply.ratio_at(time_s);
                }
                target.drive(plant, &tick, effort_v, &mut on_event);
            }
        }
        None
    }

    /// Returns the sample of a tick; `applied_v` is the D/A's output until the next sample, V.
    #[inline]
    pub fn moment(
        &self,
        time_s: f64,
        tick: Tick,
        applied_v: f64,
        joint: &impl AxisSolver,
    ) -> LoopSample {
        let setpoint = tick.setpoint().position;
        LoopSample {
            time_s,
            tick,
            reference_deg: (f64::from(setpoint.counts) + f64::from(setpoint.fraction))
                * self.encoder.resolution,
            position_deg: joint.position(),
            at_encoder_deg: joint.at_encoder(),
            at_load_deg: joint.at_load(),
            motor_counts: None,
            velocity_deg_per_s: joint.velocity(),
            applied_v,
            stuck: joint.stuck(),
        }
    }
}
