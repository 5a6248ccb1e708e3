//! Tunes gains for a page, on a thread of its own: `stiction tune`, of the file that the studio was
//! started with or of the joint that was identified, with the same seed and joints.
//!
//! It asks the device nothing, is no word of a page, and writes no file: the new one is sent to the
//! pages. One tuning runs at a time. It goes on if its page is closed, since it moves nothing, and
//! any page may cancel it. Two events tell of it: `tuning` says what could be tuned and what runs,
//! and `tuned` what was found last. What was found before a cancelling, or before a law that has
//! nothing to be tuned, is found all the same.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::desk::Shared;
use super::machine_in_use::no_joint;
use super::request::{Source, Tuning};
use super::spare_cores::{begin, let_others_in, on_spare_cores};
use super::wording::of_a_page;
use crate::ensemble::rules::TUNING_SEEDS;
use crate::error::Error;
use crate::experiment::Document;
use crate::tuning::{
    CASES, CASES_ALLOWED, Goal, Request, Tuned, is_refused, limit, object, reason, rewritten,
    spreads,
};

/// Time between two reports of how far it is.
const TOLD: Duration = Duration::from_millis(250);

/// Tunes for all pages.
#[derive(Debug)]
pub struct Tuner {
    machine: Option<String>,
    shared: Arc<Shared>,
    /// Whether the tuning that runs is to go on.
    under_way: Mutex<Option<Arc<AtomicBool>>>,
}

/// The tuning that is under way. Another one may begin when this is dropped.
struct Busy(Arc<Tuner>);

impl Drop for Busy {
    fn drop(&mut self) {
        *self.0.under_way() = None;
        self.0.tell(None);
    }
}

/// What is to be tuned.
struct Task {
    request: Request,
    text: String,
    laws: Vec<String>,
    joint: Source,
}

/// What has come of it.
#[derive(Default)]
struct Found {
    tuned: Vec<Tuned>,
    /// Laws that were not tuned, and why.
    failed: Vec<(String, String)>,
    is_cancelled: bool,
}

impl Tuner {
    /// Tells what could be tuned. `machine` is the file whose joint the device has, if somebody has
    /// told one.
    pub fn new(machine: Option<String>, shared: Arc<Shared>) -> Arc<Self> {
        let tuner = Self { machine, shared, under_way: Mutex::default() };
        tuner.tell(None);
        Arc::new(tuner)
    }

    fn under_way(&self) -> MutexGuard<'_, Option<Arc<AtomicBool>>> {
        self.under_way.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, running: Option<Value>) {
        let file = self.file(Source::File).and_then(|(_, _, document)| laws(&document));
        let (laws, why) = match file {
            Ok(laws) => (laws, Value::Null),
            Err(why) => (vec![], why.to_string().into()),
        };
        let told = json!({
            "machine": self.machine, "laws": laws, "why": why, "running": running,
            "of_found": true,
        });
        self.shared.news.tell("tuning", told);
    }

    /// A joint's file by its name, as it is now, and what is in it.
    fn file(&self, joint: Source) -> Result<(String, String, Document), Error> {
        if joint == Source::Found {
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

    /// Begins to tune on a thread of its own, and answers from there: that it does, or that there
    /// is no file or no such controller, or that a value is not allowed. While a tuning runs, that
    /// is the answer.
    pub fn start(
        self: &Arc<Self>,
        wanted: Tuning,
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
        // A file may be long, and the connections have one thread.
        begin(move || match busy.0.task(&wanted) {
            Ok(task) => {
                let Request { file, goal, .. } = &task.request;
                let said = format!("tunes {} of {file} for {}", task.laws.join(", "), name(*goal));
                busy.0.shared.news.forget("tuned");
                busy.0.tell(Some(task.running(0, 0)));
                answered(Ok(said.into()));
                let told = task.run(&busy.0, &goes_on);
                busy.0.shared.news.tell("tuned", told);
            }
            Err(error) => {
                drop(busy);
                answered(Err(of_a_page(error)));
            }
        });
    }

    /// What a page wants, checked as the command checks it.
    fn task(&self, wanted: &Tuning) -> Result<Task, Error> {
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
            return refuse(format!("{cases} joints: allowed is a number from {least} to {most}"));
        }
        let limits = wanted.limits.iter().map(|text| {
            limit(text).map_err(|why| Error::Input(format!("tune: limit {text}: {why}")))
        });
        let limits = limits.collect::<Result<_, _>>()?;
        if wanted.goal == Goal::Track && document.machine()?.reference.trajectories.is_empty() {
            let why = "the goal track needs a trajectory in `reference.trajectories`";
            return refuse(format!("{file}: {why}"));
        }
        let (goal, seed, joint) = (wanted.goal, *TUNING_SEEDS.start(), wanted.joint);
        let spreads = spreads(&document)?;
        let request = Request { file, goal, limits, spreads, cases, seed, document };
        Ok(Task { request, text, laws, joint })
    }

    /// Ends the tuning that runs, within the time of one set of joints. If it has just let the
    /// prediction of a self-test go first, that is over before.
    ///
    /// # Errors
    /// Says that none runs.
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
    /// How far it is: the place of a law, and how many sets of its gains were tried.
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
        let told = on_spare_cores(|| self.found(tuner, goes_on)).and_then(|all| self.told(&all));
        told.unwrap_or_else(
            |error| json!({ "ok": false, "said": format!("tune: {}", of_a_page(error)) }),
        )
    }

    /// Tunes one law after the other, and tells how far that is.
    fn found(&self, tuner: &Tuner, goes_on: &AtomicBool) -> Found {
        let mut found = Found::default();
        for (place, law) in self.laws.iter().enumerate() {
            let told = Mutex::new((0, None::<Instant>));
            let tried_one = || {
                let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
                if told.1.is_none_or(|last| last.elapsed() >= TOLD) {
                    told.1 = Some(Instant::now());
                    tuner.tell(Some(self.running(place, told.0)));
                }
                told.0 += 1;
            };
            let still = || {
                let goes_on = || goes_on.load(Ordering::Relaxed);
                // The work of others may take as long as the prediction of a self-test.
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
                Err(why) => found.failed.push((law.clone(), of_a_page(why).to_string())),
            }
        }
        found
    }

    /// What has come of it, in a sentence.
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

    /// What the pages are told of it. The charts are those of `stiction tune --plot`.
    fn told(&self, found: &Found) -> Result<Value, Error> {
        let said = self.said(found);
        let Found { tuned, is_cancelled, .. } = found;
        if tuned.is_empty() {
            return Ok(json!({ "ok": false, "said": said, "cancelled": is_cancelled }));
        }
        let Request { file, goal, spreads, .. } = &self.request;
        let name_of =
            |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let new = Path::new(file).with_extension("tuned.toml");
        let charts = self.request.charts(tuned)?;
        Ok(json!({
            "ok": true,
            "said": said,
            "cancelled": is_cancelled,
            "goal": name(*goal),
            // Those of the figures: the gains were not found on them.
            "joints": self.request.judges(),
            "spreads": spreads,
            "doubts": self.request.document.doubts()?,
            "unseen_slack": self.request.document.unseen_slack()?.map(|slack| slack.to_string()),
            "machine": file,
            "joint": self.joint,
            "result": object(file, tuned),
            "file": name_of(&new),
            // The file's own gains are no new file.
            "toml": tuned.iter().any(|one| one.better).then(|| rewritten(&self.text, tuned)).transpose()?,
            "charts": charts.iter().filter_map(|chart| chart.to_svg()).collect::<Vec<_>>(),
        }))
    }
}

/// The controllers that `stiction tune --controller all` tunes.
fn laws(document: &Document) -> Result<Vec<String>, Error> {
    Ok(document.machine()?.sampling.extras.list().to_vec())
}

/// A goal as the command line has it.
fn name(goal: Goal) -> String {
    use clap::ValueEnum as _;

    goal.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::tuning::Figures;

    #[test]
    fn a_law_that_cannot_be_tuned_is_told_beside_what_was_found_for_the_others() {
        let figures = Figures::of(&[]);
        let tuned = |controller: &str, better| Tuned {
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
        let request = Request {
            file: "step-response".into(),
            goal: Goal::Settle,
            limits: vec![],
            spreads: vec![],
            cases: 8,
            seed: 1,
            document,
        };
        let text = Document::text("step-response").unwrap();
        let laws: Vec<String> = ["pd", "dnpf", "srnf"].map(String::from).into();
        let task = Task { request, text, laws, joint: Source::File };
        let failed = vec![("dnpf".to_owned(), "it has no gain to turn".to_owned())];
        let all = vec![tuned("pd", true), tuned("srnf", false)];
        let found = Found { tuned: all, failed: failed.clone(), is_cancelled: false };
        let told = task.told(&found).unwrap();
        let said = "better gains were found for 1 of 2 laws; dnpf: it has no gain to turn";
        assert_eq!((&told["ok"], &told["said"]), (&json!(true), &json!(said)));
        let found = Found { tuned: vec![], failed: failed.clone(), is_cancelled: true };
        let said = "cancelled: nothing was found; dnpf: it has no gain to turn";
        assert_eq!(task.said(&found), said);
        let found = Found { tuned: vec![], failed, is_cancelled: false };
        let told = task.told(&found).unwrap();
        let said = "nothing was tuned; dnpf: it has no gain to turn";
        assert_eq!((&told["ok"], &told["said"]), (&json!(false), &json!(said)));
        let found = Found { tuned: vec![tuned("pd", false)], failed: vec![], is_cancelled: true };
        let said = task.said(&found);
        let why = "no gains were found, the file's gains stay: pd: none of 41 sets is better";
        assert_eq!(said, format!("cancelled after 1 of 3 laws: {why}"));
    }
}
