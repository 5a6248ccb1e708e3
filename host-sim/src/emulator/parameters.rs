//! The parameter sector that a run's image finds.

use stiction::Parameters;
use stiction::parameters::{Device, Motion as DeviceMotion, ROOM};
use stiction::position::Position;
use stiction::reference::{Corner, MAX_CORNERS};

use crate::error::Error;
use crate::experiment::{Motion, RunPlan};

/// From the first tick to arming, in ticks: time for the encoder to be shown where the joint is.
const WAIT_TICKS: f32 = 3.0;

/// What the device is told so that it does what the host does: to begin by itself, at once with its full scale, and
/// to leave the duty alone.
///
/// # Errors
/// Names a value that is not allowed, or that the device would refuse.
pub fn parameters(plan: &RunPlan) -> Result<Parameters, Error> {
    let controller = plan.controller_config()?;
    // The device calls the place zero in which it is armed. The host's joint rests there too, but its disc may already
    // be a count further.
    let start = plan.encoder()?.counts(0.0) as i32;
    let seen = |position: Position| Position { counts: position.counts.wrapping_sub(start), ..position };
    let corners = plan.corners()?;
    let motion = match &plan.motion {
        Motion::Step(_) => {
            DeviceMotion::Step(seen(corners.first().map_or(Position::default(), |corner| corner.position)))
        }
        Motion::Trajectory(trajectory) => {
            let mut moved = heapless::Vec::<_, MAX_CORNERS>::new();
            for corner in &corners {
                let corner = Corner { position: seen(corner.position), ..*corner };
                moved.push(corner).map_err(|_| {
                    let why = format!("a device takes at most {MAX_CORNERS} corners");
                    Error::Input(format!("{}: `{}`: {why}", plan.origin, plan.label))
                })?;
            }
            DeviceMotion::Trajectory { corners: moved, half_blend: trajectory.half_blend_s as f32 }
        }
        Motion::Ramp(_) => {
            return Err(Error::Input(format!(
                "{}: `{}` is a ramp of the effort, which the firmware has no law for; run it with --target host",
                plan.origin, plan.label
            )));
        }
    };
    let device = Device {
        autostart: true,
        autostart_delay: WAIT_TICKS * controller.sample_time,
        soft_start: 0.0,
        nominal_supply: 0.0,
        ..Device::CAUTIOUS
    };
    let parameters = Parameters { controller, motion, device };
    parameters.prepare().map_err(|error| {
        Error::Input(format!("{}: `{}` cannot run on the device: {error}", plan.origin, plan.label))
    })?;
    Ok(parameters)
}

/// The same as the bytes of the sector.
///
/// # Errors
/// As [`parameters`].
pub fn blob(plan: &RunPlan) -> Result<Vec<u8>, Error> {
    let mut room = [0; ROOM];
    let record = parameters(plan)?.encode(1, &mut room).map(<[u8]>::to_vec);
    record.ok_or_else(|| Error::Input(format!("{}: the parameters do not fit {ROOM} bytes", plan.origin)))
}
