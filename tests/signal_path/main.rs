//! The parts that every law stands on: measured velocity, references and the drive's two maps. Each
//! is held against a second way of computing it, in `f64` or in integers.
//!
//! These tests run on the host only, and are blind to the motion itself: positions come from a
//! list. So nothing here says how well a velocity that is measured so serves a loop, or whether a
//! joint can follow a trajectory; nor what a timer makes of a compare value, or that a
//! microcontroller computes the same bits.

use proptest::prelude::ProptestConfig;

mod crystal;
mod drive;
mod option_bytes;
mod output_control;
mod position;
mod profile;
mod receive_ring;
mod reference;
mod reset_cause;
mod trajectory;
mod velocity;

/// Joint angle of one count, deg.
const RESOLUTION: f32 = 0.00242;
/// Time between samples, s.
const SAMPLE_TIME: f32 = 0.02;
/// Half a unit in the last place of an `f32`, relative to it.
const HALF_ULP: f64 = 1.0 / 16_777_216.0;

fn config() -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::default() }
}
