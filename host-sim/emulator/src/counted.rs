//! Counts the instructions of runs with everything on that a device can be configured to do in a
//! tick: every monitor, the soft start, and an output that is scaled by the supply.
//!
//! No core runs beside the image, since the host's loop has neither soft start nor supply: the
//! joint follows the bridge. Image and core are compared elsewhere, with both off. So no
//! [`Target`](simulator::target::Target) is stepped: the board runs from power-on, in lockstep with
//! the same plant, until enough ticks are counted. A halt at each tick would make the runs longer
//! without other results.

use std::sync::Arc;

use rayon::prelude::*;

use super::board::FittedParts;
use super::board_under_test::{BoardUnderTest, PlantInLockstep, PoweredOffBoard, StopCondition};
use super::image::FirmwareImage;
use super::parameters;
use super::probe::{Points, Probe};
use super::setup::BoardSetup;
use files::error::Error;
use simulator::experiment::RunPlan;

/// Assignments that turn on what the benchmark's files leave off. The soft start lasts for most of
/// a step's motion, and the supply is a tenth below the nominal one, so that every output is
/// scaled.
pub const EVERYTHING_ON: [&str; 3] =
    ["device.soft_start_s=2", "device.nominal_supply_v=12", "device.supply_full_scale_v=24"];
/// Voltage on the supply pin, mV: that of 10.8 V, with 3300 mV for 24 V.
const SUPPLY_PIN_MV: u32 = 1485;
/// Time from power-on to the first sample of the motion, ns: a second is ample for the boot and for
/// the joint to be at rest.
const BOOT_NS: u64 = 1_000_000_000;

/// Counts all plans, as many at once as there are cores. Each must be made with [`EVERYTHING_ON`].
///
/// # Errors
/// Returns an error about a plan that cannot be run to its last sample, or whose ticks cannot be
/// counted.
pub fn count_all(
    image: &Arc<FirmwareImage>,
    points: &Arc<Points>,
    plans: &[RunPlan],
) -> Result<Vec<Probe>, Error> {
    plans.par_iter().map(|plan| count(image, points, plan)).collect()
}

/// Counts all plans as [`count_all`] does, with a profiled move instead of each step.
///
/// # Errors
/// As [`count_all`].
pub fn count_all_profiled(
    image: &Arc<FirmwareImage>,
    points: &Arc<Points>,
    plans: &[RunPlan],
) -> Result<Vec<Probe>, Error> {
    let with = |plan| count_with(image, points, plan, parameters::profiled(plan)?);
    plans.par_iter().map(with).collect()
}

/// Counts one plan, from power-on to its last sample.
///
/// # Errors
/// As [`count_all`].
pub fn count(
    image: &Arc<FirmwareImage>,
    points: &Arc<Points>,
    plan: &RunPlan,
) -> Result<Probe, Error> {
    count_with(image, points, plan, parameters::everything_on(plan)?)
}

fn count_with(
    image: &Arc<FirmwareImage>,
    points: &Arc<Points>,
    plan: &RunPlan,
    record: Vec<u8>,
) -> Result<Probe, Error> {
    plan.validate()?;
    let samples = plan.samples()? as usize;
    let sample_s = plan.machine.sampling.sample_time_s();
    let or_ns = BOOT_NS + ((samples + 2) as f64 * sample_s * 1e9) as u64;
    let mut setup = BoardSetup::new(&plan.label, image, record);
    setup.fitted = FittedParts { supply_pin_mv: SUPPLY_PIN_MV, ..FittedParts::default() };
    setup.points = Some(points.clone());
    let mut board = BoardUnderTest::power_on(setup, PlantInLockstep::of(plan)?)?;
    // The end of the last sample is detected at the start of the next one.
    let counted =
        board.until(StopCondition::Counted { ticks: samples + 1, or_ns }).and_then(|()| {
            board.act(|halted| halted.harness.probe.as_ref().map_or(0, |probe| probe.ticks.len()))
        })?;
    let PoweredOffBoard { mut harness, .. } = board.off()?;
    let trouble =
        |why: &str| Error::Emulator(format!("{}: {why}; {}", plan.label, harness.log.tail()));
    let Some(probe) = harness.probe.take() else {
        return Err(trouble("no tick was counted"));
    };
    if counted <= samples {
        let asked = samples + 1;
        return Err(trouble(&format!("it was armed for only {counted} of {asked} ticks")));
    }
    match &probe.trouble {
        Some(why) => Err(trouble(why)),
        None if probe.disturbed => Err(trouble("the control interrupt was itself interrupted")),
        None => Ok(probe),
    }
}
