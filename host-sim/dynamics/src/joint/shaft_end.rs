//! One end of a shaft: a body that sticks or slips independently of the other end, since the shaft
//! makes the torque between the two continuous.

use super::description::Body;
use super::step::SwitchFunction;
use super::surface::Surface;

/// Motor or load of a flexible joint.
#[derive(Clone, Debug)]
pub struct ShaftEnd {
    /// Inertia J, kg m^2.
    pub inertia: f64,
    /// Friction on the body.
    pub surface: Surface,
    /// Direction of the slip, 1 or -1; 0 at rest.
    pub sense: f64,
    /// Range of the driving torque within which a body at rest stays at rest, N m.
    pub range: [f64; 2],
}

impl ShaftEnd {
    /// Creates a body at rest. Its range is still to be set.
    pub fn new(body: &Body) -> Self {
        let surface = Surface::new(&body.friction);
        Self { inertia: body.inertia, surface, sense: 0.0, range: [0.0; 2] }
    }

    /// Returns the switch functions of a body in motion: its speed, and `wall`, the distance to the
    /// wall.
    #[inline]
    pub fn watched_in_motion(&self, v: f64, a: f64, wall: SwitchFunction) -> [SwitchFunction; 2] {
        // A body that has just broken away is at its limit except for rounding, and does not halt.
        let slope = if v == 0.0 { (self.sense * a).max(0.0) } else { self.sense * a };
        [[self.sense * v, slope], wall]
    }

    /// Returns the switch functions of a stuck body: the distances of the driving torque from the
    /// ends of its range.
    #[inline]
    pub fn watched_at_rest(&self, torque: f64, rate: f64) -> [SwitchFunction; 2] {
        [[self.range[1] - torque, -rate], [torque - self.range[0], rate]]
    }

    /// Returns whether a body at rest stays at rest under a driving torque (N m).
    pub fn holds(&self, torque: f64) -> bool {
        self.range[0] <= torque && torque <= self.range[1]
    }
}
