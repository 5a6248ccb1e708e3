//! What a joint is to do in one run, in a person's units.
//!
//! ```text
//! [reference], [identification] -> Task -> stiction::Motion -> stiction::Course
//! what a file asks, all runs       one     in counts, f32      what a tick follows
//! ```

use crate::machine::TrajectoryTable;

/// What a joint is to do in one run: the set points of a closed loop, or the effort of an open one.
#[derive(Clone, Debug, PartialEq)]
pub enum Task {
    /// A jump by so many degrees.
    Step(f64),
    /// A motion through corners.
    Trajectory(TrajectoryTable),
    /// An effort that rises until the joint moves and falls until it rests, V/s.
    Ramp(f64),
}

impl Task {
    /// `step-5.0`, `trajectory-2.5` (its speed in deg/s), `rate-0.001`.
    pub fn slug(&self) -> String {
        match self {
            Self::Step(step) => format!("step-{}", short(*step)),
            Self::Trajectory(trajectory) => format!("trajectory-{}", short(trajectory.speed())),
            Self::Ramp(rate) => format!("rate-{rate}"),
        }
    }

    /// How far a step or a trajectory leads away from where the joint starts (zero), deg.
    pub fn span_deg(&self) -> f64 {
        match self {
            Self::Step(step) => step.abs(),
            Self::Ramp(_) => 0.0,
            Self::Trajectory(trajectory) => {
                let positions = trajectory.corner_positions_deg.iter();
                positions.map(|deg| deg.abs()).fold(0.0, f64::max)
            }
        }
    }
}

/// At least one digit behind the point, at most three; what would vanish like that is written with
/// its exponent.
fn short(number: f64) -> String {
    if number != 0.0 && number.abs() < 5e-4 {
        return format!("{number:e}");
    }
    let text = format!("{number:.3}");
    let text = text.trim_end_matches('0');
    if text.ends_with('.') { format!("{text}0") } else { text.into() }
}
