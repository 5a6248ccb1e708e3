//! The thesis's axis between two hard stops.

use dynamics::joint::{
    Body, CoreUnits, Description, DiscSide, Stops, StribeckCurve, Substitute, Train, presets,
};

/// Any effort gain, N m/V: the core does not see it.
const UNITS: CoreUnits = CoreUnits { effort_gain: 12.5 };

/// Angle of a count, deg.
pub const COUNT_DEG: f64 = 0.00242;

/// Makes the rigid axis with its stops at two positions, deg. It starts at zero.
pub fn axis_with_stops([lower_deg, upper_deg]: [f64; 2]) -> Substitute {
    let torque = UNITS.effort_gain;
    let per_degree = torque * 1.0_f64.to_degrees();
    let axis = presets::thesis_axis();
    let curve = axis.friction.curve;
    let curve = StribeckCurve {
        coulomb: curve.coulomb * torque,
        stick: curve.stick * torque,
        viscous: curve.viscous * per_degree,
        ..curve
    };
    let body = Body { inertia: axis.inertia * per_degree, friction: curve.into() };
    let stops = Stops { lower: lower_deg.to_radians(), upper: upper_deg.to_radians() };
    let rigid = Description::of(Train::Rigid(body), COUNT_DEG.to_radians());
    let joint = Description { stops, ..rigid };
    Substitute { joint, units: UNITS, side: DiscSide::Load }
}
