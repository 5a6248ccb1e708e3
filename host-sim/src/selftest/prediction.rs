//! What joints around that of a file do in the same session.

use rayon::prelude::*;
use stiction::Parameters;
use stiction::link::StateCode;
use stiction::servo::Boot;

use super::measures::{Figures, Measures};
use super::session;
use crate::device::client::Client;
use crate::device::simulated::SimulatedDevice;
use crate::device::wire::SimulatedWire;
use crate::device::words;
use crate::ensemble::{Spread, drawn_keys};
use crate::error::Error;
use crate::experiment::{Document, Experiment, RunPlan};

/// What is predicted.
#[derive(Clone, Debug)]
pub struct Request {
    /// The file whose joint it is.
    pub document: Document,
    /// What the device runs.
    pub parameters: Parameters,
    /// Keys of the joint that vary, `KEY=LOW..HIGH`.
    pub spreads: Vec<String>,
    /// The number of joints: the file's own, and the others around it.
    pub joints: u64,
    /// The seed by which they are drawn.
    pub seed: u64,
    /// The moves, deg.
    pub targets: Vec<f64>,
}

/// What the joints did.
#[derive(Clone, Debug, Default)]
pub struct Prediction {
    /// The figures of each joint that made all moves.
    pub figures: Vec<Figures>,
    /// Their moves.
    pub moves: Vec<Vec<Measures>>,
    /// How the others ended.
    pub ended: Vec<String>,
}

impl Request {
    /// Runs the joints, on all cores.
    ///
    /// # Errors
    /// Names a key that does not vary, or a value that no joint can have.
    pub fn predict(&self) -> Result<Prediction, Error> {
        let spreads: Vec<Spread> =
            self.spreads.iter().map(|text| Spread::read(text)).collect::<Result<_, _>>()?;
        let run = |number: u64| {
            let mut document = self.document.clone();
            // The first one is the file's own.
            if number > 0 {
                document.draw(&drawn_keys(&spreads, self.seed, number))?;
            }
            // A counter that is read between two counts is as far from the next one as chance has
            // it: the joints begin evenly spread between two.
            let phase = (number as f64 + 0.5) / self.joints as f64;
            document.set(&[format!("encoder.phase={phase:?}")])?;
            // There is one, or it has been refused.
            self.one(&Experiment::without_variants(&document, &[])?.swap_remove(0))
        };
        let all: Vec<_> =
            (0..self.joints).into_par_iter().map(run).collect::<Result<Vec<_>, Error>>()?;
        let mut prediction = Prediction::default();
        for one in all {
            match one {
                Ok(moves) => {
                    prediction.figures.push(Figures::of(&moves));
                    prediction.moves.push(moves);
                }
                Err(why) => prediction.ended.push(why),
            }
        }
        Ok(prediction)
    }

    /// The moves of a joint, or what has ended them.
    fn one(&self, plan: &RunPlan) -> Result<Result<Vec<Measures>, String>, Error> {
        let mut parameters = self.parameters.clone();
        parameters.device.autostart = false;
        let device = SimulatedDevice::running(plan, &parameters, Boot::default())?;
        let mut client = Client::connect(SimulatedWire::new(device))?;
        // A joint that the device refuses to arm, since its load moves it, ends like one that
        // trips.
        let session = match session::run(&mut client, &self.targets, |_| {}) {
            Ok(session) => session,
            Err(why) => return Ok(Err(why.to_string())),
        };
        let status = &session.status;
        if status.state == StateCode::Armed {
            return Ok(Ok(session.moves));
        }
        Ok(Err(words::told(&status.fault, status.sample_time)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::parameters;

    /// The thesis's joint under SRNF, with other variants than its own.
    fn with(variants: &str) -> Document {
        let text = Document::text("step-response").unwrap();
        let (machine, _) = text.split_once("[[variant]]").unwrap();
        let mut document = Document::parse("mine.toml", &format!("{machine}{variants}")).unwrap();
        document.set(&["loop.controller=srnf".into()]).unwrap();
        document
    }

    fn predicted(document: &Document) -> Result<Vec<Figures>, Error> {
        let plan = Experiment::plan(&with(""), &[], &[])?.runs.swap_remove(0);
        let request = Request {
            document: document.clone(),
            parameters: parameters(&plan)?,
            spreads: vec!["joint.friction.slip_v=0.30..0.39".into()],
            joints: 3,
            seed: 1,
            targets: vec![1.0, 0.0],
        };
        Ok(request.predict()?.figures)
    }

    /// A variant sets its keys last: it would put its own joint in the place of each that is drawn.
    #[test]
    fn a_variant_before_the_file_as_it_stands_is_no_part_of_the_prediction() {
        const OTHER: &str = "[[variant]]\nslug = \"dry\"\n\
             set = { \"joint.friction.stick_v\" = 0.1, \"joint.friction.slip_v\" = 0.1 }\n";
        let plain = predicted(&with("")).unwrap();
        assert!(plain[0].sliding_v != plain[1].sliding_v, "the friction does not vary: {plain:?}");
        assert_eq!(predicted(&with(&format!("{OTHER}[[variant]]\nslug = \"\"\n"))).unwrap(), plain);
        let refused = predicted(&with(OTHER)).unwrap_err().to_string();
        assert!(refused.contains("nothing but variants (`dry`)"), "{refused}");
    }
}
