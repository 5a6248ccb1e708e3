//! Parameters of a run, and the contents of the parameter sector for its image.

use stiction::control::brake_resistor::BrakeResistor;
use stiction::control::current_sensor::CurrentSensor;
use stiction::control::encoder::EncoderOutput;
use stiction::control::motor_ntc::MotorNtc;
use stiction::parameters::{DeviceConfig, ROOM};
use stiction::{Limits, Motion, Parameters};

use files::error::Error;
use simulator::experiment::{RunPlan, assembled, check_laws, validate};
use simulator::target::from_start;

/// Ticks from the first tick to arming: time for the encoder to reach the position of the joint.
const WAIT_TICKS: f32 = 3.0;

/// Returns parameters with which the device does the same as the host: it starts automatically, at
/// once with its full scale, and does not scale the duty by the supply. The other parameters are
/// those of a board, except that the monitors are off: the simulator continues whatever happens to
/// the joint, and so must the image.
///
/// # Errors
/// Returns an error that names a value that is invalid, or that the device would refuse.
pub fn parameters(plan: &RunPlan) -> Result<Parameters, Error> {
    let mut parameters = by_itself(plan)?;
    parameters.device.soft_start = 0.0;
    parameters.device.nominal_supply = 0.0;
    // A holding brake delays the motion.
    (parameters.device.brake_open, parameters.device.brake_close) = (0.0, 0.0);
    // So does a test at arming.
    parameters.device.arming_test = 0.0;
    parameters.limits = Limits::OFF;
    // The twist of the gear has its limits beside the encoder.
    (parameters.controller.motor.twist, parameters.controller.motor.swing) = (0.0, 0.0);
    // The loop on the host has no servo around it, which limits the effort by the current.
    parameters.current = CurrentSensor::NONE;
    // It needs the monitor of the supply.
    parameters.brake_resistor = BrakeResistor::NONE;
    // Nothing in a run reads it.
    parameters.motor_ntc = MotorNtc::NONE;
    validate(&parameters, plan)?;
    Ok(parameters)
}

/// Returns the parameters of a board, with an automatic start from zero.
fn by_itself(plan: &RunPlan) -> Result<Parameters, Error> {
    check_laws(plan)?;
    let mut parameters = assembled(plan)?;
    // The zero of the device is the position at which it is armed. The host's joint rests there
    // too, but its disc can already be a count further.
    let start = plan.encoder()?.counts(0.0) as i32;
    from_start(&mut parameters.motion, start);
    parameters.device = DeviceConfig {
        autostart: true,
        // The emulated microcontroller is as delivered: without a brown-out reset.
        autostart_after_dip: true,
        autostart_delay: WAIT_TICKS * parameters.controller.sample_time,
        ..parameters.device
    };
    Ok(parameters)
}

/// Returns [`parameters`] as the bytes of the sector.
///
/// # Errors
/// As [`parameters`].
pub fn blob(plan: &RunPlan) -> Result<Vec<u8>, Error> {
    record(plan, &parameters(plan)?)
}

/// Returns the bytes of the sector with the test for open lines, and with monitors, soft start and
/// supply as in the plan's file.
///
/// # Errors
/// As [`parameters`].
pub fn everything_on(plan: &RunPlan) -> Result<Vec<u8>, Error> {
    let mut parameters = by_itself(plan)?;
    parameters.controller.encoder.output = EncoderOutput::PushPull;
    parameters.controller.motor.output = EncoderOutput::PushPull;
    validate(&parameters, plan)?;
    record(plan, &parameters)
}

/// Returns the bytes of the sector with a profiled move instead of the plan's step, and with
/// monitors, soft start and supply as in the plan's file.
///
/// # Errors
/// As [`parameters`].
pub fn profiled(plan: &RunPlan) -> Result<Vec<u8>, Error> {
    let mut parameters = by_itself(plan)?;
    if let Motion::Step(to) = parameters.motion {
        parameters.motion = Motion::Profiled(to);
    }
    validate(&parameters, plan)?;
    record(plan, &parameters)
}

fn record(plan: &RunPlan, parameters: &Parameters) -> Result<Vec<u8>, Error> {
    let mut room = [0; ROOM];
    let record = parameters.encode(1, &mut room).map(<[u8]>::to_vec);
    record.ok_or_else(|| {
        Error::Input(format!("{}: the parameters do not fit {ROOM} bytes", plan.origin))
    })
}
