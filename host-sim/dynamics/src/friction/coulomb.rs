//! Stick-slip friction with two levels: the classical model (thesis Fig. 1a), which Karnopp's model
//! makes computable.
//!
//! ```text
//! V = 0:   F_f = F_i              |F_i| <= F_s      (stuck)
//!          F_f = F_s sgn(F_i)     |F_i| >  F_s      (about to break away)
//! V != 0:  F_f = F_d sgn(V)                         (slipping)
//! ```
//!
//! Thesis eq. 1, whose third row prints `F_s sgn(V)`: at the velocity of this row, the sign of V is
//! meaningless, and the friction opposes the applied force. Units are those of the mechanism (volts
//! for the robot axis).

/// The two levels of stick-slip friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    /// Largest friction at rest F_s; not below `slip`.
    pub stick: f64,
    /// Friction in motion F_d.
    pub slip: f64,
}

impl Coulomb {
    /// Returns both levels raised by `amount`.
    pub fn raised(self, amount: f64) -> Self {
        Self { stick: self.stick + amount, slip: self.slip + amount }
    }
}

impl super::SetValued for Coulomb {
    fn stick(&self) -> f64 {
        self.stick
    }

    fn slip(&self, _: f64) -> f64 {
        self.slip
    }
}

/// Friction that is added to a joint, all the time or at times: the wooden wedge of thesis section
/// 3.3.8.2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AddedFriction {
    /// Friction that is added to both levels.
    pub amount: f64,
    /// Windows of time `[from, to)` in which it is added, s; `None`: always.
    pub during_s: Option<Vec<[f64; 2]>>,
}

impl AddedFriction {
    /// Returns the added friction at a time (s).
    #[inline]
    pub fn at(&self, time_s: f64) -> f64 {
        let on = match &self.during_s {
            None => true,
            Some(windows) => windows.iter().any(|[from, to]| (*from..*to).contains(&time_s)),
        };
        if on { self.amount } else { 0.0 }
    }

    /// Returns the time of the first change after `from_s` and before `to_s`, s.
    #[inline]
    pub fn next_change(&self, from_s: f64, to_s: f64) -> Option<f64> {
        let windows = self.during_s.as_ref()?;
        windows.iter().flatten().copied().filter(|t| *t > from_s && *t < to_s).reduce(f64::min)
    }
}
