//! One end of a shaft: a body that sticks or slips by itself, since the shaft makes the torque
//! between the two continuous.

use super::description::Body;
use super::step::SwitchFunction;
use super::surface::Surface;

/// Motor or load of a flexible joint.
#[derive(Clone, Debug)]
pub struct ShaftEnd {
    /// J.
    pub inertia: f64,
    /// Its friction.
    pub surface: Surface,
    /// The sense of the slip, 0 at rest.
    pub sense: f64,
    /// At rest: the range of the driving torque that leaves it so.
    pub range: [f64; 2],
}

impl ShaftEnd {
    /// At rest; its range is not known yet.
    pub fn new(body: &Body) -> Self {
        let surface = Surface::new(&body.friction);
        Self { inertia: body.inertia, surface, sense: 0.0, range: [0.0; 2] }
    }

    /// What stays above zero while it slips; `wall` is how far the wall is away.
    #[inline]
    pub fn watched_in_motion(&self, v: f64, a: f64, wall: SwitchFunction) -> [SwitchFunction; 2] {
        // What has just broken away is at its limit but for rounding: it does not fall back.
        let slope = if v == 0.0 { (self.sense * a).max(0.0) } else { self.sense * a };
        [[self.sense * v, slope], wall]
    }

    /// What stays above zero while it is stuck, of the driving torque and its rate.
    #[inline]
    pub fn watched_at_rest(&self, torque: f64, rate: f64) -> [SwitchFunction; 2] {
        [[self.range[1] - torque, -rate], [torque - self.range[0], rate]]
    }

    /// Whether a driving torque leaves it at rest.
    pub fn holds(&self, torque: f64) -> bool {
        self.range[0] <= torque && torque <= self.range[1]
    }
}
