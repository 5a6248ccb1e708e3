//! Runs that are counted, with everything on that a device may be told to do in a tick: every monitor, the soft start, and
//! an output that is scaled by the supply.
//!
//! No core is replayed beside them, since the host's loop has neither soft start nor supply: the joint follows what the
//! bridge does. That the image computes what the core does is shown elsewhere, with both off.

use std::sync::Arc;

use rayon::prelude::*;
use rigless::emulator::{AccessKind, Driver, Host, Settled, Start, Stop};
use rigless::session::Session;
use rigless::time::VirtualNanos;

use super::board::{EmulatedBoard, Fitted};
use super::image::FirmwareImage;
use super::in_the_loop::{TIM2_CNT, flash};
use super::log::Log;
use super::parameters;
use super::probe::{Points, Probe};
use super::rig::Rig;
use crate::error::Error;
use crate::experiment::RunPlan;

/// What turns on what the benchmark's files leave off. The soft start takes most of a step's motion with it, and the
/// supply is a tenth below the nominal one, so that every output is scaled.
pub const EVERYTHING_ON: [&str; 3] =
    ["device.soft_start_s=2", "device.nominal_supply_v=12", "device.supply_full_scale_v=24"];
/// On the pin, mV: of 3300 mV that stand for 24 V, those of 10.8 V.
const SUPPLY_PIN_MV: u32 = 1485;
/// From power-on to the first sample of the motion: a second of boot and of waiting for a joint at rest is plenty, ns.
const BOOT_NS: u64 = 1_000_000_000;

/// Counts all plans, as many at once as there are cores. Each is to be made with [`EVERYTHING_ON`].
///
/// # Errors
/// The first plan that cannot be run to its last sample, or whose ticks cannot be counted.
pub fn count_all(
    image: &Arc<FirmwareImage>,
    points: &Arc<Points>,
    plans: &[RunPlan],
) -> Result<Vec<Probe>, Error> {
    plans.par_iter().map(|plan| count(image, points, plan)).collect()
}

/// Counts one plan, from power-on to its last sample.
///
/// # Errors
/// As [`count_all`].
pub fn count(image: &Arc<FirmwareImage>, points: &Arc<Points>, plan: &RunPlan) -> Result<Probe, Error> {
    plan.validate()?;
    let trouble = |why: String| Error::Emulator(format!("{}: {why}", plan.label));
    let record = parameters::everything_on(plan)?;
    let images = flash(image, [Some(&record), None]).map_err(&trouble)?;
    let fitted = Fitted { supply_pin_mv: SUPPLY_PIN_MV, ..Fitted::default() };
    let board = Box::new(EmulatedBoard::new(fitted)?);
    let samples = plan.samples()? as usize;
    let sample_s = plan.machine.sampling.sample_time_s();
    let meter = Meter {
        rig: Rig::new(plan, Log::new(image.clone(), &plan.label, None))?,
        probe: Probe::new(points.clone()),
        samples,
        give_up_at: VirtualNanos(BOOT_NS + ((samples + 2) as f64 * sample_s * 1e9) as u64),
        failed: None,
    };
    let session = Session::new(board, 0, VirtualNanos(0)).map_err(|error| trouble(error.to_string()))?;
    let finished = rigless::emulator::run(session, &Start::new(&images), meter)
        .map_err(|error| trouble(error.to_string()))?;
    let Meter { rig, probe, failed, .. } = finished.driver;
    let failed = failed.or_else(|| probe.trouble.clone());
    if let Some(why) = failed {
        return Err(trouble(format!("{why}; {}", rig.log.tail())));
    }
    if probe.disturbed {
        return Err(trouble("the control interrupt was itself interrupted".into()));
    }
    Ok(probe)
}

struct Meter {
    rig: Rig,
    probe: Probe,
    /// After the first.
    samples: usize,
    give_up_at: VirtualNanos,
    failed: Option<String>,
}

impl Meter {
    fn act(
        &mut self,
        board: &mut EmulatedBoard,
        host: &mut dyn Host,
        at: VirtualNanos,
    ) -> Result<bool, String> {
        if at.0 == 0 {
            self.probe.attach(host).map_err(|error| error.to_string())?;
        }
        self.rig.act(board, host, at).map_err(|error| error.to_string())?;
        if self.probe.ticks.len() > self.samples {
            self.probe.detach(host).map_err(|error| error.to_string())?;
            return Ok(false);
        }
        if at >= self.give_up_at {
            let ticks = self.probe.ticks.len();
            return Err(format!("it was not armed all the time: {ticks} ticks of {}", self.samples + 1));
        }
        Ok(true)
    }
}

impl Driver<EmulatedBoard> for Meter {
    fn on_settled(&mut self, session: &mut Session<EmulatedBoard>, _: &mut dyn Host, settled: Settled) {
        match settled {
            Settled::Hit(hit) => self.probe.hit(&hit),
            Settled::Access { access, .. } => {
                if (access.kind, access.address) == (AccessKind::Read, TIM2_CNT) {
                    self.rig.counter_read(session.board_mut(), access.virtual_time);
                    session.run_until(self.rig.next());
                }
            }
            _ => session.board_mut().settle(),
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<EmulatedBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        match self.act(session.board_mut(), host, stop.at) {
            Ok(true) => Some(self.rig.next()),
            Ok(false) => None,
            Err(why) => {
                self.failed = Some(why);
                None
            }
        }
    }
}
