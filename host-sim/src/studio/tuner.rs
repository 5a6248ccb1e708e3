//! Tunes gains for a page, on a thread of its own: `stiction tune`, of the file that the studio was
//! started with, and with the same seed and joints.
//!
//! It asks the device nothing, is no word of a page, and writes no file: the new one is sent to the
//! pages. One tuning runs at a time. It goes on if its page is closed, since it moves nothing, and
//! any page may cancel it. Two events tell of it: `tuning` says what could be tuned and what runs,
//! and `tuned` what was found last.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::desk::Shared;
use super::machine_in_use::no_file;
use super::spare_cores::on_spare_cores;
use crate::ensemble::rules::TUNING_SEEDS;
use crate::error::Error;
use crate::experiment::Document;
use crate::tuning::{CASES, Goal, Request, Tuned, charts, object, rewritten, spreads};

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

/// What is to be tuned, and where it says how far it is.
struct Task {
    tuner: Arc<Tuner>,
    request: Request,
    text: String,
    laws: Vec<String>,
    goes_on: Arc<AtomicBool>,
}

impl Drop for Task {
    fn drop(&mut self) {
        *self.tuner.under_way() = None;
        self.tuner.tell(None);
    }
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
        let (laws, why) = match self.file().and_then(|(_, document)| laws(&document)) {
            Ok(laws) => (laws, Value::Null),
            Err(why) => (vec![], why.to_string().into()),
        };
        let told = json!({ "machine": self.machine, "laws": laws, "why": why, "running": running });
        self.shared.news.tell("tuning", told);
    }

    /// The file, as it is now.
    fn file(&self) -> Result<(&str, Document), Error> {
        let machine =
            self.machine.as_deref().ok_or_else(|| no_file("there is nothing to tune for"))?;
        let document = Document::open(machine)?;
        if document.is_lab() {
            let why = "is a friction experiment, which has no controller";
            return Err(Error::Input(format!("{machine} {why}")));
        }
        Ok((machine, document))
    }

    /// Begins to tune controllers of the file for a goal; none of them means all.
    ///
    /// # Errors
    /// Says that there is no file or no such controller, or that a tuning runs already.
    pub fn start(self: &Arc<Self>, wanted: &[String], goal: Goal) -> Result<Value, Error> {
        let (machine, document) = self.file()?;
        let mut laws = laws(&document)?;
        if let Some(unknown) = wanted.iter().find(|name| !laws.contains(name)) {
            let why = format!("tune: {machine} has no controller `{unknown}` in its list");
            return Err(Error::Input(why));
        }
        laws.retain(|name| wanted.is_empty() || wanted.contains(name));
        let request = Request {
            file: machine.into(),
            goal,
            limits: vec![],
            spreads: spreads(&document)?,
            cases: CASES,
            seed: *TUNING_SEEDS.start(),
            document,
        };
        let text = Document::text(machine)?;
        let goes_on = Arc::new(AtomicBool::new(true));
        {
            let mut under_way = self.under_way();
            if under_way.is_some() {
                let why = "tune: a tuning runs already, and one runs at a time; cancel it first";
                return Err(Error::Refused(why.into()));
            }
            *under_way = Some(goes_on.clone());
        }
        let said = format!("tunes {} for {}", laws.join(", "), name(goal));
        let task = Task { tuner: self.clone(), request, text, laws, goes_on };
        self.shared.news.forget("tuned");
        std::thread::spawn(move || task.run());
        Ok(said.into())
    }

    /// Ends the tuning that runs, within the time of one set of gains.
    ///
    /// # Errors
    /// Says that none runs.
    pub fn cancel(&self) -> Result<Value, Error> {
        match &*self.under_way() {
            Some(goes_on) => {
                goes_on.store(false, Ordering::Relaxed);
                Ok("the tuning is cancelled".into())
            }
            None => Err(Error::Refused("tune: no tuning runs".into())),
        }
    }
}

impl Task {
    fn run(self) {
        let told = match on_spare_cores(|| self.tuned()).and_then(|tuned| tuned) {
            Ok(Some(tuned)) => self.found(&tuned),
            Ok(None) => Ok(json!({ "ok": false, "said": "cancelled: nothing was found" })),
            Err(error) => Err(error),
        };
        let told =
            told.unwrap_or_else(|error| json!({ "ok": false, "said": format!("tune: {error}") }));
        self.tuner.shared.news.tell("tuned", told);
    }

    /// Tunes one law after the other, and tells how far that is.
    fn tuned(&self) -> Result<Option<Vec<Tuned>>, Error> {
        let mut all = Vec::new();
        for (place, law) in self.laws.iter().enumerate() {
            let tried = Mutex::new((0, None::<Instant>));
            let goes_on = || {
                let mut tried = tried.lock().unwrap_or_else(PoisonError::into_inner);
                if tried.1.is_none_or(|last| last.elapsed() >= TOLD) {
                    tried.1 = Some(Instant::now());
                    let (law, of) = (law.as_str(), self.laws.len());
                    let running = json!({
                        "law": law, "place": place + 1, "of": of, "tried": tried.0,
                        "goal": name(self.request.goal),
                    });
                    self.tuner.tell(Some(running));
                }
                tried.0 += 1;
                self.goes_on.load(Ordering::Relaxed)
            };
            match self.request.tune_while(law, &goes_on)? {
                Some(tuned) => all.push(tuned),
                None => return Ok(None),
            }
        }
        Ok(Some(all))
    }

    /// What the pages are told of it. The charts are those of `stiction tune --plot`.
    fn found(&self, tuned: &[Tuned]) -> Result<Value, Error> {
        let Request { file, goal, cases, spreads, .. } = &self.request;
        let name_of =
            |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let new = Path::new(file).with_extension("tuned.toml");
        let better = tuned.iter().filter(|one| one.better).count();
        let said = match (better, tuned.len()) {
            (0, _) => "nothing better was found: the file's gains stay".to_owned(),
            (1, 1) => "better gains were found".to_owned(),
            (better, of) => format!("better gains were found for {better} of {of} laws"),
        };
        let charts = charts(file, tuned);
        Ok(json!({
            "ok": true,
            "said": said,
            "goal": name(*goal),
            "joints": cases,
            "spreads": spreads,
            "result": object(file, tuned),
            "file": name_of(&new),
            "toml": rewritten(&self.text, tuned)?,
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
