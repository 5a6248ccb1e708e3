//! `stiction params`.

use std::path::PathBuf;

use stiction::parameters::DeviceConfig;

use super::outputs::print_beside;
use super::warn;
use files::error::Error;
use simulator::device::sectors;
use simulator::experiment::{Document, Experiment};
use simulator::output::OverwriteGuard;

/// Address of sector 10 of the flash; sector 11 follows it.
const ADDRESS: u32 = 0x080C_0000;

#[derive(Debug, clap::Args)]
pub struct ParamsArguments {
    /// A name from `stiction list`, or a machine's own TOML file
    experiment: String,
    /// File for the contents of both parameter sectors; - for the standard output
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Write over a file that this command reads, or over a machine's file
    #[arg(long)]
    force: bool,
    /// Set a key of the file, as in device.autostart=true
    #[arg(long, value_name = "TABLE.KEY=VALUE")]
    set: Vec<String>,
    /// This controller instead of the file's first
    #[arg(long, value_name = "NAME")]
    controller: Option<String>,
}

pub fn params(arguments: &ParamsArguments) -> Result<(), Error> {
    let guard = OverwriteGuard::new(arguments.force).opens(&arguments.experiment);
    let out = guard.results("--out", &arguments.out)?;
    let mut document = Document::open(&arguments.experiment)?;
    document.set(&arguments.set)?;
    warn(&document.doubts()?);
    let fixed: Vec<String> = arguments
        .set
        .iter()
        .filter_map(|a| a.split_once('='))
        .map(|(key, _)| key.trim().into())
        .collect();
    let controllers: Vec<String> = arguments.controller.iter().cloned().collect();
    let experiment = Experiment::plan(&document, &controllers, &fixed)?;
    warn(&experiment.left_out);
    let Some(plan) = experiment.runs.first() else { return Ok(()) };
    let sectors = sectors(plan)?;
    out.write(&sectors)?;
    let device = plan.machine.device.core(DeviceConfig::CAUTIOUS);
    let arming = if device.autostart {
        format!("arms automatically {} s after power-on", device.autostart_delay)
    } else {
        "does not move: device.autostart is false".into()
    };
    let path = if out.is_standard_output() { "FILE".into() } else { out.to_string() };
    let text = format!(
        "{path}: {}, for sectors 10 and 11; the board {arming}\n\
         probe-rs download --chip STM32F405RGTx --binary-format bin --base-address {ADDRESS:#x} \
         {path}\n",
        plan.label,
    );
    print_beside(Some(&out), &text)
}
