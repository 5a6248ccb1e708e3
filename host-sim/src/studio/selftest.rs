//! The self-test of a page: `stiction device selftest`, driven over the studio's own client.
//!
//! ```text
//! predict: parameters of the device, joint of the file -> another thread predicts; nothing moves
//! begin:   arm, and then a move after the other, each on a word of the page that has begun it
//! end:     the last move, a stop, a fault -> off, verdict
//! ```
//!
//! The moves, their times and their judgement are those of [`crate::selftest::Steps`]. The two are
//! apart because a prediction takes its time: nobody expects a motor to move for a button that was
//! pressed long before. A move begins, and the status is asked for, only while the page that has
//! begun the self-test commands and gives its words. So that page alone keeps the link alive: if it
//! is gone, the device's link timeout ends the self-test, also where another page commands by then.

use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::time::Duration;

use serde_json::{Value, json};
use stiction::link::{Sample, StateCode, Status};

use super::machine_in_use::no_file;
use super::request::Way;
use super::spare_cores::on_spare_cores;
use super::worker::Worker;
use crate::device::wire::Wire;
use crate::error::Error;
use crate::selftest::{
    Asked, Check, JOINTS, Next, Prepared, SEED, Session, Steps, object, sentence, words,
};

/// A self-test, as far as it is.
#[derive(Debug)]
pub enum Test {
    /// Another thread predicts it.
    Predicting(Receiver<Result<Prepared, Error>>),
    /// It may begin.
    Ready(Box<Prepared>),
    /// It moves the joint.
    Moving(Box<Moving>),
}

/// A self-test that moves the joint.
#[derive(Debug)]
pub struct Moving {
    prepared: Prepared,
    steps: Steps,
    /// The page that has begun it.
    page: u64,
    /// The tick in which the wait began that is on.
    since: u32,
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

    /// Tells that nothing is predicted, and why.
    pub(super) fn tell_no_test(&self, said: Option<String>) {
        let why = (!self.about.is_its_file).then(|| nothing_known().to_string());
        self.shared.news.tell("selftest", json!({ "phase": "none", "why": why, "said": said }));
    }

    /// Lets another thread predict the moves from where the joint is. Nothing moves.
    pub(super) fn predict_selftest(
        &mut self,
        range_deg: Option<f64>,
        moves: usize,
    ) -> Result<Value, Error> {
        if !self.about.is_its_file {
            return Err(nothing_known());
        }
        if let Some(Test::Predicting(_)) = self.test {
            let why = "selftest: it is being predicted; one prediction is computed at a time";
            return Err(Error::Refused(why.into()));
        }
        if self.driven {
            let why = "selftest: the output is on; stop first, since the moves begin where the \
                       joint is then";
            return Err(Error::Refused(why.into()));
        }
        let machine = self.about.machine.clone();
        let asked =
            Asked { machine, range_deg, moves, joints: JOINTS, seed: SEED, spreads: vec![] };
        let planned = asked.plan(&mut self.client).map_err(of_a_page)?;
        let (done, is_done) = sync_channel(1);
        std::thread::spawn(move || {
            let predicted = on_spare_cores(|| planned.predict()).and_then(|predicted| predicted);
            // A studio that has ended needs none.
            let _ = done.send(predicted);
        });
        self.test = Some(Test::Predicting(is_done));
        let told = json!({ "phase": "predicting", "moves": moves, "joints": JOINTS });
        self.shared.news.tell("selftest", told);
        Ok("predicts the self-test: nothing moves".into())
    }

    /// Takes what was predicted, if it is there.
    pub(super) fn take_prediction(&mut self) {
        let Some(Test::Predicting(coming)) = &self.test else { return };
        let predicted = match coming.try_recv() {
            Ok(predicted) => predicted,
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => {
                Err(Error::Device("selftest: the prediction has ended by itself".into()))
            }
        };
        match predicted {
            Ok(prepared) => {
                let told = json!({
                    "phase": "ready",
                    "range_deg": prepared.range_deg(),
                    "moves": prepared.request.targets.len(),
                    "longest_s": prepared.longest_s(),
                    "joints": JOINTS,
                    "spreads": prepared.request.spreads,
                    "differences": prepared.differences(),
                    "checks": prepared.bounds().iter().map(bound).collect::<Vec<_>>(),
                });
                self.shared.news.tell("selftest", told);
                self.test = Some(Test::Ready(prepared.into()));
            }
            Err(error) => {
                self.test = None;
                self.tell_no_test(Some(of_a_page(error).to_string()));
            }
        }
    }

    /// Arms the device for the self-test that was predicted last. `page` has begun it.
    pub(super) fn begin_selftest(&mut self, page: u64) -> Result<Value, Error> {
        let Some(Test::Ready(prepared)) = &self.test else {
            return Err(Error::Refused("selftest: predict it first".into()));
        };
        prepared.fits(&mut self.client).map_err(of_a_page)?;
        let prepared = Prepared::clone(prepared);
        let (steps, time) = Steps::arm(&mut self.client, &prepared.request.targets)?;
        let since = self.client.status()?.clock;
        let moves = prepared.request.targets.len();
        let deg = prepared.range_deg();
        self.test = Some(Test::Moving(Moving { prepared, steps, page, since, time }.into()));
        self.tell_moves(0, moves, None);
        Ok(format!("the self-test begins: {moves} moves within {deg:.3} deg either way").into())
    }

    /// The self-test sees a sample.
    pub(super) fn test_sees(&mut self, sample: &Sample) {
        if let Some(Test::Moving(moving)) = &mut self.test {
            moving.steps.see(sample);
        }
    }

    /// Begins the next move if the last one is over. The page that has begun the self-test has just
    /// given a word.
    ///
    /// # Errors
    /// Says that the device does not answer.
    pub(super) fn go_on_testing(&mut self, status: &Status) -> Result<(), Error> {
        let Some(Test::Moving(moving)) = &self.test else { return Ok(()) };
        let ticks = status.clock.wrapping_sub(moving.since);
        let passed_s = f64::from(ticks) * f64::from(status.sample_time);
        if status.state != StateCode::Armed || passed_s < moving.time.as_secs_f64() {
            return Ok(());
        }
        // They are of the move that is over.
        self.show_kept();
        let next = match &mut self.test {
            Some(Test::Moving(moving)) => moving.steps.next(&mut self.client, status),
            _ => Ok(None),
        };
        let begun = next.and_then(|next| match next {
            Some(Next { motion, to_deg, time }) => {
                self.client.move_along(motion)?;
                self.tell_motion(&Way::Move(to_deg));
                Ok(Some((self.client.status()?.clock, time, to_deg)))
            }
            None => Ok(None),
        });
        match begun {
            Ok(Some((since, time, to_deg))) => {
                if let Some(Test::Moving(moving)) = &mut self.test {
                    (moving.since, moving.time) = (since, time);
                    let (made, all) = (moving.steps.made(), moving.prepared.request.targets.len());
                    self.tell_moves(made, all, Some(to_deg));
                }
            }
            // It was the last one. The verdict is that of the device that was armed until now.
            Ok(None) => {
                self.client.stop()?;
                self.end_testing(status);
                self.ask_status()?;
            }
            Err(error @ (Error::Device(_) | Error::Emulator(_))) => return Err(error),
            Err(refused) => {
                self.client.stop()?;
                if let Some(Test::Moving(moving)) = self.test.take() {
                    self.test = Some(Test::Ready(moving.prepared.into()));
                }
                self.tell_no_test(Some(refused.to_string()));
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
        let Moving { prepared, steps, .. } = *moving;
        let session: Session = steps.ended(*status);
        let tested = prepared.clone().judged(session);
        let labels: serde_json::Map<String, Value> =
            tested.checks.iter().map(|check| (check.name.to_owned(), check.words.into())).collect();
        let told = json!({
            "phase": "done",
            "ok": tested.passes(),
            "said": sentence(&tested),
            "moves": prepared.request.targets.len(),
            "labels": labels,
            "result": object(&tested, self.client.warning()),
            "text": words(&tested),
        });
        self.shared.news.tell("selftest", told);
        // It may be repeated.
        self.test = Some(Test::Ready(prepared.into()));
    }

    fn tell_moves(&self, made: usize, all: usize, to_deg: Option<f64>) {
        let told = json!({ "phase": "moving", "made": made, "moves": all, "to_deg": to_deg });
        self.shared.news.tell("selftest", told);
    }
}

/// A figure with its bounds, before anything was measured.
fn bound(check: &Check) -> Value {
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
    no_file("there is nothing that a self-test could be judged by")
}

/// A refusal in the words of the page, which has no options.
fn of_a_page(error: Error) -> Error {
    let said = |text: String| text.replace("--range", "range");
    match error {
        Error::Input(text) => Error::Input(said(text)),
        Error::Refused(text) => Error::Refused(said(text)),
        // Not of the link: the session goes on.
        Error::Device(text) if text.starts_with("selftest") => Error::Refused(said(text)),
        other => other,
    }
}
