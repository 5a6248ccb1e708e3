//! Why a solver gave up. It always does within bounded work, and says when and where.

/// A run that could not be brought to its end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what} at {time_s:.9} s, in the state {state}")]
pub struct SolverFailure {
    /// What went wrong, in words.
    pub what: String,
    /// When, s.
    pub time_s: f64,
    /// Coordinates and velocities there.
    pub state: String,
}

impl SolverFailure {
    /// `what` happened at a time and in a state.
    pub fn new<const N: usize>(
        what: impl Into<String>,
        time_s: f64,
        q: &[f64; N],
        v: &[f64; N],
    ) -> Self {
        Self { what: what.into(), time_s, state: format!("q = {q:?}, v = {v:?}") }
    }
}
