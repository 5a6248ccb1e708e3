//! Task of a joint in one run, in the units of the file.
//!
//! ```text
//! [reference], [identification] -> Task -> stiction::Motion -> stiction::Course
//! of all runs of a file           of one   in counts, f32      evaluated in each tick
//! ```

use files::machine::{SineTable, TrajectoryTable};

/// Task of a joint in one run: set points of a closed loop, or the effort of an open one.
#[derive(Clone, Debug, PartialEq)]
pub enum Task {
    /// Step of the set point, deg.
    Step(f64),
    /// Motion through corners.
    Trajectory(TrajectoryTable),
    /// Motion to and fro, without an end.
    Sine(SineTable),
    /// Ramp of the effort, V/s: it rises until the joint moves, and falls until it rests.
    Ramp(f64),
}

impl Task {
    /// Returns the slug: `step-5.0`, `trajectory-2.5` (its speed in deg/s), `sine-2.0-0.5` (its
    /// amplitude in deg, its frequency in Hz), `rate-0.001`.
    pub fn slug(&self) -> String {
        match self {
            Self::Step(step) => format!("step-{}", short(*step)),
            Self::Trajectory(trajectory) => format!("trajectory-{}", short(trajectory.speed())),
            Self::Sine(sine) => {
                format!("sine-{}-{}", short(sine.amplitude_deg), short(sine.frequency_hz))
            }
            Self::Ramp(rate) => format!("rate-{rate}"),
        }
    }

    /// Returns the largest distance of the set point from its start (zero), deg.
    pub fn span_deg(&self) -> f64 {
        match self {
            Self::Step(step) => step.abs(),
            Self::Sine(sine) => 2.0 * sine.amplitude_deg.abs(),
            Self::Ramp(_) => 0.0,
            Self::Trajectory(trajectory) => {
                let positions = trajectory.corner_positions_deg.iter();
                positions.map(|deg| deg.abs()).fold(0.0, f64::max)
            }
        }
    }
}

/// Formats a number with one to three decimals, or with an exponent if they would all be zero.
fn short(number: f64) -> String {
    if number != 0.0 && number.abs() < 5e-4 {
        return format!("{number:e}");
    }
    let text = format!("{number:.3}");
    let text = text.trim_end_matches('0');
    if text.ends_with('.') { format!("{text}0") } else { text.into() }
}
