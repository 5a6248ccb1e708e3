//! What somebody does who commissions a drive: gains are tuned, the joint is tested, on a simulated
//! device and on the flash image. The other tests of the loop (`tests/`) do without the studies of
//! this crate.
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

#[cfg(feature = "emulator")]
mod identified_families;
mod selftest;
#[cfg(feature = "emulator")]
mod selftest_in_the_image;
mod tuned;
