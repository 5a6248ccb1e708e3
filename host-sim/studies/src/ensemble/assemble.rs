//! Parameters of a servo for a law on a joint: the same as from a machine's file with the same
//! figures, with every limit and every time at its default.

use stiction::control::brake_resistor::BrakeResistor;
use stiction::control::controller::EffortMode;
use stiction::control::current_sensor::CurrentSensor;
use stiction::control::drive::DriveConfig;
use stiction::control::encoder::{CounterBits, Encoder};
use stiction::control::motor_ntc::MotorNtc;
use stiction::control::reference::{Corner, Reference, Trajectory};
use stiction::motion::jog::JogBounds;
use stiction::parameters::DeviceConfig;
use stiction::units::value::Table as _;
use stiction::{ControllerConfig, Limits, Motion, Parameters, ProfileLimits};

use super::drawn_case::{Case, Trapezoid};
use files::error::Error;
use simulator::experiment::position;
use simulator::rules::{ControllerGains, JointBounds};

/// Returns the parameters of a servo that holds its joint where it is armed.
///
/// The limits of the monitors follow from the bounds of the law: the joint breaks away with the
/// largest friction and the largest load, and is accelerated by up to twice what the nominal
/// inertia yields (as a machine's file derives it from its joint).
pub fn parameters(bounds: &JointBounds, gains: &ControllerGains) -> Parameters {
    let encoder = Encoder {
        resolution: bounds.sampled.count as f32,
        counter_bits: CounterBits::ThirtyTwo,
        ..Encoder::EXAMPLE
    };
    let (full_scale, lsb) = (bounds.sampled.largest_effort as f32, bounds.sampled.lsb as f32);
    let controller = ControllerConfig {
        sample_time: bounds.sampled.sample_time as f32,
        encoder,
        motor: bounds.motor_config(),
        drive: DriveConfig { full_scale, lsb, ..DriveConfig::EXAMPLE },
        velocity_window: gains.velocity_window,
        effort: EffortMode::Voltage,
        pd: gains.pd,
        compensator: gains.laws.iter().copied().collect(),
    };
    let device = DeviceConfig::CAUTIOUS;
    let breakaway = (bounds.breakaway[1] + bounds.load) as f32;
    let gain = (1.0 / bounds.inertia) as f32;
    // Every encoder here works. A probe of it would move joints that a law leaves where they stick.
    let limits = Limits {
        breakaway_min: breakaway,
        play: bounds.known_twist(),
        ..Limits::derived(&controller, &device, breakaway).of_gain(gain, &controller)
    };
    let profile = ProfileLimits::derived(&controller, limits.overspeed, gain);
    let jog = JogBounds::derived(&controller, &device, breakaway);
    let current = CurrentSensor::NONE;
    Parameters {
        controller,
        motion: Motion::Hold,
        device,
        limits,
        profile,
        jog,
        current,
        brake_resistor: BrakeResistor::NONE,
        motor_ntc: MotorNtc::NONE,
    }
}

/// A trajectory with the ticks in which it is judged.
pub struct TrackedTrajectory {
    /// Reference that is followed.
    pub reference: Reference,
    /// First and last judged tick: from the start of the first blend to the end of the last.
    pub window: [u32; 2],
    /// Largest speed of the reference, counts a tick.
    pub top: f64,
}

/// Returns the trapezoid of a case from where it is armed: 0 to A to 0 with the corners at 1,
/// 1 + A/V, 1 + A/V + D and 1 + 2 A/V + D s.
///
/// # Errors
/// If the core refuses the trajectory, for example at a rate without a tick in half a blend.
pub fn trapezoid(case: &Case) -> Result<TrackedTrajectory, Error> {
    trapezoid_of(case, &case.trapezoid)
}

/// Returns the trapezoid of either joint of a case.
///
/// # Errors
/// As [`trapezoid`].
pub fn trapezoid_of(case: &Case, of_joint: &Trapezoid) -> Result<TrackedTrajectory, Error> {
    let Trapezoid { distance, speed, dwell_s, half_blend_s } = *of_joint;
    let way_s = distance.abs() / speed;
    let times_s = [1.0, 1.0 + way_s, 1.0 + way_s + dwell_s, 1.0 + 2.0 * way_s + dwell_s];
    let h = case.bounds.sampled.sample_time;
    let corners = [0, 1, 2, 3].map(|i: usize| Corner {
        tick: (times_s[i] / h).round() as u32,
        position: position(if i == 1 || i == 2 { distance / case.count() } else { 0.0 }),
    });
    let trajectory =
        Trajectory::new(&corners, half_blend_s as f32, h as f32, case.bounds.sampled.count as f32);
    let trajectory = trajectory.map_err(|error| {
        Error::Input(format!("--rate {}: the trajectory does not fit it: {error:?}", 1.0 / h))
    })?;
    let [first, last] = [times_s[0] - half_blend_s, times_s[3] + half_blend_s];
    Ok(TrackedTrajectory {
        reference: Reference::Trajectory(trajectory),
        window: [(first / h).round() as u32, (last / h).round() as u32],
        top: speed * h / case.count(),
    })
}
