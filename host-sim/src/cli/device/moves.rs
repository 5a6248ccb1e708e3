//! `stiction device move`.

use std::path::PathBuf;
use std::time::Duration;

use stiction::link::StateCode;

use super::{arm, ended, lost, off, then_off, time};
use crate::device::client::Client;
use crate::device::log::Log;
use crate::device::moved::Moved;
use crate::device::signals::Signals;
use crate::device::wire::Wire;
use crate::device::words;
use crate::error::Error;
use crate::output::write_whole;

/// Time of a step, s.
const STEP_S: f64 = 5.0;
/// Time that a joint has after its set point rests, s: a second of an integral, and its settling.
const SETTLES_S: f64 = 2.0;

/// Time in which a sample comes.
const FIRST_SAMPLE: Duration = Duration::from_millis(200);

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// In the zero that arming sets, deg
    #[arg(allow_negative_numbers = true)]
    deg: f64,
    /// Step to the position at once, without the limits of [profile]
    #[arg(long)]
    step: bool,
    /// How long the loop stays closed, s; then the output goes off [default: the longest time of
    /// the move and 2 s; of a step 5 s]
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    r#for: Option<f64>,
    /// Write a sample of every tick to this file
    #[arg(long, value_name = "FILE.csv")]
    log: Option<PathBuf>,
    /// Tell the end of the move as JSON
    #[arg(long)]
    json: bool,
}

/// What is said at the end, and whether the move was ended before.
pub struct Said {
    pub text: String,
    pub ended: Result<(), Error>,
    /// Whether the text stands alone, without a warning before it.
    pub alone: bool,
}

/// Arms the device if it is not armed, moves, and turns the output off.
///
/// # Errors
/// Says why the move was not made, and how the drive is left.
pub fn go<W: Wire>(arguments: &Arguments, client: &mut Client<W>) -> Result<Said, Error> {
    let Arguments { deg, step, r#for, log, json } = arguments;
    let given = r#for.map(|seconds| time("--for", seconds)).transpose()?;
    // The position is checked first, so that nothing is armed for a number that is none.
    let motion = if *step { client.step(*deg)? } else { client.profiled(*deg)? };
    let signals = Signals::new(client.signals()?);
    let mut samples = Log::new(signals.clone(), &[])?;
    let before = client.status()?;
    let mut moved = Moved::to(*deg, before.resolution.into(), before.sample_time.into());
    let status = then_off(client, |client| {
        let was_armed = client.status()?.state == StateCode::Armed;
        if !was_armed {
            arm(client)?;
        }
        let (mask, every) =
            if log.is_some() { (samples.mask(), 1) } else { moved.subscription(&signals) };
        client.subscribe(mask, every)?;
        let time = match given {
            Some(time) => time,
            None if *step => Duration::from_secs_f64(STEP_S),
            None => {
                // A joint that was armed before may be anywhere.
                let first = if was_armed { client.sample(FIRST_SAMPLE)? } else { None };
                let from = first.map_or(0.0, |sample| signals.number(&sample, "counts"));
                let way = deg - from * f64::from(before.resolution);
                Duration::from_secs_f64((client.longest_s(way)? + SETTLES_S).min(86_400.0))
            }
        };
        client.move_along(motion)?;
        let status = client.pass_armed(time)?;
        // The log ends before the output goes off: a tick without the loop has neither zero nor
        // position.
        while let Some(sample) = client.kept() {
            if signals.is_armed(&sample) {
                moved.see(&signals, &sample);
            }
            if log.is_some() {
                samples.push(sample);
            }
        }
        Ok(status)
    })?;
    if let Some(path) = log {
        write_whole(path, &samples.render(status.sample_time, status.resolution)?)?;
    }
    let text = if *json {
        let object = moved.json(status.at_rest, client.warning());
        format!("{object:#}\n")
    } else {
        let rest =
            if status.at_rest { "" } else { "the joint still moved when the time was over\n" };
        words::status(&status) + &moved.to_string() + rest + off(&status) + &lost(client)
    };
    Ok(Said { text, ended: ended("move", &status), alone: *json })
}
