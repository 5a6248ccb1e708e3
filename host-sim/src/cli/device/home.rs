//! `stiction device home`.

use std::time::Duration;

use stiction::link::StateCode;
use stiction::motion::home::{HomeRequest, HomeTarget, Sense};

use files::error::Error;
use files::typed_number;
use simulator::device::client::Client;
use simulator::device::homed::HomeResult;
use simulator::device::wire::Wire;

/// Longest homing that a device allows, s: half an hour, a soft start of 10 s, and another 10 s for
/// the driver's wake-up and the end.
const LONGEST_S: u64 = 1820;

/// Sense in which the stop is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Towards {
    /// Smaller positions
    Minus,
    /// Larger positions
    Plus,
}

/// Place that the homing looks for
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Place {
    /// A hard stop
    Stop,
    /// The edge of the switch of `device.home_switch`
    Switch,
    /// The encoder's index (`device.index_counts`)
    Index,
    /// The index next to the edge of the switch, on the way back from it
    SwitchIndex,
}

/// Place of known position, and bounds of the homing
#[derive(Debug, clap::Args)]
pub struct HomeArguments {
    /// Place that the homing looks for
    #[arg(long, value_enum, default_value_t = Place::Stop)]
    to: Place,
    /// Sense in which the place is
    #[arg(long, value_enum)]
    towards: Towards,
    /// Position of the joint at the place, deg
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse)]
    at: f64,
    /// Largest effort, V, from 0.3 to 0.9 of the way from `limits.breakaway_v` to `limits.stall_v`
    /// [default: the device's jog.effort_v, within these]
    #[arg(long, value_name = "V", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    effort: Option<f32>,
    /// Largest distance from the present position, deg [default: 1.1 times the range of positions,
    /// or 360 without one]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    travel: Option<f32>,
    /// Speed, deg/s, up to that of `[profile]` [default: the device's jog.speed_deg_per_s]
    #[arg(long, value_name = "DEG/S", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    speed: Option<f32>,
    /// Longest time after the soft start, s [default: 1.5 times that of the travel, four times that
    /// of the way back (to a switch 16 times), once that of the last way into the range, and 5 s]
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    time: Option<f32>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

impl HomeArguments {
    /// Runs a homing to its end.
    pub fn run<W: Wire>(&self, client: &mut Client<W>) -> Result<HomeResult, Error> {
        let Self { effort, travel, speed, time, .. } = *self;
        let sense = match self.towards {
            Towards::Minus => Sense::Minus,
            Towards::Plus => Sense::Plus,
        };
        let to = match self.to {
            Place::Stop => HomeTarget::Stop,
            Place::Switch => HomeTarget::Switch,
            Place::Index => HomeTarget::Index,
            Place::SwitchIndex => HomeTarget::SwitchIndex,
        };
        let at = client.counts_of("home", self.at)?;
        if !client.status()?.at_rest {
            client.pass(Duration::from_millis(100))?;
        }
        client.home(HomeRequest { sense, at, effort, travel, speed, time, to })?;
        // The device ends the homing.
        let status = client.pass_armed(Duration::from_secs(LONGEST_S))?;
        match (status.state, client.homed()?) {
            (StateCode::Armed, _) => Err(Error::Device(
                "home: the device did not end the homing in time; the joint is not referenced"
                    .into(),
            )),
            (_, Some(found)) => Ok(HomeResult::new(found, to, &status, &client.parameters()?)),
            _ => {
                let place = match to {
                    HomeTarget::Stop => "a hard stop",
                    HomeTarget::Switch => "a switch",
                    HomeTarget::Index => "an index",
                    HomeTarget::SwitchIndex => "a switch with an index",
                };
                let so = format!(", before {place} was found; the joint is not referenced");
                Err(super::ended_early("home", &status, &so))
            }
        }
    }

    /// Returns the result as text, or with `--json` as a JSON object.
    pub fn shown(&self, result: &HomeResult, warning: Option<&str>) -> String {
        if self.json {
            return format!("{:#}\n", result.json(warning));
        }
        let warning = warning.map_or(String::new(), |warning| format!("{warning}\n"));
        warning + &result.words() + super::OFF
    }
}

/// Returns an error unless the place was found and the joint is referenced, so that a script stops.
pub fn found(result: &HomeResult) -> Result<(), Error> {
    if result.is_found() {
        return Ok(());
    }
    Err(Error::Device(format!("home: {}", result.headline())))
}
