//! Joints that were identified by others, and the thesis's axis.
//!
//! The identified ones are of BAM (Duclusaud, Passault and others, "Extended Friction Models for
//! the Physics Simulation of Servo Actuators", arXiv 2410.08650); the numbers are those of its
//! repository Rhoban/bam, `bam/params`. Each is the actuator alone, at its output, without a load.
//! If a fit has no separate level at rest, F_s is F_c: such a joint does not stick and slip unless
//! [`with_stick`] sets another level.

use super::description::{Body, StribeckCurve};

/// eRob80 with a harmonic drive of 50:1 (`erob80_50/m1.json`).
pub fn erob80_50() -> Body {
    coulomb(0.337, 4.10, 1.30)
}

/// eRob80 with a harmonic drive of 100:1 (`erob80_100/m1.json`).
pub fn erob80_100() -> Body {
    coulomb(0.959, 5.61, 8.39)
}

/// Dynamixel MX-64, a DC servo with spur gears (`mx64/m2.json`). The fit has the exponent 3 where
/// this curve has 2.
pub fn mx64() -> Body {
    let curve = StribeckCurve {
        coulomb: 0.0561,
        stick: 0.0561 + 0.0819,
        stribeck_velocity: 1.12,
        viscous: 0.0192,
    };
    Body { inertia: 0.0119, friction: curve.into() }
}

/// The base axis of the thesis's robot, in deg, V and V s^2/deg: `1/kappa`, T_d, T_s and b of its
/// Tables 20 and 21.
pub fn thesis_axis() -> Body {
    let curve = StribeckCurve { coulomb: 0.38, stick: 0.40, stribeck_velocity: 0.0, viscous: 0.02 };
    Body { inertia: 1.0 / 27.0, friction: curve.into() }
}

/// Returns a joint with another level at rest: F_s is `ratio` times F_c, and falls over the
/// Stribeck velocity (rad/s).
pub fn with_stick(mut body: Body, ratio: f64, stribeck_velocity: f64) -> Body {
    let curve = &mut body.friction.curve;
    curve.stick = ratio * curve.coulomb;
    curve.stribeck_velocity = stribeck_velocity;
    body
}

fn coulomb(inertia: f64, level: f64, viscous: f64) -> Body {
    let curve = StribeckCurve { coulomb: level, stick: level, stribeck_velocity: 0.0, viscous };
    Body { inertia, friction: curve.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks one of the fits by its own numbers: up to 4.10 N m the actuator stays at rest; above
    /// them its final speed is `(u - F_c)/B`.
    #[test]
    fn an_identified_joint_moves_as_its_fit_says() {
        use super::super::{Description, Joint, Train};
        let mut joint = Description::of(Train::Rigid(erob80_50()), 1e-4).build().unwrap();
        (0..1000).for_each(|_| joint.hold(4.09, 1e-3));
        assert!(joint.is_stuck());
        (0..5000).for_each(|_| joint.hold(6.70, 1e-3));
        assert!((joint.motor().velocity - 2.0).abs() < 1e-6);
        let sticky = with_stick(erob80_50(), 1.5, 0.05);
        let mut joint = Description::of(Train::Rigid(sticky), 1e-4).build().unwrap();
        joint.hold(6.1, 1e-3);
        assert!(joint.is_stuck());
    }
}
