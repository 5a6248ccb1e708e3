//! The self-test of a page: `stiction device selftest`, driven over the studio's own client.
//!
//! ```text
//! predict: parameters of the device, a joint -> another thread predicts; nothing moves
//! start:   arm, and then one move after the other, each after a keep-alive of the page that
//! started
//!          it
//! end:     the last move, a stop, a fault -> off, verdict
//! ```
//!
//! The moves, their times and their judgement are those of [`studies::selftest::Steps`]. Prediction
//! and moves are separate requests because a prediction takes time: a motor must not move for a
//! button that was pressed long before. For the same reason the request's age is checked last
//! before the arming, and nothing is sent between the check of the page's keep-alive and a move. A
//! move starts, and the status is requested, only while the page that started the self-test
//! commands and sends keep-alives. So only that page keeps the link alive: if it is gone, the
//! device's link timeout ends the self-test, even if another page commands by then. Limit: on a
//! link whose answers take longer than a keep-alive is valid, 0.15 s, no move starts.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::time::Duration;

use serde_json::{Value, json};
use stiction::link::{Sample, StateCode, Status};

use super::desk::QueuedRequest;
use super::machine_in_use::no_joint;
use super::pending_gear::{MEASURING, PendingGear};
use super::request::{JointSource, RequestedMotion};
use super::spare_cores::{begin, on_spare_cores};
use super::worker::Worker;
use files::error::Error;
use simulator::device::wire::Wire;
use simulator::experiment::Document;
use studies::selftest::{
    JOINTS, NextMove, PreparedSelfTest, SEED, SelfTestCheck, SelfTestRequest, SelfTestSession,
    Steps, object, sentence,
};

/// Phase of a self-test.
#[derive(Debug)]
pub enum SelftestPhase {
    /// Another thread predicts it.
    Predicting(PendingPrediction),
    /// It is predicted, and can start.
    Ready(Box<PredictedSelftest>),
    /// It moves the joint.
    Moving(Box<RunningSelftest>),
}

/// Request of a self-test. A page recognizes its prediction by these values.
#[derive(Clone, Debug)]
pub struct SelftestRequest {
    /// Number of the prediction, unique in this studio.
    number: u32,
    /// Range to either side, deg; `None` derives it.
    range_deg: Option<f64>,
    joint: JointSource,
}

impl SelftestRequest {
    fn add_to(&self, event: &mut Value) {
        event["number"] = self.number.into();
        event["deg"] = self.range_deg.into();
        event["joint"] = json!(self.joint);
    }
}

/// A self-test that was predicted.
#[derive(Clone, Debug)]
pub struct PredictedSelftest {
    wanted: SelftestRequest,
    prepared: PreparedSelfTest,
}

/// A self-test that is being predicted. The prediction ends when this is dropped.
#[derive(Debug)]
pub struct PendingPrediction {
    coming: Receiver<Result<Option<PreparedSelfTest>, Error>>,
    wanted: SelftestRequest,
    moves: usize,
    machine: String,
    /// Number of joints whose prediction is complete.
    over: Arc<AtomicU64>,
    /// Number of these joints that was published last.
    reported: u64,
    goes_on: Arc<AtomicBool>,
}

impl Drop for PendingPrediction {
    fn drop(&mut self) {
        self.goes_on.store(false, Ordering::Relaxed);
    }
}

impl PendingPrediction {
    fn event(&self) -> Value {
        json!({
            "phase": "predicting",
            "moves": self.moves,
            "joints": JOINTS,
            "over": self.reported,
            "machine": self.machine,
        })
    }
}

/// A self-test that moves the joint.
#[derive(Debug)]
pub struct RunningSelftest {
    ready: PredictedSelftest,
    steps: Steps,
    /// Number of the page that started it.
    page: u64,
    /// Clock at the start of the present wait, ticks; `None` until the next status.
    since: Option<u32>,
    /// Length of the wait.
    time: Duration,
}

impl<W: Wire> Worker<'_, W> {
    /// Returns whether a self-test moves the joint.
    pub(super) const fn is_testing(&self) -> bool {
        matches!(self.test, Some(SelftestPhase::Moving(_)))
    }

    /// Returns whether the page that started the self-test or the moves for the gear commands; true
    /// without them.
    pub(super) fn has_its_page(&self) -> bool {
        let page = match &self.test {
            Some(SelftestPhase::Moving(moving)) => Some(moving.page),
            _ => self.gear.as_ref().and_then(PendingGear::page),
        };
        page.is_none_or(|page| self.shared.control.is_held_by(page))
    }

    /// Publishes the state of the self-test, and the joints that it can be predicted with.
    fn publish_test(&self, mut event: Value) {
        let Self { about, .. } = self;
        event["file"] = about.is_its_file.then_some(&about.machine).map(String::as_str).into();
        event["why"] = (!about.is_its_file).then(|| nothing_known().to_string()).into();
        event["of_found"] = true.into();
        self.shared.news.publish("selftest", event);
    }

    /// Publishes that no self-test is predicted, and why.
    pub(super) fn publish_no_test(&self, said: Option<String>) {
        self.publish_test(json!({ "phase": "none", "said": said }));
    }

    /// Starts the prediction of the moves from the present position on another thread. Nothing
    /// moves.
    pub(super) fn predict_selftest(
        &mut self,
        range_deg: Option<f64>,
        moves: usize,
        joint: JointSource,
    ) -> Result<Value, Error> {
        if joint == JointSource::File && !self.about.is_its_file {
            return Err(nothing_known());
        }
        if let Some(SelftestPhase::Predicting(_)) = self.test {
            let why = "selftest: a prediction is running; wait until it ends, or cancel it";
            return Err(Error::Refused(why.into()));
        }
        if self.driven {
            let why = "selftest: the motor is driven; stop first, since the moves start from the \
                       position of the joint at rest";
            return Err(Error::Refused(why.into()));
        }
        let (machine, document) = match joint {
            JointSource::File => (self.about.machine.clone(), Document::open(&self.about.machine)?),
            JointSource::Found => {
                let found = self.shared.found()?;
                let document = Document::parse(&found.name, &found.text)?;
                (found.name, document)
            }
        };
        let (joints, seed, spreads) = (JOINTS, SEED, vec![]);
        let asked =
            SelfTestRequest { machine: machine.clone(), range_deg, moves, joints, seed, spreads };
        let planned = asked.plan_of(&mut self.client, document)?;
        let (done, coming) = sync_channel(1);
        let (over, goes_on) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(true)));
        let (counted, still) = (over.clone(), goes_on.clone());
        begin(move || {
            let look = |over| {
                counted.fetch_max(over, Ordering::Relaxed);
                still.load(Ordering::Relaxed)
            };
            let predicted = on_spare_cores(|| planned.predict_while(&look));
            // If the studio has ended, the result is dropped.
            let _ = done.send(predicted.and_then(|predicted| predicted));
        });
        let said = format!("predicts the self-test with the joint of {machine}: nothing moves");
        let number = self.shared.predictions.fetch_add(1, Ordering::Relaxed) + 1;
        let wanted = SelftestRequest { number, range_deg, joint };
        let predicting =
            PendingPrediction { coming, wanted, moves, machine, over, reported: 0, goes_on };
        self.publish_test(predicting.event());
        self.test = Some(SelftestPhase::Predicting(predicting));
        Ok(said.into())
    }

    /// Cancels the running prediction and publishes why. Returns whether there was one.
    pub(super) fn cancel_prediction(&mut self, why: &str) -> bool {
        let is_predicting = matches!(self.test, Some(SelftestPhase::Predicting(_)));
        if is_predicting {
            self.test = None;
            self.publish_no_test(Some(why.to_owned()));
        }
        is_predicting
    }

    /// Drops a self-test of the identified joint after another joint was identified.
    pub(super) fn drop_test_of_found(&mut self) {
        let of = match &self.test {
            Some(SelftestPhase::Predicting(predicting)) => predicting.wanted.joint,
            Some(SelftestPhase::Ready(ready)) => ready.wanted.joint,
            // While a self-test moves the joint, none is identified.
            Some(SelftestPhase::Moving(_)) | None => return,
        };
        if of == JointSource::Found {
            self.test = None;
            let why = "selftest: another joint was identified; predict the self-test again";
            self.publish_no_test(Some(why.into()));
        }
    }

    /// Publishes the prediction once it is complete, and its progress until then.
    pub(super) fn take_prediction(&mut self) {
        let Some(SelftestPhase::Predicting(predicting)) = &mut self.test else { return };
        let ended = || Error::Device("selftest: the prediction ended without a result".into());
        let predicted = match predicting.coming.try_recv() {
            Ok(predicted) => predicted.and_then(|predicted| predicted.ok_or_else(ended)),
            Err(TryRecvError::Empty) => {
                let over = predicting.over.load(Ordering::Relaxed);
                if over != predicting.reported {
                    predicting.reported = over;
                    let event = predicting.event();
                    self.publish_test(event);
                }
                return;
            }
            Err(TryRecvError::Disconnected) => Err(ended()),
        };
        match predicted {
            Ok(prepared) => {
                let wanted = predicting.wanted.clone();
                let mut event = json!({
                    "phase": "ready",
                    "machine": prepared.machine(),
                    "range_deg": prepared.range_deg(),
                    "moves": prepared.request.targets.len(),
                    "longest_s": prepared.longest_s(),
                    "joints": JOINTS,
                    "spreads": prepared.request.spreads,
                    "doubts": prepared.doubts(),
                    "differences": prepared.differences(),
                    "goal": prepared.goal().describe(),
                    "unseen_slack": prepared.unseen_slack().map(|slack| slack.to_string()),
                    "predicted_sides": prepared.predicted_sides(),
                    "checks": prepared.bounds().iter().map(bound).collect::<Vec<_>>(),
                });
                wanted.add_to(&mut event);
                self.publish_test(event);
                self.test =
                    Some(SelftestPhase::Ready(PredictedSelftest { wanted, prepared }.into()));
            }
            Err(error) => {
                self.test = None;
                self.publish_no_test(Some(error.to_string()));
            }
        }
    }

    /// Arms the device for the self-test that was predicted last. Refuses a request with another
    /// number, or one that is too old when the device is to be armed.
    pub(super) fn begin_selftest(
        &mut self,
        number: u32,
        order: &QueuedRequest,
    ) -> Result<Value, Error> {
        // An identification may have ended since the last status: its result is published first.
        // Moves for the gear may follow it.
        if self.running.is_some() {
            self.ask_status()?;
        }
        if self.gear.is_some() {
            return Err(Error::Refused(MEASURING.into()));
        }
        let Some(SelftestPhase::Ready(ready)) = &self.test else {
            return Err(Error::Refused("selftest: predict it first".into()));
        };
        if ready.wanted.number != number {
            let why = "selftest: it was predicted again meanwhile; look at the new moves first";
            return Err(Error::Refused(why.into()));
        }
        let ready = PredictedSelftest::clone(ready);
        let prepared = &ready.prepared;
        let status = prepared.fits(&mut self.client)?;
        let (signals, request) = (self.signals.clone(), &prepared.request);
        let (steps, time) = Steps::of(&request.targets, signals, &request.parameters, &status)?;
        let steps = steps.judged_by(prepared.goal());
        let moves = request.targets.len();
        let deg = prepared.range_deg();
        // The requests above took time.
        self.is_expected(order)?;
        self.client.arm()?;
        let (page, since) = (order.page, None);
        self.test =
            Some(SelftestPhase::Moving(RunningSelftest { ready, steps, page, since, time }.into()));
        self.publish_moves(0, moves, None);
        Ok(format!("the self-test starts: {moves} moves within {deg:.3} deg either way").into())
    }

    /// Passes a sample to the running self-test.
    pub(super) fn test_sees(&mut self, sample: &Sample) {
        if let Some(SelftestPhase::Moving(moving)) = &mut self.test {
            moving.steps.see(sample, self.client.load_ahead_deg(sample.clock));
        }
    }

    /// Starts the wait of the running self-test at this tick, unless it has started.
    pub(super) fn testing_since(&mut self, clock: u32) {
        if let Some(SelftestPhase::Moving(moving)) = &mut self.test {
            moving.since.get_or_insert(clock);
        }
    }

    /// Starts the next move if the last one is over, the page that started the self-test has just
    /// sent a keep-alive, and no stop is requested.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub(super) fn go_on_testing(&mut self, status: &Status) -> Result<(), Error> {
        let Some(SelftestPhase::Moving(moving)) = &mut self.test else { return Ok(()) };
        if status.is_testing {
            // The wait begins after the test at arming.
            moving.since = Some(status.clock);
        }
        let Some(since) = moving.since else { return Ok(()) };
        let ticks = status.clock.wrapping_sub(since);
        let passed_s = f64::from(ticks) * f64::from(status.sample_time);
        if status.state != StateCode::Armed || passed_s < moving.time.as_secs_f64() {
            return Ok(());
        }
        // These samples belong to the move that is over.
        self.show_kept();
        // Nothing is sent between this check and the move.
        if self.shared.is_stop_wanted() || !self.has_keep_alive() {
            return Ok(());
        }
        let Some(SelftestPhase::Moving(moving)) = &mut self.test else { return Ok(()) };
        let Some(NextMove { motion, to_deg, time }) = moving.steps.next(status)? else {
            // After the last move: the verdict uses the status of the armed device.
            self.client.stop()?;
            self.end_testing(status);
            self.ask_status()?;
            return Ok(());
        };
        match self.client.move_along(motion) {
            Ok(()) => {
                (moving.since, moving.time) = (None, time);
                let all = moving.ready.prepared.request.targets.len();
                let made = moving.steps.made();
                self.publish_motion(&RequestedMotion::Move(to_deg));
                self.publish_moves(made, all, Some(to_deg));
            }
            Err(error @ (Error::Device(_) | Error::Emulator(_))) => return Err(error),
            // The moves so far are judged, with the reason.
            Err(refused) => {
                moving.steps.refused(refused.to_string());
                self.client.stop()?;
                self.ask_status()?;
            }
        }
        Ok(())
    }

    /// Judges the moves of the running self-test after the last move, or after the output went off.
    pub(super) fn end_testing(&mut self, status: &Status) {
        let Some(SelftestPhase::Moving(moving)) =
            self.test.take_if(|test| matches!(test, SelftestPhase::Moving(_)))
        else {
            return;
        };
        let RunningSelftest { ready, steps, .. } = *moving;
        let PredictedSelftest { wanted, prepared } = &ready;
        let session: SelfTestSession = steps.ended(*status);
        let tested = prepared.clone().judged(session);
        let labels: serde_json::Map<String, Value> =
            tested.checks.iter().map(|check| (check.name.to_owned(), check.words.into())).collect();
        let mut event = json!({
            "phase": "done",
            "ok": tested.passes(),
            "said": sentence(&tested),
            "moves": prepared.request.targets.len(),
            "labels": labels,
            "unseen_slack": prepared.unseen_slack().map(|slack| slack.to_string()),
            "machine": prepared.machine(),
            "result": object(&tested, self.client.warning()),
        });
        wanted.add_to(&mut event);
        self.publish_test(event);
        // The same self-test can be started again.
        self.test = Some(SelftestPhase::Ready(ready.into()));
    }

    fn publish_moves(&self, made: usize, all: usize, to_deg: Option<f64>) {
        let event = json!({ "phase": "moving", "made": made, "moves": all, "to_deg": to_deg });
        self.publish_test(event);
    }
}

/// Returns a metric as JSON, with its predicted values and its bounds, before it is measured.
fn bound(check: &SelfTestCheck) -> Value {
    let [least, median, largest] = check.predicted.map(|value| value.is_finite().then_some(value));
    json!({
        "name": check.name,
        "words": check.words,
        "predicted": { "least": least, "median": median, "largest": largest },
        "least": check.least,
        "most": check.most,
    })
}

fn nothing_known() -> Error {
    no_joint("a self-test cannot be judged")
}
