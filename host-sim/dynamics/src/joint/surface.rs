//! Set-valued friction that varies with the gear's angle, with rest and temperature; and a brake.
//!
//! The exponentials are those of the crate `libm`, which are the same on every machine; a system's
//! own are not.

use super::description::{Dwell, Ripple, SetValuedFriction, Thermal};

/// Beyond this many Stribeck velocities the rest of the curve is below f64's rounding:
/// `exp(-6.1^2) = 7e-17`.
const OVER: f64 = 6.1;

/// The friction on one body, with its state.
#[derive(Clone, Debug)]
pub struct Surface {
    friction: SetValuedFriction,
    /// Present values of F_c, F_s - F_c and B.
    coulomb: f64,
    drop: f64,
    viscous: f64,
    /// 1/v_s; infinite if the level falls at once.
    per_speed: f64,
    /// Constant friction of a brake, added to both levels, N m.
    brake: f64,
    /// Viscous friction that an open winding takes away, N m s/rad.
    opened: f64,
    /// Time for which the body has been at rest, s.
    rested_s: f64,
    /// Temperature above the surroundings, K, and its rise in half a sample, K.
    kelvin: f64,
    ahead: f64,
}

impl Surface {
    /// Creates the friction of a body that has just come to rest.
    pub fn new(friction: &SetValuedFriction) -> Self {
        let mut surface = Self {
            friction: *friction,
            coulomb: 0.0,
            drop: 0.0,
            viscous: 0.0,
            per_speed: 1.0 / friction.curve.stribeck_velocity,
            brake: 0.0,
            opened: 0.0,
            rested_s: 0.0,
            kelvin: friction.thermal.map_or(0.0, |thermal| thermal.start_k),
            ahead: 0.0,
        };
        surface.refresh();
        surface
    }

    /// Updates the levels for the present temperature and time at rest.
    fn refresh(&mut self) {
        let curve = &self.friction.curve;
        let [levels, viscous] = self.friction.thermal.map_or([1.0; 2], |thermal: Thermal| {
            [thermal.levels_per_k, thermal.viscous_per_k]
                .map(|k| libm::exp(-k * (self.kelvin + self.ahead)))
        });
        let grown = self.friction.dwell.map_or(1.0, |dwell: Dwell| {
            1.0 - dwell.growth * libm::expm1(-self.rested_s / dwell.time_s)
        });
        self.coulomb = levels * curve.coulomb;
        self.drop = levels * (curve.stick * grown - curve.coulomb);
        self.viscous = (viscous * curve.viscous - self.opened).max(0.0);
    }

    /// Returns the factor of the levels at a position (rad).
    #[inline]
    fn ripple(&self, position: f64) -> f64 {
        self.friction.ripple.map_or(1.0, |Ripple { depth, cycles, phase }| {
            1.0 + depth * libm::sin(cycles * position + phase)
        })
    }

    /// Returns the largest friction at rest, N m.
    #[inline]
    pub fn stick(&self, position: f64) -> f64 {
        (self.coulomb + self.drop) * self.ripple(position) + self.brake
    }

    /// Returns the largest friction at rest after a further time at rest (s), N m.
    pub fn stick_after(&self, position: f64, time_s: f64) -> f64 {
        let mut later = self.clone();
        later.rest(time_s);
        later.stick(position)
    }

    /// Returns the friction in motion, with the viscous part, N m. The speed (rad/s) is positive in
    /// the direction of the motion. The curve continues smoothly below zero, so that a step can go
    /// beyond a halt.
    #[inline]
    pub fn slip(&self, speed: f64, position: f64) -> f64 {
        let part = speed * self.per_speed;
        let over = if part.abs() < OVER { self.drop * libm::exp(-part * part) } else { 0.0 };
        (self.coulomb + over) * self.ripple(position) + self.brake + self.viscous * speed
    }

    /// Returns whether the stick level depends on time while the body rests.
    #[inline]
    pub const fn grows_at_rest(&self) -> bool {
        self.friction.dwell.is_some()
    }

    /// Returns whether any level depends on time.
    #[inline]
    pub const fn varies(&self) -> bool {
        self.friction.dwell.is_some() || self.friction.thermal.is_some()
    }

    /// Adds a time (s) to the present rest.
    pub fn rest(&mut self, time_s: f64) {
        if self.grows_at_rest() {
            self.rested_s += time_s;
            self.refresh();
        }
    }

    /// Starts a rest: the growth of the stick level in the last rest is removed.
    pub fn halt(&mut self) {
        if self.grows_at_rest() {
            self.rested_s = 0.0;
            self.refresh();
        }
    }

    /// Heats the gear by an amount (J) that is spread evenly over a time (s).
    pub fn warm(&mut self, heat: f64, time_s: f64) {
        if let Some(thermal) = self.friction.thermal {
            let aim = thermal.heating_k_per_w * heat / time_s;
            let before = self.kelvin;
            self.kelvin -= (aim - self.kelvin) * libm::expm1(-time_s / thermal.time_s);
            // The levels of the next sample are those in its middle, if the rise stays the same.
            self.ahead = 0.5 * (self.kelvin - before);
            self.refresh();
        }
    }

    /// Sets the brake, N m.
    pub const fn set_brake(&mut self, torque: f64) {
        self.brake = torque;
    }

    /// Takes a part of the viscous friction away, N m s/rad.
    pub fn open_winding(&mut self, viscous: f64) {
        if viscous != self.opened {
            self.opened = viscous;
            self.refresh();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::description::StribeckCurve;
    use super::*;

    const CURVE: StribeckCurve =
        StribeckCurve { coulomb: 4.0, stick: 6.0, stribeck_velocity: 0.1, viscous: 1.3 };

    #[test]
    fn the_curve_is_the_one_that_is_written_down() {
        let surface = Surface::new(&CURVE.into());
        assert_eq!(surface.stick(0.3), 6.0);
        for speed in [0.0_f64, 0.02, 0.1, 0.4, 0.7, 3.0] {
            let wanted = 4.0 + 2.0 * (-(speed / 0.1).powi(2)).exp() + 1.3 * speed;
            assert!((surface.slip(speed, 0.3) - wanted).abs() < 1e-14);
        }
        // A level that falls at once.
        let sharp = Surface::new(&StribeckCurve { stribeck_velocity: 0.0, ..CURVE }.into());
        assert_eq!((sharp.stick(0.0), sharp.slip(1e-300, 0.0)), (6.0, 4.0));
    }

    #[test]
    fn levels_repeat_with_the_angle() {
        let ripple = Some(Ripple { depth: 0.3, cycles: 100.0, phase: 0.5 });
        let surface = Surface::new(&SetValuedFriction { ripple, ..CURVE.into() });
        let factor = 1.0 + 0.3 * (100.0_f64 * 0.02 + 0.5).sin();
        assert!((surface.stick(0.02) - 6.0 * factor).abs() < 1e-13);
        assert!((surface.slip(2.0, 0.02) - (4.0 * factor + 2.6)).abs() < 1e-13);
    }

    #[test]
    fn the_stick_level_grows_at_rest_and_starts_anew_at_the_next() {
        let dwell = Some(Dwell { growth: 0.5, time_s: 2.0 });
        let mut surface = Surface::new(&SetValuedFriction { dwell, ..CURVE.into() });
        surface.rest(1.0);
        surface.rest(1.0);
        let grown = 6.0 * (1.0 + 0.5 * (1.0 - (-1.0_f64).exp()));
        assert!((surface.stick(0.0) - grown).abs() < 1e-14);
        // The curve in motion starts at the level of the break.
        assert!((surface.slip(0.0, 0.0) - grown).abs() < 1e-14);
        surface.halt();
        assert_eq!(surface.stick(0.0), 6.0);
    }

    /// A constant power heats the gear by `P R (1 - exp(-t/tau))`, also in short steps.
    #[test]
    fn friction_falls_as_the_gear_warms() {
        let thermal = Some(Thermal {
            start_k: 0.0,
            heating_k_per_w: 2.0,
            time_s: 100.0,
            levels_per_k: 0.01,
            viscous_per_k: 0.03,
        });
        let mut surface = Surface::new(&SetValuedFriction { thermal, ..CURVE.into() });
        for _ in 0..500 {
            surface.warm(1.0, 0.1);
        }
        // Half a sample ahead.
        let kelvin = 20.0 * (1.0 - (-0.5005_f64).exp());
        assert!((surface.stick(0.0) - 6.0 * (-0.01 * kelvin).exp()).abs() < 1e-6);
        let sliding = 4.0 * (-0.01 * kelvin).exp() + 1.3 * (-0.03 * kelvin).exp();
        assert!((surface.slip(1.0, 0.0) - sliding).abs() < 1e-6);
    }
}
