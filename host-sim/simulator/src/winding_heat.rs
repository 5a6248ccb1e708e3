//! Temperature of a motor's winding: two bodies, winding and case, heated by the copper loss.
//!
//! ```text
//! C_w T_w' = i^2 R(T_w) - (T_w - T_c) / R_wc             R(T) = R_20 (1 + 0.00393 (T - 20))
//! C_c T_c' = (T_w - T_c) / R_wc - (T_c - T_a) / R_ca     T in deg C, R_wc and R_ca in K/W
//! ```
//!
//! Data sheets of small motors list R_wc, R_ca and two time constants, from which the capacities
//! follow: `C_w = tau_w / R_wc`, `C_c = tau_m / R_ca`. 0.00393 1/K is the coefficient of annealed
//! copper at 20 deg C (IEC 60028).
//!
//! The equations are solved by the implicit Euler method, which is stable for any values. One
//! update a sample is enough: its error is half a sample over the shorter time constant, and that
//! is 0.1 s or more.
//!
//! Does badly: magnets, iron loss, friction and the heat that a moving case gives off count for
//! nothing; K_t does not fall with the temperature. Between two ends of a held effort the current
//! counts as linear in time.

use files::data_sheet::tables::Motor;

/// Temperature to which the resistance of a file refers, deg C.
pub const REFERENCE_C: f64 = 20.0;
/// Temperature coefficient of copper at [`REFERENCE_C`], 1/K.
pub const COPPER_PER_K: f64 = 0.00393;

/// Heat path from a winding to the ambient air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatPath {
    /// Thermal resistance from winding to case R_wc, K/W.
    pub winding_k_per_w: f64,
    /// Thermal resistance from case to ambient R_ca, K/W.
    pub case_k_per_w: f64,
    /// Time constant of the winding R_wc C_w, s.
    pub winding_s: f64,
    /// Time constant of the case R_ca C_c, s.
    pub case_s: f64,
    /// Temperature of the ambient air, and of the whole motor at the start, deg C.
    pub ambient_c: f64,
}

/// Temperatures of a motor, deg C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Temperatures {
    /// Temperature of the winding.
    pub winding_c: f64,
    /// Temperature of the case.
    pub case_c: f64,
}

impl HeatPath {
    /// Returns the heat path of a checked data sheet's motor; `None` without its keys.
    pub fn of(motor: &Motor) -> Option<Self> {
        Some(Self {
            winding_k_per_w: motor.thermal_resistance_winding_k_per_w?,
            case_k_per_w: motor.thermal_resistance_case_k_per_w?,
            winding_s: motor.thermal_time_winding_s?,
            case_s: motor.thermal_time_motor_s?,
            ambient_c: motor.ambient_c.unwrap_or(REFERENCE_C),
        })
    }

    /// Returns the temperatures at the start.
    pub const fn start(&self) -> Temperatures {
        Temperatures { winding_c: self.ambient_c, case_c: self.ambient_c }
    }
}

impl Temperatures {
    /// Returns the winding's resistance over that at [`REFERENCE_C`].
    pub fn resistance_ratio(&self) -> f64 {
        1.0 + COPPER_PER_K * (self.winding_c - REFERENCE_C)
    }

    /// Advances by a time (s) in which a copper loss (J) heats the winding.
    pub fn advance(&mut self, of: &HeatPath, loss_j: f64, duration_s: f64) {
        // The rates at which a body follows its neighbour, times the step.
        let winding = duration_s / of.winding_s;
        let to_winding = duration_s / of.case_s * of.case_k_per_w / of.winding_k_per_w;
        let to_ambient = duration_s / of.case_s;
        let heated_c = self.winding_c + loss_j * of.winding_k_per_w / of.winding_s;
        let cooled_c = self.case_c + to_ambient * of.ambient_c;
        // T_w = (heated + winding T_c) / (1 + winding), put into the case's equation.
        let passed = to_winding / (1.0 + winding);
        self.case_c = (cooled_c + passed * heated_c) / (1.0 + to_ambient + passed);
        self.winding_c = (heated_c + winding * self.case_c) / (1.0 + winding);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a motor of 90 W.
    const PATH: HeatPath = HeatPath {
        winding_k_per_w: 1.9,
        case_k_per_w: 4.6,
        winding_s: 30.0,
        case_s: 600.0,
        ambient_c: 25.0,
    };

    /// Solution for a constant loss (W) from rest: the two roots of the characteristic polynomial
    /// of `x' = A x + b`, `x(0) = 0`, above the ambient air, K.
    fn rises_k(loss_w: f64, time_s: f64) -> [f64; 2] {
        let HeatPath { winding_k_per_w: r1, case_k_per_w: r2, winding_s, case_s, .. } = PATH;
        let (c1, c2) = (winding_s / r1, case_s / r2);
        let a =
            [[-1.0 / (r1 * c1), 1.0 / (r1 * c1)], [1.0 / (r1 * c2), -(1.0 / r1 + 1.0 / r2) / c2]];
        let end = [loss_w * (r1 + r2), loss_w * r2];
        let (trace, det) = (a[0][0] + a[1][1], a[0][0] * a[1][1] - a[0][1] * a[1][0]);
        let root = (trace * trace - 4.0 * det).sqrt();
        let (slow, fast) = (0.5 * (trace + root), 0.5 * (trace - root));
        // Sylvester: e^(A t) = ((A - fast) e^(slow t) - (A - slow) e^(fast t)) / (slow - fast).
        let (grows, falls) = ((slow * time_s).exp(), (fast * time_s).exp());
        let left = |row: usize| {
            let of = |column: usize| {
                let one = if row == column { 1.0 } else { 0.0 };
                let (by_slow, by_fast) = (a[row][column] - fast * one, a[row][column] - slow * one);
                (by_slow * grows - by_fast * falls) / (slow - fast)
            };
            of(0) * end[0] + of(1) * end[1]
        };
        [end[0] - left(0), end[1] - left(1)]
    }

    #[test]
    fn a_constant_loss_heats_winding_and_case_as_two_exponentials() {
        let (loss_w, step_s) = (12.0, 1e-2);
        let mut found = PATH.start();
        let mut ticks = 0;
        for until_s in [5.0, 30.0, 300.0, 1200.0, 6000.0] {
            while f64::from(ticks) * step_s < until_s - 0.5 * step_s {
                found.advance(&PATH, loss_w * step_s, step_s);
                ticks += 1;
            }
            let [winding_k, case_k] = rises_k(loss_w, until_s);
            let apart = [found.winding_c - 25.0 - winding_k, found.case_c - 25.0 - case_k];
            assert!(apart.iter().all(|k| k.abs() < 5e-3), "{until_s} s: {apart:?} K");
        }
        // At the end, the loss flows through both resistances: 12 W x 6.5 K/W.
        assert!((found.winding_c - 25.0 - 78.0).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn copper_gains_two_fifths_of_its_resistance_over_a_hundred_kelvin() {
        let at = |winding_c| Temperatures { winding_c, case_c: 20.0 }.resistance_ratio();
        assert_eq!(at(20.0), 1.0);
        assert!((at(120.0) - 1.393).abs() < 1e-12);
    }

    #[test]
    fn a_step_that_is_longer_than_all_time_constants_ends_at_rest() {
        let mut found = PATH.start();
        found.advance(&PATH, 12.0 * 1e9, 1e9);
        assert!((found.winding_c - 103.0).abs() < 1e-3 && (found.case_c - 80.2).abs() < 1e-3);
    }
}
