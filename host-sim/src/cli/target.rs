//! Target of a run's control core: this program, or the flash image on an emulated microcontroller.

use std::path::PathBuf;

use super::bar::Bar;
use files::error::Error;
use simulator::experiment::RunPlan;
use simulator::run::{RunDriver, RunResult, run_all_driven};

/// Target of the control core.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum Target {
    /// In this program
    #[default]
    Host,
    /// In this program, in the servo around the loop: with soft start and monitors, as on a device
    Servo,
    /// In the flash image, on an emulated microcontroller
    Emulator,
}

#[derive(Debug, clap::Args)]
pub struct TargetArguments {
    /// Target of the control core
    #[arg(
        long,
        value_name = "host|servo|emulator",
        value_enum,
        hide_possible_values = true,
        default_value = "host"
    )]
    target: Target,
    /// Emulator: edges and PWM at their own times instead of in lockstep with the samples
    #[arg(long)]
    free_running: bool,
    /// Emulator: the flash image [default: the one that cargo xtask firmware builds for the file's
    /// encoders]
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// Emulator: print the firmware's log as it arrives
    #[arg(long)]
    log: bool,
}

impl TargetArguments {
    /// Returns whether the target is `host`, without any option of the emulator.
    pub fn is_host(&self) -> bool {
        self.target == Target::Host && !self.free_running && self.image.is_none() && !self.log
    }

    /// Returns whether the target is the flash image on an emulated board.
    pub fn is_emulator(&self) -> bool {
        self.target == Target::Emulator
    }

    /// Returns the flash image of the option, if any.
    pub const fn image(&self) -> Option<&PathBuf> {
        self.image.as_ref()
    }

    /// Runs all plans on the target.
    pub fn run(&self, plans: &[RunPlan]) -> Result<Vec<RunResult>, Error> {
        match self.target {
            Target::Emulator => self.emulate(plans),
            Target::Host | Target::Servo => {
                let given = [
                    ("--free-running", self.free_running),
                    ("--image", self.image.is_some()),
                    ("--log", self.log),
                ];
                match given.into_iter().find(|(_, given)| *given) {
                    Some((option, _)) => {
                        let why = "without it the core runs in this program";
                        Err(Error::Input(format!("{option} needs --target emulator; {why}")))
                    }
                    None if self.target == Target::Servo => {
                        run_all_driven(plans, RunDriver::ByServo, &Bar::new())
                    }
                    None => run_all_driven(plans, RunDriver::ByLoop, &Bar::new()),
                }
            }
        }
    }

    #[cfg(not(feature = "emulator"))]
    fn emulate(&self, _: &[RunPlan]) -> Result<Vec<RunResult>, Error> {
        Err(not_built("--target emulator"))
    }

    #[cfg(feature = "emulator")]
    fn emulate(&self, plans: &[RunPlan]) -> Result<Vec<RunResult>, Error> {
        use std::io::{Write, stderr};
        use std::sync::Arc;
        use std::sync::atomic::Ordering;

        use emulator::Emulation;

        // If the terminal cannot be written to, there is no other place to report to.
        let say = |text: String| drop(writeln!(stderr(), "{text}"));
        let mut emulation = Emulation::new(self.image.as_deref())?;
        emulation.free_running = self.free_running;
        if self.log {
            let alone = plans.len() == 1;
            emulation.listener = Some(Arc::new(move |label, line| {
                say(if alone { line.to_string() } else { format!("{label}: {line}") });
            }));
        }
        super::interrupt::end_on_ctrl_c(&emulation.interrupt)?;
        let runs = emulation.run_all(plans)?;
        // The rest is quick and does not check the flag: from here on, Ctrl-C ends the program at
        // once.
        emulation.interrupt.store(true, Ordering::Relaxed);
        for run in &runs {
            if let Some(latency) = run.latency {
                let (mean, max) = (latency.mean_us, latency.max_us);
                let label = &run.result.plan.label;
                say(format!(
                    "{label}: from the encoder to the duty {mean:.1} us on average, {max:.1} us \
                     at most"
                ));
            }
        }
        Ok(runs.into_iter().map(|run| run.result).collect())
    }
}

/// Returns the error of an option in a build without the emulator.
#[cfg(not(feature = "emulator"))]
pub fn not_built(option: &str) -> Error {
    files::missing_part::not_built(option, "the emulator is", "emulator")
}
