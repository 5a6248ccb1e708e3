//! The shaft between motor and load: spring, damper, and a dead zone in front of them.
//!
//! ```text
//! T = k e + c (v_m - v_l)    outside of the dead zone, e = x_m - x_l -+ backlash/2 beyond its edge
//! T = 0                      inside of it, and where the damper would pull the flanks together
//! ```
//!
//! A shaft without backlash pulls and pushes.

use super::description;
use super::step::SwitchFunction;

/// Where the flanks are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Contact {
    /// There is no dead zone.
    Bound,
    /// They are apart.
    Free,
    /// The motor's flank presses on this side (1 or -1) of the load.
    Pressed(f64),
    /// On this side the spring is still bent, but goes back more slowly than the flanks part.
    Parting(f64),
}

/// A shaft and its contact.
#[derive(Clone, Debug)]
pub struct Shaft {
    /// k.
    pub stiffness: f64,
    damping: f64,
    half: f64,
    contact: Contact,
}

/// Positions and velocities of motor and load.
pub type Ends = [f64; 4];

impl Shaft {
    /// A shaft at rest in the middle of its backlash.
    pub fn new(shaft: &description::ShaftDescription) -> Self {
        let contact = if shaft.backlash > 0.0 { Contact::Free } else { Contact::Bound };
        let description::ShaftDescription { stiffness, damping, backlash } = *shaft;
        Self { stiffness, damping, half: 0.5 * backlash, contact }
    }

    /// The bend of the spring on a side.
    #[inline]
    fn bend(&self, side: f64, [x_m, _, x_l, _]: &Ends) -> f64 {
        x_m - x_l - side * self.half
    }

    /// What spring and damper would give on a side.
    #[inline]
    fn spring(&self, side: f64, ends: &Ends) -> f64 {
        self.stiffness * self.bend(side, ends) + self.damping * (ends[1] - ends[3])
    }

    /// The torque on the load, N m.
    #[inline]
    pub fn torque(&self, ends: &Ends) -> f64 {
        match self.contact {
            Contact::Bound => self.spring(0.0, ends),
            Contact::Pressed(side) => self.spring(side, ends),
            Contact::Free | Contact::Parting(_) => 0.0,
        }
    }

    /// Returns by how much the motor is ahead of the load at rest under a torque on the load (N m)
    /// that is not zero, rad.
    pub fn twist_of(&self, torque: f64) -> f64 {
        torque.signum() * self.half + torque / self.stiffness
    }

    /// How fast the torque on the load rises, of the rates of the ends.
    #[inline]
    pub fn torque_rate(&self, rates: &Ends) -> f64 {
        match self.contact {
            Contact::Bound | Contact::Pressed(_) => self.spring_rate(rates),
            Contact::Free | Contact::Parting(_) => 0.0,
        }
    }

    #[inline]
    fn spring_rate(&self, rates: &Ends) -> f64 {
        self.stiffness * (rates[0] - rates[2]) + self.damping * (rates[1] - rates[3])
    }

    /// What stays above zero as long as the contact is what it is.
    #[inline]
    pub fn watched(&self, ends: &Ends, rates: &Ends) -> [SwitchFunction; 2] {
        let twist = ends[0] - ends[2];
        let twisting = rates[0] - rates[2];
        match self.contact {
            Contact::Bound => [[f64::INFINITY, 0.0]; 2],
            Contact::Free => [[self.half - twist, -twisting], [self.half + twist, twisting]],
            Contact::Pressed(side) => [
                [side * self.spring(side, ends), side * self.spring_rate(rates)],
                [f64::INFINITY, 0.0],
            ],
            Contact::Parting(side) => [
                [-side * self.spring(side, ends), -side * self.spring_rate(rates)],
                [side * self.bend(side, ends), side * twisting],
            ],
        }
    }

    /// The size of number `which` of what is watched: that of a torque or that of a position.
    pub fn scale(&self, which: usize, torque: f64, position: f64) -> f64 {
        match (self.contact, which) {
            (Contact::Pressed(_) | Contact::Parting(_), 0) => torque,
            _ => position,
        }
    }

    /// Goes over to the next contact after number `which` of what is watched has fallen to zero.
    pub fn switch(&mut self, which: usize) {
        self.contact = match (self.contact, which) {
            (Contact::Free, 0) => Contact::Pressed(1.0),
            (Contact::Free, _) => Contact::Pressed(-1.0),
            (Contact::Pressed(side), _) => Contact::Parting(side),
            (Contact::Parting(side), 0) => Contact::Pressed(side),
            (Contact::Parting(_), _) => Contact::Free,
            (Contact::Bound, _) => Contact::Bound,
        };
    }

    /// Finds the contact of ends that were put somewhere.
    pub fn put(&mut self, ends: &Ends) {
        if self.contact != Contact::Bound {
            let twist = ends[0] - ends[2];
            self.contact = if twist.abs() > self.half {
                Contact::Pressed(twist.signum())
            } else {
                Contact::Free
            };
        }
    }
}
