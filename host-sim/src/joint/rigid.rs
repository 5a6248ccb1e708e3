//! A rigid joint with set-valued friction.
//!
//! ```text
//! J v' = u + d(t, x) - F,    |F| <= F_s at v = 0,    F = sgn(v) g(|v|, x) + B v otherwise
//! ```
//!
//! Between two switches the motion is smooth. A step of [`super::runge_kutta`] is accepted by its
//! error; a halt or a wall inside it is located by Newton's method on the integrated motion. At
//! rest nothing is integrated: without a lag the joint breaks away when the effort changes or
//! never, with one the instant is found in closed form or by bisection.
//!
//! Guarantees: velocity exactly zero while stuck, also against a wall; every halt is located, also
//! a short one within a step as far as a cubic shows it; steps as long as the sample where the
//! motion is smooth. Does badly: levels that drift with temperature are taken as constant within a
//! sample.

use super::description::{Body, Description, Load, Stops};
use super::lag::Lag;
use super::push::Pushes;
use super::runge_kutta::{Attempt, attempt, growth};
use super::surface::Surface;
use super::{Joint, Turn};
use crate::solver::roots::first_falling_zero;
use crate::solver::{Event, EventKind};

/// The joint.
#[derive(Clone, Debug)]
pub struct Rigid {
    inertia: f64,
    surface: Surface,
    load: Load,
    stops: Stops,
    push: Pushes,
    /// Whether rest takes work: the friction changes, or a push comes.
    is_busy: bool,
    lag: Lag,
    /// Errors of a step are kept below these: position, velocity.
    allowed: [f64; 2],
    x: f64,
    v: f64,
    /// The sense of the slip, 0 at rest.
    sense: f64,
    /// At rest: the load's torque, and the range of the effort that leaves the joint there.
    pull: f64,
    range: [f64; 2],
    push_now: f64,
    time_s: f64,
    step_s: f64,
    /// Friction's work since the begin of the sample, J.
    heat: f64,
}

/// No step is shorter, s, whatever its error.
const SHORTEST_S: f64 = 1e-10;

/// Errors allowed in a step: of the position in counts, of the velocity in counts per second.
const ALLOWED_COUNTS: f64 = 1e-5;
const ALLOWED_COUNTS_PER_S: f64 = 1e-3;

/// A halt is located to this part of the error that is allowed.
const HALTED: f64 = 1e-3;

/// So many halts and breaks in a sample are no motion any more: the rest of it passes at rest.
const MOST_HALTS: usize = 64;

impl Rigid {
    /// At rest at the start.
    pub(super) fn new(description: &Description, body: &Body) -> Self {
        let count = description.count;
        let surface = Surface::new(&body.friction);
        let is_busy = description.push.is_some() || surface.varies();
        let mut joint = Self {
            inertia: body.inertia,
            surface,
            load: description.load,
            stops: description.stops,
            push: Pushes(description.push),
            is_busy,
            lag: Lag::new(description.lag_s),
            allowed: [ALLOWED_COUNTS * count, ALLOWED_COUNTS_PER_S * count],
            x: description.start,
            v: 0.0,
            sense: 0.0,
            pull: 0.0,
            range: [0.0; 2],
            push_now: 0.0,
            time_s: 0.0,
            step_s: 1.0,
            heat: 0.0,
        };
        joint.settle();
        joint
    }

    /// The torque of load and push at a position.
    #[inline]
    fn torque(&self, x: f64) -> f64 {
        let gravity = self
            .load
            .gravity
            .map_or(0.0, |gravity| -gravity.amplitude * libm::sin(gravity.angle + x));
        self.load.constant + gravity + self.push_now
    }

    /// What of the effort leaves the joint at rest where it is.
    fn settle(&mut self) {
        self.pull = self.torque(self.x);
        self.limit(self.surface.stick(self.x));
    }

    fn limit(&mut self, stick: f64) {
        let free = [self.x <= self.stops.lower, self.x >= self.stops.upper];
        self.range = [
            if free[0] { f64::NEG_INFINITY } else { -stick - self.pull },
            if free[1] { f64::INFINITY } else { stick - self.pull },
        ];
    }

    /// Lets time pass at rest; gives what is left of it when the joint breaks away.
    fn rest(&mut self, duration_s: f64, on: &mut impl FnMut(EventKind, f64)) -> f64 {
        let holds = |range: &[f64; 2], effort: f64| range[0] <= effort && effort <= range[1];
        if !holds(&self.range, self.lag.now()) {
            return self.break_away(duration_s, on);
        }
        let time_s = if self.lag.left() == 0.0 { duration_s } else { self.breaks_at(duration_s) };
        self.lag.prepare(time_s);
        self.lag.pass();
        if self.surface.varies() {
            self.surface.rest(time_s);
            self.limit(self.surface.stick(self.x));
        }
        if time_s < duration_s {
            return self.break_away(duration_s - time_s, on);
        }
        0.0
    }

    fn break_away(&mut self, left_s: f64, on: &mut impl FnMut(EventKind, f64)) -> f64 {
        self.sense = if self.lag.now() > self.range[1] { 1.0 } else { -1.0 };
        on(EventKind::Break, left_s);
        left_s
    }

    /// The time after which the lagging effort leaves its range, or the whole time.
    fn breaks_at(&self, duration_s: f64) -> f64 {
        let stick = self.surface.stick(self.x);
        let beyond = |time_s: f64| {
            let effort = self.lag.after(time_s);
            let grown = if self.surface.grows_at_rest() {
                self.surface.stick_after(self.x, time_s) - stick
            } else {
                0.0
            };
            (effort - self.range[1] - grown).max(self.range[0] - grown - effort)
        };
        // Without growth the effort leaves the range once or never. With it, it may come back
        // within the sample, as both are exponentials: such a visit is looked for at some places.
        let places = if self.surface.grows_at_rest() { 16 } else { 1 };
        let mut from = 0.0;
        for place in 1..=places {
            let mut until = duration_s * f64::from(place) / f64::from(places);
            if beyond(until) > 0.0 {
                for _ in 0..60 {
                    let middle = 0.5 * (from + until);
                    if beyond(middle) > 0.0 {
                        until = middle;
                    } else {
                        from = middle;
                    }
                }
                return until;
            }
            from = until;
        }
        duration_s
    }

    /// Rates of position and velocity at a stage, without what is left of the former effort.
    #[inline]
    fn rate(&self, stage: usize, y: &[f64; 2]) -> [f64; 2] {
        let [impulse, way] = self.lag.impulse(stage);
        let x = y[0] + way / self.inertia;
        let v = y[1] + impulse / self.inertia;
        let friction = self.sense * self.surface.slip(self.sense * v, x);
        [y[1], (self.lag.target() + self.torque(x) - friction) / self.inertia]
    }

    /// A step, lag included.
    #[inline]
    fn attempt(&mut self, first: &[f64; 2], h: f64) -> Attempt<2> {
        self.lag.prepare(h);
        let mut attempt = attempt(|stage, y| self.rate(stage, y), &[self.x, self.v], first, h);
        let [impulse, way] = self.lag.impulse(6);
        attempt.end[0] += way / self.inertia;
        attempt.end[1] += impulse / self.inertia;
        attempt.rate[1] += self.lag.left_at_end() / self.inertia;
        attempt
    }

    /// Lets time pass in motion, up to the end or a halt; gives what is left of it.
    fn slip(&mut self, mut left_s: f64, on: &mut impl FnMut(EventKind, f64)) -> f64 {
        let mut first = self.rate(0, &[self.x, self.v]);
        let mut longest_s = left_s;
        loop {
            let (mut step, mut h) = self.accepted(&first, longest_s.min(left_s));
            if !step.end.iter().all(|x| x.is_finite()) {
                [self.x, self.v] = step.end;
                return 0.0;
            }
            let mut halts = false;
            if let Some(part) = self.first_halt(&first, &step, h) {
                let Some(found) = self.locate_halt(&first, [part * h, h]) else {
                    // The cubic saw what is not there: it sees better in a shorter step.
                    longest_s = (0.5 * h).max(SHORTEST_S);
                    continue;
                };
                (step, h) = found;
                halts = true;
            }
            let wall = if self.sense > 0.0 { self.stops.upper } else { self.stops.lower };
            if (step.end[0] - wall) * self.sense >= 0.0 {
                (step, h) = self.locate_wall(&first, h, wall);
                halts = true;
            }
            let way = step.end[0] - self.x;
            let speed = 0.5 * (self.v + step.end[1]) * self.sense;
            self.heat += (self.surface.slip(speed, self.x) * way).abs();
            self.lag.prepare(h);
            self.lag.pass();
            [self.x, self.v] = step.end;
            left_s -= h;
            if halts {
                self.halt(left_s, on);
                return left_s;
            }
            if left_s <= 0.0 {
                return 0.0;
            }
            longest_s = left_s;
            first = [self.v, step.rate[1] - self.lag.left() / self.inertia];
        }
    }

    /// A step whose error is allowed, no longer than `longest_s`.
    #[inline]
    fn accepted(&mut self, first: &[f64; 2], longest_s: f64) -> (Attempt<2>, f64) {
        let mut h = self.step_s.min(longest_s);
        loop {
            let step = self.attempt(first, h);
            let parts = [step.error[0] / self.allowed[0], step.error[1] / self.allowed[1]];
            let error = parts[0].abs().max(parts[1].abs());
            if error <= 1.0 || h <= SHORTEST_S {
                if h < longest_s {
                    self.step_s = h * growth(error);
                } else if error < 1e-2 {
                    // What cut the step short says little about a longer one.
                    self.step_s = self.step_s.max(2.0 * h);
                }
                return (step, h);
            }
            h = (h * growth(error).min(0.9)).max(SHORTEST_S);
            self.step_s = h;
        }
    }

    /// The part of a step at which the joint halts, as far as a cubic shows it.
    #[inline]
    fn first_halt(&self, first: &[f64; 2], step: &Attempt<2>, h: f64) -> Option<f64> {
        let (v0, v1) = (self.sense * self.v, self.sense * step.end[1]);
        let a0 = self.sense * (first[1] + self.lag.left() / self.inertia);
        let a1 = self.sense * step.rate[1];
        if v1 > 0.0 && (a0 >= 0.0 || a1 <= 0.0) {
            return None;
        }
        if v0 <= 0.0 && v1 <= 0.0 {
            return Some(0.0);
        }
        let (s0, s1) = (h * a0, h * a1);
        let cubic = [v0, s0, 3.0 * (v1 - v0) - 2.0 * s0 - s1, 2.0 * (v0 - v1) + s0 + s1, 0.0];
        first_falling_zero(&cubic).or((v1 <= 0.0).then_some(1.0))
    }

    /// Integrates up to the halt near a time; none if there is none.
    fn locate_halt(
        &mut self,
        first: &[f64; 2],
        [mut h, longest_s]: [f64; 2],
    ) -> Option<(Attempt<2>, f64)> {
        for _ in 0..12 {
            let mut step = self.attempt(first, h);
            let (v, a) = (self.sense * step.end[1], self.sense * step.rate[1]);
            if v.abs() <= HALTED * self.allowed[1] || h == 0.0 {
                step.end[1] = 0.0;
                return Some((step, h));
            }
            if a >= 0.0 {
                return None;
            }
            h = (h - v / a).clamp(0.0, longest_s);
        }
        None
    }

    /// Integrates up to a wall that a step of `h` passes.
    fn locate_wall(&mut self, first: &[f64; 2], h: f64, wall: f64) -> (Attempt<2>, f64) {
        // The position does not turn within the step: a bracket, and Newton inside of it.
        let (mut from, mut until) = (0.0, h);
        let mut time_s = (wall - self.x) / self.v;
        for _ in 0..60 {
            if !(from < time_s && time_s < until) {
                time_s = 0.5 * (from + until);
            }
            let step = self.attempt(first, time_s);
            let left = (wall - step.end[0]) * self.sense;
            if left.abs() <= HALTED * self.allowed[0] {
                break;
            }
            *(if left > 0.0 { &mut from } else { &mut until }) = time_s;
            time_s += left / (step.end[1] * self.sense);
        }
        let mut step = self.attempt(first, time_s);
        step.end = [wall, 0.0];
        (step, time_s)
    }

    /// The joint has come to a halt: it sticks, or goes the other way.
    fn halt(&mut self, left_s: f64, on: &mut impl FnMut(EventKind, f64)) {
        self.v = 0.0;
        self.surface.halt();
        self.settle();
        let (effort, before) = (self.lag.now(), self.sense);
        self.sense = if effort > self.range[1] {
            1.0
        } else if effort < self.range[0] {
            -1.0
        } else {
            0.0
        };
        if self.sense != before {
            on(if self.sense == 0.0 { EventKind::Stick } else { EventKind::Reverse }, left_s);
        }
    }

    /// Lets time pass in which the push is constant.
    fn stretch(&mut self, duration_s: f64, on: &mut impl FnMut(EventKind, f64)) {
        let mut left_s = duration_s;
        for _ in 0..MOST_HALTS {
            left_s = if self.sense == 0.0 { self.rest(left_s, on) } else { self.slip(left_s, on) };
            if left_s <= 0.0 {
                return;
            }
        }
    }
}

impl Joint for Rigid {
    #[inline]
    fn hold_and_tell(&mut self, effort: f64, duration_s: f64, on: &mut impl FnMut(Event)) {
        self.lag.set(effort);
        let is_still = self.sense == 0.0 && self.lag.left() == 0.0;
        if is_still && !self.is_busy && self.range[0] <= effort && effort <= self.range[1] {
            self.time_s += duration_s;
            return;
        }
        self.heat = 0.0;
        let mut passed_s = 0.0;
        while passed_s < duration_s {
            let left_s = duration_s - passed_s;
            let (torque, stretch_s) = self.push.within(self.time_s, left_s);
            if torque != self.push_now {
                self.push_now = torque;
                self.settle();
            }
            let end_s = passed_s + stretch_s;
            self.stretch(stretch_s, &mut |kind, left_s| {
                on(Event { time_s: end_s - left_s, kind });
            });
            self.time_s += stretch_s;
            passed_s = end_s;
        }
        self.surface.warm(self.heat, duration_s);
        if self.surface.varies() && self.sense == 0.0 {
            self.settle();
        }
    }

    #[inline]
    fn motor(&self) -> Turn {
        Turn { position: self.x, velocity: self.v }
    }

    #[inline]
    fn load(&self) -> Turn {
        self.motor()
    }

    #[inline]
    fn is_stuck(&self) -> bool {
        self.sense == 0.0
    }

    fn set_brake(&mut self, torque: f64) {
        self.surface.set_brake(torque);
        self.settle();
    }

    fn put(&mut self, turn: Turn) {
        self.x = turn.position.clamp(self.stops.lower, self.stops.upper);
        self.v = turn.velocity;
        self.sense = if turn.velocity == 0.0 { 0.0 } else { turn.velocity.signum() };
        self.settle();
    }
}
