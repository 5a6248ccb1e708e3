//! `stiction studio`.

use std::net::SocketAddr;
use std::path::PathBuf;

use super::device::planned;
use super::print;
use crate::studio::{Server, StudioOptions};
use files::error::Error;
use simulator::device::port::SerialWire;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SIMULATED, SimulatedWire};
use simulator::experiment::RunPlan;

#[derive(Debug, clap::Args)]
pub struct StudioArguments {
    /// The joint to simulate and to predict with: a name from `stiction list`, or a machine's own
    /// TOML file [default: step-response; with --port none: predictions start once a joint is
    /// identified]
    #[arg(value_name = "NAME|FILE.toml")]
    machine: Option<String>,
    /// Use the core in this program, around the simulated joint: no motor moves or stops [default]
    #[arg(long, conflicts_with_all = ["emulator", "port"])]
    simulated: bool,
    /// Use the flash image on an emulated microcontroller, around the same joint: no motor moves or
    /// stops
    #[arg(long, conflicts_with = "port")]
    emulator: bool,
    /// Emulator: the flash image [default: the one that cargo xtask firmware builds]
    #[arg(long, value_name = "ELF", requires = "emulator")]
    image: Option<PathBuf>,
    /// Use a board on a serial port: A MOTOR CAN MOVE
    #[arg(long, value_name = "DEV")]
    port: Option<PathBuf>,
    /// Simulated and emulated device: its true joint, if it differs from the one of the file, with
    /// which the page predicts
    #[arg(long, value_name = "NAME|FILE.toml", conflicts_with = "port")]
    truth: Option<String>,
    /// Controller that the simulated device starts with [default: a file's own, and srnf for an
    /// experiment from `stiction list`]
    #[arg(long, value_name = "NAME")]
    controller: Option<String>,
    /// Address to listen at. With another address than 127.0.0.1, other machines that know the
    /// token can connect; the connection is not encrypted
    #[arg(long, value_name = "IP:PORT", default_value = "127.0.0.1:0")]
    listen: SocketAddr,
    /// Do not open a browser
    #[arg(long)]
    no_open: bool,
}

impl StudioArguments {
    /// Returns the given file, or a built-in experiment if there is none.
    fn machine(&self) -> &str {
        self.machine.as_deref().unwrap_or("step-response")
    }

    /// Plans the run of a simulated device's joint.
    fn planned(&self) -> Result<RunPlan, Error> {
        planned(self.machine(), self.controller.as_deref(), self.truth.as_deref())
    }
}

/// Serves the page until the program is ended.
pub fn studio(arguments: &StudioArguments) -> Result<(), Error> {
    let wanted = StudioOptions {
        listen: arguments.listen,
        machine: arguments.machine().into(),
        is_its_file: arguments.machine.is_some() || arguments.port.is_none(),
        every_tick: arguments.port.is_none() && !arguments.emulator,
    };
    let (server, warning) = if let Some(port) = arguments.port.clone() {
        let warning = "A BOARD: its motor can move.";
        (Server::start(wanted, move || SerialWire::open(&port))?, warning)
    } else if arguments.emulator {
        emulated(wanted, arguments)?
    } else {
        let plan = arguments.planned()?;
        let open = move || SimulatedDevice::new(&plan).map(SimulatedWire::new);
        (Server::start(wanted, open)?, SIMULATED)
    };
    let url = server.url();
    print(&format!("{url}\n{warning}\nCtrl-C ends it.\n"))?;
    if !server.address().ip().is_loopback() {
        super::warn(&[
            "the connection is not encrypted: others on this network can read the token".into(),
        ]);
    }
    if !arguments.no_open && open::that_detached(&url).is_err() {
        super::warn(&["no browser could be opened; open the address above in one".into()]);
    }
    server.wait();
    Ok(())
}

#[cfg(not(feature = "emulator"))]
fn emulated(_: StudioOptions, _: &StudioArguments) -> Result<(Server, &'static str), Error> {
    Err(super::target::not_built("studio --emulator"))
}

#[cfg(feature = "emulator")]
fn emulated(
    wanted: StudioOptions,
    arguments: &StudioArguments,
) -> Result<(Server, &'static str), Error> {
    use emulator::wire::{EMULATED, EmulatedWire};

    let plan = arguments.planned()?;
    let image = arguments.image.clone();
    let open = move || EmulatedWire::new(image.as_deref(), &plan);
    Ok((Server::start(wanted, open)?, EMULATED))
}
