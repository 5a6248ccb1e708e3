//! `stiction device winding`.

use files::error::Error;
use files::typed_number;
use simulator::device::client::Client;
use simulator::device::wire::Wire;
use studies::winding::{WindingResult, measure};

/// Voltage of the measurement
#[derive(Debug, clap::Args)]
pub struct WindingArguments {
    /// Voltage of the pulses, V, up to the device's jog.effort_v [default: 0.6 of it]
    #[arg(long, value_name = "V", allow_hyphen_values = true)]
    #[arg(value_parser = typed_number::parse_single)]
    effort: Option<f32>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

impl WindingArguments {
    /// Runs the measurement.
    pub fn run<W: Wire>(&self, client: &mut Client<W>) -> Result<WindingResult, Error> {
        measure(client, self.effort)
    }

    /// Returns the result as text, or with `--json` as a JSON object.
    pub fn shown(&self, result: &WindingResult, warning: Option<&str>) -> String {
        if self.json {
            return format!("{:#}\n", result.json(warning));
        }
        let warning = warning.map_or(String::new(), |warning| format!("{warning}\n"));
        warning + &result.words() + super::OFF
    }
}
