//! A session of moves over the link: any device, real, emulated or simulated.

use std::time::Duration;

use stiction::link::{StateCode, Status};
use stiction::{Parameters, ProfileLimits};

use super::measures::{Measures, SIGNALS, measures};
use crate::device::client::Client;
use crate::device::moved::longest_s;
use crate::device::signals::Signals;
use crate::device::wire::Wire;
use crate::error::Error;

/// Least time between two samples, s.
const LOOKED_AT_S: f64 = 0.01;

/// Time that a joint has after its set point rests, s: a second of an integral and its settling,
/// and the second in which rest is judged.
const SETTLES_S: f64 = 2.0;

/// A move that takes longer than this, s, is none of a self-test: its range is refused before
/// anything moves.
pub(super) const LONGEST_S: f64 = 60.0;

/// The time that a move over so many degrees has, s: that of its set point, and to settle.
pub(super) fn time_s(profile: &ProfileLimits, way_deg: f64) -> f64 {
    longest_s(profile, way_deg) + SETTLES_S
}

/// What a session has come to.
#[derive(Clone, Debug, PartialEq)]
pub struct Session {
    /// The moves that were made.
    pub moves: Vec<Measures>,
    /// The status after the last of them.
    pub status: Status,
    /// Whether the device ended it: a fault, or a stop.
    pub is_ended: bool,
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
) -> Result<Session, Error> {
    let signals = Signals::new(client.signals()?);
    let Parameters { profile, device, .. } = client.parameters()?;
    if !client.status()?.at_rest {
        client.pass(Duration::from_millis(100))?;
    }
    client.arm()?;
    // The soft start is no part of the first move.
    let waits = [device.reset_pulse, device.wake_up, device.soft_start].map(f64::from);
    let waits_s = waits.iter().sum::<f64>() + SETTLES_S;
    let mut status = client.pass_armed(Duration::from_secs_f64(waits_s))?;
    let [count_deg, sample_time_s] = [status.resolution, status.sample_time].map(f64::from);
    let every = (LOOKED_AT_S / sample_time_s).clamp(1.0, 1000.0).round() as u16;
    client.subscribe(signals.mask(SIGNALS), every)?;
    let (mut moves, mut at_deg) = (Vec::new(), 0.0);
    for to_deg in targets {
        if status.state != StateCode::Armed {
            break;
        }
        let motion = client.profiled(*to_deg)?;
        let time_s = time_s(&profile, to_deg - at_deg);
        while client.kept().is_some() {}
        client.move_along(motion)?;
        status = client.pass_armed(Duration::from_secs_f64(time_s))?;
        let mut samples = Vec::new();
        while let Some(sample) = client.kept() {
            if signals.is_armed(&sample) {
                samples.push(sample);
            }
        }
        moves.extend(measures(&samples, &signals, *to_deg, [count_deg, sample_time_s]));
        at_deg = *to_deg;
        seen(moves.len());
    }
    client.subscribe(0, 0)?;
    let is_ended = status.state != StateCode::Armed;
    Ok(Session { moves, status, is_ended })
}
