//! Random machines that produce logs: Runge and Kutta's method of the fourth order with short fixed
//! steps, friction with a smooth sign, and a PD that follows ramps of random length and speed. No
//! code of the simulator is used.

use crate::log_identification::reading::MotionLog;

/// A random sequence (a linear congruence of 64 bits with Knuth's constants for MMIX).
pub struct LinearCongruence(pub u64);

impl LinearCongruence {
    /// Returns a random number from 0 to 1.
    pub fn part(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns a random number between two values, uniform in its logarithm.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.part())
    }

    /// Returns an approximately normally distributed number: the sum of twelve parts, minus 6.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.part()).sum::<f64>() - 6.0
    }
}

/// A machine, SI.
#[derive(Clone, Copy, Debug)]
pub struct RandomMachine {
    pub inertia: f64,
    pub viscous: [f64; 2],
    pub coulomb: [f64; 2],
    pub gravity: [f64; 2],
    /// Amplitude of the Stribeck term, and its velocity.
    pub stribeck: [f64; 2],
    /// Share of the Coulomb friction that varies with the position, and periods per unit of the
    /// position.
    pub ripple: [f64; 2],
    /// Share of the inertia that is behind a backlash, and width of the backlash.
    pub backlash: [f64; 2],
    /// Natural frequency of the load on its contact, rad/s.
    pub contact: f64,
    /// Twice the damping of the contact, as a share of the critical one.
    pub damping: f64,
    /// Coulomb friction of the load.
    pub load_coulomb: f64,
    /// Size of a count of the encoder; 0: no counts.
    pub count: f64,
    /// Standard deviation of the measured effort.
    pub noise: f64,
    /// Speed of the fastest ramp, and its acceleration.
    pub speed: f64,
    pub acceleration: f64,
    pub sample_time_s: f64,
    pub duration_s: f64,
}

/// Position and velocity of the motor's side, and of the load's.
type State = [f64; 4];

impl RandomMachine {
    /// Returns a random machine, from a gimbal to a big axis.
    pub fn random(random: &mut LinearCongruence) -> Self {
        let inertia = random.between(0.01, 100.0);
        let speed = random.between(0.1, 5.0);
        let acceleration = speed * random.between(3.0, 20.0);
        let accelerating = inertia * acceleration;
        let coulomb = accelerating * random.between(0.1, 2.0);
        let viscous = coulomb / speed * random.between(0.1, 2.0);
        let mut ways = |mean: f64| {
            let part = 0.3 * (2.0 * random.part() - 1.0);
            [mean * (1.0 + part), mean * (1.0 - part)]
        };
        let (coulomb, viscous) = (ways(coulomb), ways(viscous));
        Self {
            inertia,
            viscous,
            coulomb,
            gravity: [0.0; 2],
            stribeck: [0.0, 1.0],
            ripple: [0.0; 2],
            backlash: [0.0; 2],
            contact: 250.0,
            damping: 0.6,
            load_coulomb: 0.0,
            count: speed * random.between(1e-6, 1e-4),
            noise: accelerating * random.between(1e-3, 3e-2),
            speed,
            acceleration,
            sample_time_s: random.between(2e-4, 2e-3),
            duration_s: 12.0,
        }
    }

    fn friction(&self, q: f64, v: f64) -> f64 {
        let way = usize::from(v < 0.0);
        let [stribeck, vs] = self.stribeck;
        let ripple = 1.0 + self.ripple[0] * (std::f64::consts::TAU * self.ripple[1] * q).sin();
        let level = self.coulomb[way] * ripple + stribeck * (-(v / vs).powi(2)).exp();
        level * (v / (3e-3 * self.speed)).tanh() + self.viscous[way] * v
    }

    fn derivative(&self, [q, v, ql, vl]: State, effort: f64) -> State {
        let [behind, width] = self.backlash;
        let gravity = self.gravity[0] * q.sin() + self.gravity[1] * q.cos();
        let drive = effort - self.friction(q, v) - gravity;
        if behind == 0.0 {
            return [v, drive / self.inertia, v, drive / self.inertia];
        }
        let load = behind * self.inertia;
        let stiff = load * self.contact.powi(2);
        let twist = q - ql;
        let pressed = twist - twist.clamp(-0.5 * width, 0.5 * width);
        let torque = if pressed == 0.0 {
            0.0
        } else {
            stiff * pressed + self.damping * load * self.contact * (v - vl)
        };
        let held = self.load_coulomb * (vl / (3e-3 * self.speed)).tanh();
        [v, (drive - torque) / (self.inertia - load), vl, (torque - held) / load]
    }

    fn step(&self, at: State, effort: f64, h: f64) -> State {
        let add =
            |a: State, b: State, h: f64| -> State { std::array::from_fn(|i| a[i] + h * b[i]) };
        let k1 = self.derivative(at, effort);
        let k2 = self.derivative(add(at, k1, 0.5 * h), effort);
        let k3 = self.derivative(add(at, k2, 0.5 * h), effort);
        let k4 = self.derivative(add(at, k3, h), effort);
        std::array::from_fn(|i| at[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    /// Returns time, position, measured effort, and position of the load of each sample.
    pub fn samples(&self, random: &mut LinearCongruence) -> Vec<[f64; 4]> {
        let h = self.sample_time_s;
        let wn = 25.0f64.min(0.1 / h);
        // Steps short enough for a stable smooth sign: its rate is level/(3e-3 speed inertia).
        let level = self.coulomb[0].max(self.coulomb[1]) + self.stribeck[0];
        let [behind, _] = self.backlash;
        let of_motor = level / (3e-3 * self.speed * self.inertia * (1.0 - behind));
        let of_load = self.load_coulomb / (3e-3 * self.speed * self.inertia * behind.max(0.1));
        let rate = of_motor.max(of_load);
        let steps = (h * rate / 1.5).ceil().max(2.0);
        let mut at = [0.0; 4];
        let (mut goal, mut set, mut set_speed, mut rest) = (0.0f64, 0.0f64, 0.0f64, 0.0);
        let mut top = self.speed;
        let (mut velocity, mut effort) = (0.0, 0.0);
        let mut former = 0.0;
        let mut samples = Vec::new();
        for i in 0..(self.duration_s / h) as usize {
            let left = goal - set;
            let braking = (1.8 * self.acceleration * left.abs()).sqrt().min(top);
            let wanted = if left.abs() < 1e-3 * self.speed { 0.0 } else { braking * left.signum() };
            let most = self.acceleration * h;
            let gain = (wanted - set_speed).clamp(-most, most);
            set_speed += gain;
            set += h * set_speed;
            if wanted == 0.0 && set_speed.abs() < most {
                rest += h;
            }
            if rest > 0.1 {
                rest = 0.0;
                goal = self.speed * (2.0 * random.part() - 1.0);
                top = self.speed * (0.2 + 0.8 * random.part());
            }
            let [seen, load] = [at[0], at[2]].map(|position| {
                if self.count > 0.0 {
                    (position / self.count).floor() * self.count
                } else {
                    position
                }
            });
            velocity += 0.3 * ((seen - former) / h - velocity);
            former = seen;
            let asked = self.inertia
                * (wn * wn * (set - seen) + 1.6 * wn * (set_speed - velocity) + gain / h);
            // The measured effort is the mean of the efforts before and after the sample.
            let measured = 0.5 * (effort + asked) + self.noise * random.normal();
            effort = asked;
            samples.push([h * i as f64, seen, measured, load]);
            for _ in 0..steps as usize {
                at = self.step(at, effort, h / steps);
            }
        }
        samples
    }

    /// Returns the samples as a log.
    pub fn log(&self, random: &mut LinearCongruence) -> MotionLog {
        let samples = self.samples(random);
        let column = |place: usize| samples.iter().map(|sample| sample[place]).collect();
        MotionLog {
            time: column(0),
            position: column(1),
            effort: column(2),
            rows: samples.len() as u64,
            folded: 1,
            time_digit: 1e-9,
            smallest_change: self.count,
            ..MotionLog::default()
        }
    }
}
