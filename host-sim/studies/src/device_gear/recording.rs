//! Samples of both encoders and of the effort, while a device makes the moves of
//! [`moves`](super::moves).
//!
//! A sample of four signals takes up to 38 bytes on the wire, which carries 92 160 bytes/s. Samples
//! are at least 1 ms apart, so they take two fifths of that. A gap in their numbers shows how many
//! were lost. Every tick is sampled if the sample time is 1 ms or longer; with shorter ones, the
//! effort between two samples is not seen.

use std::time::Duration;

use stiction::Motion;
use stiction::control::signal::name;
use stiction::link::{Sample, StateCode, Status};

use super::moves::GearMove;
use files::error::Error;
use files::written::single;
use simulator::device::client::Client;
use simulator::device::signals::Signals;
use simulator::device::wire::Wire;

/// Signals of a sample.
pub const SIGNALS: [&str; 4] =
    [name("counts"), name("motor_counts"), name("v_applied"), name("status")];

/// Least time between two samples, s.
const LEAST_S: f64 = 0.001;

/// Time after which received samples are collected.
const SHORT: Duration = Duration::from_millis(250);

/// Samples of a device with two encoders.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GearRecording {
    /// Time (s), position of the load (counts), effort (V), and position of the motor (counts).
    pub rows: Vec<[f64; 4]>,
    /// Number of samples that did not arrive.
    pub lost: u64,
}

/// Next step of the moves.
#[derive(Clone, Debug, PartialEq)]
pub enum GearStep {
    /// The present move goes on.
    Wait,
    /// Start this motion.
    Move(Box<Motion>),
    /// All moves are made.
    Done,
}

/// Moves of an armed device, one after the other, with their samples. It sends nothing: the caller
/// starts the motions and passes on status and samples.
#[derive(Clone, Debug)]
pub struct GearRecorder {
    moves: Vec<GearMove>,
    made: usize,
    /// Clock at the start of the present move, ticks; `None` until the next status.
    since: Option<u32>,
    signals: Signals,
    tick_s: f64,
    every: u16,
    samples: Vec<Sample>,
}

impl GearRecorder {
    /// Returns a recorder before the first move of a device with these signals.
    ///
    /// # Errors
    /// Returns an error if the device does not have a signal.
    pub fn new(moves: Vec<GearMove>, signals: Signals, status: &Status) -> Result<Self, Error> {
        SIGNALS.iter().try_for_each(|name| {
            signals.check(name).map_err(|_| {
                Error::Device(format!("the device has no signal `{name}`; flash its firmware anew"))
            })
        })?;
        let tick_s = single(status.sample_time);
        let every = (LEAST_S / tick_s - 1e-6).ceil().max(1.0) as u16;
        Ok(Self { moves, made: 0, since: None, signals, tick_s, every, samples: Vec::new() })
    }

    /// Returns the mask of the signals, and the ticks from one sample to the next.
    pub fn subscription(&self) -> (u64, u16) {
        (self.signals.mask(SIGNALS), self.every)
    }

    /// Returns the number of moves that have started, and the number of all moves.
    pub const fn progress(&self) -> [usize; 2] {
        [self.made, self.moves.len()]
    }

    /// Stores a sample of the armed device. Samples that are closer than required are skipped.
    pub fn see(&mut self, sample: Sample) {
        let since = self.samples.last().map(|last| sample.clock.wrapping_sub(last.clock));
        let is_due = since.is_none_or(|ticks| ticks >= u32::from(self.every));
        if is_due && self.signals.is_armed(&sample) {
            self.samples.push(sample);
        }
    }

    /// Returns the next step. A returned motion counts as started.
    ///
    /// # Errors
    /// Returns an error if the output went off.
    pub fn next(&mut self, status: &Status) -> Result<GearStep, Error> {
        if status.state != StateCode::Armed {
            return Err(Error::Device("the output went off during the moves".into()));
        }
        if status.is_testing {
            return Ok(GearStep::Wait);
        }
        if let Some(present) = self.made.checked_sub(1).and_then(|last| self.moves.get(last)) {
            let since = *self.since.get_or_insert(status.clock);
            if f64::from(status.clock.wrapping_sub(since)) * self.tick_s < present.time_s {
                return Ok(GearStep::Wait);
            }
        }
        let Some(next) = self.moves.get(self.made) else { return Ok(GearStep::Done) };
        (self.made, self.since) = (self.made + 1, None);
        Ok(GearStep::Move(next.motion.clone().into()))
    }

    /// Returns the samples; `lost` did not arrive.
    pub fn ended(&self, lost: u64) -> GearRecording {
        let begin = self.samples.first().map_or(0, |sample| sample.clock);
        let row = |sample: &Sample| {
            let [load, motor, effort, _] = SIGNALS.map(|name| self.signals.number(sample, name));
            [f64::from(sample.clock.wrapping_sub(begin)) * self.tick_s, load, effort, motor]
        };
        GearRecording { rows: self.samples.iter().map(row).collect(), lost }
    }
}

/// Makes the moves with the loop closed, and records them. The caller arms the device before;
/// afterwards it stops the device first, also after an error, and then ends the subscription.
///
/// # Errors
/// Returns an error if the device refuses a move or does not answer, or if the output went off.
pub fn record<W: Wire>(
    client: &mut Client<W>,
    moves: Vec<GearMove>,
) -> Result<GearRecording, Error> {
    let signals = Signals::new(client.signals()?);
    let mut recorder = GearRecorder::new(moves, signals, &client.status()?)?;
    let lost = client.lost();
    let (mask, every) = recorder.subscription();
    client.subscribe(mask, every)?;
    make(client, &mut recorder)?;
    Ok(recorder.ended(client.lost() - lost))
}

fn make<W: Wire>(client: &mut Client<W>, recorder: &mut GearRecorder) -> Result<(), Error> {
    let mut status = client.status()?;
    loop {
        match recorder.next(&status)? {
            GearStep::Done => return Ok(()),
            GearStep::Move(motion) => {
                client.move_along(*motion)?;
                status = client.status()?;
            }
            GearStep::Wait => {
                status = client.pass_armed(SHORT)?;
                while let Some(sample) = client.kept() {
                    recorder.see(sample);
                }
            }
        }
    }
}
