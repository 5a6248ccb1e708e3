//! `stiction`, the command line of the simulator.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::cli::main()
}
