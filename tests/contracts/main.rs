//! The contracts: what every law promises, whatever its gains are and whatever it is fed, as
//! properties of whole ticks. The tests run on the host only, and are blind to everything around
//! the core. No plant answers the effort, so nothing here says that a gain is good or that a joint
//! arrives; counters come from a list, so nothing says that a tick is in time; and no
//! microcontroller computes, so nothing says that its bits are the bits of the host.

// The fixtures of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used)]

mod bounds;
mod equations;
mod fixture;
mod identification;
mod invariance;
mod observer_equation;
mod parameters;
mod reset;
#[cfg(feature = "rivals")]
mod rival_equations;
mod sums;
mod validation;
