//! A session of moves over the link: any device, real, emulated or simulated.
//!
//! [`Steps`] says what comes next and judges what came, and asks no device. Who arms, moves and
//! waits is another matter: the command does it in [`run`], and the studio serves its pages and
//! looks before each request whether it is wanted still.

use std::time::Duration;

use stiction::link::{Sample, StateCode, Status};
use stiction::{Motion, Parameters, ProfileLimits};

use super::measures::{MoveMeasures, SIGNALS, measures};
use crate::device::client::{Client, position_of};
use crate::device::moved::longest_s;
use crate::device::signals::Signals;
use crate::device::wire::Wire;
use crate::error::Error;
use crate::goal::PositionGoal;

/// Least time between two samples, s.
const LOOKED_AT_S: f64 = 0.01;

/// Time that a joint has after its set point rests, s: a second of an integral and its settling,
/// and the second in which rest is judged.
const SETTLES_S: f64 = 2.0;

/// A move that takes longer than this, s, is none of a self-test: its range is refused before
/// anything moves.
pub(super) const LONGEST_S: f64 = 60.0;

/// The time that a move over so many degrees has, s: that of its set point, and to settle.
pub(super) fn time_s(profile: &ProfileLimits, goal: &PositionGoal, way_deg: f64) -> f64 {
    longest_s(profile, way_deg) + goal.watched_s(SETTLES_S)
}

/// What a session has come to.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfTestSession {
    /// The moves that were made.
    pub moves: Vec<MoveMeasures>,
    /// The status after the last of them.
    pub status: Status,
    /// Whether the device ended it: a fault, or a stop.
    pub is_ended: bool,
    /// Why the device refused a move, if one was refused.
    pub refused: Option<String>,
}

/// A move that is to begin.
#[derive(Clone, Debug, PartialEq)]
pub struct NextMove {
    /// What the device is told.
    pub motion: Motion,
    /// Where it leads, deg.
    pub to_deg: f64,
    /// How long it has. It is over before if the device is not armed any more.
    pub time: Duration,
}

/// A session in steps.
#[derive(Clone, Debug)]
pub struct Steps {
    targets: Vec<f64>,
    signals: Signals,
    profile: ProfileLimits,
    count_deg: f64,
    sample_time_s: f64,
    /// Where the move leads that is made, deg.
    to_deg: Option<f64>,
    samples: Vec<Sample>,
    /// The load's angle minus that of the encoder's side in each of them, deg.
    load_ahead_deg: Vec<Option<f64>>,
    goal: PositionGoal,
    moves: Vec<MoveMeasures>,
    begun: usize,
    refused: Option<String>,
}

impl Steps {
    /// Moves of a device that has these signals and parameters, and stood like that. It is armed
    /// where its joint is, and the first move begins after the time that is returned: the soft
    /// start is no part of it.
    ///
    /// # Errors
    /// Says that a target is no position.
    pub fn of(
        targets: &[f64],
        signals: Signals,
        parameters: &Parameters,
        status: &Status,
    ) -> Result<(Self, Duration), Error> {
        let Parameters { profile, device, .. } = parameters;
        let [count_deg, sample_time_s] = [status.resolution, status.sample_time].map(f64::from);
        targets.iter().try_for_each(|deg| position_of(*deg, count_deg).map(|_| ()))?;
        let waits = [device.reset_pulse, device.wake_up, device.soft_start].map(f64::from);
        let steps = Self {
            targets: targets.to_vec(),
            signals,
            profile: *profile,
            count_deg,
            sample_time_s,
            to_deg: None,
            samples: vec![],
            load_ahead_deg: vec![],
            goal: PositionGoal::default(),
            moves: vec![],
            begun: 0,
            refused: None,
        };
        Ok((steps, Duration::from_secs_f64(waits.iter().sum::<f64>() + SETTLES_S)))
    }

    /// Judges the moves by a file's goal.
    #[must_use]
    pub fn judged_by(self, goal: PositionGoal) -> Self {
        Self { goal, ..self }
    }

    /// The signals that are needed, as a sum of 1 << place.
    pub fn mask(&self) -> u64 {
        self.signals.mask(SIGNALS)
    }

    /// Ticks from one sample to the next one that is needed.
    pub fn every(&self) -> u16 {
        (LOOKED_AT_S / self.sample_time_s).clamp(1.0, 1000.0).round() as u16
    }

    /// How many moves are over.
    pub const fn made(&self) -> usize {
        self.moves.len()
    }

    /// Takes a sample. Of samples that come more often than [`every`](Self::every) says, only so
    /// many are kept: the prediction has no more. One from just before a move begins changes
    /// nothing of it, since the set point stands still in it.
    ///
    /// `load_ahead_deg` is the load's angle minus that of the encoder's side, deg, if the device
    /// knows it.
    pub fn see(&mut self, sample: &Sample, load_ahead_deg: Option<f64>) {
        let is_due =
            |last: &Sample| sample.clock.wrapping_sub(last.clock) >= u32::from(self.every());
        if self.signals.is_armed(sample) && self.samples.last().is_none_or(is_due) {
            self.samples.push(sample.clone());
            self.load_ahead_deg.push(load_ahead_deg);
        }
    }

    /// Judges the move whose time is over, and says which one begins now; none if there is none
    /// any more, or the device is not armed.
    ///
    /// # Errors
    /// Says that a target is no position, which [`of`](Self::of) has refused already.
    pub fn next(&mut self, status: &Status) -> Result<Option<NextMove>, Error> {
        self.judge();
        let Some(to_deg) = self.targets.get(self.begun).copied() else { return Ok(None) };
        if status.state != StateCode::Armed {
            return Ok(None);
        }
        let from_deg = self.begun.checked_sub(1).and_then(|last| self.targets.get(last));
        let way_deg = to_deg - from_deg.copied().unwrap_or(0.0);
        let time = Duration::from_secs_f64(time_s(&self.profile, &self.goal, way_deg));
        let motion = Motion::Profiled(position_of(to_deg, self.count_deg)?);
        (self.to_deg, self.begun) = (Some(to_deg), self.begun + 1);
        Ok(Some(NextMove { motion, to_deg, time }))
    }

    fn judge(&mut self) {
        let samples = std::mem::take(&mut self.samples);
        let ahead = std::mem::take(&mut self.load_ahead_deg);
        if let Some(to_deg) = self.to_deg.take() {
            let each = [self.count_deg, self.sample_time_s];
            let wanted = (to_deg, &self.goal);
            self.moves.extend(measures(&samples, &ahead, &self.signals, wanted, each));
        }
    }

    /// The move that was to begin was refused: it was not made, and none comes after it.
    pub fn refused(&mut self, why: String) {
        (self.to_deg, self.refused) = (None, Some(why));
    }

    /// What it has come to, with the status after the last move.
    pub fn ended(mut self, status: Status) -> SelfTestSession {
        self.judge();
        let is_ended = status.state != StateCode::Armed || self.refused.is_some();
        SelfTestSession { moves: self.moves, status, is_ended, refused: self.refused }
    }
}

/// Arms a device where its joint is, and makes the moves, one after the other. `seen` is told how
/// many are done. The device stays armed, unless it ends the session by itself: the caller turns
/// its output off, whatever comes back.
///
/// # Errors
/// Says why the device refuses, or that it does not answer.
pub fn run<W: Wire>(
    client: &mut Client<W>,
    targets: &[f64],
    mut seen: impl FnMut(usize),
) -> Result<SelfTestSession, Error> {
    let goes_on = |made| {
        seen(made);
        true
    };
    let cancelled = || Error::Input("selftest: the moves have ended by themselves".into());
    run_while(client, (targets, &PositionGoal::default()), goes_on)?.ok_or_else(cancelled)
}

/// Does the same, judges the moves by a goal, and checks before each move whether to go on. Returns
/// nothing if not.
///
/// # Errors
/// As [`run`].
pub fn run_while<W: Wire>(
    client: &mut Client<W>,
    (targets, goal): (&[f64], &PositionGoal),
    mut goes_on: impl FnMut(usize) -> bool,
) -> Result<Option<SelfTestSession>, Error> {
    let signals = Signals::new(client.signals()?);
    let parameters = client.parameters()?;
    let status = client.status()?;
    let (steps, waits) = Steps::of(targets, signals, &parameters, &status)?;
    let mut steps = steps.judged_by(*goal);
    if !status.at_rest {
        client.pass(Duration::from_millis(100))?;
    }
    client.arm()?;
    let mut status = client.pass_armed(waits)?;
    client.subscribe(steps.mask(), steps.every())?;
    while let Some(next) = steps.next(&status)? {
        if !goes_on(steps.made()) {
            return Ok(None);
        }
        while client.kept().is_some() {}
        client.move_along(next.motion)?;
        status = client.pass_armed(next.time)?;
        while let Some(sample) = client.kept() {
            steps.see(&sample, client.load_ahead_deg(sample.clock));
        }
    }
    // All are made: nobody can cancel them any more.
    goes_on(steps.made());
    client.subscribe(0, 0)?;
    Ok(Some(steps.ended(status)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction::signal::index;

    /// The prediction has a sample every 10 ms. A studio that shows every tick has more.
    #[test]
    fn of_samples_that_come_more_often_than_is_needed_so_many_are_kept() {
        let sample = |clock: u32, state: u32| Sample {
            number: 0,
            clock,
            signals: 1 << index("status"),
            values: state.to_le_bytes().into_iter().collect(),
        };
        let profile = ProfileLimits { velocity: 10.0, acceleration: 20.0, jerk: 400.0 };
        let mut steps = Steps {
            targets: vec![],
            signals: Signals::of_core(),
            profile,
            count_deg: 0.01,
            sample_time_s: 0.001,
            to_deg: None,
            samples: vec![],
            load_ahead_deg: vec![],
            goal: PositionGoal::default(),
            moves: vec![],
            begun: 0,
            refused: None,
        };
        assert_eq!(steps.every(), 10);
        (0..5).for_each(|clock| steps.see(&sample(clock, 1), None));
        (5..105).for_each(|clock| steps.see(&sample(clock, 2), None));
        let clocks: Vec<u32> = steps.samples.iter().map(|sample| sample.clock).collect();
        assert_eq!(clocks, (0..10).map(|k| 5 + 10 * k).collect::<Vec<_>>());
    }
}
