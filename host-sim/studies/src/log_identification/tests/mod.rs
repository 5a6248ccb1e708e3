//! Logs of machines that are known, made by a solver that the simulator does not have; and the
//! parts of the way, against closed forms.
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

mod filters;
mod gears;
mod grids;
mod machine;
mod machines;
mod regressions;
