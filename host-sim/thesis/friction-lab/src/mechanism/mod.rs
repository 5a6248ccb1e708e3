//! Mechanisms of the lab, one a file: each implements
//! [`Mechanism`](dynamics::mechanism::Mechanism).
//!
//! A mechanism of your own is one more file with a `terms` in it, and one line in `thesis::lab` if
//! the command line is to know it.

mod block;
mod drive;
mod pendulum;
mod spring_mass;
mod two_blocks;

pub use block::DrivenBlock;
pub use drive::{Pull, Shape, Wave};
pub use pendulum::Pendulum;
pub use spring_mass::SpringMass;
pub use two_blocks::{CoupledBlocks, IndependentBlocks, TwoBlocks};
