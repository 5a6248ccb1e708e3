//! Electrics of a drawn joint: the winding of its motor, the supply, and the sensor of the current.
//!
//! ```text
//! tau dT/dt = s u - r T - D w      T: torque of the current, as an effort of the joint
//! ```
//!
//! with the bridge's voltage u as the effort that it causes at standstill, the time constant tau =
//! L/R of the configured winding, the true resistance over the configured one r, the supply over
//! its nominal voltage s, and the damping by the back-EMF D at the motor's speed w. The
//! [condition](super::condition) of the joint sets r and s.
//!
//! | figure | drawn from |
//! |---|---|
//! | tau | L(0.1, 1) ms, or more under `slow-winding-1` and `-5` |
//! | D | U(0, 0.9) times the viscous friction of the motor, which keeps the rest |
//!
//! A volt of the core is the current of one ampere: the configured resistance is 1 ohm. The sensor
//! measures up to 1.5 times the current of the largest effort, in steps of 1 mV of 3.3 V, and its
//! readings have a noise of 3 mV either way. The PWM has the whole number of periods in a sample
//! time that is nearest to 21 kHz.
//!
//! A current loop is configured with tau, D and 1 ohm, and law and monitors with the viscous
//! friction without D: a current does not brake a joint by the back-EMF. If the effort is a
//! voltage, the joint has the same winding, and no sensor.
//!
//! Does badly: speed and torque count as constant for a period of the PWM, or for 0.25 ms if the
//! effort is a voltage. With the bridge off, the current ends at once.

use stiction::Parameters;
use stiction::control::controller::EffortMode;
use stiction::control::current_sensor::CurrentSensor;

use super::bridge::{Bridge, Electrics};
use super::distribution::Draws;
use super::drawn_case::{Case, UnitScale};
use dynamics::joint::{AnyJoint, CountNoise, Description, Joint, Train};
use simulator::current_periods::SensedMotor;
use simulator::shunt::Shunt;

/// Bounds of the time constant L/R, s.
const WINDING_S: [f64; 2] = [1e-4, 1e-3];
/// Largest share of the viscous friction that is the back-EMF.
const MOST_INDUCED: f64 = 0.9;
/// Range of the sensor, and largest current of an effort, over the current of the largest effort.
const RANGE: f64 = 1.5;
/// Noise of the sensor, as a part of its range: 3 mV of 1.65 V.
const NOISE: f64 = 3.0 / 1650.0;
/// Frequency of the PWM, Hz.
const PWM_HZ: f64 = 21e3;
/// Time for which the speed counts as constant if the effort is a voltage, s.
const CONSTANT_S: f64 = 0.25e-3;

impl Electrics {
    /// Draws the electrics of a case, and takes them out of its joint. Returns `None` for an ideal
    /// bridge.
    pub(super) fn draw(bridge: Bridge, case: &mut Case, draws: &mut Draws) -> Option<Self> {
        if bridge == Bridge::Ideal {
            return None;
        }
        let [least, most] = WINDING_S;
        let slow_s = case.condition.winding_s();
        let lag_s = draws.log_uniform(least, most).max(slow_s);
        let induced = draws.uniform(0.0, MOST_INDUCED);
        case.joint.lag_s = 0.0;
        let viscous = viscous_of_motor(&mut case.joint);
        let damping = induced * *viscous;
        *viscous -= damping;
        if bridge == Bridge::Current {
            let UnitScale { effort, angle } = case.scale;
            case.bounds = case.bounds.with_current_loop(damping * angle / effort);
        }
        Some(Self { bridge, lag_s, damping })
    }

    /// Adds current sensor, loop and frequency of the PWM to the parameters of a servo.
    pub(super) fn configure(&self, parameters: &mut Parameters, scale: UnitScale) {
        if self.bridge != Bridge::Current {
            return;
        }
        let Parameters { controller, limits, current, .. } = parameters;
        let most = controller.drive.full_scale * controller.drive.duty_max;
        let sensor = CurrentSensor::derived(RANGE as f32 * most, [1.0, self.lag_s as f32]);
        *current = CurrentSensor { peak: most, ..sensor };
        controller.effort = EffortMode::Current;
        let sample_time_s = f64::from(controller.sample_time);
        controller.drive.pwm_hz = ((PWM_HZ * sample_time_s).round() / sample_time_s) as f32;
        limits.back_emf = (self.damping * scale.angle / scale.effort) as f32;
    }
}

/// Returns the viscous friction on the body of the motor.
const fn viscous_of_motor(joint: &mut Description) -> &mut f64 {
    match &mut joint.train {
        Train::Rigid(body) | Train::Flexible { motor: body, .. } => {
            &mut body.friction.curve.viscous
        }
        Train::LuGre { curve, .. } => &mut curve.viscous,
    }
}

/// The winding of a joint in motion.
#[derive(Debug)]
pub(super) struct Winding {
    electrics: Electrics,
    scale: UnitScale,
    lsb: f64,
    /// Torque of the current, in the unit of the joint.
    torque: f64,
    /// Mean torque in the first half of a period of the PWM, if the second half is next.
    first_half: Option<f64>,
    shunt: Shunt,
    range: f64,
    noise: CountNoise,
}

/// Drive of a winding: its joint, and what the condition makes of supply and resistance.
pub(super) struct DrivenWinding<'a> {
    pub winding: &'a mut Winding,
    pub joint: &'a mut AnyJoint,
    /// Supply over its nominal voltage, and resistance over the configured one.
    pub ratios: [f64; 2],
}

impl Winding {
    pub fn new(electrics: Electrics, case: &Case, parameters: &Parameters) -> Self {
        Self {
            electrics,
            scale: case.scale,
            lsb: case.bounds.sampled.lsb,
            torque: 0.0,
            first_half: None,
            shunt: Shunt::of(&parameters.current),
            range: parameters.current.full_scale.into(),
            noise: CountNoise::new(case.number ^ u64::MAX >> 1),
        }
    }

    /// Returns what the bridge makes of an effort.
    pub const fn bridge(&self) -> Bridge {
        self.electrics.bridge
    }

    /// Returns the mean torque over a time (s) under a voltage, as an effort of the joint, at a
    /// speed of the motor.
    fn pass(&mut self, effort: f64, speed: f64, [supply, ohm]: [f64; 2], duration_s: f64) -> f64 {
        let settled = (supply * effort - self.electrics.damping * speed) / ohm;
        let lag_s = self.electrics.lag_s / ohm;
        let left = self.torque - settled;
        let keeps = libm::exp(-duration_s / lag_s);
        self.torque = settled + left * keeps;
        settled + left * lag_s / duration_s * (1.0 - keeps)
    }
}

impl DrivenWinding<'_> {
    /// Holds a voltage for a time (s), as an effort of the joint.
    pub fn hold_voltage(&mut self, effort: f64, duration_s: f64) {
        let steps = (duration_s / CONSTANT_S).ceil().max(1.0);
        for _ in 0..steps as u32 {
            let torque = self.pass(effort, duration_s / steps);
            self.joint.hold(torque, duration_s / steps);
        }
    }

    fn pass(&mut self, effort: f64, duration_s: f64) -> f64 {
        let speed = self.joint.motor().velocity;
        self.winding.pass(effort, speed, self.ratios, duration_s)
    }
}

impl SensedMotor for DrivenWinding<'_> {
    fn hold(&mut self, code: i16, is_on: bool, duration_s: f64) -> f64 {
        let mut torque = 0.0;
        if is_on {
            let effort = f64::from(code) * self.winding.lsb * self.winding.scale.effort;
            torque = self.pass(effort, duration_s);
        } else {
            self.winding.torque = 0.0;
        }
        match self.winding.first_half.take() {
            Some(first) => self.joint.hold(0.5 * (first + torque), 2.0 * duration_s),
            None => self.winding.first_half = Some(torque),
        }
        self.winding.torque / self.winding.scale.effort
    }

    fn read(&mut self, current_a: f64) -> u16 {
        let noise_a = NOISE * self.winding.range * self.winding.noise.next() as f64;
        self.winding.shunt.reading(current_a + noise_a)
    }
}
