//! The self-test of a page: `stiction device selftest`, driven over the studio's own client.
//!
//! ```text
//! predict: parameters of the device, a joint -> another thread predicts; nothing moves
//! begin:   arm, and then a move after the other, each on a word of the page that has begun it
//! end:     the last move, a stop, a fault -> off, verdict
//! ```
//!
//! The moves, their times and their judgement are those of [`crate::selftest::Steps`]. The two are
//! apart because a prediction takes its time: nobody expects a motor to move for a button that was
//! pressed long before. For the same reason the last thing before the arming is to look whether the
//! order is expected still, and nothing is asked between a look at the page's word and a move. A
//! move begins, and the status is asked for, only while the page that has begun the self-test
//! commands and gives its words. So that page alone keeps the link alive: if it is gone, the
//! device's link timeout ends the self-test, also where another page commands by then. Does badly:
//! on a link whose answers take as long as a word is worth, 0.15 s, no move begins.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::time::Duration;

use serde_json::{Value, json};
use stiction::link::{Sample, StateCode, Status};

use super::desk::Order;
use super::machine_in_use::no_joint;
use super::request::{Source, Way};
use super::spare_cores::{begin, on_spare_cores};
use super::wording::of_a_page;
use super::worker::Worker;
use crate::device::wire::Wire;
use crate::error::Error;
use crate::experiment::Document;
use crate::selftest::{
    JOINTS, NextMove, PreparedSelfTest, SEED, SelfTestCheck, SelfTestRequest, SelfTestSession,
    Steps, object, sentence,
};

/// A self-test, as far as it is.
#[derive(Debug)]
pub enum Test {
    /// Another thread predicts it.
    Predicting(Predicting),
    /// It may begin.
    Ready(Box<Ready>),
    /// It moves the joint.
    Moving(Box<Moving>),
}

/// What was asked for, so that a page knows whose moves it is to make.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// No other prediction of this studio has it.
    number: u32,
    /// Left out, the range is derived.
    range_deg: Option<f64>,
    joint: Source,
}

impl Wanted {
    fn add_to(&self, told: &mut Value) {
        told["number"] = self.number.into();
        told["deg"] = self.range_deg.into();
        told["joint"] = json!(self.joint);
    }
}

/// A self-test that was predicted.
#[derive(Clone, Debug)]
pub struct Ready {
    wanted: Wanted,
    prepared: PreparedSelfTest,
}

/// A self-test that is being predicted. The prediction ends when this is dropped.
#[derive(Debug)]
pub struct Predicting {
    coming: Receiver<Result<Option<PreparedSelfTest>, Error>>,
    wanted: Wanted,
    moves: usize,
    machine: String,
    /// How many joints are done, and how many the pages have been told of.
    over: Arc<AtomicU64>,
    told: u64,
    goes_on: Arc<AtomicBool>,
}

impl Drop for Predicting {
    fn drop(&mut self) {
        self.goes_on.store(false, Ordering::Relaxed);
    }
}

impl Predicting {
    fn told(&self) -> Value {
        json!({
            "phase": "predicting",
            "moves": self.moves,
            "joints": JOINTS,
            "over": self.told,
            "machine": self.machine,
        })
    }
}

/// A self-test that moves the joint.
#[derive(Debug)]
pub struct Moving {
    ready: Ready,
    steps: Steps,
    /// The page that has begun it.
    page: u64,
    /// The tick in which the wait was seen to begin that is on.
    since: Option<u32>,
    /// How long it is.
    time: Duration,
}

impl<W: Wire> Worker<'_, W> {
    /// Whether it moves the joint.
    pub(super) const fn is_testing(&self) -> bool {
        matches!(self.test, Some(Test::Moving(_)))
    }

    /// Whether the page commands that has begun the self-test; without one, any is right.
    pub(super) fn has_its_page(&self) -> bool {
        match &self.test {
            Some(Test::Moving(moving)) => self.shared.control.is_held_by(moving.page),
            _ => true,
        }
    }

    /// Tells how far the self-test is, and whose joints it could be predicted with.
    fn tell_test(&self, mut told: Value) {
        let Self { about, .. } = self;
        told["file"] = about.is_its_file.then_some(&about.machine).map(String::as_str).into();
        told["why"] = (!about.is_its_file).then(|| nothing_known().to_string()).into();
        told["of_found"] = true.into();
        self.shared.news.tell("selftest", told);
    }

    /// Tells that nothing is predicted, and why.
    pub(super) fn tell_no_test(&self, said: Option<String>) {
        self.tell_test(json!({ "phase": "none", "said": said }));
    }

    /// Lets another thread predict the moves from where the joint is. Nothing moves.
    pub(super) fn predict_selftest(
        &mut self,
        range_deg: Option<f64>,
        moves: usize,
        joint: Source,
    ) -> Result<Value, Error> {
        if joint == Source::File && !self.about.is_its_file {
            return Err(nothing_known());
        }
        if let Some(Test::Predicting(_)) = self.test {
            let why = "selftest: it is being predicted; one prediction is computed at a time";
            return Err(Error::Refused(why.into()));
        }
        if self.driven {
            let why = "selftest: the motor is driven; stop first, since the moves begin where \
                       the joint is then";
            return Err(Error::Refused(why.into()));
        }
        let (machine, document) = match joint {
            Source::File => (self.about.machine.clone(), Document::open(&self.about.machine)?),
            Source::Found => {
                let found = self.shared.found()?;
                let document = Document::parse(&found.name, &found.text)?;
                (found.name, document)
            }
        };
        let (joints, seed, spreads) = (JOINTS, SEED, vec![]);
        let asked =
            SelfTestRequest { machine: machine.clone(), range_deg, moves, joints, seed, spreads };
        let planned = asked.plan_of(&mut self.client, document).map_err(of_a_page)?;
        let (done, coming) = sync_channel(1);
        let (over, goes_on) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(true)));
        let (counted, still) = (over.clone(), goes_on.clone());
        begin(move || {
            let look = |over| {
                counted.fetch_max(over, Ordering::Relaxed);
                still.load(Ordering::Relaxed)
            };
            let predicted = on_spare_cores(|| planned.predict_while(&look));
            // A studio that has ended needs none.
            let _ = done.send(predicted.and_then(|predicted| predicted));
        });
        let said = format!("predicts the self-test with the joint of {machine}: nothing moves");
        let number = self.shared.predictions.fetch_add(1, Ordering::Relaxed) + 1;
        let wanted = Wanted { number, range_deg, joint };
        let predicting = Predicting { coming, wanted, moves, machine, over, told: 0, goes_on };
        self.tell_test(predicting.told());
        self.test = Some(Test::Predicting(predicting));
        Ok(said.into())
    }

    /// Ends the prediction that is computed, and tells why; whether there was one.
    pub(super) fn cancel_prediction(&mut self, why: &str) -> bool {
        let is_predicting = matches!(self.test, Some(Test::Predicting(_)));
        if is_predicting {
            self.test = None;
            self.tell_no_test(Some(why.to_owned()));
        }
        is_predicting
    }

    /// Another joint was found, so what was predicted with the one before is none of it.
    pub(super) fn drop_test_of_found(&mut self) {
        let of = match &self.test {
            Some(Test::Predicting(predicting)) => predicting.wanted.joint,
            Some(Test::Ready(ready)) => ready.wanted.joint,
            // None was identified meanwhile.
            Some(Test::Moving(_)) | None => return,
        };
        if of == Source::Found {
            self.test = None;
            let why = "selftest: another joint was identified; predict it anew";
            self.tell_no_test(Some(why.into()));
        }
    }

    /// Takes what was predicted, if it is there.
    pub(super) fn take_prediction(&mut self) {
        let Some(Test::Predicting(predicting)) = &mut self.test else { return };
        let by_itself = || Error::Device("selftest: the prediction has ended by itself".into());
        let predicted = match predicting.coming.try_recv() {
            Ok(predicted) => predicted.and_then(|predicted| predicted.ok_or_else(by_itself)),
            Err(TryRecvError::Empty) => {
                let over = predicting.over.load(Ordering::Relaxed);
                if over != predicting.told {
                    predicting.told = over;
                    let told = predicting.told();
                    self.tell_test(told);
                }
                return;
            }
            Err(TryRecvError::Disconnected) => Err(by_itself()),
        };
        match predicted {
            Ok(prepared) => {
                let wanted = predicting.wanted.clone();
                let mut told = json!({
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
                wanted.add_to(&mut told);
                self.tell_test(told);
                self.test = Some(Test::Ready(Ready { wanted, prepared }.into()));
            }
            Err(error) => {
                self.test = None;
                self.tell_no_test(Some(of_a_page(error).to_string()));
            }
        }
    }

    /// Arms the device for the self-test that was predicted last, unless the order means another
    /// one, or is not expected any more by then.
    pub(super) fn begin_selftest(&mut self, number: u32, order: &Order) -> Result<Value, Error> {
        // An identification may have ended since the status was asked: what it has found is first.
        if self.running.is_some() {
            self.ask_status()?;
        }
        let Some(Test::Ready(ready)) = &self.test else {
            return Err(Error::Refused("selftest: predict it first".into()));
        };
        if ready.wanted.number != number {
            let why = "selftest: it was predicted anew meanwhile; look at these moves first";
            return Err(Error::Refused(why.into()));
        }
        let ready = Ready::clone(ready);
        let prepared = &ready.prepared;
        let status = prepared.fits(&mut self.client).map_err(of_a_page)?;
        let (signals, request) = (self.signals.clone(), &prepared.request);
        let (steps, time) = Steps::of(&request.targets, signals, &request.parameters, &status)?;
        let steps = steps.judged_by(prepared.goal());
        let moves = request.targets.len();
        let deg = prepared.range_deg();
        // All that was asked so far took its time.
        self.is_expected(order)?;
        self.client.arm()?;
        let (page, since) = (order.page, None);
        self.test = Some(Test::Moving(Moving { ready, steps, page, since, time }.into()));
        self.tell_moves(0, moves, None);
        Ok(format!("the self-test begins: {moves} moves within {deg:.3} deg either way").into())
    }

    /// The self-test sees a sample.
    pub(super) fn test_sees(&mut self, sample: &Sample) {
        if let Some(Test::Moving(moving)) = &mut self.test {
            moving.steps.see(sample, self.client.load_ahead_deg(sample.clock));
        }
    }

    /// A wait of the self-test that has just begun is counted from this tick on.
    pub(super) fn testing_since(&mut self, clock: u32) {
        if let Some(Test::Moving(moving)) = &mut self.test {
            moving.since.get_or_insert(clock);
        }
    }

    /// Begins the next move if the last one is over, if the page that has begun the self-test has
    /// just given a word, and if nobody wants to stop.
    ///
    /// # Errors
    /// Says that the device does not answer.
    pub(super) fn go_on_testing(&mut self, status: &Status) -> Result<(), Error> {
        let Some(Test::Moving(moving)) = &self.test else { return Ok(()) };
        let Some(since) = moving.since else { return Ok(()) };
        let ticks = status.clock.wrapping_sub(since);
        let passed_s = f64::from(ticks) * f64::from(status.sample_time);
        if status.state != StateCode::Armed || passed_s < moving.time.as_secs_f64() {
            return Ok(());
        }
        // They are of the move that is over.
        self.show_kept();
        // Nothing is asked between this look and the move.
        if self.shared.is_stop_wanted() || !self.has_word() {
            return Ok(());
        }
        let Some(Test::Moving(moving)) = &mut self.test else { return Ok(()) };
        let Some(NextMove { motion, to_deg, time }) = moving.steps.next(status)? else {
            // It was the last one. The verdict is that of the device that was armed until now.
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
                self.tell_motion(&Way::Move(to_deg));
                self.tell_moves(made, all, Some(to_deg));
            }
            Err(error @ (Error::Device(_) | Error::Emulator(_))) => return Err(error),
            // What was made so far is judged, with the reason.
            Err(refused) => {
                moving.steps.refused(refused.to_string());
                self.client.stop()?;
                self.ask_status()?;
            }
        }
        Ok(())
    }

    /// Judges the moves, if there is a self-test that moves the joint: all were made, or the device
    /// is off.
    pub(super) fn end_testing(&mut self, status: &Status) {
        let Some(Test::Moving(moving)) = self.test.take_if(|test| matches!(test, Test::Moving(_)))
        else {
            return;
        };
        let Moving { ready, steps, .. } = *moving;
        let Ready { wanted, prepared } = &ready;
        let session: SelfTestSession = steps.ended(*status);
        let tested = prepared.clone().judged(session);
        let labels: serde_json::Map<String, Value> =
            tested.checks.iter().map(|check| (check.name.to_owned(), check.words.into())).collect();
        let mut told = json!({
            "phase": "done",
            "ok": tested.passes(),
            "said": sentence(&tested),
            "moves": prepared.request.targets.len(),
            "labels": labels,
            "unseen_slack": prepared.unseen_slack().map(|slack| slack.to_string()),
            "machine": prepared.machine(),
            "result": object(&tested, self.client.warning()),
        });
        wanted.add_to(&mut told);
        self.tell_test(told);
        // It may be repeated.
        self.test = Some(Test::Ready(ready.into()));
    }

    fn tell_moves(&self, made: usize, all: usize, to_deg: Option<f64>) {
        let told = json!({ "phase": "moving", "made": made, "moves": all, "to_deg": to_deg });
        self.tell_test(told);
    }
}

/// A figure with its bounds, before anything was measured.
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
    no_joint("there is nothing that a self-test could be judged by")
}
