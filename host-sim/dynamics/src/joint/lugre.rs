//! A rigid joint with a LuGre bristle (Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans.
//! Automatic Control 40(3), 1995).
//!
//! ```text
//! J v' = u + d(t, x) - sigma0 z - sigma1 z' - B v
//! z'   = v - r(v) z    r(v) = sigma0 |v|/g(|v|)    g(v) = F_c + (F_s - F_c) exp(-(v/v_s)^2)
//! ```
//!
//! In motion r is 10^4 to 10^5 1/s, at rest the bristle swings at sqrt(sigma0/J). Both are too fast
//! for an explicit method. The steps are those of Rodas3 (Sandu and others, Atmospheric Environment
//! 31(20), 1997), a linearly implicit method of order 3(2), L-stable, whose linear system is solved
//! by hand.
//!
//! A bristle comes to rest only in the limit. It is frozen, without further computation until the
//! effort changes, once the remaining distance is far below the allowed error.
//!
//! Guarantees: steps as long as accuracy allows, whatever the stiffness. Limits: breaks and sticks
//! are not sharp, and are reported at the end of a sample; at a wall the bristle keeps its
//! deflection.

use super::description::{Bristle, Description, LoadTorque, Stops, StribeckCurve};
use super::lag::Lag;
use super::push::Pushes;
use super::step::{LOCATED, Pace};
use super::{Joint, Turn};
use crate::solver::{Event, EventKind};

/// A rigid joint with a LuGre bristle.
#[derive(Clone, Debug)]
pub struct LuGreJoint {
    inertia: f64,
    bristle: Bristle,
    curve: StribeckCurve,
    /// Viscous friction with a closed winding, N m s/rad.
    closed: f64,
    brake: f64,
    torques: LoadTorque,
    stops: Stops,
    push: Pushes,
    push_now: f64,
    lag: Lag,
    pace: Pace,
    state: State,
    /// At rest, with the bristle in balance, until something changes.
    frozen: bool,
    /// Direction of the slip in the last event, 0 for none.
    sense: f64,
    time_s: f64,
    unfollowed_s: f64,
}

/// Position, velocity, deflection of the bristle; or their rates.
type State = [f64; 3];

/// Share of the deflection g/sigma0 beyond which a bristle counts as slipping.
const SLIPPING: f64 = 0.99;

/// Largest number of steps in a sample; the rest of the sample is skipped.
const MOST_STEPS: usize = 10_000;

/// Interval at which a lagging effort is checked while the joint rests on a wall, s.
const WALL_S: f64 = 1e-5;

/// Rodas3's gamma.
const GAMMA: f64 = 0.5;

/// The linear system of a step: `k/(gamma h) - Jacobian k`.
struct Linear {
    /// 1/(gamma h).
    diagonal: f64,
    /// Derivatives of z' in v and z.
    by_velocity: f64,
    by_bend: f64,
    /// Derivative of v' in x, and minus the one in z.
    load: f64,
    spring: f64,
    /// Inverse of the coefficient of v after x and z are eliminated.
    inverse: f64,
}

impl LuGreJoint {
    /// Creates the joint at rest at its start, with the bristle relaxed.
    pub(super) fn new(
        description: &Description,
        inertia: f64,
        curve: &StribeckCurve,
        bristle: Bristle,
    ) -> Self {
        Self {
            inertia,
            bristle,
            curve: *curve,
            closed: curve.viscous,
            brake: 0.0,
            torques: description.load,
            stops: description.stops,
            push: Pushes(description.push),
            push_now: 0.0,
            lag: Lag::new(description.lag_s),
            // Errors of the velocity are damped as fast as the bristle swings.
            pace: Pace::of_bristle(description.count, (bristle.stiffness / inertia).sqrt()),
            state: [description.start, 0.0, 0.0],
            frozen: false,
            sense: 0.0,
            time_s: 0.0,
            unfollowed_s: 0.0,
        }
    }

    /// Returns the level g at a speed, N m, and its derivative.
    #[inline]
    fn level(&self, speed: f64) -> [f64; 2] {
        // Beyond this many Stribeck velocities, the rest of the curve is below rounding.
        const OVER: f64 = 6.1;
        let StribeckCurve { coulomb, stick, stribeck_velocity, .. } = self.curve;
        let part = speed / stribeck_velocity;
        // Not a number is a level that does not fall, of a curve without a Stribeck velocity.
        if part < OVER {
            let over = (stick - coulomb) * libm::exp(-part * part);
            [coulomb + self.brake + over, -2.0 * part * over / stribeck_velocity]
        } else {
            [coulomb + self.brake, 0.0]
        }
    }

    /// Returns r at a velocity, 1/s, and its derivative.
    #[inline]
    fn relaxation(&self, v: f64) -> [f64; 2] {
        let speed = v.abs();
        let [level, falls] = self.level(speed);
        let r = self.bristle.stiffness * speed / level;
        let slope = self.bristle.stiffness * (level - speed * falls) / (level * level);
        [r, if v < 0.0 { -slope } else { slope }]
    }

    /// Returns the rates of the state under an effort (N m), given r (1/s).
    #[inline]
    fn rates(&self, r: f64, effort: f64, &[x, v, z]: &State) -> State {
        let bend = v - r * z;
        let friction =
            self.bristle.stiffness * z + self.bristle.damping * bend + self.curve.viscous * v;
        let torque = effort + self.torques.at(x) + self.push_now;
        [v, (torque - friction) / self.inertia, bend]
    }

    #[inline]
    fn linear(&self, [r, slope]: [f64; 2], h: f64) -> Linear {
        let [x, _, z] = self.state;
        let diagonal = 1.0 / (GAMMA * h);
        let (by_velocity, by_bend) = (1.0 - slope * z, -r);
        let load = self.torques.slope(x) / self.inertia;
        let damping = self.bristle.damping / self.inertia;
        let spring = self.bristle.stiffness / self.inertia + damping * by_bend;
        let left = diagonal + damping * by_velocity + self.curve.viscous / self.inertia
            - load / diagonal
            + spring * by_velocity / (diagonal - by_bend);
        Linear { diagonal, by_velocity, by_bend, load, spring, inverse: 1.0 / left }
    }

    /// Computes a step of Rodas3 from the rates `first`. Returns the state at its end and the
    /// error.
    #[inline]
    fn attempt(&self, first: &State, relaxation: [f64; 2], h: f64) -> (State, State) {
        let linear = self.linear(relaxation, h);
        let effort = self.lag.after(h);
        // The derivative over time is that of the lagging effort.
        let by_time = h * self.lag.rate_of(self.lag.left()) / self.inertia;
        let per_h = 1.0 / h;
        let k1 = linear.solve(sum(first, &[], 0.5 * by_time));
        let k2 = linear.solve(sum(first, &[(4.0 * per_h, &k1)], 1.5 * by_time));
        let at = sum(&self.state, &[(2.0, &k1)], 0.0);
        let third = self.rates(self.relaxation(at[1])[0], effort, &at);
        let k3 = linear.solve(sum(&third, &[(per_h, &k1), (-per_h, &k2)], 0.0));
        let at = sum(&at, &[(1.0, &k3)], 0.0);
        let fourth = self.rates(self.relaxation(at[1])[0], effort, &at);
        let back = [(per_h, &k1), (-per_h, &k2), (-8.0 / 3.0 * per_h, &k3)];
        let k4 = linear.solve(sum(&fourth, &back, 0.0));
        (sum(&at, &[(1.0, &k4)], 0.0), k4)
    }

    /// Makes one step of at most `longest_s`. Returns its length, s.
    fn step(&mut self, longest_s: f64) -> f64 {
        let relaxation = self.relaxation(self.state[1]);
        let first = self.rates(relaxation[0], self.lag.now(), &self.state);
        let mut h = self.pace.step_s.min(longest_s);
        let mut end = loop {
            let (end, error) = self.attempt(&first, relaxation, h);
            match self.pace.shorter(&error, h, longest_s) {
                None => break end,
                Some(shorter) => h = shorter,
            }
        };
        if end[0] > self.stops.upper || end[0] < self.stops.lower {
            let upper = end[0] > self.stops.upper;
            let wall = if upper { self.stops.upper } else { self.stops.lower };
            let (mut from, mut until) = (0.0, h);
            // Inside of a step the position goes through the wall once.
            for _ in 0..50 {
                h = 0.5 * (from + until);
                (end, _) = self.attempt(&first, relaxation, h);
                if (end[0] - wall).abs() < LOCATED * self.pace.position {
                    break;
                }
                *(if (end[0] > wall) == upper { &mut until } else { &mut from }) = h;
            }
            end = [wall, 0.0, end[2]];
        }
        self.lag.prepare(h);
        self.lag.pass();
        self.state = end;
        h
    }

    /// Returns the torque on the joint without friction, N m.
    #[inline]
    fn torque(&self) -> f64 {
        self.lag.now() + self.torques.at(self.state[0]) + self.push_now
    }

    /// Returns whether the joint rests against a wall and the torque presses it there.
    fn presses_on_wall(&self) -> bool {
        let [x, v, z] = self.state;
        let net = self.torque() - self.bristle.stiffness * z;
        v == 0.0 && ((x >= self.stops.upper && net >= 0.0) || (x <= self.stops.lower && net <= 0.0))
    }

    /// Freezes the bristle once its remaining distance is negligible.
    #[inline]
    fn freeze(&mut self) {
        let [_, v, z] = self.state;
        let least = LOCATED * self.pace.position;
        let stiffness = self.bristle.stiffness;
        if self.lag.left() != 0.0 || v * v * self.inertia > stiffness * least * least {
            return;
        }
        // Near the break, the bristle is softer than its stiffness.
        let stick = self.curve.stick + self.brake;
        let firm = stiffness * (1.0 - (stiffness * z / stick).abs());
        if (self.torque() - stiffness * z).abs() <= least * firm || self.presses_on_wall() {
            self.state[1] = 0.0;
            self.frozen = true;
        }
    }

    /// Reports the start or the end of slip.
    fn report_slip(&mut self, time_s: f64, on: &mut impl FnMut(Event)) {
        let [_, v, z] = self.state;
        let slips =
            v * z > 0.0 && self.bristle.stiffness * z.abs() > SLIPPING * self.level(v.abs())[0];
        let sense = if slips { v.signum() } else { 0.0 };
        let kind = match (self.sense != 0.0, slips) {
            _ if self.sense == sense => return,
            (false, _) => EventKind::Break,
            (true, false) => EventKind::Stick,
            (true, true) => EventKind::Reverse,
        };
        self.sense = sense;
        on(Event { time_s, kind });
    }

    /// Advances the joint over a time (s) in which the push is constant.
    fn stretch(&mut self, duration_s: f64) {
        let mut left_s = duration_s;
        for _ in 0..MOST_STEPS {
            if self.presses_on_wall() {
                // With a lag, the joint leaves the wall at the end of a short step.
                let step_s = if self.lag.left() == 0.0 { left_s } else { left_s.min(WALL_S) };
                self.lag.prepare(step_s);
                self.lag.pass();
                left_s -= step_s;
            } else {
                left_s -= self.step(left_s);
            }
            if left_s <= 0.0 || !self.state[0].is_finite() {
                return;
            }
        }
        self.unfollowed_s += left_s;
    }
}

impl Linear {
    /// Solves for one stage.
    #[inline]
    fn solve(&self, [b1, b2, b3]: State) -> State {
        let bend = 1.0 / (self.diagonal - self.by_bend);
        let v = (b2 + self.load * b1 / self.diagonal - self.spring * b3 * bend) * self.inverse;
        [(b1 + v) / self.diagonal, v, (b3 + self.by_velocity * v) * bend]
    }
}

/// Returns `a` plus the weighted others, with `velocity` added to the velocity.
#[inline]
fn sum(a: &State, others: &[(f64, &State)], velocity: f64) -> State {
    let mut sum = [a[0], a[1] + velocity, a[2]];
    for (weight, other) in others {
        for i in 0..3 {
            sum[i] += weight * other[i];
        }
    }
    sum
}

impl Joint for LuGreJoint {
    #[inline]
    fn hold_and_report(&mut self, effort: f64, duration_s: f64, on: &mut impl FnMut(Event)) {
        let is_same = effort == self.lag.target();
        self.lag.set(effort);
        if self.frozen && is_same && self.push.0.is_none() {
            self.time_s += duration_s;
            return;
        }
        let mut passed_s = 0.0;
        while passed_s < duration_s {
            let (torque, stretch_s) = self.push.within(self.time_s, duration_s - passed_s);
            if !(self.frozen && is_same && torque == self.push_now) {
                self.frozen = false;
                self.push_now = torque;
                self.stretch(stretch_s);
                self.freeze();
            }
            self.time_s += stretch_s;
            passed_s += stretch_s;
        }
        self.report_slip(duration_s, on);
    }

    #[inline]
    fn motor(&self) -> Turn {
        Turn { position: self.state[0], velocity: self.state[1] }
    }

    #[inline]
    fn load(&self) -> Turn {
        self.motor()
    }

    fn effort_left(&self) -> f64 {
        self.lag.left()
    }

    #[inline]
    fn is_stuck(&self) -> bool {
        self.frozen
    }

    fn unfollowed_s(&self) -> f64 {
        self.unfollowed_s
    }

    fn set_brake(&mut self, torque: f64) {
        self.frozen &= torque == self.brake;
        self.brake = torque;
    }

    fn open_winding(&mut self, viscous: f64) {
        self.curve.viscous = (self.closed - viscous).max(0.0);
    }

    fn put(&mut self, turn: Turn) {
        let x = turn.position.clamp(self.stops.lower, self.stops.upper);
        self.state = [x, turn.velocity, 0.0];
        self.frozen = false;
    }
}
