//! The command line with the emulator built in.
#![allow(clippy::unwrap_used, clippy::panic)]

#[cfg(feature = "emulator")]
mod command_line;

/// Stands for all tests of the emulator in a build without it, so that they are not left out in
/// silence.
#[cfg(not(feature = "emulator"))]
#[test]
#[ignore = "the flash image in the loop: cargo xtask test"]
fn the_command_line_with_the_emulator() {
    panic!("built without the emulator: run `cargo xtask test`");
}
