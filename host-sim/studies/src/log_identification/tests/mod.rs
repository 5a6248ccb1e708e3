//! Tests with logs of known machines, from a solver that is independent of the simulator; and tests
//! of the steps of the identification, against closed forms.
// The helpers of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used, clippy::panic)]

mod filters;
mod gears;
mod grids;
mod machine;
mod machines;
mod motor;
mod regressions;
