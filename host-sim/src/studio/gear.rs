//! The gear of a device with two encoders, measured by moves after an identification, as
//! `stiction device identify` does.
//!
//! ```text
//! sequence ends -> the moves are planned -> at rest, after a keep-alive: armed
//!               -> one move after the other, each after a keep-alive -> off, fit, published
//! ```
//!
//! Moves, samples and fit are those of [`studies::device_gear`]. As in a self-test, the device is
//! armed and a move starts only while the page that started the identification commands and sends
//! keep-alives, and nothing is sent between that check and the request. If the page is silent, the
//! device's link timeout ends the moves. However the moves end, the joint of the sequence is
//! published, also if the device does not answer any more. Limit: the fit blocks the thread of the
//! device; the motor is off by then.

use std::time::Duration;

use stiction::identification::Summary;
use stiction::link::Status;

use super::orders::MotionReport;
use super::pending_gear::{PendingGear, waited_s};
use super::worker::Worker;
use files::error::Error;
use simulator::device::client::Map;
use simulator::device::wire::Wire;
use studies::device_gear::{self, GearRecorder, GearStep, PrecedingSequence};

/// Time after which the moves start though the joint is not at rest: the device may refuse that.
const LONGEST_REST_S: f64 = 1.0;

/// Time after the sequence in which the moves must start: a motor must not move for a button that
/// was pressed long before.
const LATEST: Duration = Duration::from_secs(3);

impl<W: Wire> Worker<'_, W> {
    /// Plans the moves for the gear after a sequence that a page has started. Returns the result if
    /// there are no moves.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub(super) fn sequence_ended(
        &mut self,
        summary: Summary,
        map: Map,
        sequence: &PrecedingSequence,
        page: u64,
    ) -> Result<Option<MotionReport>, Error> {
        let parameters = self.client.parameters()?;
        let status = self.client.status()?;
        let moves = match sequence.moves(summary.outcome, status.position, &parameters) {
            Some(Ok(moves)) => moves,
            Some(Err(why)) => {
                return Ok(Some(self.identified(summary, map, parameters, Some(Err(why)))));
            }
            None => return Ok(Some(self.identified(summary, map, parameters, None))),
        };
        let recorder = match GearRecorder::new(moves, self.signals.clone(), &status) {
            Ok(recorder) => recorder,
            Err(error) => {
                let gear = Some(Err(error.to_string()));
                return Ok(Some(self.identified(summary, map, parameters, gear)));
            }
        };
        self.gear = Some(PendingGear {
            summary,
            map,
            parameters,
            page,
            recorder,
            is_armed: false,
            since: status.clock,
            until: self.shared.now() + LATEST,
            lost: self.client.lost(),
        });
        self.fit_subscription()?;
        Ok(None)
    }

    /// Arms the device for the moves, or starts the next one, if it is time, the page that started
    /// the identification has just sent a keep-alive, and no stop is requested.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub(super) fn go_on_with_gear(&mut self, status: &Status) -> Result<(), Error> {
        if self.gear.is_none() {
            return Ok(());
        }
        self.next_step_of_gear(status)?;
        if self.gear.is_none() {
            // The pages show at once that the moves are over.
            self.ask_status()?;
        }
        Ok(())
    }

    fn next_step_of_gear(&mut self, status: &Status) -> Result<(), Error> {
        let Some(gear) = &self.gear else { return Ok(()) };
        let is_held = self.shared.control.is_held_by(gear.page);
        if !gear.is_armed && (!is_held || self.shared.now() > gear.until) {
            let why = "its moves were not started: the page that started the identification was \
                       gone or silent";
            return self.end_gear(Err(why.into()));
        }
        // Nothing is sent between this check and the request.
        if self.shared.is_stop_wanted() || !is_held || !self.has_keep_alive() {
            return Ok(());
        }
        let Some(gear) = &mut self.gear else { return Ok(()) };
        if !gear.is_armed {
            if !status.at_rest
                && waited_s(gear.since, status.clock, status.sample_time) < LONGEST_REST_S
            {
                return Ok(());
            }
            gear.is_armed = true;
            // The motor may be driven even if the answer is lost.
            (self.driven, self.armed_here) = (true, true);
            return match self.client.arm() {
                // Another client may drive the motor, which is then not stopped.
                Err(Error::Refused(why)) => self.end_gear(Err(why)),
                armed => armed,
            };
        }
        match gear.recorder.next(status) {
            Ok(GearStep::Wait) => Ok(()),
            Ok(GearStep::Move(motion)) => match self.client.move_along(*motion) {
                Err(Error::Refused(why)) => {
                    self.client.stop()?;
                    self.end_gear(Err(why))
                }
                started => started,
            },
            Ok(GearStep::Done) => {
                self.client.stop()?;
                self.end_gear(Ok(()))
            }
            Err(error) => self.end_gear(Err(error.to_string())),
        }
    }

    /// Ends the moves if the output has gone off, with the fault of the device.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub(super) fn gear_is_off(&mut self, status: &Status) -> Result<(), Error> {
        let Some(gear) = self.gear.as_mut().filter(|gear| gear.is_armed) else { return Ok(()) };
        let Err(error) = gear.recorder.next(status) else { return Ok(()) };
        let why = device_gear::why_ended(&error, &status.fault, &gear.parameters);
        self.end_gear(Err(why))
    }

    /// Publishes the identified joint with the gear, if moves for one are not over, and restores
    /// the subscription of the pages. An error is why the moves have ended early.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub(super) fn end_gear(&mut self, ended: Result<(), String>) -> Result<(), Error> {
        if self.gear.is_none() {
            return Ok(());
        }
        self.publish_gear(ended);
        self.fit_subscription()
    }

    /// Publishes the identified joint with the gear, if moves for one are not over. Sends nothing
    /// to the device, which may not answer any more.
    pub(super) fn publish_gear(&mut self, ended: Result<(), String>) {
        let Some(gear) = self.gear.take() else { return };
        let PendingGear { summary, map, parameters, recorder, lost, .. } = gear;
        let recording = recorder.ended(self.client.lost() - lost);
        // Without units the values are in V; the joint's report names the reason.
        let units = self.of_file().map_or(None, |(_, units)| units);
        let gear = ended.and_then(|()| device_gear::identify(&recording, &parameters, units));
        let report = self.identified(summary, map, parameters, Some(gear));
        self.publish_report(&report);
    }

    /// Changes the subscription if it does not suit: the moves need their signals, and the page its
    /// own afterwards.
    fn fit_subscription(&mut self) -> Result<(), Error> {
        if self.client.is_guest() || self.subscribed == self.wanted_subscription() {
            return Ok(());
        }
        self.publish_device()
    }
}
