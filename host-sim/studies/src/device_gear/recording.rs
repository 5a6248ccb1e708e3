//! Samples of both encoders and of the effort, while a device makes the moves of
//! [`moves`](super::moves).
//!
//! A sample of four signals takes up to 38 bytes on the wire, which carries 92 160 bytes/s. Samples
//! are at least 1 ms apart, so they take two fifths of that. A gap in their numbers shows how many
//! were lost. Every tick is sampled if the sample time is 1 ms or longer; with shorter ones, the
//! effort between two samples is not seen.

use std::time::Duration;

use stiction::control::signal::name;
use stiction::link::{Sample, StateCode};

use super::moves::GearMove;
use files::error::Error;
use files::written::single;
use simulator::device::client::Client;
use simulator::device::signals::Signals;
use simulator::device::wire::Wire;

/// Signals of a sample.
const SIGNALS: [&str; 4] =
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

/// Makes the moves with the loop closed, and records them. The caller arms the device before and
/// stops it afterwards.
///
/// # Errors
/// Returns an error if the device refuses a move or does not answer, or if the output went off.
pub fn record<W: Wire>(client: &mut Client<W>, moves: &[GearMove]) -> Result<GearRecording, Error> {
    let signals = Signals::new(client.signals()?);
    SIGNALS.iter().try_for_each(|name| {
        signals.check(name).map_err(|_| {
            Error::Device(format!("the device has no signal `{name}`; flash its firmware anew"))
        })
    })?;
    let tick_s = single(client.status()?.sample_time);
    let every = (LEAST_S / tick_s - 1e-6).ceil().max(1.0) as u16;
    let lost = client.lost();
    client.subscribe(signals.mask(SIGNALS), every)?;
    let mut samples: Vec<Sample> = Vec::new();
    for one in moves {
        client.move_along(one.motion.clone())?;
        let begin = client.status()?.clock;
        loop {
            let status = client.pass_armed(SHORT)?;
            while let Some(sample) = client.kept() {
                samples.push(sample);
            }
            if status.state != StateCode::Armed {
                client.subscribe(0, 0)?;
                return Err(Error::Device("the output went off during the moves".into()));
            }
            if f64::from(status.clock.wrapping_sub(begin)) * tick_s >= one.time_s {
                break;
            }
        }
    }
    client.subscribe(0, 0)?;
    let begin = samples.first().map_or(0, |sample| sample.clock);
    let row = |sample: &Sample| {
        let [load, motor, effort, _] = SIGNALS.map(|name| signals.number(sample, name));
        [f64::from(sample.clock.wrapping_sub(begin)) * tick_s, load, effort, motor]
    };
    let rows = samples.iter().filter(|sample| signals.is_armed(sample)).map(row).collect();
    Ok(GearRecording { rows, lost: client.lost() - lost })
}
