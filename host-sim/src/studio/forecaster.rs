//! Thread that computes predictions. It sends nothing to the device, and does not delay it.
//!
//! While a slider moves, a page sends more requests than can be answered. Only the last request of
//! each page is kept, and it cancels an older one that is being computed.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::control::laws::Gains;
use tokio::sync::mpsc::Sender;

use super::cloud::cloud;
use super::desk::{NONE_IDENTIFIED, StudioState, UnsavedJoint, answer};
use super::knobs::knobs;
use super::machine_in_use::{MachineInUse, first_trajectory, no_joint};
use super::request::{JointSource, PredictionRequest, StudioAction};
use super::{form, prediction};
use files::error::Error;
use files::machine::{PD, TrajectoryTable};
use simulator::device::machine_file;
use simulator::experiment::{Document, Experiment, for_a_device};

/// Interval at which the thread checks whether any connection is left.
const LOOKS: Duration = Duration::from_millis(500);

/// A request of a page to predict or to compare, with the sender of its answer.
#[derive(Clone, Debug)]
pub struct PredictionJob {
    /// The page's number of the request.
    id: u32,
    what: StudioAction,
    answer: Sender<String>,
}

/// Number of a page, and whether its request is a comparison. A prediction does not cancel a
/// comparison.
pub type PredictionKey = (u64, bool);

/// The last requests of all pages.
#[derive(Debug, Default)]
pub struct PredictionQueue {
    last: Mutex<BTreeMap<PredictionKey, PredictionJob>>,
    come: Condvar,
}

impl PredictionQueue {
    fn last(&self) -> MutexGuard<'_, BTreeMap<PredictionKey, PredictionJob>> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Queues a request of a page. It replaces the previous one.
    pub fn put(&self, page: u64, id: u32, what: StudioAction, answer: Sender<String>) {
        let is_compared = matches!(what, StudioAction::Compare(_));
        self.last().insert((page, is_compared), PredictionJob { id, what, answer });
        self.come.notify_one();
    }

    /// Returns whether a newer request of the page waits.
    fn is_old(&self, whose: PredictionKey) -> bool {
        self.last().contains_key(&whose)
    }

    /// Takes the next request, if any.
    pub fn take(&self) -> Option<(PredictionKey, PredictionJob)> {
        self.last().pop_first()
    }

    fn next(&self) -> Option<(PredictionKey, PredictionJob)> {
        let last = self.last();
        let wait = self.come.wait_timeout_while(last, LOOKS, |last| last.is_empty());
        wait.unwrap_or_else(PoisonError::into_inner).0.pop_first()
    }
}

/// Predicts until the connections have dropped the queue. `machine` is the file of the device's
/// joint, if it is known.
pub fn run(wishes: &Arc<PredictionQueue>, shared: &StudioState, machine: Option<&str>) {
    let mut forecaster = Forecaster::new(machine);
    while Arc::strong_count(wishes) > 1 {
        let next = wishes.next();
        forecaster.pass(wishes, shared, next);
    }
}

/// Twin of the device: its parameters with the joint of a file, or the reason why there is none,
/// and the file's first trajectory.
#[derive(Clone, Debug)]
struct Twin {
    in_use: Result<MachineInUse, String>,
    trajectory: Option<TrajectoryTable>,
}

impl Twin {
    /// Combines the parameters with the joint's file.
    fn new(parameters: &Parameters, file: Result<Document, Error>) -> Self {
        let trajectory = file.as_ref().ok().and_then(|file| first_trajectory(file).ok());
        let in_use = file.and_then(|file| MachineInUse::new(parameters, &file));
        Self { in_use: in_use.map_err(|error| error.to_string()), trajectory }
    }

    /// Returns the knobs of the joint for the page.
    fn knobs_json(&self, machine: Option<&str>) -> Value {
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
            "has_two_encoders": self.in_use.as_ref().is_ok_and(MachineInUse::has_two_encoders),
        })
    }
}

/// Twins of the device, one for each known joint.
#[derive(Clone, Debug)]
struct JointTwins {
    parameters: Parameters,
    found: Option<UnsavedJoint>,
    of_file: Twin,
    of_found: Option<Twin>,
}

impl JointTwins {
    fn new(parameters: Parameters, machine: Option<&str>, found: Option<UnsavedJoint>) -> Self {
        let none = || no_joint("nothing is predicted");
        let of_file = Twin::new(&parameters, machine.ok_or_else(none).and_then(Document::open));
        let of_found = found.as_ref().map(|UnsavedJoint { name, text, .. }| {
            Twin::new(&parameters, Document::parse(name, text))
        });
        Self { parameters, found, of_file, of_found }
    }

    /// Publishes the knobs of each joint.
    fn publish(&self, machine: Option<&str>, shared: &StudioState) {
        let mut event = self.of_file.knobs_json(machine);
        let found = self.found.as_ref().zip(self.of_found.as_ref());
        event["found"] = found.map(|(joint, twin)| twin.knobs_json(Some(&joint.name))).into();
        shared.news.publish("what-if", event);
    }

    /// Returns the machine in use with one of the joints, or the reason why there is none.
    fn in_use(&self, joint: JointSource) -> Result<&MachineInUse, &str> {
        let twin = match joint {
            JointSource::File => &self.of_file,
            JointSource::Found => self.of_found.as_ref().ok_or(NONE_IDENTIFIED)?,
        };
        twin.in_use.as_ref().map_err(String::as_str)
    }
}

/// Predictor with the twins of the device.
#[derive(Debug)]
pub struct Forecaster<'a> {
    machine: Option<&'a str>,
    known: Option<JointTwins>,
}

impl<'a> Forecaster<'a> {
    /// Starts without a twin.
    pub const fn new(machine: Option<&'a str>) -> Self {
        Self { machine, known: None }
    }

    /// Publishes the knobs if the parameters or the identified joint have changed, and computes the
    /// next request, if any.
    pub fn pass(
        &mut self,
        wishes: &PredictionQueue,
        shared: &StudioState,
        next: Option<(PredictionKey, PredictionJob)>,
    ) {
        let Some(parameters) = shared.in_use() else {
            if let Some((_, asked)) = next {
                send_part(
                    &asked,
                    "refused",
                    json!(
                        "the device has no parameters; set them with `params push FILE.toml --save`"
                    ),
                );
            }
            return;
        };
        let found = shared.found().ok();
        let is_new = |known: &JointTwins| known.parameters != parameters || known.found != found;
        if self.known.as_ref().is_none_or(is_new) {
            let now = JointTwins::new(parameters, self.machine, found);
            now.publish(self.machine, shared);
            self.known = Some(now);
        }
        let (Some((whose, asked)), Some(known)) = (next, &self.known) else { return };
        match &asked.what {
            StudioAction::Compare(text) => {
                let compared = compared(&known.parameters, self.machine, text);
                let _ = asked.answer.try_send(answer(asked.id, &compared));
            }
            StudioAction::Predict(wish) => match known.in_use(wish.joint) {
                Ok(in_use) => predict(in_use, &asked, wish, || wishes.is_old(whose)),
                Err(why) => send_part(&asked, "refused", json!(why)),
            },
            // The queue holds no other actions.
            _ => {}
        }
    }
}

/// Compares the parameters in use with a machine's file: the file's values by their paths, and a
/// line for each difference. Of the file's controllers, the one in use is compared if the file has
/// it.
fn compared(in_use: &Parameters, machine: Option<&str>, text: &str) -> Result<Value, Error> {
    let document = match (text, machine) {
        ("", Some(machine)) => Document::open(machine)?,
        ("", None) => {
            let why = "compare: the studio was started without a machine's file; choose one";
            return Err(Error::Input(why.into()));
        }
        _ => Document::parse("the file", text)?,
    };
    let law = match in_use.controller.compensator.first() {
        // A file has one name for both laws.
        Some(Gains::RobustDual(_)) => "robust",
        Some(law) => law.name(),
        None => PD,
    };
    let has_it = document.get(&format!("controller.{law}")).is_some();
    let wanted: Vec<String> = has_it.then(|| law.to_owned()).into_iter().collect();
    let first = Experiment::plan(&document, &wanted, &[])?.into_first();
    let nothing = || Error::Input(format!("{}: there is nothing to run", document.origin.name));
    let file = for_a_device(&first.ok_or_else(nothing)?)?;
    let values: BTreeMap<String, String> = form::values(&file)?.into_iter().collect();
    let changes = machine_file::changes(in_use, &file)?;
    Ok(json!({ "name": document.origin.name, "values": values, "changes": changes }))
}

fn predict(
    machine: &MachineInUse,
    asked: &PredictionJob,
    wish: &PredictionRequest,
    is_old: impl Fn() -> bool,
) {
    if let Err(error) = prediction::check(machine, &wish.way) {
        return send_part(asked, "refused", json!(error.to_string()));
    }
    send_part(asked, "laws", prediction::laws(machine, wish));
    if wish.cloud == 0 || is_old() {
        return;
    }
    match cloud(machine, wish, is_old) {
        Ok(Some(cloud)) => send_part(asked, "cloud", cloud),
        Ok(None) => {}
        Err(error @ (Error::Input(_) | Error::Refused(_))) => {
            send_part(asked, "cloud", json!({ "refused": error.to_string() }));
        }
        Err(error) => send_part(asked, "cloud", json!({ "refused": error.to_string() })),
    }
}

/// Sends a part of an answer. If the page does not read, the part is dropped.
fn send_part(asked: &PredictionJob, part: &str, content: Value) {
    let event = json!({ "event": "predicted", "id": asked.id, "part": part, "content": content });
    let _ = asked.answer.try_send(event.to_string());
}
