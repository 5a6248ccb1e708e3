//! Failure of a solver. The work of a solver is bounded, so it fails instead of running forever.

/// Failure of a run, with time and state.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what} at {time_s:.9} s, in the state {state}")]
pub struct SolverFailure {
    /// Reason, in words.
    pub what: String,
    /// Time, s.
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
