//! Predicts a session: simulates it with joints around that of a file.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use stiction::Parameters;
use stiction::link::StateCode;
use stiction::servo::Boot;

use super::measures::{MoveMeasures, SessionFigures};
use super::session;
use crate::ensemble::{KeySpread, drawn_keys};
use files::error::Error;
use files::goal::PositionGoal;
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use simulator::device::words;
use simulator::experiment::{Document, Experiment, RunPlan};

/// Input of a prediction.
#[derive(Clone, Debug)]
pub struct PredictionInput {
    /// Parsed machine's file, which describes the joint.
    pub document: Document,
    /// Parameters of the device.
    pub parameters: Parameters,
    /// Keys of the joint that vary, `KEY=LOW..HIGH`.
    pub spreads: Vec<String>,
    /// Number of joints, including that of the file.
    pub joints: u64,
    /// Seed of the draw.
    pub seed: u64,
    /// Targets of the moves, deg.
    pub targets: Vec<f64>,
}

/// Results of the simulated joints.
#[derive(Clone, Debug, Default)]
pub struct Prediction {
    /// Figures of each joint that completed all moves.
    pub figures: Vec<SessionFigures>,
    /// Measures of the moves of these joints.
    pub moves: Vec<Vec<MoveMeasures>>,
    /// Reasons why the other joints ended early.
    pub ended: Vec<String>,
}

impl Prediction {
    /// Returns the number of moves that the median joint misses, at the encoder and at the load;
    /// `None` if it is unknown.
    pub fn missed_of_most(&self) -> [Option<u32>; 2] {
        let median = |of: fn(&SessionFigures) -> Option<u32>| {
            let mut all: Vec<u32> = self.figures.iter().filter_map(of).collect();
            all.sort_unstable();
            all.get(all.len() / 2).copied()
        };
        [median(|figures| Some(figures.missed)), median(|figures| figures.missed_at_load)]
    }
}

impl PredictionInput {
    /// Simulates the joints, on all cores.
    ///
    /// # Errors
    /// Returns an error that names a key that cannot vary, or an invalid value.
    pub fn predict(&self) -> Result<Prediction, Error> {
        let cancelled = || Error::Input("selftest: the prediction was cancelled".into());
        self.predict_while(&|_| true)?.ok_or_else(cancelled)
    }

    /// Simulates the joints, on all cores. Before each move of each joint, `goes_on` is called with
    /// the number of completed joints. If it returns false, the result is `None`, after at most one
    /// more move of each running joint.
    ///
    /// # Errors
    /// As [`predict`](Self::predict).
    pub fn predict_while(
        &self,
        goes_on: &(dyn Fn(u64) -> bool + Sync),
    ) -> Result<Option<Prediction>, Error> {
        let spreads: Vec<KeySpread> =
            self.spreads.iter().map(|text| KeySpread::read(text)).collect::<Result<_, _>>()?;
        let goal = self.document.machine()?.goal;
        let over = AtomicU64::new(0);
        let run = |number: u64| -> Result<Option<Result<Vec<MoveMeasures>, String>>, Error> {
            let still = || goes_on(over.load(Ordering::Relaxed));
            if !still() {
                return Ok(None);
            }
            let mut document = self.document.clone();
            // The first joint is that of the file.
            if number > 0 {
                document.draw(&drawn_keys(&spreads, self.seed, number))?;
            }
            // The position between two counts at the start is random: the joints start evenly
            // spread over one count.
            let phase = (number as f64 + 0.5) / self.joints as f64;
            document.set(&[format!("encoder.phase={phase:?}")])?;
            // There is at least one run: otherwise `without_variants` returns an error.
            let plan = Experiment::without_variants(&document, &[])?.swap_remove(0);
            let one = self.one(&plan, &goal, still)?;
            over.fetch_add(u64::from(one.is_some()), Ordering::Relaxed);
            Ok(one)
        };
        let all: Vec<_> =
            (0..self.joints).into_par_iter().map(run).collect::<Result<Vec<_>, Error>>()?;
        let mut prediction = Prediction::default();
        for one in all {
            match one {
                None => return Ok(None),
                Some(Ok(moves)) => {
                    prediction.figures.push(SessionFigures::of(&moves));
                    prediction.moves.push(moves);
                }
                Some(Err(why)) => prediction.ended.push(why),
            }
        }
        Ok(Some(prediction))
    }

    /// Returns the moves of a joint, or the reason of its end; `None` if cancelled.
    fn one(
        &self,
        plan: &RunPlan,
        goal: &PositionGoal,
        goes_on: impl Fn() -> bool,
    ) -> Result<Option<Result<Vec<MoveMeasures>, String>>, Error> {
        let mut parameters = self.parameters.clone();
        parameters.device.autostart = false;
        let device = SimulatedDevice::running(plan, &parameters, Boot::at_zero())?;
        let mut client = Client::connect(SimulatedWire::new(device))?;
        // A joint that is refused at arming, because its load moves it, ends like one that trips.
        let wanted = (&self.targets[..], goal);
        let session = match session::run_while(&mut client, wanted, |_| goes_on()) {
            Ok(Some(session)) => session,
            Ok(None) => return Ok(None),
            Err(why) => return Ok(Some(Err(why.to_string()))),
        };
        let status = &session.status;
        Ok(Some(if status.state == StateCode::Armed {
            Ok(session.moves)
        } else {
            Err(words::fault(&status.fault, status.sample_time))
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use simulator::experiment::parameters;

    /// The thesis's joint under SRNF, with other variants than its own.
    fn with(variants: &str) -> Document {
        let text = Document::text("step-response").unwrap();
        let (machine, _) = text.split_once("[[variant]]").unwrap();
        let mut document = Document::parse("mine.toml", &format!("{machine}{variants}")).unwrap();
        document.set(&["loop.controller=srnf".into()]).unwrap();
        document
    }

    fn predicted(document: &Document) -> Result<Vec<SessionFigures>, Error> {
        let plan = Experiment::plan(&with(""), &[], &[])?.runs.swap_remove(0);
        let request = PredictionInput {
            document: document.clone(),
            parameters: parameters(&plan)?,
            spreads: vec!["joint.friction.slip_v=0.30..0.39".into()],
            joints: 3,
            seed: 1,
            targets: vec![1.0, 0.0],
        };
        Ok(request.predict()?.figures)
    }

    /// A variant sets its keys last, so its joint would replace each drawn joint.
    #[test]
    fn a_variant_before_the_file_as_it_stands_is_no_part_of_the_prediction() {
        const OTHER: &str = "[[variant]]\nslug = \"dry\"\n\
             set = { \"joint.friction.stick_v\" = 0.1, \"joint.friction.slip_v\" = 0.1 }\n";
        let plain = predicted(&with("")).unwrap();
        assert!(plain[0].sliding_v != plain[1].sliding_v, "the friction does not vary: {plain:?}");
        assert_eq!(predicted(&with(&format!("{OTHER}[[variant]]\nslug = \"\"\n"))).unwrap(), plain);
        let refused = predicted(&with(OTHER)).unwrap_err().to_string();
        assert!(refused.contains("variants only (`dry`)"), "{refused}");
    }

    #[test]
    fn a_cancelled_prediction_ends_at_once() {
        let plan = Experiment::plan(&with(""), &[], &[]).unwrap().runs.swap_remove(0);
        let request = PredictionInput {
            document: with(""),
            parameters: parameters(&plan).unwrap(),
            spreads: vec![],
            joints: 4,
            seed: 1,
            targets: vec![1.0, 0.0],
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let asked_until = |last: u64| {
            let (asked, most) = (AtomicU64::new(0), AtomicU64::new(0));
            let goes_on = |over| {
                most.fetch_max(over, Ordering::Relaxed);
                asked.fetch_add(1, Ordering::Relaxed) < last
            };
            let predicted = pool.install(|| request.predict_while(&goes_on)).unwrap();
            (asked.into_inner(), most.into_inner(), predicted.map(|all| all.figures.len()))
        };
        // Calls for each joint: at its start, at both moves, and after them. One thread simulates
        // one joint after the other, so the last one sees the count of all others.
        let (asked, most, predicted) = asked_until(u64::MAX);
        assert_eq!((asked, most, predicted), (16, 3, Some(4)));
        for last in [0, 1, 5] {
            let (asked, most, predicted) = asked_until(last);
            // Each joint after the cancelled one is cancelled at its start.
            let done = last / 4;
            assert_eq!((asked, most, predicted), (last + 1 + (3 - done), done, None));
        }
    }
}
