//! Model of the machine: one body, driven by an effort u, with friction.
//!
//! ```text
//! symmetric:   u = J a + B v + F_c sgn v + c
//! asymmetric:  u = J a + B+ v+ + B- v- + F+ 1(v > 0) - F- 1(v < 0)
//!              v+ = max(v, 0), v- = min(v, 0)
//! Stribeck:    .. + F_s sgn(v) exp(-(v/v_s)^2)
//! gravity:     .. + g_s sin q + g_c cos q
//! ```
//!
//! Source: inverse dynamic identification, M. Gautier and Ph. Poignet, *Control Engineering
//! Practice* 9 (2001), 1361; the asymmetric friction as in A. Janot, P.-O. Vandanjon and M.
//! Gautier, *IEEE Trans. Control Systems Technology* 22 (2014), 132. Units: u in that of the
//! effort; a, v and q in SI. In motion, a constant load cannot be distinguished from friction that
//! differs between the directions: F+ and F- include both, and `offset` is (F+ - F-)/2.

use super::least_squares::{Fit, MOST, RegressionRow};

/// Filtered signals at one time, in SI; a row of the regression.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RegressionSample {
    /// Time, s.
    pub time_s: f64,
    /// Position.
    pub position: f64,
    /// Velocity.
    pub velocity: f64,
    /// Acceleration.
    pub acceleration: f64,
    /// Filtered direction: -1 to 1.
    pub direction: f64,
    /// Effort.
    pub effort: f64,
    /// Distance since the last change of direction.
    pub since_reversal: f64,
}

/// Terms of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MachineModel {
    /// Whether friction differs between the directions.
    pub is_asymmetric: bool,
    /// Stribeck velocity v_s, if the model has the term.
    pub stribeck: Option<f64>,
    /// Whether gravity acts on a rotating load.
    pub has_gravity: bool,
}

/// Value of a parameter, with its standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct FittedParameter {
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub sd: f64,
}

/// A fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedModel {
    /// Terms.
    pub model: MachineModel,
    /// Coefficients.
    pub fit: Fit,
}

impl MachineModel {
    /// Returns "symmetric" or "asymmetric".
    pub const fn name(&self) -> &'static str {
        if self.is_asymmetric { "asymmetric" } else { "symmetric" }
    }

    /// Returns the names of the coefficients, in the order of the columns.
    pub fn coefficients(&self) -> Vec<&'static str> {
        let mut names = vec!["inertia"];
        names.extend(if self.is_asymmetric {
            &["viscous_positive", "viscous_negative", "coulomb_positive", "coulomb_negative"][..]
        } else {
            &["viscous", "coulomb", "offset"][..]
        });
        if self.stribeck.is_some() {
            names.push("stribeck");
        }
        if self.has_gravity {
            names.extend(["gravity_sine", "gravity_cosine"]);
        }
        names
    }

    /// Returns the columns of the regression at one time.
    pub fn columns(&self, at: &RegressionSample) -> RegressionRow {
        let mut columns = [0.0; MOST];
        let mut place = 0;
        let mut push = |value: f64| {
            if let Some(column) = columns.get_mut(place) {
                *column = value;
            }
            place += 1;
        };
        push(at.acceleration);
        if self.is_asymmetric {
            push(at.velocity.max(0.0));
            push(at.velocity.min(0.0));
            push(0.5 * (1.0 + at.direction));
            push(-0.5 * (1.0 - at.direction));
        } else {
            push(at.velocity);
            push(at.direction);
            push(1.0);
        }
        if let Some(stribeck) = self.stribeck {
            push(at.direction * (-(at.velocity / stribeck).powi(2)).exp());
        }
        if self.has_gravity {
            push(at.position.sin());
            push(at.position.cos());
        }
        columns
    }
}

impl FittedModel {
    /// Returns the ratio of residual to effort, both as root mean squares, %.
    pub fn relative_residual_percent(&self) -> f64 {
        100.0 * (self.fit.residual / self.fit.total).sqrt()
    }

    /// Returns a coefficient by its name.
    pub fn get(&self, name: &str) -> Option<FittedParameter> {
        let place = self.model.coefficients().iter().position(|one| *one == name)?;
        let sd = self.fit.deviation(place);
        self.fit.values.get(place).map(|value| FittedParameter { value: *value, sd })
    }

    fn value(&self, name: &str) -> f64 {
        self.get(name).map_or(0.0, |parameter| parameter.value)
    }

    /// Returns the reported parameters, with their names.
    pub fn parameters(&self) -> Vec<(&'static str, FittedParameter)> {
        let names = self.model.coefficients();
        let mut all: Vec<_> =
            names.iter().filter_map(|name| Some((*name, self.get(name)?))).collect();
        if self.model.is_asymmetric {
            let c = &self.fit.covariance;
            let variance = 0.25 * (c[3][3] + c[4][4] - 2.0 * c[3][4]);
            let value = 0.5 * (self.fit.values[3] - self.fit.values[4]);
            all.insert(5, ("offset", FittedParameter { value, sd: variance.max(0.0).sqrt() }));
        }
        all
    }

    /// Returns the difference of the friction between the directions, standard deviations: of the
    /// viscous and of the Coulomb part. Both are 0 for a symmetric model.
    pub fn asymmetry(&self) -> [f64; 2] {
        let c = &self.fit.covariance;
        let of = |i: usize, j: usize| {
            let variance = c[i][i] + c[j][j] - 2.0 * c[i][j];
            (self.fit.values[i] - self.fit.values[j]).abs() / variance.max(0.0).sqrt()
        };
        if self.model.is_asymmetric { [of(1, 2), of(3, 4)] } else { [0.0; 2] }
    }

    /// Returns the machine's inertia J: effort, in the log's unit, for 1 m/s^2 or 1 rad/s^2.
    pub fn inertia(&self) -> f64 {
        self.value("inertia")
    }

    /// Returns the viscous coefficients of the positive and the negative way: effort, in the log's
    /// unit, for 1 m/s or 1 rad/s.
    pub fn viscous(&self) -> [f64; 2] {
        if self.model.is_asymmetric {
            [self.value("viscous_positive"), self.value("viscous_negative")]
        } else {
            [self.value("viscous"); 2]
        }
    }

    /// Returns the efforts that move the machine slowly the positive and the negative way, without
    /// the Stribeck term. The sign of the second one is reversed.
    pub fn levels(&self) -> [f64; 2] {
        if self.model.is_asymmetric {
            [self.value("coulomb_positive"), self.value("coulomb_negative")]
        } else {
            let (coulomb, offset) = (self.value("coulomb"), self.value("offset"));
            [coulomb + offset, coulomb - offset]
        }
    }

    /// Returns the Coulomb friction, mean of both ways, with the deviation of the fit.
    pub fn coulomb(&self) -> FittedParameter {
        if !self.model.is_asymmetric {
            return self.get("coulomb").unwrap_or_default();
        }
        let c = &self.fit.covariance;
        let variance = 0.25 * (c[3][3] + c[4][4] + 2.0 * c[3][4]);
        let [forward, backward] = self.levels();
        FittedParameter { value: 0.5 * (forward + backward), sd: variance.max(0.0).sqrt() }
    }

    /// Returns the Stribeck term at a speed, which adds to the level of either way.
    pub fn stribeck(&self, velocity: f64) -> f64 {
        self.model
            .stribeck
            .map_or(0.0, |vs| self.value("stribeck") * (-(velocity / vs).powi(2)).exp())
    }

    /// Returns the effort of gravity at a position.
    pub fn gravity(&self, position: f64) -> f64 {
        if !self.model.has_gravity {
            return 0.0;
        }
        self.value("gravity_sine") * position.sin() + self.value("gravity_cosine") * position.cos()
    }

    /// Returns the effort of friction and constant load at a velocity other than 0.
    pub fn friction(&self, velocity: f64) -> f64 {
        let way = usize::from(velocity < 0.0);
        let level = self.levels()[way] + self.stribeck(velocity);
        level * velocity.signum() + self.viscous()[way] * velocity
    }
}
