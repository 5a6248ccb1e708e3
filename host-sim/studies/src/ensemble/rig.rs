//! A joint on the bench: the servo with all of its monitors, amplifier, encoder and joint, stepped
//! tick by tick.
//!
//! The servo is armed with its joint at rest, and holds it for the length of its soft start. Then
//! a motion begins, as over a link: this is time zero of all measures. A brake that holds the
//! joint opens at the same time.

use stiction::Tick;
use stiction::control::current_loop::CurrentTarget;
use stiction::control::laws::Gains;
use stiction::control::reference::Reference;
use stiction::control::signal::MAX_LAW_SIGNALS;
use stiction::safety::fault::Fault;

use super::assemble::parameters;
use super::bridge::Bridge;
use super::condition::{Condition, EccentricDisc, JitteringTicks};
use super::drawn_case::Case;
use super::electrics::{DrivenWinding, Winding};
#[cfg(test)]
use super::failed_sensor::FailedSensor;
use super::measures::CaseSample;
use super::motions::Approach;
use dynamics::joint::{AnyJoint, CountNoise, DiscSide, Joint, JointEncoder, Turn};
use files::error::Error;
use simulator::counters::Counters;
use simulator::plant::{Delay, DelayLine};
use simulator::rules::{ControllerGains, JointBounds};
use simulator::target::{Target, WatchedServo};

/// Torque of a brake that holds any joint, in multiples of the effort limit.
const BRAKE: f64 = 10.0;

/// A servo and its joint.
#[derive(Debug)]
pub struct Rig {
    joint: AnyJoint,
    encoder: JointEncoder,
    motor_encoder: Option<JointEncoder>,
    /// Noise of the joint's encoder and of the motor's encoder.
    noise: Option<[CountNoise; 2]>,
    condition: Condition,
    jitter: Option<JitteringTicks>,
    disc: Option<EccentricDisc>,
    /// Failed encoder of a joint that has two.
    #[cfg(test)]
    failed: Option<FailedSensor>,
    /// Time since arming, s.
    time_s: f64,
    amplified: Amplified,
    /// Winding of the motor, with the delay of a current loop's targets; `None` with an ideal
    /// bridge.
    winding: Option<(Winding, DelayLine<CurrentTarget>)>,
    bounds: JointBounds,
    /// Position at arming, counts.
    armed_at: i64,
}

/// A servo with its amplifier.
#[derive(Debug)]
pub(super) struct Amplified {
    pub servo: WatchedServo,
    delay: DelayLine,
    /// Effort of a code, in the unit of the joint.
    per_code: f64,
    /// Angle of a degree, in the unit of the joint.
    per_degree: f64,
    /// Whether the law has given up, as of the last tick.
    has_given_up: bool,
    /// Signals that the law published in the last tick.
    published: [f32; MAX_LAW_SIGNALS],
}

/// A servo that is armed, with the length of its soft start (ticks) and the winding that it drives.
pub(super) struct ArmedServo {
    pub servo: WatchedServo,
    pub lead_in: u32,
    pub winding: Option<Winding>,
}

/// Arms a servo whose encoders have these counters at rest.
pub(super) fn armed(
    case: &Case,
    bounds: &JointBounds,
    gains: &ControllerGains,
    at_rest: Counters,
) -> Result<ArmedServo, Error> {
    let mut parameters = parameters(bounds, gains);
    if let Some(electrics) = &case.electrics {
        electrics.configure(&mut parameters, case.scale);
    }
    let law = gains.laws.iter().map(Gains::name).collect::<Vec<_>>().join(" + ");
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
    let winding = case.electrics.map(|electrics| Winding::new(electrics, case, &parameters));
    let counts = at_rest.position as i32;
    let servo = WatchedServo::new(parameters, at_rest, counts)?;
    Ok(ArmedServo { servo, lead_in, winding })
}

impl Amplified {
    /// Puts an amplifier with a delay behind a servo. The last argument is the effort of a volt and
    /// the angle of a degree, in the unit of the joint.
    pub fn new(
        servo: WatchedServo,
        bounds: &JointBounds,
        delay: Delay,
        [effort, per_degree]: [f64; 2],
    ) -> Self {
        let delay = DelayLine::new(delay);
        let published = [0.0; MAX_LAW_SIGNALS];
        let per_code = bounds.sampled.lsb * effort;
        Self { servo, delay, per_code, per_degree, has_given_up: false, published }
    }

    /// Outputs the effort of a tick, and returns the sample of a joint with this motion of its
    /// encoder's side and of its load. `count` is the angle of a count, and ticks are `tick_s`
    /// apart.
    #[inline]
    pub fn sample(
        &mut self,
        tick: &Tick,
        [turn, load]: [Turn; 2],
        [count, tick_s]: [f64; 2],
    ) -> CaseSample {
        self.has_given_up = tick.status & Tick::GAVE_UP != 0;
        self.published = tick.law;
        let setpoint = f64::from(tick.reference_counts) + f64::from(tick.reference_fraction);
        let speed = f64::from(tick.reference_velocity) * self.per_degree;
        CaseSample {
            error: setpoint - turn.position / count,
            load_error: setpoint - load.position / count,
            position: turn.position / count,
            speed_ratio: if speed == 0.0 { 0.0 } else { turn.velocity / speed },
            speed: speed * tick_s / count,
            effort: f64::from(self.delay.put(tick.code)) * self.per_code,
        }
    }
}

impl Rig {
    /// Arms a servo on the joint of a case, and holds the joint until the soft start is over.
    ///
    /// # Errors
    /// If gains are not allowed, or the servo refuses to be armed.
    pub fn armed(case: &Case, gains: &ControllerGains) -> Result<Self, Error> {
        let mut joint = case.joint.build()?;
        let disc = (case.condition == Condition::Eccentric)
            .then(|| EccentricDisc::new(case.scale.angle, case.phase));
        let armed_at = read(&case.encoder, disc.as_ref(), &joint);
        let motor = case.motor_encoder.as_ref().map(|motor| motor.read(&joint) as u32);
        let at_rest = Counters { position: armed_at as u32, motor };
        let ArmedServo { servo, lead_in, winding } = armed(case, &case.bounds, gains, at_rest)?;
        if case.is_braked {
            joint.set_brake(BRAKE * case.bounds.sampled.largest_effort * case.scale.effort);
        }
        let scale = [case.scale.effort, case.scale.angle];
        let mut rig = Self {
            joint,
            encoder: case.encoder,
            motor_encoder: case.motor_encoder,
            noise: case
                .family
                .has_noise()
                .then(|| [case.number, !case.number].map(CountNoise::new)),
            condition: case.condition,
            jitter: (case.condition == Condition::SamplingJitter)
                .then(|| JitteringTicks::new(case.number)),
            disc,
            #[cfg(test)]
            failed: None,
            time_s: 0.0,
            amplified: Amplified::new(servo, &case.bounds, case.delay, scale),
            winding: winding
                .map(|winding| (winding, DelayLine::after(case.delay, CurrentTarget::default()))),
            bounds: case.bounds,
            armed_at,
        };
        for _ in 0..lead_in {
            rig.step();
        }
        rig.joint.set_brake(0.0);
        Ok(rig)
    }

    /// Commands the servo to follow a reference from the next tick on; returns whether it does. The
    /// servo refuses if it has tripped, or if a trajectory begins too far from the joint.
    #[must_use]
    pub fn follow(&mut self, reference: Reference) -> bool {
        self.amplified.servo.follow(reference).is_ok()
    }

    /// Returns the position at arming, counts.
    pub const fn armed_at(&self) -> f64 {
        self.armed_at as f64
    }

    /// Commands the servo to go to a target, in counts from the position at arming; returns whether
    /// it does.
    ///
    /// # Errors
    /// If the core refuses the limits of the profile.
    pub fn go_to(&mut self, approach: Approach, to: f64) -> Result<bool, Error> {
        approach.start(&mut self.amplified.servo, to, &self.bounds)
    }

    /// Makes one of two encoders fail from the next tick on.
    #[cfg(test)]
    pub(super) const fn fail(&mut self, failed: FailedSensor) {
        self.failed = Some(failed);
    }

    /// Returns the fault that has ended the motion, if there was one.
    pub fn fault(&self) -> Option<Fault> {
        self.amplified.servo.fault.map(|(latched, _)| latched.fault)
    }

    /// Returns what makes the motion a failure, if anything does: a fault, or a motion that the
    /// simulation could not follow.
    pub fn failure(&self) -> Option<String> {
        failure(self.fault(), self.joint.unfollowed_s())
    }

    /// Returns whether the law had given up at the last tick.
    pub const fn has_given_up(&self) -> bool {
        self.amplified.has_given_up
    }

    /// Returns the signals that the law published in the last tick, `name=value` with a space
    /// between. Of several laws, the first one that has signals is used.
    pub fn published(&self, laws: &[Gains]) -> String {
        let signals = laws.iter().map(Gains::signals).find(|signals| !signals.is_empty());
        let values = signals.into_iter().flatten().zip(self.amplified.published);
        let bounds: Vec<_> =
            values.map(|(signal, value)| format!("{}={value}", signal.name)).collect();
        bounds.join(" ")
    }

    /// Runs a tick, and moves the joint on to the next one; returns the sample at the tick.
    #[inline]
    pub fn step(&mut self) -> CaseSample {
        let [noise, motor_noise] =
            self.noise.as_mut().map_or([0; 2], |each| each.each_mut().map(CountNoise::next));
        let reading = read(&self.encoder, self.disc.as_ref(), &self.joint);
        #[cfg(test)]
        let reading =
            self.failed.as_mut().map_or(reading, |failed| failed.read(DiscSide::Load, reading));
        let position = reading.wrapping_add(noise) as u32;
        let mut motor = None;
        if let Some(encoder) = &self.motor_encoder {
            let of_motor = encoder.read(&self.joint);
            #[cfg(test)]
            let of_motor = self
                .failed
                .as_mut()
                .map_or(of_motor, |failed| failed.read(DiscSide::Motor, of_motor));
            motor = Some(of_motor.wrapping_add(motor_noise) as u32);
        }
        let tick = self.amplified.servo.tick(Counters { position, motor }).unwrap_or_default();
        let load = self.joint.load();
        let mut turn = match self.encoder.side {
            DiscSide::Motor => self.joint.motor(),
            DiscSide::Load => load,
        };
        if let Some(disc) = &self.disc {
            turn.position = disc.shows(turn.position);
        }
        let (count, sample_time_s) = (self.encoder.count, self.bounds.sampled.sample_time);
        let sample = self.amplified.sample(&tick, [turn, load], [count, sample_time_s]);
        let lasts_s = sample_time_s * self.jitter.as_mut().map_or(1.0, JitteringTicks::next);
        self.drive(sample.effort, lasts_s);
        self.time_s += sample_time_s;
        sample
    }

    /// Moves the joint for a time (s) under an effort.
    #[inline]
    fn drive(&mut self, effort: f64, duration_s: f64) {
        let Some((winding, delay)) = &mut self.winding else {
            self.joint.hold(effort * self.condition.share(self.time_s), duration_s);
            return;
        };
        let bridge = winding.bridge();
        let ratios = self.condition.ratios(self.time_s);
        let mut motor = DrivenWinding { winding, joint: &mut self.joint, ratios };
        if bridge == Bridge::Current {
            self.amplified.servo.regulate(&mut motor, duration_s, delay);
        } else {
            motor.hold_voltage(effort, duration_s);
        }
    }
}

/// Returns what makes a motion a failure: the time that the simulation skipped in it (s), which
/// makes the motion invalid, or a fault.
pub fn failure(fault: Option<Fault>, unfollowed_s: f64) -> Option<String> {
    if unfollowed_s > 0.0 {
        return Some(UNFOLLOWED.into());
    }
    fault.map(|fault| fault.describe().to_owned())
}

/// Result of a joint that sticks and slips more often in a sample than the simulation follows.
pub const UNFOLLOWED: &str = "not simulated: too many switches in a sample";

/// Returns the count that the disc of a joint shows.
#[inline]
fn read(encoder: &JointEncoder, disc: Option<&EccentricDisc>, joint: &AnyJoint) -> i64 {
    disc.map_or_else(
        || encoder.read(joint),
        |disc| encoder.count_at(disc.shows(encoder.position(joint))),
    )
}
