//! Description of a joint as plain data; [`Description::build`] makes the simulated joint.
//!
//! Units are SI: rad, N m, kg m^2, s. Any other consistent set works as well, since no constant of
//! the plants has a unit: the thesis's axis is simulated in deg, V and V s^2/deg.

use super::{AnyJoint, FlexibleJoint, LuGreJoint, RigidJoint};
use crate::refused::{InvalidModel, shown};

/// Friction whose level falls with the speed: `|F| <= stick` at rest, and in motion
/// `F = coulomb + (stick - coulomb) exp(-(v/stribeck_velocity)^2) + viscous v`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StribeckCurve {
    /// Level F_c of slow sliding, N m.
    pub coulomb: f64,
    /// Level F_s at which the joint breaks away, N m; not below `coulomb`.
    pub stick: f64,
    /// Stribeck velocity v_s, rad/s; at zero the level falls to `coulomb` as soon as the joint
    /// moves.
    pub stribeck_velocity: f64,
    /// Viscous coefficient B, N m s/rad.
    pub viscous: f64,
}

/// Friction levels that repeat with the angle of the gear: they are multiplied by
/// `1 + depth sin(cycles x + phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ripple {
    /// Relative amplitude of the ripple of the levels, from 0 to below 1.
    pub depth: f64,
    /// Angular frequency over the position, 1/rad: twice the ratio of a harmonic drive.
    pub cycles: f64,
    /// Phase at position zero, rad.
    pub phase: f64,
}

/// A stick level that grows while the joint rests for `t`: it is multiplied by
/// `1 + growth (1 - exp(-t/time_s))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dwell {
    /// Relative growth of the level after a long rest.
    pub growth: f64,
    /// Time constant of the growth, s.
    pub time_s: f64,
}

/// Friction that drifts with the gear's temperature, which its own heat raises:
/// `time_s T' = heating P - T` with P the friction's power and T above the surroundings. Levels are
/// multiplied by `exp(-levels_per_k T)`, the viscous coefficient by `exp(-viscous_per_k T)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    /// Temperature at the start, K above the surroundings; negative for a gear colder than them.
    pub start_k: f64,
    /// Thermal resistance to the surroundings, K/W.
    pub heating_k_per_w: f64,
    /// Thermal time constant, s.
    pub time_s: f64,
    /// Fall of the levels, 1/K.
    pub levels_per_k: f64,
    /// Fall of the viscous coefficient, 1/K.
    pub viscous_per_k: f64,
}

/// Set-valued friction with its variations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetValuedFriction {
    /// Friction at rest and in motion, over the speed.
    pub curve: StribeckCurve,
    /// Variation with the angle.
    pub ripple: Option<Ripple>,
    /// Growth at rest.
    pub dwell: Option<Dwell>,
    /// Drift with temperature.
    pub thermal: Option<Thermal>,
}

impl From<StribeckCurve> for SetValuedFriction {
    fn from(curve: StribeckCurve) -> Self {
        Self { curve, ripple: None, dwell: None, thermal: None }
    }
}

/// The bristle of a LuGre model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bristle {
    /// Stiffness sigma0, N m/rad.
    pub stiffness: f64,
    /// Damping sigma1, N m s/rad.
    pub damping: f64,
}

impl Bristle {
    /// Creates a bristle that breaks away at a deflection (rad) under the friction `stick` (N m),
    /// with the damping `1.4 sqrt(sigma0 J)` for the inertia J (kg m^2).
    pub fn breaking_at(deflection: f64, stick: f64, inertia: f64) -> Self {
        let stiffness = stick / deflection;
        Self { stiffness, damping: 1.4 * (stiffness * inertia).sqrt() }
    }
}

/// A rotor or a load, and the friction on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Inertia at the joint, kg m^2.
    pub inertia: f64,
    /// Friction on the body.
    pub friction: SetValuedFriction,
}

/// The shaft of a flexible joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftDescription {
    /// Stiffness k, N m/rad.
    pub stiffness: f64,
    /// Damping c, N m s/rad.
    pub damping: f64,
    /// Whole width of the dead zone between motor and load, rad; it is centred at the start.
    pub backlash: f64,
}

/// Drive train between the effort and the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Train {
    /// One inertia with set-valued friction.
    Rigid(Body),
    /// One inertia with LuGre friction.
    LuGre {
        /// Inertia J, kg m^2.
        inertia: f64,
        /// Friction in steady sliding, over the speed.
        curve: StribeckCurve,
        /// The bristle.
        bristle: Bristle,
    },
    /// Motor and load with a shaft between them; the load's torque, push and stop act on the load.
    Flexible {
        /// The motor.
        motor: Body,
        /// The load.
        load: Body,
        /// The shaft.
        shaft: ShaftDescription,
    },
}

/// A pendulum on the joint: the torque `-amplitude sin(angle + x)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gravity {
    /// Largest torque G, N m.
    pub amplitude: f64,
    /// Angle q_0 to the vertical at position zero, rad.
    pub angle: f64,
}

/// Torque of the load on the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadTorque {
    /// A constant torque, N m.
    pub constant: f64,
    /// A pendulum.
    pub gravity: Option<Gravity>,
}

impl LoadTorque {
    /// Returns the torque at a position (rad), N m.
    #[inline]
    pub fn at(&self, x: f64) -> f64 {
        let pendulum = |gravity: Gravity| gravity.amplitude * libm::sin(gravity.angle + x);
        self.constant - self.gravity.map_or(0.0, pendulum)
    }

    /// Returns the slope of the torque over the position, N m/rad.
    #[inline]
    pub fn slope(&self, x: f64) -> f64 {
        self.gravity.map_or(0.0, |gravity| -gravity.amplitude * libm::cos(gravity.angle + x))
    }
}

/// A torque over a window of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorquePulse {
    /// Torque that acts on the joint, N m.
    pub torque: f64,
    /// Start, s.
    pub from_s: f64,
    /// End, s.
    pub until_s: f64,
}

/// Rigid, inelastic walls: the joint stays between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stops {
    /// The lower wall, rad.
    pub lower: f64,
    /// The upper wall, rad.
    pub upper: f64,
}

impl Default for Stops {
    fn default() -> Self {
        Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY }
    }
}

impl Stops {
    /// Returns the range of the torque (N m) within which a body stays at rest at a position (rad),
    /// if friction holds it up to `stick` (N m).
    pub fn range(&self, x: f64, stick: f64) -> [f64; 2] {
        [
            if x <= self.lower { f64::NEG_INFINITY } else { -stick },
            if x >= self.upper { f64::INFINITY } else { stick },
        ]
    }
}

/// Description of a whole joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Description {
    /// Inertia, friction, elasticity.
    pub train: Train,
    /// Torque of the load.
    pub load: LoadTorque,
    /// Time constant of the first-order lag of the effort, s; 0 for none.
    pub lag_s: f64,
    /// Hard stops.
    pub stops: Stops,
    /// Push on the joint.
    pub push: Option<TorquePulse>,
    /// Start position, at rest, rad.
    pub start: f64,
    /// Angle of the motor minus that of the load at the start, rad: slack and twist of the shaft.
    /// At zero, the shaft is in the middle of the slack.
    pub twist: f64,
    /// Angle of one count, rad. The errors of the solvers are far below it.
    pub count: f64,
}

impl Description {
    /// Creates the description of a joint without load, lag, stops or push that starts at zero.
    pub fn of(train: Train, count: f64) -> Self {
        Self {
            train,
            load: LoadTorque::default(),
            lag_s: 0.0,
            stops: Stops::default(),
            push: None,
            start: 0.0,
            twist: 0.0,
            count,
        }
    }

    /// Returns the same joint with its zero moved to a position (rad), where it starts.
    #[must_use]
    pub fn begun_at(mut self, position: f64) -> Self {
        let turn = |friction: &mut SetValuedFriction| {
            if let Some(ripple) = &mut friction.ripple {
                ripple.phase += ripple.cycles * position;
            }
        };
        match &mut self.train {
            Train::Rigid(body) => turn(&mut body.friction),
            Train::LuGre { .. } => {}
            Train::Flexible { motor, load, .. } => {
                turn(&mut motor.friction);
                turn(&mut load.friction);
            }
        }
        if let Some(gravity) = &mut self.load.gravity {
            gravity.angle += position;
        }
        let Stops { lower, upper } = self.stops;
        self.stops = Stops { lower: lower - position, upper: upper - position };
        self.start = 0.0;
        self
    }

    /// Makes the joint, at rest at its start.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn build(&self) -> Result<AnyJoint, InvalidModel> {
        self.check()?;
        Ok(match self.train {
            Train::Rigid(body) => AnyJoint::Rigid(RigidJoint::new(self, &body)),
            Train::LuGre { inertia, curve, bristle } => {
                AnyJoint::LuGre(LuGreJoint::new(self, inertia, &curve, bristle))
            }
            Train::Flexible { motor, load, shaft } => {
                AnyJoint::Flexible(Box::new(FlexibleJoint::new(self, [&motor, &load], &shaft)))
            }
        })
    }

    fn check(&self) -> Result<(), InvalidModel> {
        above_zero("count", self.count)?;
        at_least_zero("lag", self.lag_s)?;
        let inside = self.stops.lower <= self.start && self.start <= self.stops.upper;
        require("start", self.start, inside && self.start.is_finite(), "between the stops")?;
        finite("load", self.load.constant)?;
        if let Some(gravity) = &self.load.gravity {
            finite("gravity", gravity.amplitude)?;
            finite("angle of gravity", gravity.angle)?;
        }
        if let Some(push) = &self.push {
            finite("push", push.torque)?;
            require("push's end", push.until_s, push.from_s <= push.until_s, "after its start")?;
        }
        match &self.train {
            Train::Rigid(body) => check_body(body),
            Train::LuGre { inertia, curve, bristle } => {
                above_zero("inertia", *inertia)?;
                check_curve(curve)?;
                above_zero("slip level of a bristle", curve.coulomb)?;
                let is_smooth = curve.stribeck_velocity > 0.0 || curve.stick == curve.coulomb;
                let what = "above zero, since the level of a bristle cannot jump";
                require("Stribeck velocity", curve.stribeck_velocity, is_smooth, what)?;
                above_zero("bristle's stiffness", bristle.stiffness)?;
                at_least_zero("bristle's damping", bristle.damping)
            }
            Train::Flexible { motor, load, shaft } => {
                check_body(motor)?;
                check_body(load)?;
                above_zero("shaft's stiffness", shaft.stiffness)?;
                at_least_zero("shaft's damping", shaft.damping)?;
                at_least_zero("backlash", shaft.backlash)
            }
        }
    }
}

fn check_body(body: &Body) -> Result<(), InvalidModel> {
    above_zero("inertia", body.inertia)?;
    let SetValuedFriction { curve, ripple, dwell, thermal } = &body.friction;
    check_curve(curve)?;
    if let Some(ripple) = ripple {
        require("ripple", ripple.depth, (0.0..1.0).contains(&ripple.depth), "from 0 to below 1")?;
        finite("cycles of the ripple", ripple.cycles)?;
    }
    if let Some(dwell) = dwell {
        at_least_zero("growth at rest", dwell.growth)?;
        above_zero("time constant of the growth at rest", dwell.time_s)?;
    }
    if let Some(thermal) = thermal {
        at_least_zero("heating", thermal.heating_k_per_w)?;
        above_zero("thermal time constant", thermal.time_s)?;
    }
    Ok(())
}

fn check_curve(curve: &StribeckCurve) -> Result<(), InvalidModel> {
    at_least_zero("slip level", curve.coulomb)?;
    require("stick level", curve.stick, curve.stick >= curve.coulomb, "not below the slip level")?;
    finite("stick level", curve.stick)?;
    at_least_zero("Stribeck velocity", curve.stribeck_velocity)?;
    at_least_zero("viscous friction", curve.viscous)
}

fn above_zero(name: &str, value: f64) -> Result<(), InvalidModel> {
    require(name, value, value > 0.0 && value.is_finite(), "a number above zero")
}

fn at_least_zero(name: &str, value: f64) -> Result<(), InvalidModel> {
    require(name, value, value >= 0.0 && value.is_finite(), "zero or a number above it")
}

fn finite(name: &str, value: f64) -> Result<(), InvalidModel> {
    require(name, value, value.is_finite(), "a finite number")
}

fn require(name: &str, value: f64, allowed: bool, what: &str) -> Result<(), InvalidModel> {
    if allowed {
        return Ok(());
    }
    Err(InvalidModel(format!("joint: the {name} is {}; it must be {what}", shown(value))))
}
