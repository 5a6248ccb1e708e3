//! A rigid joint with Coulomb friction and stiction, a load and a wall, and the law around it.

use stiction::control::laws::robust::RobustState;
use stiction::control::laws::{Law, LawInput, Loop, Robust, RobustGains};
use stiction::control::motor_encoder::MotorEncoder;
use stiction::control::reference::Setpoint;
use stiction::units::position::Position;
use stiction::units::value::Table;

/// The loop: 1 kHz, 100 000 counts a turn, 60 V in steps of 0.06 V.
pub const AROUND: Loop = Loop {
    sample_time: 0.001,
    resolution: 0.0036,
    full_scale: 60.0,
    lsb: 0.06,
    kp: 0.0,
    motor: MotorEncoder::NONE,
};

/// Returns the gains that the law is configured with.
pub fn configured() -> RobustGains {
    RobustGains {
        inertia: 0.006,
        viscous: 0.02,
        breakaway_low: 2.0,
        breakaway_high: 12.0,
        ..RobustGains::EXAMPLE
    }
}

/// The joint: it is a third lighter than its configured inertia.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// Static and dynamic friction, V.
    pub stick: f64,
    pub slip: f64,
    /// A load, V.
    pub load: f64,
    /// The highest position, deg.
    pub wall: f64,
    /// Position, deg, and speed, deg/s.
    pub position: f64,
    pub speed: f64,
}

impl Joint {
    pub fn new(stick: f64, slip: f64) -> Self {
        Self { stick, slip, load: 0.0, wall: f64::INFINITY, position: 0.0, speed: 0.0 }
    }

    fn counts(&self) -> i32 {
        (self.position / f64::from(AROUND.resolution) + 0.5).floor() as i32
    }

    /// Moves for a tick under an effort, V.
    fn advance(&mut self, effort: f64) {
        const SUBSTEPS: u32 = 20;
        let dt = f64::from(AROUND.sample_time) / f64::from(SUBSTEPS);
        for _ in 0..SUBSTEPS {
            let force = effort + self.load - 0.02 * self.speed;
            if self.speed == 0.0 {
                if force.abs() > self.stick {
                    self.speed = (force - self.slip * force.signum()) / 0.004 * dt;
                }
            } else {
                let before = self.speed;
                self.speed += (force - self.slip * before.signum()) / 0.004 * dt;
                if self.speed * before <= 0.0 {
                    self.speed = 0.0;
                }
            }
            self.position += self.speed * dt;
            if self.position >= self.wall {
                (self.position, self.speed) = (self.wall, self.speed.min(0.0));
            }
        }
    }
}

/// The law around a joint.
pub struct ClosedLoop {
    pub joint: Joint,
    pub state: RobustState,
    law: Robust,
    /// Effort of the last tick, V.
    pub applied: f32,
}

impl ClosedLoop {
    pub fn new(joint: Joint, gains: &RobustGains) -> Self {
        Self {
            joint,
            state: RobustState::default(),
            law: Robust::new(gains, &AROUND),
            applied: 0.0,
        }
    }

    /// Runs for a time, s, with the set point at rest, deg; calls `f` after each tick.
    pub fn run(&mut self, target: f64, seconds: f64, mut f: impl FnMut(&Self)) {
        let place = target / f64::from(AROUND.resolution);
        let position =
            Position { counts: place.floor() as i32, fraction: (place - place.floor()) as f32 };
        for _ in 0..(seconds / f64::from(AROUND.sample_time)).round() as u32 {
            let input = LawInput {
                counts: self.joint.counts(),
                setpoint: Setpoint::at_rest(position),
                applied: self.applied,
                ..LawInput::default()
            };
            let effort = self.law.update(&mut self.state, &input);
            self.applied = (effort / AROUND.lsb).round() * AROUND.lsb;
            self.joint.advance(self.applied.into());
            f(self);
        }
    }

    /// Returns how far the joint is from a target, counts.
    pub fn off(&self, target: f64) -> f64 {
        (target - self.joint.position) / f64::from(AROUND.resolution)
    }

    /// Returns the signal of a name.
    pub fn signal(&self, name: &str) -> f32 {
        let place = Robust::SIGNALS.iter().position(|signal| signal.name == name).unwrap();
        self.law.signals(&self.state)[place]
    }
}
