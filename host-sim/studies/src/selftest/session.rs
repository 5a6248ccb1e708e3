//! A session of moves over the link: any device, real, emulated or simulated.
//!
//! [`Steps`] returns the next move and evaluates the samples; it does not talk to a device. [`run`]
//! arms, moves and waits for the command line. The studio does so itself, since it serves its pages
//! meanwhile and can cancel before each request.

use std::time::Duration;

use stiction::link::{Sample, StateCode, Status};
use stiction::{Motion, Parameters, ProfileLimits};

use super::measures::{MoveMeasures, SIGNALS, measures};
use files::error::Error;
use files::goal::PositionGoal;
use simulator::device::client::{Client, position_of};
use simulator::device::moved::longest_s;
use simulator::device::signals::Signals;
use simulator::device::wire::Wire;

/// Least time between two samples, s.
const LOOKED_AT_S: f64 = 0.01;

/// Time of a move after its set point rests, s: 1 s for an integral to settle, and 1 s in which
/// rest is judged.
const SETTLES_S: f64 = 2.0;

/// Longest time of a move, s. A range with a longer move is refused before anything moves.
pub(super) const LONGEST_S: f64 = 60.0;

/// Returns the time of a move over `way_deg`, s: the motion of its set point, plus the time to
/// settle.
pub(super) fn time_s(profile: &ProfileLimits, goal: &PositionGoal, way_deg: f64) -> f64 {
    longest_s(profile, way_deg) + goal.watched_s(SETTLES_S)
}

/// Result of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfTestSession {
    /// Measures of the completed moves.
    pub moves: Vec<MoveMeasures>,
    /// Status after the last move.
    pub status: Status,
    /// Whether a fault or a stop ended the session.
    pub is_ended: bool,
    /// Reason of a refused move.
    pub refused: Option<String>,
}

/// The next move of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct NextMove {
    /// Motion for the device.
    pub motion: Motion,
    /// Target, deg.
    pub to_deg: f64,
    /// Time of the move. It ends earlier if the device is no longer armed.
    pub time: Duration,
}

/// A session, move by move.
#[derive(Clone, Debug)]
pub struct Steps {
    targets: Vec<f64>,
    signals: Signals,
    profile: ProfileLimits,
    count_deg: f64,
    sample_time_s: f64,
    /// Target of the running move, deg.
    to_deg: Option<f64>,
    samples: Vec<Sample>,
    /// Load's angle minus that of the encoder's side in each sample, deg.
    load_ahead_deg: Vec<Option<f64>>,
    goal: PositionGoal,
    moves: Vec<MoveMeasures>,
    begun: usize,
    refused: Option<String>,
}

impl Steps {
    /// Creates the session of a device with these signals, parameters and status. Also returns the
    /// time from arming to the first move: reset pulse, wake-up and soft start, plus 2 s.
    ///
    /// # Errors
    /// Returns an error if a target is out of range.
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

    /// Sets the goal by which the moves are judged.
    #[must_use]
    pub fn judged_by(self, goal: PositionGoal) -> Self {
        Self { goal, ..self }
    }

    /// Returns the mask of the needed signals.
    pub fn mask(&self) -> u64 {
        self.signals.mask(SIGNALS)
    }

    /// Returns the number of ticks between two samples.
    pub fn every(&self) -> u16 {
        (LOOKED_AT_S / self.sample_time_s).clamp(1.0, 1000.0).round() as u16
    }

    /// Returns the number of completed moves.
    pub const fn made(&self) -> usize {
        self.moves.len()
    }

    /// Stores a sample. If samples arrive more often than every [`every`](Self::every) ticks, the
    /// others are skipped, as in the prediction. A sample from just before a move does not affect
    /// it, since its set point is at rest.
    ///
    /// `load_ahead_deg` is the load's angle minus that of the encoder's side, deg, if the device
    /// reports it.
    pub fn see(&mut self, sample: &Sample, load_ahead_deg: Option<f64>) {
        let is_due =
            |last: &Sample| sample.clock.wrapping_sub(last.clock) >= u32::from(self.every());
        if self.signals.is_armed(sample) && self.samples.last().is_none_or(is_due) {
            self.samples.push(sample.clone());
            self.load_ahead_deg.push(load_ahead_deg);
        }
    }

    /// Evaluates the completed move, and returns the next one; `None` after the last one, or if the
    /// device is not armed.
    ///
    /// # Errors
    /// Returns an error if a target is out of range, which [`of`](Self::of) has already refused.
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

    /// Ends the session after a refused move.
    pub fn refused(&mut self, why: String) {
        (self.to_deg, self.refused) = (None, Some(why));
    }

    /// Returns the result; `status` is that after the last move.
    pub fn ended(mut self, status: Status) -> SelfTestSession {
        self.judge();
        let is_ended = status.state != StateCode::Armed || self.refused.is_some();
        SelfTestSession { moves: self.moves, status, is_ended, refused: self.refused }
    }
}

/// Arms a device and makes the moves, one after the other. `seen` is called with the number of
/// completed moves. The device stays armed, unless a fault ends the session: the caller must turn
/// its output off in any case.
///
/// # Errors
/// Returns why the device refuses, or that it does not answer.
pub fn run<W: Wire>(
    client: &mut Client<W>,
    targets: &[f64],
    mut seen: impl FnMut(usize),
) -> Result<SelfTestSession, Error> {
    let goes_on = |made| {
        seen(made);
        true
    };
    let cancelled = || Error::Input("selftest: the moves were cancelled".into());
    run_while(client, (targets, &PositionGoal::default()), goes_on)?.ok_or_else(cancelled)
}

/// Makes the moves as [`run`] does, judges them by a goal, and calls `goes_on` before each move. If
/// it returns false, the result is `None`.
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
    client.arm_tested()?;
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
    // All moves are complete and can no longer be cancelled.
    goes_on(steps.made());
    client.subscribe(0, 0)?;
    Ok(Some(steps.ended(status)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction::control::signal::index;

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
