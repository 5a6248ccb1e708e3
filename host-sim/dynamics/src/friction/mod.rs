//! Friction of a joint: a limit at rest, a level in motion.
//!
//! [`SetValued`] friction has no value of its own at zero velocity: it is whatever keeps the body
//! at rest, within the limit. The mechanism and the solver find it there. The friction lab of the
//! thesis has more models.

mod coulomb;

pub use coulomb::{AddedFriction, Coulomb};

/// Friction that holds a body at rest up to a limit.
pub trait SetValued {
    /// Largest friction at rest F_s.
    fn stick(&self) -> f64;

    /// Friction in motion at a `speed` >= 0. At zero it is the limit from above, and not above
    /// [`Self::stick`].
    fn slip(&self, speed: f64) -> f64;
}
