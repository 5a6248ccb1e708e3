//! `stiction device jog`.

use std::time::Duration;

use stiction::Parameters;
use stiction::link::StateCode;
use stiction::motion::jog::{JogFindings, JogRequest};

use files::error::Error;
use files::typed_number;
use simulator::device::client::Client;
use simulator::device::jog_offset::{Offset, has_offset};
use simulator::device::jogged;
use simulator::device::wire::Wire;

/// Number of attempts to read the angle.
const READINGS: u32 = 5;

/// Bounds of a jog. The device refuses more than its own bounds in `[jog]`
#[derive(Debug, clap::Args)]
pub struct JogArguments {
    /// Largest effort, V [default and limit: the device's jog.effort_v]
    #[arg(long, value_name = "V", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    effort: Option<f32>,
    /// Rate of the effort, V/s [default: the device's jog.rate_v_per_s]
    #[arg(long, value_name = "V/S", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    rate: Option<f32>,
    /// Largest distance from the present position, deg [default: the device's jog.travel_deg]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    travel: Option<f32>,
    /// Largest speed, deg/s [default: the device's jog.speed_deg_per_s]
    #[arg(long, value_name = "DEG/S", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    speed: Option<f32>,
    /// Longest time, s [default: the device's jog.time_s]
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    time: Option<f32>,
    /// Position of the joint when the jog begins, deg: checks the offset of an absolute encoder
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse)]
    at: Option<f64>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Result of a jog, with the parameters of the device.
pub struct JogResult {
    pub parameters: Parameters,
    pub found: JogFindings,
    pub offset: Offset,
}

impl JogArguments {
    const fn asked(&self) -> JogRequest {
        let Self { effort, rate, travel, speed, time, .. } = *self;
        JogRequest { effort, rate, travel, speed, time }
    }

    /// Runs a jog to its end.
    pub fn run<W: Wire>(&self, client: &mut Client<W>) -> Result<JogResult, Error> {
        let parameters = client.parameters()?;
        if self.at.is_some() && !has_offset(&parameters) {
            return Err(Error::Input(
                "jog --at: this joint has no absolute encoder on its load, and so no offset; \
                 `reference --at DEG` sets its position. Nothing has moved"
                    .into(),
            ));
        }
        if !client.status()?.at_rest {
            client.pass(Duration::from_millis(100))?;
        }
        let angle = self.angle(client)?;
        client.jog(self.asked())?;
        // The device ends the jog; the client waits a second longer.
        let longest = Duration::from_secs_f32(parameters.jog.time + 1.0);
        let status = client.pass_armed(longest)?;
        match (status.state, client.jogged()?) {
            (StateCode::Armed, _) => {
                Err(Error::Device("jog: no result: the device did not end the jog in time".into()))
            }
            (_, Some(found)) => {
                let offset = Offset::check(self.at, angle, &found, &parameters);
                Ok(JogResult { parameters, found, offset })
            }
            _ => Err(super::ended_early("jog", &status, super::NOTHING)),
        }
    }

    /// Returns the angle of an absolute encoder on the load, counts of its turn, if its offset is
    /// to be checked. A single answer may be damaged.
    fn angle<W: Wire>(&self, client: &mut Client<W>) -> Result<u16, Error> {
        if self.at.is_none() {
            return Ok(0);
        }
        for _ in 0..READINGS {
            if let Some(angle) = client.status()?.load_angle {
                return Ok(angle);
            }
            client.pass(Duration::from_millis(50))?;
        }
        Err(Error::Device(
            "jog --at: the absolute encoder on the load gives no valid angle (docs/reference/\
             faults.md, 27). Nothing has moved"
                .into(),
        ))
    }

    /// Returns the result as text, or with `--json` as a JSON object.
    pub fn shown(&self, jogged: &JogResult, warning: Option<&str>) -> Result<String, Error> {
        let JogResult { parameters, found, offset } = jogged;
        if !self.json {
            let warning = warning.map_or(String::new(), |warning| format!("{warning}\n"));
            let words = jogged::words(found, parameters) + &offset.words();
            return Ok(warning + &words + super::OFF);
        }
        let mut object = jogged::json(found, parameters, warning);
        offset.add_to(&mut object);
        let text = serde_json::to_string_pretty(&object);
        text.map(|text| text + "\n").map_err(|error| Error::Input(error.to_string()))
    }
}

/// Returns an error unless direction, ratio and offset are right, as far as they were checked, so
/// that a script stops.
pub fn agrees(jogged: &JogResult) -> Result<(), Error> {
    let JogResult { parameters, found, offset } = jogged;
    if jogged::is_right(found, parameters) {
        return match (offset, offset.wrong()) {
            (Offset::Unknown, _) => Err(Error::Device("jog: the offset was not checked".into())),
            (_, None) => Ok(()),
            (_, Some(wrong)) => Err(Error::Device(format!(
                "jog: the offset is wrong by {:+.2} deg: set load_encoder.zero_counts = {}",
                wrong.error_deg, wrong.zero_counts
            ))),
        };
    }
    Err(Error::Device(format!("jog: {}", jogged::headline(found, parameters))))
}
