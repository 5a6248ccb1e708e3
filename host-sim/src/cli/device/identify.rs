//! `stiction device identify`.

use std::path::PathBuf;
use std::time::Duration;

use serde_json::json;
use stiction::identification::{IdentificationRequest, Outcome};
use stiction::link::StateCode;

use super::{NOTHING, OFF, ended_early};
use crate::cli::outputs::check_standard_output;
use files::error::Error;
use files::typed_number;
use simulator::device::client::Client;
use simulator::device::identified::{IdentifiedJoint, ended};
use simulator::device::wire::Wire;
use simulator::device::{into, words};
use simulator::experiment::Document;
use simulator::output::{OutputFile, OverwriteGuard};
use studies::device_gear::{self, DeviceGear, PrecedingSequence};

/// Default rate of a ramp, V/s, and default time between its rise and its fall, s.
const RAMP_RATE: f32 = 0.02;
const RAMP_HOLD: f32 = 10.0;

#[derive(Debug, clap::Args)]
pub struct DeviceIdentifyArguments {
    /// Only a ramp of the effort: up until the joint moves, down until it rests. --rate and --hold
    /// imply it
    #[arg(long)]
    ramp: bool,
    /// Ramp: rate of the effort, V/s; slower is more accurate [default: 0.02]
    #[arg(long, value_name = "V/S", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    rate: Option<f32>,
    /// Ramp: time between the rise and the fall, s: some time constants of the joint [default: 10]
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    hold: Option<f32>,
    /// Largest effort, V [default: four times the device's limits.breakaway_v]
    #[arg(long, value_name = "V", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    effort: Option<f32>,
    /// Largest distance either way from the present position, deg [default: 45, or less if a limit
    /// of the position is nearer]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    travel: Option<f32>,
    /// Largest speed, deg/s [default and limit: the device's profile.velocity_deg_per_s]
    #[arg(long, value_name = "DEG/S", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    speed: Option<f32>,
    /// Longest time, s [default: 300]
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    time: Option<f32>,
    /// Write the device's parameters with the identified joint to this new machine's file; - for
    /// the standard output
    #[arg(long, value_name = "FILE.toml")]
    into: Option<PathBuf>,
    /// With --into: write over a file that exists
    #[arg(long = "force", visible_alias = "overwrite", requires = "into")]
    pub overwrite: bool,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Text of the result, and an error if no joint was identified.
pub struct IdentifyReport {
    pub text: String,
    pub ended: Result<(), Error>,
}

impl DeviceIdentifyArguments {
    /// Returns whether the options select a ramp.
    const fn is_ramp(&self) -> bool {
        self.ramp || self.rate.is_some() || self.hold.is_some()
    }

    /// Refuses options that do not go together, before anything moves.
    pub fn check(&self) -> Result<(), Error> {
        let of_sequence = [
            ("--effort", self.effort.is_some()),
            ("--travel", self.travel.is_some()),
            ("--speed", self.speed.is_some()),
            ("--time", self.time.is_some()),
            ("--into", self.into.is_some()),
            ("--json", self.json),
        ];
        if let Some((name, _)) = of_sequence.iter().find(|(_, given)| *given && self.is_ramp()) {
            return Err(Error::Input(format!(
                "device identify: {name} does not go with a ramp (--ramp, --rate, --hold)"
            )));
        }
        Ok(())
    }

    /// Checks the path of the joint's file, if one is to be written.
    pub fn output(&self, guard: &OverwriteGuard) -> Result<Option<OutputFile>, Error> {
        let into = self.into.as_ref().map(|path| guard.new_file("--into", path)).transpose()?;
        check_standard_output(self.json, into.as_ref())?;
        Ok(into)
    }

    /// Runs the identification to its end. If `machine` is a data sheet, a written file uses its SI
    /// units.
    pub fn run<W: Wire>(
        &self,
        client: &mut Client<W>,
        machine: &str,
        into: Option<&OutputFile>,
    ) -> Result<IdentifyReport, Error> {
        if self.is_ramp() {
            let rate = self.rate.unwrap_or(RAMP_RATE);
            let text = ramp(client, rate, self.hold.unwrap_or(RAMP_HOLD))?;
            return Ok(IdentifyReport { text, ended: Ok(()) });
        }
        let document = Document::open(machine)?;
        let units = document.mapping()?.map(|(_, mapping)| mapping.units);
        let parameters = client.parameters()?;
        if !client.status()?.at_rest && !client.pass(Duration::from_millis(100))?.at_rest {
            return Err(Error::Device(
                "identify: the joint moves though the motor is off: a load or a person moves it. \
                 Nothing was driven. Let the joint come to rest. If its load moves it, take the \
                 load off or balance it (a counterweight, another posture). Keep clear, and \
                 identify again. A joint that its load moves without effort cannot be identified \
                 with that load on it"
                    .into(),
            ));
        }
        let Self { effort, travel, speed, time, .. } = *self;
        let asked = IdentificationRequest { effort, travel, speed, time };
        let asked = client.check_identification(&asked)?;
        let begin = client.status()?.position;
        client.identify_joint(asked)?;
        let status = until_off(client)?;
        let (summary, map) =
            client.identified()?.ok_or_else(|| ended_early("identify", &status, NOTHING))?;
        let sequence = PrecedingSequence { bounds: asked, begin };
        let gear = if parameters.controller.motor.count().is_none() {
            Ok(None)
        } else {
            client.status().map(|at| at.position).and_then(|end| {
                match sequence.moves(summary.outcome, end, &parameters) {
                    Some(Ok(moves)) => {
                        device_gear::measure(client, &parameters, units, moves).map(Some)
                    }
                    Some(Err(why)) => Ok(Some(Err(why))),
                    None => Ok(None),
                }
            })
        };
        // The joint is known by now: what goes wrong with the gear does not lose it.
        let (gear, failed) = match gear {
            Ok(None) => (None, false),
            Ok(gear) => (gear, !client.status().is_ok_and(|status| status.fault.code == 0)),
            Err(error) => (Some(Err(error.to_string())), true),
        };
        let measured = gear.as_ref().and_then(|gear| gear.as_ref().ok()?.measured());
        let found = IdentifiedJoint { summary, map, parameters, units, gear: measured };
        let warning = client.warning();
        let outcome = found.summary.outcome;
        let mut ended = if outcome == Outcome::Done {
            Ok(())
        } else {
            Err(Error::Device(format!("identify: {}", ended(outcome))))
        };
        if failed && ended.is_ok() {
            let what = "identify: the joint is identified, its gear is not: the moves for it were \
                        ended, and the result has the reason; the motor is off";
            ended = Err(Error::Device(what.into()));
        }
        // A run takes minutes, so its result is printed even if the file cannot be written.
        let (mut file, mut new) = (None, into::IdentifiedFile::default());
        if let Some(wanted) = into {
            match written(wanted, &found, &document, warning) {
                Ok(written) => (file, new) = (Some(wanted), written),
                Err(error) => {
                    let by_hand = if found.gear.is_some() { BY_HAND } else { "" };
                    ended = Err(Error::Device(format!("{error}{by_hand}; the motor is off")));
                }
            }
        }
        if self.json {
            let mut object = found.json(warning);
            object["gear"] = gear.iter().flatten().next().map(DeviceGear::json).into();
            object["gear_refused"] = gear.and_then(Result::err).into();
            object["written"] = file.map(ToString::to_string).into();
            object["left_out"] = new.left_out.into();
            object["kept"] = new.kept.into();
            object["contradicted"] = json!(new.contradicted);
            return Ok(IdentifyReport { text: format!("{object:#}\n"), ended });
        }
        let mut text = warning.map_or(String::new(), |warning| format!("{warning}\n"));
        text += &found.words();
        text += &gear.as_ref().map_or_else(String::new, device_gear::words_of);
        text += OFF;
        if let Some(file) = file {
            text += &format!("{file}: written, with the identified joint\n");
        }
        new.words.iter().chain(&new.left_out).for_each(|line| text += &format!("{line}\n"));
        Ok(IdentifyReport { text, ended })
    }
}

/// What to do with a gear that is measured, but not written.
const BY_HAND: &str = "; the gear is measured: copy stiffness and slack of the gear by hand";

/// Options that set the bounds of an identification. An error names them if a bound ended it.
const OPTIONS: &str = " (--effort, --travel, --speed, --time)";

/// Writes the file of an identified joint, and returns what it keeps, contradicts and leaves out.
fn written(
    file: &OutputFile,
    found: &IdentifiedJoint,
    of: &Document,
    warning: Option<&str>,
) -> Result<into::IdentifiedFile, Error> {
    let nothing = |why: Error| Error::Device(format!("identify --into: nothing is written: {why}"));
    found.joint().map_err(|why| {
        let at_bounds = matches!(
            found.summary.outcome,
            Outcome::Still | Outcome::Travel | Outcome::Speed | Outcome::Time
        );
        let options = if at_bounds { OPTIONS } else { "" };
        nothing(Error::Device(format!("{why}{options}")))
    })?;
    let header = warning.map_or(String::new(), |warning| format!("# {warning}\n"));
    let written = into::written(found, of)?;
    file.write((header + &written.text).as_bytes())?;
    Ok(written)
}

/// Waits until the device has turned the motor off.
fn until_off<W: Wire>(client: &mut Client<W>) -> Result<stiction::link::Status, Error> {
    loop {
        let status = client.pass(Duration::from_secs(1))?;
        if status.state != StateCode::Armed {
            return Ok(status);
        }
    }
}

/// Runs a ramp to its end.
fn ramp<W: Wire>(client: &mut Client<W>, rate: f32, hold: f32) -> Result<String, Error> {
    client.identify(rate, hold)?;
    let status = until_off(client)?;
    let found = client.levels()?.ok_or_else(|| ended_early("identify", &status, NOTHING))?;
    let warning = client.warning().map_or(String::new(), |warning| format!("{warning}\n"));
    Ok(warning + &words::levels(&found, rate) + OFF)
}
