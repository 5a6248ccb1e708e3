//! `stiction device selftest`.

use indicatif::{ProgressBar, ProgressStyle};

use super::{OFF, end_on_ctrl_c, then_off};
use crate::cli::warn;
use files::error::Error;
use files::typed_number;
use simulator::device::client::Client;
use simulator::device::wire::Wire;
use studies::selftest::{JOINTS, MOVES, SEED, SelfTestRequest, object, run_while, words};

#[derive(Debug, clap::Args)]
pub struct SelftestArguments {
    /// Largest distance either way from the present position, deg [default: the distance of a
    /// profiled move of a second, at most 10 deg, within the limits of the position]
    #[arg(long, value_name = "DEG", value_parser = typed_number::parse)]
    range: Option<f64>,
    /// Number of moves
    #[arg(
        long,
        default_value_t = MOVES as u16,
        value_parser = clap::value_parser!(u16).range(2..=200)
    )]
    moves: u16,
    /// Number of simulated joints around the file's that make the prediction
    #[arg(long, default_value_t = JOINTS, value_parser = clap::value_parser!(u64).range(3..=1000))]
    joints: u64,
    /// Seed of these joints
    #[arg(long, default_value_t = SEED)]
    seed: u64,
    /// Range of a key of the joint, instead of the file's [spread]; can be repeated
    #[arg(long, value_name = "KEY=LOW..HIGH")]
    spread: Vec<String>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Text of the result, and an error unless the joint moves as its file predicts.
pub struct SelftestReport {
    pub text: String,
    pub ended: Result<(), Error>,
}

/// Predicts the moves, makes them, and compares the two.
///
/// # Errors
/// Reports why nothing was moved, or the state of the drive.
pub fn test<W: Wire>(
    arguments: &SelftestArguments,
    client: &mut Client<W>,
    machine: &str,
) -> Result<SelftestReport, Error> {
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
    // `goes_on` never cancels the moves.
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
            "selftest: ended by {by}; the motor is off (docs/reference/faults.md)"
        ))),
        None if tested.passes() => Ok(()),
        None => Err(Error::Device(format!(
            "selftest: the joint does not move as {machine} predicts: {} \
             (docs/tutorial/commission-a-joint.md)",
            tested.failed().join("; ")
        ))),
    };
    Ok(SelftestReport { text, ended })
}
