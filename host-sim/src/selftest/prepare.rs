//! What has to be settled before anything moves: that the device is the file's machine, how far the
//! moves lead, and what is predicted of them.

use stiction::Parameters;

use super::measures::Figures;
use super::moves::{Range, room, targets};
use super::prediction::{Prediction, Request};
use super::session::Session;
use super::text::Tested;
use super::verdict::verdict;
use crate::device::client::Client;
use crate::device::wire::Wire;
use crate::device::{machine_file, parameters, words};
use crate::error::{Error, rounded};
use crate::experiment::{Document, Experiment, RunPlan};
use crate::tuning::spreads;

/// Tables in which a difference between device and file makes another machine.
const OF_THE_MACHINE: [&str; 3] = ["encoder.", "drive.", "loop.sample_time_s"];

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The machine's file.
    pub machine: String,
    /// Range of the moves to either side, deg; left out, the derived one.
    pub range_deg: Option<f64>,
    /// Moves.
    pub moves: usize,
    /// Simulated joints.
    pub joints: u64,
    /// Their seed.
    pub seed: u64,
    /// Keys of the joint that vary, `KEY=LOW..HIGH`; of none, what the file says.
    pub spreads: Vec<String>,
}

/// A self-test with its prediction, before the moves.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// What was predicted of what.
    pub request: Request,
    machine: String,
    range: Range,
    prediction: Prediction,
    differences: Vec<String>,
}

impl Asked {
    /// Asks a device for its parameters, and predicts.
    ///
    /// # Errors
    /// Says what is wrong with the file, the range or the device, or that the moves end before in
    /// most of the simulated joints.
    pub fn prepare<W: Wire>(&self, client: &mut Client<W>) -> Result<Prepared, Error> {
        let document = Document::open(&self.machine)?;
        let parameters = client.parameters()?;
        let differences = differences(&self.machine, &document, &parameters)?;
        let range = self.range(client, &parameters)?;
        let spreads =
            if self.spreads.is_empty() { spreads(&document)? } else { self.spreads.clone() };
        let request = Request {
            document,
            parameters,
            spreads,
            joints: self.joints,
            seed: self.seed,
            targets: targets(range, self.moves),
        };
        let prediction = request.predict()?;
        if prediction.figures.len() < prediction.ended.len().max(1) {
            let why = prediction.ended.first().map_or("", String::as_str);
            return Err(Error::Device(format!(
                "selftest: nothing was moved: of {} simulated joints {} end before, the first by \
                 {why}; a smaller --range may help, or other gains",
                self.joints,
                prediction.ended.len()
            )));
        }
        let machine = self.machine.clone();
        Ok(Prepared { request, machine, range, prediction, differences })
    }

    /// The range that was asked for, or else the derived one.
    fn range<W: Wire>(&self, client: &mut Client<W>, found: &Parameters) -> Result<Range, Error> {
        let status = client.status()?;
        let at_deg = f64::from(status.position) * f64::from(status.resolution);
        let derived = Range::derived(found, at_deg);
        let deg = self.range_deg.unwrap_or(derived.deg);
        let (least, most) = (derived.least_deg(), room(found, at_deg));
        let refuse =
            |allowed: String| Err(Error::Input(format!("selftest --range {deg}: {allowed}")));
        if !deg.is_finite() || deg < least {
            return refuse(format!(
                "allowed is a number from {} on, ten times the shortest move",
                rounded(least)
            ));
        }
        if deg > most {
            return refuse(format!(
                "the joint stands {} deg from a limit of its position (`limits.position_min_deg`, \
             `limits.position_max_deg`), and moves to either side",
                rounded(most)
            ));
        }
        Ok(Range { deg, ..derived })
    }
}

impl Prepared {
    /// Judges what the device has made of the moves.
    pub fn judged(self, session: Session) -> Tested {
        let Session { moves, status, is_ended } = session;
        let by = || match status.fault.code {
            0 => "a stop".into(),
            _ => words::told(&status.fault, status.sample_time),
        };
        let checks =
            if is_ended { vec![] } else { verdict(&Figures::of(&moves), &self.prediction) };
        Tested {
            machine: self.machine,
            range_deg: self.range.deg,
            spreads: self.request.spreads,
            seed: self.request.seed,
            prediction: self.prediction,
            moves,
            checks,
            ended_by: is_ended.then(by),
            differences: self.differences,
        }
    }
}

/// In what the device's parameters differ from those of the file's nearest controller.
fn differences(
    machine: &str,
    document: &Document,
    found: &Parameters,
) -> Result<Vec<String>, Error> {
    let runs = Experiment::plan(document, &[], &[])?.runs;
    let compared = |plan: &RunPlan| -> Result<Vec<String>, Error> {
        let mut lines = machine_file::changes(&parameters(plan)?, found)?;
        // A session does not ask what starts by itself, nor where a run of the file leads; and a
        // bridge that switches slower moves the joint as well.
        let is_asked = |line: &String| {
            !["reference", "identification", "device.autostart", "drive.pwm_hz"]
                .iter()
                .any(|no| line.starts_with(no))
        };
        lines.retain(is_asked);
        Ok(lines)
    };
    let nearest = runs.iter().filter_map(|plan| compared(plan).ok()).min_by_key(Vec::len);
    let lines = nearest.ok_or_else(|| {
        Error::Input(format!("{machine}: no controller of it can go to a device"))
    })?;
    let other = lines.iter().find(|line| OF_THE_MACHINE.iter().any(|key| line.starts_with(key)));
    other.map_or(Ok(lines.clone()), |line| {
        Err(Error::Device(format!(
            "selftest: the device is another machine than {machine} ({line}); push that file, or \
             name the device's own by --machine"
        )))
    })
}
