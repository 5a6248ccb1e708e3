//! The thread that predicts. It has nothing to do with the device, and delays nobody who has.
//!
//! A page that moves a slider asks more often than there is time to answer. Of each page's wishes
//! only the last one is kept, and a wish that has become old is given up while it is computed.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::compensator::Gains;
use tokio::sync::mpsc::Sender;

use super::cloud::cloud;
use super::desk::{FoundJoint, NONE_FOUND, Shared, answer};
use super::form;
use super::knobs::knobs;
use super::machine_in_use::{MachineInUse, first_trajectory, no_joint};
use super::prediction;
use super::request::{Ask, Source, Wish};
use crate::device::machine_file;
use crate::error::Error;
use crate::experiment::{Document, Experiment, for_a_device};
use crate::machine::{PD, TrajectoryTable};

/// Time after which the thread looks whether anybody is left.
const LOOKS: Duration = Duration::from_millis(500);

/// What a page wants to know, and where it is told.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The page's number for it.
    id: u32,
    what: Ask,
    answer: Sender<String>,
}

/// A page, and whether it wants a comparison: that is not given up for a prediction.
pub type Whose = (u64, bool);

/// The wishes of all pages.
#[derive(Debug, Default)]
pub struct Wishes {
    last: Mutex<BTreeMap<Whose, Asked>>,
    come: Condvar,
}

impl Wishes {
    fn last(&self) -> MutexGuard<'_, BTreeMap<Whose, Asked>> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a wish of a page, in the place of the one that it had.
    pub fn put(&self, page: u64, id: u32, what: Ask, answer: Sender<String>) {
        let is_compared = matches!(what, Ask::Compare(_));
        self.last().insert((page, is_compared), Asked { id, what, answer });
        self.come.notify_one();
    }

    /// Whether a page has another wish by now.
    fn is_old(&self, whose: Whose) -> bool {
        self.last().contains_key(&whose)
    }

    /// Takes the next wish, if there is one.
    pub fn take(&self) -> Option<(Whose, Asked)> {
        self.last().pop_first()
    }

    fn next(&self) -> Option<(Whose, Asked)> {
        let last = self.last();
        let wait = self.come.wait_timeout_while(last, LOOKS, |last| last.is_empty());
        wait.unwrap_or_else(PoisonError::into_inner).0.pop_first()
    }
}

/// Predicts for as long as the connections have the wishes, too. `machine` is the file whose joint
/// the device has, if somebody has told one.
pub fn run(wishes: &Arc<Wishes>, shared: &Shared, machine: Option<&str>) {
    let mut forecaster = Forecaster::new(machine);
    while Arc::strong_count(wishes) > 1 {
        let next = wishes.next();
        forecaster.pass(wishes, shared, next);
    }
}

/// A joint's file with what the device runs, and the file's trajectory; or why there is none.
#[derive(Clone, Debug)]
struct Twin {
    in_use: Result<MachineInUse, String>,
    trajectory: Option<TrajectoryTable>,
}

impl Twin {
    /// `file` is the joint's.
    fn new(parameters: &Parameters, file: Result<Document, Error>) -> Self {
        let trajectory = file.as_ref().ok().and_then(|file| first_trajectory(file).ok());
        let in_use = file.and_then(|file| MachineInUse::new(parameters, &file));
        Self { in_use: in_use.map_err(|error| prediction::said(&error)), trajectory }
    }

    /// What a page is told of it: what can be turned.
    fn told(&self, machine: Option<&str>) -> Value {
        let (knobs, laws, why) = match &self.in_use {
            Ok(now) => (knobs(now), now.laws.clone(), Value::Null),
            Err(error) => (vec![], vec![], error.as_str().into()),
        };
        let slack = self.in_use.as_ref().ok().and_then(|now| now.unseen_slack().ok().flatten());
        let goal = self.in_use.as_ref().ok().and_then(|now| now.document.machine().ok());
        json!({
            "machine": machine, "knobs": knobs, "laws": laws, "why": why,
            "trajectory": self.trajectory,
            "unseen_slack": slack.map(|slack| slack.to_string()),
            "goal": goal.map(|machine| machine.goal.describe()),
        })
    }
}

/// What was told last: of these parameters and this joint that was identified.
#[derive(Clone, Debug)]
struct Known {
    parameters: Parameters,
    found: Option<FoundJoint>,
    of_file: Twin,
    of_found: Option<Twin>,
}

impl Known {
    fn new(parameters: Parameters, machine: Option<&str>, found: Option<FoundJoint>) -> Self {
        let none = || no_joint("nothing is predicted");
        let of_file = Twin::new(&parameters, machine.ok_or_else(none).and_then(Document::open));
        let of_found = found.as_ref().map(|FoundJoint { name, text, .. }| {
            Twin::new(&parameters, Document::parse(name, text))
        });
        Self { parameters, found, of_file, of_found }
    }

    /// Tells what can be turned with each of the joints.
    fn tell(&self, machine: Option<&str>, shared: &Shared) {
        let mut told = self.of_file.told(machine);
        let found = self.found.as_ref().zip(self.of_found.as_ref());
        told["found"] = found.map(|(joint, twin)| twin.told(Some(&joint.name))).into();
        shared.news.tell("what-if", told);
    }

    /// The machine with one of the joints, or why there is none.
    fn in_use(&self, joint: Source) -> Result<&MachineInUse, &str> {
        let twin = match joint {
            Source::File => &self.of_file,
            Source::Found => self.of_found.as_ref().ok_or(NONE_FOUND)?,
        };
        twin.in_use.as_ref().map_err(String::as_str)
    }
}

/// What is known of the machine that the device drives.
#[derive(Debug)]
pub struct Forecaster<'a> {
    machine: Option<&'a str>,
    known: Option<Known>,
}

impl<'a> Forecaster<'a> {
    /// As [`run`], which looks after it.
    pub const fn new(machine: Option<&'a str>) -> Self {
        Self { machine, known: None }
    }

    /// Tells what can be turned, if the device runs something else by now or another joint was
    /// identified, and predicts the next of the wishes, if there is one.
    pub fn pass(&mut self, wishes: &Wishes, shared: &Shared, next: Option<(Whose, Asked)>) {
        let Some(parameters) = shared.in_use() else {
            if let Some((_, asked)) = next {
                tell(&asked, "refused", json!("it is not known what the device runs"));
            }
            return;
        };
        let found = shared.found().ok();
        let is_new = |known: &Known| known.parameters != parameters || known.found != found;
        if self.known.as_ref().is_none_or(is_new) {
            let now = Known::new(parameters, self.machine, found);
            now.tell(self.machine, shared);
            self.known = Some(now);
        }
        let (Some((whose, asked)), Some(known)) = (next, &self.known) else { return };
        match &asked.what {
            Ask::Compare(text) => {
                let compared = compared(&known.parameters, self.machine, text);
                let _ = asked.answer.try_send(answer(asked.id, &compared));
            }
            Ask::Predict(wish) => match known.in_use(wish.joint) {
                Ok(in_use) => predict(in_use, &asked, wish, || wishes.is_old(whose)),
                Err(why) => tell(&asked, "refused", json!(why)),
            },
            // Nothing else comes here.
            _ => {}
        }
    }
}

/// Compares what is in use with a machine's file: its values by their paths, and what is different
/// as a line each. Of the file's controllers, the one that is in use is compared if it is there.
fn compared(in_use: &Parameters, machine: Option<&str>, text: &str) -> Result<Value, Error> {
    let document = match (text, machine) {
        ("", Some(machine)) => Document::open(machine)?,
        ("", None) => {
            let why = "compare: the studio was started without a machine's file; choose one";
            return Err(Error::Input(why.into()));
        }
        _ => Document::parse("the file", text)?,
    };
    let law = in_use.controller.compensator.first().map_or(PD, Gains::name);
    let has_it = document.get(&format!("controller.{law}")).is_some();
    let wanted: Vec<String> = has_it.then(|| law.to_owned()).into_iter().collect();
    let first = Experiment::plan(&document, &wanted, &[])?.into_first();
    let nothing = || Error::Input(format!("{}: there is nothing to run", document.origin.name));
    let file = for_a_device(&first.ok_or_else(nothing)?)?;
    let values: BTreeMap<String, String> = form::values(&file)?.into_iter().collect();
    let changes = machine_file::changes(in_use, &file)?;
    Ok(json!({ "name": document.origin.name, "values": values, "changes": changes }))
}

fn predict(machine: &MachineInUse, asked: &Asked, wish: &Wish, is_old: impl Fn() -> bool) {
    if let Err(error) = prediction::check(machine, &wish.way) {
        return tell(asked, "refused", json!(prediction::said(&error)));
    }
    tell(asked, "laws", prediction::laws(machine, wish));
    if wish.cloud == 0 || is_old() {
        return;
    }
    match cloud(machine, wish, is_old) {
        Ok(Some(cloud)) => tell(asked, "cloud", cloud),
        Ok(None) => {}
        Err(error @ (Error::Input(_) | Error::Refused(_))) => {
            tell(asked, "cloud", json!({ "refused": prediction::said(&error) }));
        }
        Err(error) => tell(asked, "cloud", json!({ "refused": error.to_string() })),
    }
}

/// Tells a part of an answer. A page that does not read needs none.
fn tell(asked: &Asked, part: &str, content: Value) {
    let told = json!({ "event": "predicted", "id": asked.id, "part": part, "content": content });
    let _ = asked.answer.try_send(told.to_string());
}
