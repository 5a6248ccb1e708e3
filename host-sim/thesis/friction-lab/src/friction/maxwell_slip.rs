//! Generalized Maxwell-slip friction (Al-Bender, Lampaert and Swevers, IEEE Trans. Automatic
//! Control 50(11), 2005): N springs side by side, each with a share of the load at which it slides.
//!
//! ```text
//! F_f = sum F_i + sigma2 V,    sum a_i = 1
//! F_i' = k_i V                             while F_i sgn(V) < a_i g(|V|)      (the element sticks)
//!      = C (a_i sgn(V) - F_i / g(|V|))     else                               (it slips)
//! ```
//!
//! Guarantees: hysteresis with the memory of every reversal, without drift; the virgin curve from
//! rest is `sum min(k_i x, a_i F_s)` as long as the motion is slow against v_s.
//!
//! Does badly: an element that slips while the body slows down, and g rises, is taken as sticking
//! as soon as it is below its share; the paper lets it slip until the velocity changes sign. That
//! memory would be a state that jumps. Springs without dampers ring on below the first element's
//! limit. The rates jump where an element begins to slip: fixed Runge-Kutta steps are of order one
//! there.

use super::{Implicit, SingleValued, Stribeck, impedance};
use dynamics::friction::Coulomb;

/// N elements. The states are their deflections `F_i / k_i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaxwellSlip<const N: usize> {
    /// k_i, N/m or N m/rad.
    pub stiffness: [f64; N],
    /// Shares a_i of the elements in the friction; their sum is one.
    pub share: [f64; N],
    /// C, N/s or N m/s: how fast a slipping element follows the curve.
    pub attraction: f64,
    /// Friction in steady motion: g and sigma2.
    pub sliding: Stribeck,
}

impl<const N: usize> MaxwellSlip<N> {
    /// Equal shares, of which the elements reach F_s at deflections evenly up to `range`: at
    /// `range` all slip. A slipping element follows with the time constant of the Reset
    /// Integrator's spring, 1/omega.
    pub fn by_rules(levels: Coulomb, range: f64, mass: f64) -> Self {
        let share = 1.0 / N as f64;
        let stiffness =
            std::array::from_fn(|i| share * levels.stick * N as f64 / (range * (i + 1) as f64));
        let omega = impedance(levels.stick / range, mass) / mass;
        let sliding = Stribeck::by_rules(levels, range, mass);
        Self { stiffness, share: [share; N], attraction: levels.stick * omega, sliding }
    }
}

impl<const N: usize> SingleValued<N> for MaxwellSlip<N> {
    #[inline]
    fn force(&self, _: u8, v: f64, z: &[f64; N]) -> f64 {
        self.stiffness.iter().zip(z).map(|(k, z)| k * z).sum::<f64>() + self.sliding.viscous * v
    }

    #[inline]
    fn rate(&self, _: u8, v: f64, z: &[f64; N]) -> [f64; N] {
        let level = self.sliding.level(v.abs());
        std::array::from_fn(|i| {
            let force = self.stiffness[i] * z[i];
            if force * v.signum() < self.share[i] * level {
                v
            } else if v == 0.0 {
                0.0
            } else {
                self.attraction * (self.share[i].copysign(v) - force / level) / self.stiffness[i]
            }
        })
    }

    /// Every element does.
    fn slips(&self, _: u8, v: f64, z: &[f64; N]) -> bool {
        let level = self.sliding.level(v.abs());
        // An element on its share is an ulp to either side of it.
        (0..N).all(|i| self.stiffness[i] * z[i] * v.signum() > 0.999 * self.share[i] * level)
    }

    fn state_scale(&self) -> [f64; N] {
        std::array::from_fn(|i| self.share[i] * self.sliding.levels.stick / self.stiffness[i])
    }
}

/// g is taken at the begin of the step. An element above its share, as g has fallen, comes down by
/// an implicit step of the law above.
impl<const N: usize> Implicit<N> for MaxwellSlip<N> {
    fn friction(&self, h: f64, v: f64, z: &[f64; N], v_end: f64) -> (f64, f64) {
        let viscous = self.sliding.viscous;
        let end = self.states(h, v, z, v_end);
        let mut sum = (viscous * v_end, viscous);
        for i in 0..N {
            sum.0 += self.stiffness[i] * end[i];
            if end[i] == z[i] + h * v_end {
                sum.1 += self.stiffness[i] * h;
            }
        }
        sum
    }

    fn largest(&self) -> f64 {
        self.sliding.levels.stick
    }

    fn states(&self, h: f64, v: f64, z: &[f64; N], v_end: f64) -> [f64; N] {
        let level = self.sliding.level(v.abs());
        let follow = h * self.attraction;
        std::array::from_fn(|i| {
            let (k, share) = (self.stiffness[i], self.share[i]);
            let limit = share * level / k;
            let (mut low, mut high) = (-limit, limit);
            let nearer = (z[i].abs() + follow * share / k) / (1.0 + follow / level);
            if z[i] > limit {
                high = nearer;
            } else if z[i] < -limit {
                low = -nearer;
            }
            (z[i] + h * v_end).max(low).min(high)
        })
    }
}
