//! A joint on the bench: the servo with all of its monitors, amplifier, encoder and joint, stepped
//! tick by tick.
//!
//! The servo is armed with its joint at rest, and holds it for the length of its soft start. Then
//! it is told to move, as over a link: this is time zero of all measures. A brake that holds the
//! joint opens at the same time.

use stiction::compensator::Gains;
use stiction::fault::Fault;
use stiction::reference::Reference;

use super::assemble::parameters;
use super::draw::Case;
use super::measures::Sample;
use super::rules::Tuned;
use crate::error::Error;
use crate::joint::{AnyJoint, Encoder, Joint, Side, Turn};
use crate::plant::DelayLine;
use crate::target::{Target, WatchedServo};

/// A brake that holds any joint, in multiples of the effort limit.
const BRAKE: f64 = 10.0;

/// A servo and its joint.
#[derive(Debug)]
pub struct Rig {
    servo: WatchedServo,
    joint: AnyJoint,
    encoder: Encoder,
    delay: DelayLine,
    /// Effort of a code, in the unit of the joint.
    per_code: f64,
    /// Angle of a degree, in the unit of the joint.
    per_degree: f64,
    sample_time_s: f64,
}

impl Rig {
    /// Arms a servo on the joint of a case, and lets it hold it until its soft start is over.
    ///
    /// # Errors
    /// If gains are not allowed, or the servo refuses to be armed.
    pub fn armed(case: &Case, tuned: &Tuned) -> Result<Self, Error> {
        let mut joint = case.joint.build()?;
        let parameters = parameters(&case.told, tuned);
        let law = tuned.laws.iter().map(Gains::name).collect::<Vec<_>>().join(" + ");
        let (family, number) = (case.family.name(), case.number);
        parameters.check().map_err(|error| {
            let key = error.key.0;
            Error::Input(format!(
                "the rule of `{law}` gives a value that the core refuses, on case {number} of \
                 {family}: number {key:#06x} is {}; {:?}",
                error.found, error.allowed
            ))
        })?;
        let lead_in = parameters.ticks_at_least(parameters.device.soft_start);
        let counts = case.encoder.read(&joint);
        let servo = WatchedServo::new(parameters, counts as u32, counts as i32)?;
        if case.is_braked {
            joint.set_brake(BRAKE * case.told.full_scale * case.scale.effort);
        }
        let mut rig = Self {
            servo,
            joint,
            encoder: case.encoder,
            delay: DelayLine::new(case.delay),
            per_code: case.told.lsb * case.scale.effort,
            per_degree: case.scale.angle,
            sample_time_s: case.told.sample_time,
        };
        for _ in 0..lead_in {
            rig.tick();
        }
        rig.joint.set_brake(0.0);
        Ok(rig)
    }

    /// Has the servo follow a reference from the next tick on; returns whether it does. One that
    /// has tripped does not, and none follows a trajectory that begins too far from its joint.
    #[must_use]
    pub fn follow(&mut self, reference: Reference) -> bool {
        self.servo.follow(reference).is_ok()
    }

    /// Returns the fault that has ended the motion, if there was one.
    pub fn fault(&self) -> Option<Fault> {
        self.servo.fault.map(|(latched, _)| latched.fault)
    }

    /// Runs a tick, and moves the joint on to the next one; returns where it was at the tick.
    #[inline]
    pub fn tick(&mut self) -> Sample {
        let counter = self.encoder.read(&self.joint) as u32;
        let tick = self.servo.tick(counter).unwrap_or_default();
        let effort = f64::from(self.delay.put(tick.code)) * self.per_code;
        let load = self.joint.load();
        let Turn { position, velocity } = match self.encoder.side {
            Side::Motor => self.joint.motor(),
            Side::Load => load,
        };
        let setpoint = f64::from(tick.reference_counts) + f64::from(tick.reference_fraction);
        let speed = f64::from(tick.reference_velocity) * self.per_degree;
        let count = self.encoder.count;
        let sample = Sample {
            error: setpoint - position / count,
            load_error: setpoint - load.position / count,
            position: position / count,
            speed_ratio: if speed == 0.0 { 0.0 } else { velocity / speed },
            speed: speed * self.sample_time_s / count,
            effort,
        };
        self.joint.hold(effort, self.sample_time_s);
        sample
    }
}
