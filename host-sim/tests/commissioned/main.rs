//! Commissioning of a drive: gains are tuned and the joint is tested, on a simulated device and on
//! the flash image. The other tests of the loop (`tests/`) do not use the crate `studies`.
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../joints_under_test/gearmotor.rs"]
mod gearmotor;
#[cfg(feature = "emulator")]
mod identified_families;
mod rest;
mod selftest;
#[cfg(feature = "emulator")]
mod selftest_in_the_image;
mod tuned;
mod walk;

/// Stands for those of the image in a build without the emulator, so that they are not left out in
/// silence.
#[cfg(not(feature = "emulator"))]
#[test]
#[ignore = "the flash image in the loop: cargo xtask test"]
fn the_flash_image_is_commissioned() {
    panic!("built without the emulator: run `cargo xtask test`");
}
