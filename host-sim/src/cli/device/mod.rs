//! `stiction device`.

mod edit;
mod home;
mod identify;
mod jog;
mod moves;
mod params;
mod pulled_file;
mod selftest;
#[cfg(feature = "watch")]
mod watch;
#[cfg(not(feature = "watch"))]
#[path = "no_watch.rs"]
mod watch;
mod winding;

use std::io::{Write, stderr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use stiction::link::{StateCode, Status};

use super::outputs::print_beside;
use super::{interrupt, print};
use files::error::Error;
use files::typed_number;
use simulator::device::client::Client;
use simulator::device::log::SampleLog;
use simulator::device::signals::Signals;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use simulator::device::{json, words};
use simulator::experiment::{Document, Experiment, RunPlan, builtins};
use simulator::output::{OutputFile, OverwriteGuard};

#[derive(Debug, clap::Args)]
pub struct DeviceArguments {
    /// Use a board on this serial port
    #[arg(long, value_name = "DEV")]
    port: Option<PathBuf>,
    /// Use the flash image on an emulated microcontroller, around the joint of --machine: no motor
    /// moves or stops
    #[arg(long)]
    emulator: bool,
    /// Emulator: the flash image [default: the one that cargo xtask firmware builds]
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// Use the core in this program, around the simulated joint of --machine: no motor moves or
    /// stops
    #[arg(long)]
    simulated: bool,
    /// The joint to simulate: a name from `stiction list`, or a machine's own TOML file
    #[arg(long, value_name = "NAME|FILE.toml", default_value = "step-response")]
    machine: String,
    /// Simulated and emulated device: its true joint, if it differs from the one of --machine,
    /// which the commands assume
    #[arg(long, value_name = "NAME|FILE.toml")]
    truth: Option<String>,
    /// Controller that the simulated device starts with [default: a file's own, and srnf for an
    /// experiment from `stiction list`]
    #[arg(long, value_name = "NAME")]
    controller: Option<String>,
    #[command(subcommand)]
    action: Action,
}

/// Returns the controller that the device starts with: that of the option, or SRNF for a built-in
/// experiment that has it. Otherwise returns `None`, and the device starts with the file's own.
fn begins_with<'a>(machine: &str, controller: Option<&'a str>) -> Option<&'a str> {
    const USUAL: &str = "srnf";
    let has_it = || {
        let opened = Document::open(machine).and_then(|document| document.machine());
        let is_listed = builtins().iter().any(|builtin| builtin.name == machine);
        is_listed && opened.is_ok_and(|machine| machine.controller.contains_key(USUAL))
    };
    controller.or_else(|| has_it().then_some(USUAL))
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Show state, fault, position, warnings
    Status {
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// Watch the device live, and arm, move and stop it by keys
    Watch,
    /// Arm at the present position, and hold it
    Arm {
        /// Time, s, after which the motor is turned off
        #[arg(long, value_name = "S", default_value_t = 5.0, allow_hyphen_values = true)]
        #[arg(value_parser = typed_number::parse)]
        r#for: f64,
    },
    /// Turn the motor off at once: nothing drives, holds or brakes the joint then
    Stop,
    /// Stop the motor that another client drives, and end the session of that client
    TakeOver,
    /// Arm if it is not armed, and move to a position within the limits of [profile]
    Move(moves::MoveArguments),
    /// Push a new joint a little each way, without a loop, and check the sense of its encoder: the
    /// first powered motion
    Jog(jog::JogArguments),
    /// Find the joint's position: go one way, slowly and with a bounded effort, until a hard stop
    /// blocks the joint, and set the reference there
    Home(home::HomeArguments),
    /// Measure resistance and inductance of the motor's winding, by pulses of voltage at rest
    Winding(winding::WindingArguments),
    /// Set the position at which the joint stands, from which its range counts
    Reference {
        /// Position of the joint, deg
        #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true)]
        #[arg(value_parser = typed_number::parse)]
        at: f64,
    },
    /// Identify the joint by a bounded sequence of motions: breakaway, friction, inertia, load,
    /// with error bars and a verdict; or with --ramp, two levels by a ramp of the effort
    Identify(identify::DeviceIdentifyArguments),
    /// Make twenty moves within stated bounds, and compare the joint with the simulation of
    /// --machine, with its error bars
    Selftest(selftest::SelftestArguments),
    /// Show, change or save the parameters of the device
    Params {
        #[command(subcommand)]
        action: params::ParamsAction,
    },
    /// List the faults that the device remembers
    Faults {
        /// Clear the latched fault
        #[arg(long)]
        clear: bool,
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// Turn the microcontroller's brown-out reset on permanently: a supply dip is then
    /// distinguished from power-on
    SetBrownOut,
    /// Write samples to a file, in the columns of `stiction run --csv`
    Log {
        /// Output file; - for the standard output
        file: PathBuf,
        /// Write over a file that this command reads, or over a machine's file
        #[arg(long)]
        force: bool,
        /// Time, s
        #[arg(long, value_name = "S", default_value_t = 5.0, allow_hyphen_values = true)]
        #[arg(value_parser = typed_number::parse)]
        r#for: f64,
        /// Ticks from one sample to the next
        #[arg(long, value_name = "N", default_value_t = 1)]
        #[arg(value_parser = clap::value_parser!(u16).range(1..))]
        every: u16,
        /// Further signals, a column each, by the names that the device announces
        #[arg(long, value_name = "NAME", value_delimiter = ',')]
        signals: Vec<String>,
    },
}

pub fn device(arguments: &DeviceArguments) -> Result<(), Error> {
    if let Action::Watch = arguments.action {
        watch::on_a_terminal()?;
    }
    // Before a device is opened, and before anything moves.
    let output = arguments.output()?;
    let output = output.as_ref();
    let chosen = [arguments.port.is_some(), arguments.emulator, arguments.simulated];
    if chosen.iter().filter(|chosen| **chosen).count() != 1 {
        let which = "--port is a real motor, the others drive none";
        return Err(Error::Input(format!(
            "device: exactly one of --port DEV, --emulator and --simulated is needed: {which}"
        )));
    }
    if arguments.emulator {
        return emulated(arguments, output);
    }
    if arguments.image.is_some() {
        return Err(Error::Input(
            "device --image needs --emulator; no other device runs an image".into(),
        ));
    }
    if let Some(port) = &arguments.port {
        if let Some(truth) = &arguments.truth {
            return Err(truth_of_a_board(truth));
        }
        return with(
            &arguments.action,
            &arguments.machine,
            simulator::device::port::SerialWire::open(port)?,
            output,
        );
    }
    let plan = arguments.planned()?;
    let wire = SimulatedWire::new(SimulatedDevice::new(&plan)?);
    with(&arguments.action, &arguments.machine, wire, output)
}

impl DeviceArguments {
    /// Plans the run of a simulated device's joint.
    fn planned(&self) -> Result<RunPlan, Error> {
        planned(&self.machine, self.controller.as_deref(), self.truth.as_deref())
    }

    /// Checks the path of the file that the command writes, if any.
    fn output(&self) -> Result<Option<OutputFile>, Error> {
        let guard = |force: bool| {
            let guard = OverwriteGuard::new(force).opens(&self.machine);
            let guard = self.truth.iter().fold(guard, |guard, truth| guard.opens(truth));
            self.image.iter().chain(&self.port).fold(guard, OverwriteGuard::reads)
        };
        match &self.action {
            Action::Log { file, force, .. } => guard(*force).results("device log", file).map(Some),
            Action::Move(arguments) => arguments.output(&guard(arguments.force)),
            Action::Identify(arguments) => arguments.output(&guard(arguments.overwrite)),
            Action::Params { action: params::ParamsAction::Pull { file, force } } => {
                guard(*force).results("device params pull", file).map(Some)
            }
            _ => Ok(None),
        }
    }
}

fn warn(warning: Option<&str>) {
    if let Some(warning) = warning {
        let _ = writeln!(stderr(), "{warning}");
    }
}

#[cfg(not(feature = "emulator"))]
fn emulated(_: &DeviceArguments, _: Option<&OutputFile>) -> Result<(), Error> {
    Err(super::target::not_built("device --emulator"))
}

#[cfg(feature = "emulator")]
fn emulated(arguments: &DeviceArguments, output: Option<&OutputFile>) -> Result<(), Error> {
    use emulator::wire::EmulatedWire;

    let plan = arguments.planned()?;
    with(
        &arguments.action,
        &arguments.machine,
        EmulatedWire::new(arguments.image.as_deref(), &plan)?,
        output,
    )
}

/// Plans the run of a simulated device's joint. With `truth`, the device has the joint of that file
/// instead.
pub(super) fn planned(
    machine: &str,
    controller: Option<&str>,
    truth: Option<&str>,
) -> Result<RunPlan, Error> {
    let plan = first_run(machine, begins_with(machine, controller))?;
    match truth {
        None => Ok(plan),
        Some(truth) => plan.with_truth(first_run(truth, None)?),
    }
}

/// Returns the error that refuses `--truth` for a board.
fn truth_of_a_board(truth: &str) -> Error {
    Error::Input(format!(
        "--truth {truth}: a board on a --port has its own joint; leave --truth out, or use \
         --simulated or --emulator"
    ))
}

fn first_run(machine: &str, controller: Option<&str>) -> Result<RunPlan, Error> {
    let document = Document::open(machine)?;
    let wanted: Vec<String> = controller.iter().map(|name| (*name).to_owned()).collect();
    let first = Experiment::plan(&document, &wanted, &[])?.into_first();
    first.ok_or_else(|| Error::Input(format!("{machine}: there is nothing to run")))
}

fn with(
    action: &Action,
    machine: &str,
    wire: impl Wire,
    output: Option<&OutputFile>,
) -> Result<(), Error> {
    // The warning precedes any error, on the same stream.
    let warned = wire.warning();
    warn(warned);
    let mut client = Client::connect(wire)?;
    let warning = client.warning();
    if warned.is_none() {
        warn(warning);
    }
    let warning = warning.map_or(String::new(), |warning| format!("{warning}\n"));
    let say = |text: String| print_beside(output, &format!("{warning}{text}"));
    if action.ends_on_ctrl_c() {
        end_on_ctrl_c(&mut client)?;
    }
    match action {
        Action::Status { json } => {
            let status = client.status()?;
            if *json {
                return print(&format!("{:#}\n", json::status(&status, client.warning())));
            }
            say(words::status(&status))
        }
        Action::Watch => {
            let left = watch::watch(&mut client)?;
            say(left)
        }
        Action::Arm { r#for } => {
            let time = time("--for", *r#for)?;
            let status = then_off(&mut client, |client| {
                arm(client)?;
                client.pass_armed(time)
            })?;
            let ended = ended("arm", &status);
            say(words::status(&status) + off(&status))?;
            ended
        }
        Action::Stop => {
            client.stop()?;
            let status = client.status()?;
            say(words::status(&status))
        }
        Action::TakeOver => {
            client.take_over()?;
            let status = client.status()?;
            say(words::status(&status))
        }
        Action::Move(arguments) => {
            let judged = moves::MoveCriteria::by(machine)?;
            let said = moves::go(arguments, &mut client, output, &judged)?;
            if said.alone {
                print(&said.text)?
            } else {
                say(said.text)?
            }
            said.ended
        }
        Action::Jog(jog) => {
            let jogged = then_off(&mut client, |client| jog.run(client))?;
            print(&jog.shown(&jogged, client.warning())?)?;
            jog::agrees(&jogged)
        }
        Action::Home(home) => {
            let result = then_off(&mut client, |client| home.run(client))?;
            print(&home.shown(&result, client.warning()))?;
            home::found(&result)
        }
        Action::Winding(winding) => {
            let result = then_off(&mut client, |client| winding.run(client))?;
            print(&winding.shown(&result, client.warning()))
        }
        Action::Reference { at } => {
            client.set_reference(*at)?;
            let status = client.status()?;
            say(words::status(&status))
        }
        Action::Identify(identify) => {
            identify.check()?;
            let said = then_off(&mut client, |client| identify.run(client, machine, output))?;
            print_beside(output, &said.text)?;
            said.ended
        }
        Action::Selftest(arguments) => {
            let said = selftest::test(arguments, &mut client, machine)?;
            print(&said.text)?;
            said.ended
        }
        Action::Params { action } => {
            let text = params::params(action, &mut client, machine, output)?;
            say(text)
        }
        Action::Faults { clear, json } => {
            if *clear {
                client.clear()?;
            }
            let (status, faults) = (client.status()?, client.faults()?);
            if *json {
                let each = faults.iter().map(|one| (one.code, one.tick, one.value));
                let object = json::faults(each, &status, client.warning());
                return print(&format!("{object:#}\n"));
            }
            say(words::faults(&faults, &status))
        }
        Action::SetBrownOut => {
            client.set_brown_out()?;
            say(words::BROWN_OUT_SET.into())
        }
        Action::Log { r#for, every, signals, .. } => {
            let time = time("--for", *r#for)?;
            let mut samples = SampleLog::new(Signals::new(client.signals()?), signals)?;
            client.subscribe(samples.mask(), *every)?;
            let (status, ended) = kept(&mut client, |client| client.pass(time))?;
            while let Some(sample) = client.sample(Duration::ZERO)? {
                samples.push(sample);
            }
            client.subscribe(0, 0)?;
            let Some(file) = output else { return Ok(()) };
            file.write(&samples.render(status.sample_time, status.resolution)?)?;
            say(format!("{file}: {} samples\n", samples.len()) + &lost(&client))?;
            ended.map_err(|why| Error::CtrlC(format!("log: {why}; what was logged is kept")))
        }
    }
}

impl Action {
    /// Returns whether Ctrl-C ends the command in order: logged samples are written, and a motor
    /// that the command drives is turned off. The self-test sets this up itself, just before its
    /// moves.
    const fn ends_on_ctrl_c(&self) -> bool {
        matches!(
            self,
            Self::Arm { .. }
                | Self::Move(_)
                | Self::Jog(_)
                | Self::Home(_)
                | Self::Winding(_)
                | Self::Identify(_)
                | Self::Log { .. }
        )
    }
}

/// Makes Ctrl-C end each wait of a client.
fn end_on_ctrl_c<W: Wire>(client: &mut Client<W>) -> Result<(), Error> {
    let interrupt = Arc::default();
    interrupt::end_on_ctrl_c(&interrupt)?;
    client.end_on(interrupt);
    Ok(())
}

/// Runs `wait`, and returns the status at its end. If Ctrl-C ended the wait, its error is returned
/// beside the status, and the samples until then are kept.
fn kept<W: Wire>(
    client: &mut Client<W>,
    wait: impl FnOnce(&mut Client<W>) -> Result<Status, Error>,
) -> Result<(Status, Result<(), Error>), Error> {
    match wait(client) {
        Ok(status) => Ok((status, Ok(()))),
        Err(error @ Error::CtrlC(_)) => Ok((client.status()?, Err(error))),
        Err(error) => Err(error),
    }
}

/// Arms the device once the joint counts as at rest: 50 ms after a stop or a change of parameters.
fn arm<W: Wire>(client: &mut Client<W>) -> Result<(), Error> {
    if !client.status()?.at_rest {
        client.pass(Duration::from_millis(100))?;
    }
    client.arm_tested()
}

const OFF: &str = "stopped: the motor is off now\n";

/// Remark on a drive that may not have received a stop.
const PERHAPS_ARMED: &str =
    "THE MOTOR MAY STILL BE DRIVEN: the stop was not confirmed; cut the motor's supply";

/// Runs a command that closes the loop, and then turns the output off in any case. An error reports
/// the state of the drive.
fn then_off<W: Wire, T>(
    client: &mut Client<W>,
    closed: impl FnOnce(&mut Client<W>) -> Result<T, Error>,
) -> Result<T, Error> {
    let done = closed(client);
    let left = |error: &Error, how: &str| Error::Device(format!("{error}; {how}"));
    match (done, client.stop()) {
        (Ok(found), Ok(())) => Ok(found),
        (Err(Error::CtrlC(why)), Ok(())) => Err(Error::CtrlC(format!("{why}; the motor is off"))),
        (Err(error), Ok(())) => Err(left(&error, "the motor is off")),
        (Ok(_), Err(error)) | (Err(error), Err(_)) => Err(left(&error, PERHAPS_ARMED)),
    }
}

/// Returns the sentence that the motor is off now, if the status from before the stop is armed;
/// otherwise an empty text.
const fn off(status: &Status) -> &'static str {
    if matches!(status.state, StateCode::Armed) { OFF } else { "" }
}

/// What follows if a measurement was ended early.
const NOTHING: &str = ", without a result";

/// Returns an error if the output went off before the requested time.
fn ended(what: &str, status: &Status) -> Result<(), Error> {
    if status.state == StateCode::Armed {
        return Ok(());
    }
    Err(ended_early(what, status, "; the motor is off"))
}

/// Returns the error that a fault or a stop ended a motion, with what follows from that.
fn ended_early(what: &str, status: &Status, so: &str) -> Error {
    let Status { fault, sample_time, .. } = status;
    Error::Device(match fault.code {
        0 => format!("{what}: ended by a stop command{so}"),
        _ => {
            let by = words::fault(fault, *sample_time);
            format!("{what}: ended by {by}{so} (docs/reference/faults.md)")
        }
    })
}

fn lost<W: Wire>(client: &Client<W>) -> String {
    match client.lost() {
        0 => String::new(),
        lost => format!(
            "{lost} samples did not arrive: the link is too slow for that many, or disturbed\n"
        ),
    }
}

fn time(option: &str, seconds: f64) -> Result<Duration, Error> {
    // The upper bound is a day.
    if !(0.0..=86_400.0).contains(&seconds) {
        return Err(Error::Input(format!("{option} {seconds}: must be a number from 0 to 86400")));
    }
    Ok(Duration::from_secs_f64(seconds))
}
