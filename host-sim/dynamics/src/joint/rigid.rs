//! A rigid joint with set-valued friction.
//!
//! ```text
//! J v' = u + d(t, x) - F,    |F| <= F_s at v = 0,    F = sgn(v) g(|v|, x) + B v otherwise
//! ```
//!
//! Between two switches the motion is smooth. A step of [`super::runge_kutta`] is accepted by its
//! error; a halt or a wall inside it is located by Newton's method on the integrated motion. At
//! rest nothing is integrated. Without a lag, the joint can break away only when the effort
//! changes; with a lag, the instant is found in closed form or by bisection.
//!
//! Guarantees: the velocity of a stuck joint is exactly zero, also against a wall; every halt is
//! located, also a short one within a step as far as a cubic shows it; steps are as long as the
//! sample if the motion is smooth. Limits: levels that drift with temperature are constant within a
//! sample.

use super::description::{Body, Description, LoadTorque, Stops};
use super::lag::Lag;
use super::push::Pushes;
use super::runge_kutta::{StepAttempt, attempt};
use super::step::{LOCATED, MOST_SWITCHES, Pace, SHORTEST_S, first_fall};
use super::surface::Surface;
use super::{Joint, Turn};
use crate::solver::{Event, EventKind};

/// A rigid joint with set-valued friction.
#[derive(Clone, Debug)]
pub struct RigidJoint {
    inertia: f64,
    surface: Surface,
    load: LoadTorque,
    stops: Stops,
    push: Pushes,
    /// Whether rest needs computation: the friction depends on time, or there is a push.
    is_busy: bool,
    lag: Lag,
    pace: Pace,
    x: f64,
    v: f64,
    /// Direction of the slip, 1 or -1; 0 at rest.
    sense: f64,
    /// At rest: the load's torque, and the range of the effort within which the joint stays there.
    pull: f64,
    range: [f64; 2],
    push_now: f64,
    time_s: f64,
    unfollowed_s: f64,
    /// Work of the friction since the start of the sample, J.
    heat: f64,
}

impl RigidJoint {
    /// Creates the joint at rest at its start.
    pub(super) fn new(description: &Description, body: &Body) -> Self {
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
            pace: Pace::of_count(description.count),
            x: description.start,
            v: 0.0,
            sense: 0.0,
            pull: 0.0,
            range: [0.0; 2],
            push_now: 0.0,
            time_s: 0.0,
            unfollowed_s: 0.0,
            heat: 0.0,
        };
        joint.settle();
        joint
    }

    /// Returns the torque of load and push at a position, N m.
    #[inline]
    fn torque(&self, x: f64) -> f64 {
        self.load.at(x) + self.push_now
    }

    /// Updates the load's torque and the range of the effort within which the joint stays at rest.
    fn settle(&mut self) {
        self.pull = self.torque(self.x);
        self.limit();
    }

    fn limit(&mut self) {
        let range = self.stops.range(self.x, self.surface.stick(self.x));
        self.range = range.map(|limit| limit - self.pull);
    }

    /// Advances the time at rest, up to a break at the latest. Returns the remaining time, s.
    fn rest(&mut self, duration_s: f64, on: &mut impl FnMut(EventKind, f64)) -> f64 {
        if !self.holds(self.lag.now()) {
            self.sense = if self.lag.now() > self.range[1] { 1.0 } else { -1.0 };
            on(EventKind::Break, duration_s);
            return duration_s;
        }
        let breaks_at = if self.surface.grows_at_rest() {
            self.leaves_growing_range(duration_s)
        } else {
            self.lag.leaves(self.range, duration_s)
        };
        let time_s = breaks_at.unwrap_or(duration_s);
        let rises = self.lag.left() < 0.0;
        self.lag.prepare(time_s);
        self.lag.pass();
        if self.surface.grows_at_rest() {
            self.surface.rest(time_s);
            self.limit();
        }
        if breaks_at.is_none() {
            return 0.0;
        }
        self.sense = if rises { 1.0 } else { -1.0 };
        on(EventKind::Break, duration_s - time_s);
        duration_s - time_s
    }

    #[inline]
    fn holds(&self, effort: f64) -> bool {
        self.range[0] <= effort && effort <= self.range[1]
    }

    /// Returns the time after which the lagging effort leaves a range that grows, s; `None` if it
    /// does not.
    fn leaves_growing_range(&self, duration_s: f64) -> Option<f64> {
        // Both are exponentials: the effort can return into the range within the sample, so it is
        // checked at several instants.
        const PLACES: u32 = 16;
        if self.lag.left() == 0.0 {
            return None;
        }
        let stick = self.surface.stick(self.x);
        let beyond = |time_s: f64| {
            let grown = self.surface.stick_after(self.x, time_s) - stick;
            let effort = self.lag.after(time_s);
            (effort - self.range[1]).max(self.range[0] - effort) > grown
        };
        let place = |number: u32| duration_s * f64::from(number) / f64::from(PLACES);
        let number = (1..=PLACES).find(|number| beyond(place(*number)))?;
        let (mut from, mut until) = (place(number - 1), place(number));
        for _ in 0..50 {
            let middle = 0.5 * (from + until);
            *(if beyond(middle) { &mut until } else { &mut from }) = middle;
        }
        Some(until)
    }

    /// Returns the rates of position and velocity at a stage of a step, without the rest of the
    /// former effort.
    #[inline]
    fn rate(&self, stage: usize, y: &[f64; 2]) -> [f64; 2] {
        let [impulse, way] = self.lag.impulse(stage);
        let x = y[0] + way / self.inertia;
        let v = y[1] + impulse / self.inertia;
        let friction = self.sense * self.surface.slip(self.sense * v, x);
        [y[1], (self.lag.target() + self.torque(x) - friction) / self.inertia]
    }

    /// Computes a step of `h` (s), with the lag.
    #[inline]
    fn attempt(&mut self, first: &[f64; 2], h: f64) -> StepAttempt<2> {
        self.lag.prepare(h);
        let mut attempt = attempt(|stage, y| self.rate(stage, y), &[self.x, self.v], first, h);
        let [impulse, way] = self.lag.impulse(6);
        attempt.end[0] += way / self.inertia;
        attempt.end[1] += impulse / self.inertia;
        attempt.rate[1] += self.lag.left_at_end() / self.inertia;
        attempt
    }

    /// Advances the joint in motion, up to a halt at the latest. Returns the remaining time, s.
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
                match self.locate_halt(&first, [part * h, h]) {
                    Some(found) => {
                        (step, h) = found;
                        halts = true;
                    }
                    // The cubic predicted a halt that does not exist; it is more accurate in a
                    // shorter step.
                    None if h > SHORTEST_S => {
                        longest_s = (0.5 * h).max(SHORTEST_S);
                        continue;
                    }
                    None => halts = step.end[1] * self.sense <= 0.0,
                }
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

    /// Returns a step whose error is allowed, and its length of at most `longest_s`, s.
    #[inline]
    fn accepted(&mut self, first: &[f64; 2], longest_s: f64) -> (StepAttempt<2>, f64) {
        let mut h = self.pace.step_s.min(longest_s);
        loop {
            let step = self.attempt(first, h);
            match self.pace.shorter(&step.error, h, longest_s) {
                None => return (step, h),
                Some(shorter) => h = shorter,
            }
        }
    }

    /// Returns the part of a step at which the joint halts, as far as a cubic shows it.
    #[inline]
    fn first_halt(&self, first: &[f64; 2], step: &StepAttempt<2>, h: f64) -> Option<f64> {
        let begin = first[1] + self.lag.left() / self.inertia;
        let watched = |v: f64, a: f64| [self.sense * v, self.sense * a];
        // A joint that has just broken away is at its limit except for rounding, and does not halt.
        let begin = if self.v == 0.0 { self.sense * (self.sense * begin).max(0.0) } else { begin };
        first_fall(watched(self.v, begin), watched(step.end[1], step.rate[1]), h)
    }

    /// Integrates up to the halt near the time `h`; `None` if there is no halt.
    fn locate_halt(
        &mut self,
        first: &[f64; 2],
        [mut h, longest_s]: [f64; 2],
    ) -> Option<(StepAttempt<2>, f64)> {
        for _ in 0..12 {
            let mut step = self.attempt(first, h);
            let (v, a) = (self.sense * step.end[1], self.sense * step.rate[1]);
            if v.abs() <= LOCATED * self.pace.velocity || h == 0.0 {
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
    fn locate_wall(&mut self, first: &[f64; 2], h: f64, wall: f64) -> (StepAttempt<2>, f64) {
        // The motion does not reverse within the step: Newton's method inside a bracket.
        let (mut from, mut until) = (0.0, h);
        let mut time_s = (wall - self.x) / self.v;
        for _ in 0..60 {
            if !(from < time_s && time_s < until) {
                time_s = 0.5 * (from + until);
            }
            let step = self.attempt(first, time_s);
            let left = (wall - step.end[0]) * self.sense;
            if left.abs() <= LOCATED * self.pace.position {
                break;
            }
            *(if left > 0.0 { &mut from } else { &mut until }) = time_s;
            time_s += left / (step.end[1] * self.sense);
        }
        let mut step = self.attempt(first, time_s);
        step.end = [wall, 0.0];
        (step, time_s)
    }

    /// Handles the halt of the joint: it sticks, or moves in the direction of the effort.
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

    /// Advances the joint over a time (s) in which the push is constant.
    fn stretch(&mut self, duration_s: f64, on: &mut impl FnMut(EventKind, f64)) {
        let mut left_s = duration_s;
        for _ in 0..MOST_SWITCHES {
            left_s = if self.sense == 0.0 { self.rest(left_s, on) } else { self.slip(left_s, on) };
            if left_s <= 0.0 {
                return;
            }
        }
        self.unfollowed_s += left_s;
    }
}

impl Joint for RigidJoint {
    #[inline]
    fn hold_and_report(&mut self, effort: f64, duration_s: f64, on: &mut impl FnMut(Event)) {
        self.lag.set(effort);
        let is_still = self.sense == 0.0 && self.lag.left() == 0.0;
        if is_still && !self.is_busy && self.holds(effort) {
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

    fn effort_left(&self) -> f64 {
        self.lag.left()
    }

    #[inline]
    fn is_stuck(&self) -> bool {
        self.sense == 0.0
    }

    fn unfollowed_s(&self) -> f64 {
        self.unfollowed_s
    }

    fn open_winding(&mut self, viscous: f64) {
        self.surface.open_winding(viscous);
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
