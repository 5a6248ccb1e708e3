//! The thesis's axis with play between the motor and an encoder on the load.

use dynamics::joint::{
    Body, CoreUnits, Description, DiscSide, ShaftDescription, StribeckCurve, Substitute, Train,
    presets,
};

/// Any effort gain, N m/V: the core does not see it.
const UNITS: CoreUnits = CoreUnits { effort_gain: 12.5 };

/// Angle of a count, deg.
pub const COUNT_DEG: f64 = 0.00242;

/// Makes the axis in two halves: the motor has half of the inertia and 0.05 V less of the friction.
/// The shaft has 20 V/deg and a damping of 0.02 V s/deg.
pub fn axis_with_play(play_deg: f64) -> Substitute {
    let torque = UNITS.effort_gain;
    let per_degree = torque * 1.0_f64.to_degrees();
    let axis = presets::thesis_axis();
    let curve = axis.friction.curve;
    let body = |slip_v: f64, stick_v: f64, viscous: f64| {
        let curve = StribeckCurve {
            coulomb: slip_v * torque,
            stick: stick_v * torque,
            viscous: viscous * per_degree,
            ..curve
        };
        Body { inertia: 0.5 * axis.inertia * per_degree, friction: curve.into() }
    };
    let shaft = ShaftDescription {
        stiffness: 20.0 * per_degree,
        damping: 0.02 * per_degree,
        backlash: play_deg.to_radians(),
    };
    let motor = body(curve.coulomb - 0.05, curve.stick - 0.05, curve.viscous);
    let train = Train::Flexible { motor, load: body(0.05, 0.05, 0.0), shaft };
    let joint = Description::of(train, COUNT_DEG.to_radians());
    Substitute { joint, units: UNITS, side: DiscSide::Load }
}
