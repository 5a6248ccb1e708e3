//! Tuning of gains for a page, on a thread of its own: `stiction tune` for the file that the studio
//! was started with or for the identified joint, with the same seed and joints.
//!
//! It sends nothing to the device, is no keep-alive, and writes no file: the new file is sent to
//! the pages. One tuning runs at a time. Since it moves nothing, it goes on if its page is closed,
//! and any page may cancel it. The event `tuning` lists the laws that can be tuned and the running
//! tuning; the event `tuned` has the last result. A cancelled tuning, or one with a law that cannot
//! be tuned, keeps the results so far.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::desk::StudioState;
use super::machine_in_use::no_joint;
use super::request::{JointSource, TuningRequest};
use super::spare_cores::{begin, let_others_in, on_spare_cores};
use files::error::Error;
use simulator::experiment::Document;
use simulator::rules::TUNING_SEEDS;
use studies::tuning::{
    CASES, CASES_ALLOWED, GainSearch, TuningGoal, TuningResult, is_refused, limit, object, reason,
    rewritten, spreads,
};

/// Time between two reports of the progress.
const REPORTED: Duration = Duration::from_millis(250);

/// Tuner for all pages.
#[derive(Debug)]
pub struct Tuner {
    machine: Option<String>,
    shared: Arc<StudioState>,
    /// Flag of the running tuning: false cancels it.
    under_way: Mutex<Option<Arc<AtomicBool>>>,
}

/// The running tuning. When it is dropped, another one can start.
struct Busy(Arc<Tuner>);

impl Drop for Busy {
    fn drop(&mut self) {
        *self.0.under_way() = None;
        self.0.publish(None);
    }
}

/// A checked tuning.
struct Task {
    request: GainSearch,
    text: String,
    laws: Vec<String>,
    joint: JointSource,
}

/// Results of a tuning.
#[derive(Default)]
struct Found {
    tuned: Vec<TuningResult>,
    /// Laws that were not tuned, with the reasons.
    failed: Vec<(String, String)>,
    is_cancelled: bool,
}

impl Tuner {
    /// Returns a tuner, and publishes the laws that can be tuned. `machine` is the file of the
    /// device's joint, if it is known.
    pub fn new(machine: Option<String>, shared: Arc<StudioState>) -> Arc<Self> {
        let tuner = Self { machine, shared, under_way: Mutex::default() };
        tuner.publish(None);
        Arc::new(tuner)
    }

    fn under_way(&self) -> MutexGuard<'_, Option<Arc<AtomicBool>>> {
        self.under_way.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn publish(&self, running: Option<Value>) {
        let file = self.file(JointSource::File).and_then(|(_, _, document)| laws(&document));
        let (laws, why) = match file {
            Ok(laws) => (laws, Value::Null),
            Err(why) => (vec![], why.to_string().into()),
        };
        let event = json!({
            "machine": self.machine, "laws": laws, "why": why, "running": running,
            "of_found": true,
        });
        self.shared.news.publish("tuning", event);
    }

    /// Returns name, text and document of a joint's file as it is now.
    fn file(&self, joint: JointSource) -> Result<(String, String, Document), Error> {
        if joint == JointSource::Found {
            let found = self.shared.found()?;
            let document = Document::parse(&found.name, &found.text)?;
            return Ok((found.name, found.text, document));
        }
        let machine =
            self.machine.as_deref().ok_or_else(|| no_joint("there is nothing to tune for"))?;
        let document = Document::open(machine)?;
        if document.is_lab() {
            let why = "is a friction experiment, which has no controller";
            return Err(Error::Input(format!("{machine} {why}")));
        }
        Ok((machine.to_owned(), Document::text(machine)?, document))
    }

    /// Starts a tuning on a thread of its own. That thread answers that the tuning runs, or that
    /// the file, a controller or a value is invalid. While a tuning runs, another one is refused.
    pub fn start(
        self: &Arc<Self>,
        wanted: TuningRequest,
        answered: impl FnOnce(Result<Value, Error>) + Send + 'static,
    ) {
        let goes_on = Arc::new(AtomicBool::new(true));
        {
            let mut under_way = self.under_way();
            if under_way.is_some() {
                let why = "tune: a tuning runs already, and one runs at a time; cancel it first";
                return answered(Err(Error::Refused(why.into())));
            }
            *under_way = Some(goes_on.clone());
        }
        let busy = Busy(self.clone());
        // A file may be long, and the connections share one thread.
        begin(move || match busy.0.task(&wanted) {
            Ok(task) => {
                let GainSearch { file, goal, .. } = &task.request;
                let said = format!("tunes {} of {file} for {}", task.laws.join(", "), name(*goal));
                busy.0.shared.news.forget("tuned");
                busy.0.publish(Some(task.running(0, 0)));
                answered(Ok(said.into()));
                let event = task.run(&busy.0, &goes_on);
                busy.0.shared.news.publish("tuned", event);
            }
            Err(error) => {
                drop(busy);
                answered(Err(error));
            }
        });
    }

    /// Checks a request as the command does.
    fn task(&self, wanted: &TuningRequest) -> Result<Task, Error> {
        let refuse = |why: String| Err(Error::Input(format!("tune: {why}")));
        let (file, text, document) = self.file(wanted.joint)?;
        let mut laws = laws(&document)?;
        if let Some(unknown) = wanted.laws.iter().find(|name| !laws.contains(name)) {
            return refuse(format!("{file} has no controller `{unknown}` in its list"));
        }
        laws.retain(|name| wanted.laws.is_empty() || wanted.laws.contains(name));
        let cases = wanted.cases.unwrap_or(CASES);
        if !CASES_ALLOWED.contains(&cases) {
            let (least, most) = (CASES_ALLOWED.start(), CASES_ALLOWED.end());
            return refuse(format!("{cases} joints: must be a number from {least} to {most}"));
        }
        let limits = wanted.limits.iter().map(|text| {
            limit(text).map_err(|why| Error::Input(format!("tune: limit {text}: {why}")))
        });
        let limits = limits.collect::<Result<_, _>>()?;
        if wanted.goal == TuningGoal::Track && document.machine()?.reference.trajectories.is_empty()
        {
            let why = "the goal track needs a trajectory in `reference.trajectories`";
            return refuse(format!("{file}: {why}"));
        }
        let (goal, seed, joint) = (wanted.goal, *TUNING_SEEDS.start(), wanted.joint);
        let spreads = spreads(&document)?;
        let request = GainSearch { file, goal, limits, spreads, cases, seed, document };
        Ok(Task { request, text, laws, joint })
    }

    /// Cancels the running tuning. It ends within the time of one joint; if its threads have just
    /// started to predict a self-test, it ends after that prediction.
    ///
    /// # Errors
    /// Returns an error if none runs.
    pub fn cancel(&self) -> Result<Value, Error> {
        match &*self.under_way() {
            Some(goes_on) => {
                goes_on.store(false, Ordering::Relaxed);
                Ok("the tuning is being cancelled".into())
            }
            None => Err(Error::Refused("tune: no tuning runs".into())),
        }
    }
}

impl Task {
    /// Returns the progress as JSON: the law at a place of the list, and the number of its gain
    /// sets tried.
    fn running(&self, place: usize, tried: u32) -> Value {
        json!({
            "law": self.laws.get(place),
            "place": place + 1,
            "of": self.laws.len(),
            "tried": tried,
            "goal": name(self.request.goal),
            "machine": self.request.file,
            "joint": self.joint,
        })
    }

    fn run(&self, tuner: &Tuner, goes_on: &AtomicBool) -> Value {
        let event = on_spare_cores(|| self.found(tuner, goes_on)).and_then(|all| self.event(&all));
        event.unwrap_or_else(|error| json!({ "ok": false, "said": format!("tune: {}", error) }))
    }

    /// Tunes one law after the other, and publishes the progress.
    fn found(&self, tuner: &Tuner, goes_on: &AtomicBool) -> Found {
        let mut found = Found::default();
        for (place, law) in self.laws.iter().enumerate() {
            let progress = Mutex::new((0, None::<Instant>));
            let tried_one = || {
                let mut progress = progress.lock().unwrap_or_else(PoisonError::into_inner);
                if progress.1.is_none_or(|last| last.elapsed() >= REPORTED) {
                    progress.1 = Some(Instant::now());
                    tuner.publish(Some(self.running(place, progress.0)));
                }
                progress.0 += 1;
            };
            let still = || {
                let goes_on = || goes_on.load(Ordering::Relaxed);
                // The other work may be the prediction of a self-test, which lasts long.
                goes_on() && {
                    let_others_in();
                    goes_on()
                }
            };
            match self.request.tune_while(law, &tried_one, &still) {
                Ok(Some(tuned)) => found.tuned.push(tuned),
                Ok(None) => {
                    found.is_cancelled = true;
                    return found;
                }
                Err(why) => found.failed.push((law.clone(), why.to_string())),
            }
        }
        found
    }

    /// Returns the result in a sentence.
    fn said(&self, found: &Found) -> String {
        let Found { tuned, failed, is_cancelled } = found;
        let better = tuned.iter().filter(|one| one.better).count();
        let mut said = match (better, tuned.len()) {
            (_, 0) if *is_cancelled => "cancelled: nothing was found".to_owned(),
            (_, 0) => "nothing was tuned".to_owned(),
            (0, _) => {
                let why = reason(tuned).unwrap_or_default();
                let what =
                    if is_refused(tuned) { "no gains were found" } else { "nothing is better" };
                format!("{what}, the file's gains stay: {why}")
            }
            (1, 1) => "better gains were found".to_owned(),
            (better, of) => format!("better gains were found for {better} of {of} laws"),
        };
        if *is_cancelled && !tuned.is_empty() {
            let (over, of) = (tuned.len() + failed.len(), self.laws.len());
            said = format!("cancelled after {over} of {of} laws: {said}");
        }
        for (law, why) in failed {
            said += &format!("; {law}: {why}");
        }
        said
    }

    /// Returns the event with the result. The charts are those of `stiction tune --plot`.
    fn event(&self, found: &Found) -> Result<Value, Error> {
        let said = self.said(found);
        let Found { tuned, is_cancelled, .. } = found;
        if tuned.is_empty() {
            return Ok(json!({ "ok": false, "said": said, "cancelled": is_cancelled }));
        }
        let GainSearch { file, goal, spreads, .. } = &self.request;
        let name_of =
            |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let new = Path::new(file).with_extension("tuned.toml");
        let charts = self.request.charts(tuned)?;
        Ok(json!({
            "ok": true,
            "said": said,
            "cancelled": is_cancelled,
            "goal": name(*goal),
            // The joints of the figures, on which the gains were not tuned.
            "joints": self.request.judges(),
            "spreads": spreads,
            "doubts": self.request.document.doubts()?,
            "unseen_slack": self.request.document.unseen_slack()?.map(|slack| slack.to_string()),
            "machine": file,
            "joint": self.joint,
            "result": object(file, tuned),
            "file": name_of(&new),
            // The file's own gains make no new file.
            "toml": tuned.iter().any(|one| one.better).then(|| rewritten(&self.text, tuned)).transpose()?,
            "charts": charts.iter().filter_map(figure::chart_svg).collect::<Vec<_>>(),
        }))
    }
}

/// Returns the controllers that `stiction tune --controller all` tunes.
fn laws(document: &Document) -> Result<Vec<String>, Error> {
    Ok(document.machine()?.sampling.extras.list().to_vec())
}

/// Returns a goal's name on the command line.
fn name(goal: TuningGoal) -> String {
    use clap::ValueEnum as _;

    goal.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use studies::tuning::TuningFigures;

    #[test]
    fn a_law_that_cannot_be_tuned_is_reported_beside_what_was_found_for_the_others() {
        let figures = TuningFigures::of(&[]);
        let tuned = |controller: &str, better| TuningResult {
            controller: controller.into(),
            gains: vec![],
            better,
            refusal: (!better).then(|| "none of 41 sets is better".to_owned()),
            before: figures,
            after: figures,
            tried: vec![figures],
            kept: 0,
            margins: [1.0, 1.0],
            worst: None,
        };
        let document = Document::open("step-response").unwrap();
        let request = GainSearch {
            file: "step-response".into(),
            goal: TuningGoal::Settle,
            limits: vec![],
            spreads: vec![],
            cases: 8,
            seed: 1,
            document,
        };
        let text = Document::text("step-response").unwrap();
        let laws: Vec<String> = ["pd", "dnpf", "srnf"].map(String::from).into();
        let task = Task { request, text, laws, joint: JointSource::File };
        let failed = vec![("dnpf".to_owned(), "it has no gain to turn".to_owned())];
        let all = vec![tuned("pd", true), tuned("srnf", false)];
        let found = Found { tuned: all, failed: failed.clone(), is_cancelled: false };
        let event = task.event(&found).unwrap();
        let said = "better gains were found for 1 of 2 laws; dnpf: it has no gain to turn";
        assert_eq!((&event["ok"], &event["said"]), (&json!(true), &json!(said)));
        let found = Found { tuned: vec![], failed: failed.clone(), is_cancelled: true };
        let said = "cancelled: nothing was found; dnpf: it has no gain to turn";
        assert_eq!(task.said(&found), said);
        let found = Found { tuned: vec![], failed, is_cancelled: false };
        let event = task.event(&found).unwrap();
        let said = "nothing was tuned; dnpf: it has no gain to turn";
        assert_eq!((&event["ok"], &event["said"]), (&json!(false), &json!(said)));
        let found = Found { tuned: vec![tuned("pd", false)], failed: vec![], is_cancelled: true };
        let said = task.said(&found);
        let why = "no gains were found, the file's gains stay: pd: none of 41 sets is better";
        assert_eq!(said, format!("cancelled after 1 of 3 laws: {why}"));
    }
}
