//! `stiction device selftest`.

use indicatif::{ProgressBar, ProgressStyle};

use super::{OFF, end_on_ctrl_c, then_off};
use crate::cli::warn;
use crate::device::client::Client;
use crate::device::wire::Wire;
use crate::error::Error;
use crate::selftest::{JOINTS, MOVES, SEED, SelfTestRequest, object, run_while, words};
use crate::typed_number;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Largest distance either way from where the joint stands, deg [default: as far as a profiled
    /// move goes in a second, no more than 10 deg, within the limits of the position]
    #[arg(long, value_name = "DEG", value_parser = typed_number::parse)]
    range: Option<f64>,
    /// Moves
    #[arg(
        long,
        default_value_t = MOVES as u16,
        value_parser = clap::value_parser!(u16).range(2..=200)
    )]
    moves: u16,
    /// Simulated joints around the file's that make the prediction
    #[arg(long, default_value_t = JOINTS, value_parser = clap::value_parser!(u64).range(3..=1000))]
    joints: u64,
    /// Their seed
    #[arg(long, default_value_t = SEED)]
    seed: u64,
    /// A key of the joint and how far it may be off, instead of the file's [spread]; may be
    /// repeated
    #[arg(long, value_name = "KEY=LOW..HIGH")]
    spread: Vec<String>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What is said in the end, and whether the joint does what its file says.
pub struct Said {
    pub text: String,
    pub ended: Result<(), Error>,
}

/// Predicts, moves, and compares.
///
/// # Errors
/// Says why nothing was moved, or how the drive is left.
pub fn test<W: Wire>(
    arguments: &Arguments,
    client: &mut Client<W>,
    machine: &str,
) -> Result<Said, Error> {
    let asked = SelfTestRequest {
        machine: machine.into(),
        range_deg: arguments.range,
        moves: arguments.moves.into(),
        joints: arguments.joints,
        seed: arguments.seed,
        spreads: arguments.spread.clone(),
    };
    let prepared = asked.prepare(client)?;
    warn(prepared.doubts());
    let targets = &prepared.request.targets;
    let bar = ProgressBar::new(targets.len() as u64);
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} moves, {eta} left");
    let bar = style.map_or_else(|_| ProgressBar::hidden(), |style| bar.with_style(style));
    end_on_ctrl_c(client)?;
    let session = then_off(client, |client| {
        let goes_on = |done| {
            bar.set_position(done as u64);
            true
        };
        run_while(client, (targets, &prepared.goal()), goes_on)
    });
    bar.finish_and_clear();
    // Nothing cancels it.
    let ended = || Error::Device("selftest: the moves have ended before".into());
    let session = session?.ok_or_else(ended)?;
    let tested = prepared.judged(session);
    let warning = client.warning();
    let text = if arguments.json {
        format!("{:#}\n", object(&tested, warning))
    } else {
        let warning = warning.map_or(String::new(), |warning| format!("{warning}\n"));
        warning + &words(&tested) + OFF
    };
    let ended = match &tested.ended_by {
        Some(by) => Err(Error::Device(format!(
            "selftest: ended by {by}; the motor is off (docs/faults.md)"
        ))),
        None if tested.passes() => Ok(()),
        None => Err(Error::Device(format!(
            "selftest: the joint does not do what {machine} says: {} (docs/commissioning.md)",
            tested.failed().join("; ")
        ))),
    };
    Ok(Said { text, ended })
}
