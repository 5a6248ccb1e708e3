//! `cargo xtask demo` shows what the project does, in a few minutes.

use std::path::Path;

use crate::firmware::{self, Image};
use crate::job::{Job, JobTimes};
use crate::simulator::Simulator;
use crate::toolchain::{MICROCONTROLLER, Toolchain};

#[derive(Debug, clap::Args)]
pub struct DemoJobArguments {
    /// Only the simulator, without the firmware on the emulated microcontroller: faster to build
    #[arg(long)]
    host: bool,
}

/// The directory of the figures.
const FIGURES: &str = "target/demo";

/// The experiments that the benchmark does not run.
const MORE: [&str; 5] = [
    "step-added-friction",
    "srnf-robustness",
    "srnf-added-friction",
    "high-gain",
    "friction-identification",
];

/// Joints under untuned laws.
const UNTUNED: &str = "untuned-joints";

/// Leaves out the reading of the gain in SI, which is a variant of this experiment.
const AS_WE_READ_IT: [&str; 2] = ["--set", "joint.gain_deg_per_s2_per_v=27"];

/// One move of one controller, to read its log.
const ONE_MOVE: [&str; 6] =
    ["--controller", "srnf", "--set", "reference.steps_deg=[5.0]", "--set", "run.duration_s=1"];

pub fn demo(arguments: &DemoJobArguments) -> Result<(), String> {
    let with_image = !arguments.host
        && (Toolchain::agreed(&MICROCONTROLLER)
            .map_err(|why| format!("{why}\n`cargo xtask demo --host` needs no such compiler"))?
            || without_image());
    let mut times = JobTimes::new();
    // The fastest build comes first. The build with the emulator extends it.
    times.of("building the simulator", || Simulator::Host.build())?;
    times.of("ranking seven controllers, and drawing", || {
        Job::new(
            "Seven controllers on the thesis's robot axis, simulated: three steps, two \
                  trajectories",
        )
        .run(&mut Simulator::Host.command(&["benchmark", "--plot", FIGURES]))
    })?;
    times.of("the other experiments, and drawing", || {
        let drawing = Job::new("Drawing the other experiments of Chapter 3 and Appendix A.2");
        drawing.announce();
        MORE.iter().try_for_each(|experiment| {
            drawing
                .run_silently(&mut Simulator::Host.command(&["run", experiment, "--plot", FIGURES]))
        })
    })?;
    times.of("three untuned joints, and drawing", || {
        Job::new("PD, SRNF and the law `robust` on three untuned joints, simulated")
            .run(&mut Simulator::Host.command(&["run", UNTUNED, "--plot", FIGURES]))
    })?;
    if with_image {
        let image = times.of("the compiler for the microcontroller, and the firmware", || {
            firmware::build(Image::OneEncoder)
        })?;
        times.of("building the simulator with the emulator", || Simulator::Emulator.build())?;
        times.of("running the image", || in_the_image(&image))?;
    }
    println!("\nA figure for each result, as SVG and PNG: {FIGURES}");
    println!("The one to look at first: {FIGURES}/{UNTUNED}-compared.png");
    println!("The numbers behind them: `stiction list`, then `stiction run NAME`.");
    times.print();
    Ok(())
}

/// Returns the remark that the rest of the demo is that of `--host`.
fn without_image() -> bool {
    println!("   nothing is installed; the demo leaves the microcontroller out, as with --host");
    false
}

/// Runs the flash image against the joint. Any difference between the image and the core on this
/// machine is an error.
fn in_the_image(image: &Path) -> Result<(), String> {
    let of = |experiment: &str| {
        let mut run =
            Simulator::Emulator.command(&["run", experiment, "--target", "emulator", "--image"]);
        run.arg(image);
        run
    };
    let run = || {
        let mut run = of("step-response");
        run.args(AS_WE_READ_IT);
        run
    };
    Job::new(
        "The firmware boots on an emulated microcontroller and moves the simulated joint by 5 \
         degrees; its log:",
    )
    .run(run().args(ONE_MOVE).arg("--log"))?;
    Job::new(
        "The thesis's controllers in that image, bit for bit what the core does on this machine",
    )
    .run(&mut run())?;
    Job::new("The three untuned joints under `robust` in that image, bit for bit")
        .run(of(UNTUNED).args(["--controller", "robust"]))?;
    println!(
        "   (the emulated part counts instructions, not cycles; nothing here has run on hardware)"
    );
    Ok(())
}
