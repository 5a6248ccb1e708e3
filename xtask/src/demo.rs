//! `cargo xtask demo`: what the project does, in a few minutes.

use std::path::Path;

use crate::firmware;
use crate::job::Job;
use crate::simulator::Simulator;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Only the simulator, without the firmware on the emulated part: faster to build
    #[arg(long)]
    host: bool,
}

/// Where the figures go.
const FIGURES: &str = "target/demo";

/// The experiments that the benchmark does not run.
const MORE: [&str; 5] =
    ["step-added-friction", "srnf-robustness", "srnf-added-friction", "high-gain", "friction-identification"];

/// Leaves out the reading of the gain in SI, which is a variant of this experiment.
const AS_WE_READ_IT: [&str; 2] = ["--set", "joint.gain_deg_per_s2_per_v=27"];

/// One move of one controller, to read its log.
const ONE_MOVE: [&str; 6] =
    ["--controller", "srnf", "--set", "reference.steps_deg=[5.0]", "--set", "run.duration_s=1"];

pub fn demo(arguments: &Arguments) -> Result<(), String> {
    let simulator = if arguments.host { Simulator::Host } else { Simulator::Emulator };
    let image = if arguments.host { None } else { Some(firmware::build()?) };
    simulator.build()?;
    if let Some(image) = image {
        in_the_image(simulator, &image)?;
    }
    Job::new("Seven controllers on the thesis's robot axis, simulated: three steps, two trajectories")
        .run(&mut simulator.command(&["benchmark", "--plot", FIGURES]))?;
    let drawing = Job::new("Drawing the other experiments of Chapter 3 and Appendix A.2");
    drawing.announce();
    for experiment in MORE {
        drawing.run_silently(&mut simulator.command(&["run", experiment, "--plot", FIGURES]))?;
    }
    println!("\nA figure for each result, as SVG and PNG: {FIGURES}");
    println!("The numbers behind them: `cargo sim list`, then `cargo sim run NAME`.");
    Ok(())
}

/// The flash image against the joint. A run in which it does anything else than the core on this machine fails.
fn in_the_image(simulator: Simulator, image: &Path) -> Result<(), String> {
    let run = || {
        let mut run = simulator.command(&["run", "step-response", "--target", "emulator", "--image"]);
        run.arg(image).args(AS_WE_READ_IT);
        run
    };
    Job::new(
        "The firmware boots on an emulated microcontroller and moves the simulated joint by 5 degrees; its log:",
    )
    .run(run().args(ONE_MOVE).arg("--log"))?;
    Job::new("The thesis's controllers in that image, bit for bit what the core does on this machine")
        .run(&mut run())?;
    println!("   (the emulated part counts instructions, not cycles; nothing here has run on hardware)");
    Ok(())
}
