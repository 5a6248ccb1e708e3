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

/// Contact between the flanks of motor and load.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Contact {
    /// No backlash: the motor is always coupled to the load.
    Bound,
    /// The flanks are apart.
    Free,
    /// The motor's flank presses on this side (1 or -1) of the load.
    Pressed(f64),
    /// The flanks part on this side, faster than the bent spring relaxes: there is no torque.
    Parting(f64),
}

/// A shaft and its contact.
#[derive(Clone, Debug)]
pub struct Shaft {
    /// Stiffness k, N m/rad.
    pub stiffness: f64,
    damping: f64,
    half: f64,
    contact: Contact,
}

/// Position and velocity of the motor, then of the load; or their rates.
pub type Ends = [f64; 4];

impl Shaft {
    /// Creates a shaft at rest in the middle of its backlash.
    pub fn new(shaft: &description::ShaftDescription) -> Self {
        let contact = if shaft.backlash > 0.0 { Contact::Free } else { Contact::Bound };
        let description::ShaftDescription { stiffness, damping, backlash } = *shaft;
        Self { stiffness, damping, half: 0.5 * backlash, contact }
    }

    /// Returns the deflection of the spring on a side, rad.
    #[inline]
    fn bend(&self, side: f64, [x_m, _, x_l, _]: &Ends) -> f64 {
        x_m - x_l - side * self.half
    }

    /// Returns the torque of spring and damper on a side, N m.
    #[inline]
    fn spring(&self, side: f64, ends: &Ends) -> f64 {
        self.stiffness * self.bend(side, ends) + self.damping * (ends[1] - ends[3])
    }

    /// Returns the torque on the load, N m.
    #[inline]
    pub fn torque(&self, ends: &Ends) -> f64 {
        match self.contact {
            Contact::Bound => self.spring(0.0, ends),
            Contact::Pressed(side) => self.spring(side, ends),
            Contact::Free | Contact::Parting(_) => 0.0,
        }
    }

    /// Returns the angle of the motor minus that of the load at rest, rad, under a torque on the
    /// load (N m) that is not zero.
    pub fn twist_of(&self, torque: f64) -> f64 {
        torque.signum() * self.half + torque / self.stiffness
    }

    /// Returns the rate of the torque on the load, N m/s, given the rates of the ends.
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

    /// Returns the switch functions of the contact, which are positive until the contact changes.
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

    /// Returns the scale of switch function `which`: `torque` or `position`, by its quantity.
    pub fn scale(&self, which: usize, torque: f64, position: f64) -> f64 {
        match (self.contact, which) {
            (Contact::Pressed(_) | Contact::Parting(_), 0) => torque,
            _ => position,
        }
    }

    /// Sets the next contact after switch function `which` has fallen to zero.
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

    /// Sets the contact that follows from the given ends.
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
