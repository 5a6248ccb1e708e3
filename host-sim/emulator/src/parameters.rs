//! The parameter sector that a run's image finds.

use stiction::control::encoder::EncoderOutput;
use stiction::parameters::{DeviceConfig, ROOM};
use stiction::{Limits, Motion, Parameters};

use files::error::Error;
use simulator::experiment::{RunPlan, assembled, check_laws, validate};
use simulator::target::from_start;

/// From the first tick to arming, in ticks: time for the encoder to be shown where the joint is.
const WAIT_TICKS: f32 = 3.0;

/// Returns parameters by which the device does what the host does: it starts automatically, at once
/// with its full scale, and leaves the duty alone. The rest is as a board would have it, but for
/// the monitors' thresholds: the simulator goes on whatever happens to the joint, and so shall the
/// image.
///
/// # Errors
/// Names a value that is not allowed, or that the device would refuse.
pub fn parameters(plan: &RunPlan) -> Result<Parameters, Error> {
    let mut parameters = by_itself(plan)?;
    parameters.device.soft_start = 0.0;
    parameters.device.nominal_supply = 0.0;
    parameters.limits = Limits::OFF;
    validate(&parameters, plan)?;
    Ok(parameters)
}

/// Returns a board's parameters, but for the start: automatically, and from zero.
fn by_itself(plan: &RunPlan) -> Result<Parameters, Error> {
    plan.has_one_encoder()?;
    check_laws(plan)?;
    let mut parameters = assembled(plan)?;
    // The device calls the place zero in which it is armed. The host's joint rests there too, but
    // its disc may already be a count further.
    let start = plan.encoder()?.counts(0.0) as i32;
    from_start(&mut parameters.motion, start);
    parameters.device = DeviceConfig {
        autostart: true,
        // The emulated part is as the factory leaves it: without a brown-out reset.
        autostart_after_dip: true,
        autostart_delay: WAIT_TICKS * parameters.controller.sample_time,
        ..parameters.device
    };
    Ok(parameters)
}

/// The same as the bytes of the sector.
///
/// # Errors
/// As [`parameters`].
pub fn blob(plan: &RunPlan) -> Result<Vec<u8>, Error> {
    record(plan, &parameters(plan)?)
}

/// The same, watched by every monitor and tested for open lines, and with soft start and supply as
/// the plan's file has them.
///
/// # Errors
/// As [`parameters`].
pub fn everything_on(plan: &RunPlan) -> Result<Vec<u8>, Error> {
    let mut parameters = by_itself(plan)?;
    parameters.controller.encoder.output = EncoderOutput::PushPull;
    validate(&parameters, plan)?;
    record(plan, &parameters)
}

/// The same, with a profiled move to where the plan steps.
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
