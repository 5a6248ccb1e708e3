//! Friction models.

mod coulomb;

pub use coulomb::{AddedFriction, Coulomb};
