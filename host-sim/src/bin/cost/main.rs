//! Measures the cost of the firmware, and checks its image against the gates. `cargo xtask cost`
//! and `cargo xtask gates` build the images for this program and run it.

mod gates;
mod golden;
mod measure;
mod nesting;
mod table;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use files::Error;

#[derive(Debug, Parser)]
struct Arguments {
    #[command(subcommand)]
    work: Work,
}

#[derive(Debug, Subcommand)]
enum Work {
    /// Measure, and compare with the golden table
    Cost {
        /// The firmware
        #[arg(long)]
        image: PathBuf,
        /// The image of xtask/yardstick
        #[arg(long)]
        yardstick: Option<PathBuf>,
        /// The compiler that built it
        #[arg(long)]
        compiler: String,
        /// The page with the golden table
        #[arg(long)]
        golden: PathBuf,
        /// Write the measured table into the page
        #[arg(long)]
        bless: bool,
    },
    /// Check the firmware for what it must not contain
    Gates {
        /// The firmware
        #[arg(long)]
        image: PathBuf,
    },
}

fn main() -> ExitCode {
    let done = match Arguments::parse().work {
        Work::Cost { image, yardstick, compiler, golden, bless } => {
            cost(&image, yardstick.as_deref(), &compiler, &golden, bless)
        }
        Work::Gates { image } => gates::pass(&image),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("stiction-cost: {error}");
            ExitCode::from(2)
        }
    }
}

fn cost(
    image: &std::path::Path,
    yardstick: Option<&std::path::Path>,
    compiler: &str,
    page: &std::path::Path,
    bless: bool,
) -> Result<(), Error> {
    let measured = measure::measure(image, yardstick)?;
    let text = table::table(&measured, compiler);
    print!("{text}");
    table::within_budgets(&measured)?;
    if bless { golden::bless(page, &text) } else { golden::compare(page, &text) }
}
