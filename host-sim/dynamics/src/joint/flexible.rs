//! A flexible joint: motor and load with a shaft between them, and set-valued friction on both.
//!
//! ```text
//! J_m v_m' = u - T - F_m        J_l v_l' = T + d(t, x_l) - F_l
//! ```
//!
//! with T of [`super::shaft`]. The shaft makes the torque continuous in positions and velocities,
//! so each body sticks or slips independently. Between two switches the motion is smooth, and is
//! integrated as that of [`super::RigidJoint`]. Halts, breaks, the wall and the contacts of the
//! backlash are located by Newton's method on the integrated motion.
//!
//! Guarantees: the velocity of a stuck body is exactly zero; switches occur in order, as far as a
//! cubic on each step shows them. Limits: a stick level that grows at rest is constant within a
//! step, and levels that drift with temperature are constant within a sample.

use super::description::{Body, Description, LoadTorque, ShaftDescription as ShaftData, Stops};
use super::lag::Lag;
use super::push::Pushes;
use super::runge_kutta::{StepAttempt, attempt};
use super::shaft::{Ends, Shaft};
use super::shaft_end::ShaftEnd;
use super::step::{LOCATED, MOST_SWITCHES, Pace, SHORTEST_S, SwitchFunction, first_fall};
use super::{DiscSide, Joint, Turn};
use crate::solver::{Event, EventKind};

/// A flexible joint.
#[derive(Clone, Debug)]
pub struct FlexibleJoint {
    /// Motor and load.
    bodies: [ShaftEnd; 2],
    shaft: Shaft,
    torques: LoadTorque,
    stops: Stops,
    push: Pushes,
    push_now: f64,
    is_busy: bool,
    lag: Lag,
    pace: Pace,
    ends: Ends,
    time_s: f64,
    unfollowed_s: f64,
    /// Work of the motor's friction since the start of the sample, J.
    heat: f64,
}

const MOTOR: usize = 0;
const LOAD: usize = 1;

impl FlexibleJoint {
    /// Creates the joint at rest at its start, with the described twist of the shaft.
    pub(super) fn new(
        description: &Description,
        [motor, load]: [&Body; 2],
        shaft: &ShaftData,
    ) -> Self {
        let bodies = [motor, load].map(ShaftEnd::new);
        let is_busy = description.push.is_some() || bodies.iter().any(|side| side.surface.varies());
        let mut joint = Self {
            bodies,
            shaft: Shaft::new(shaft),
            torques: description.load,
            stops: description.stops,
            push: Pushes(description.push),
            push_now: 0.0,
            is_busy,
            lag: Lag::new(description.lag_s),
            pace: Pace::of_count(description.count),
            ends: [description.start + description.twist, 0.0, description.start, 0.0],
            time_s: 0.0,
            unfollowed_s: 0.0,
            heat: 0.0,
        };
        joint.shaft.put(&joint.ends);
        joint.settle(MOTOR);
        joint.settle(LOAD);
        joint
    }

    /// Returns the torque of load and push at a position of the load, N m.
    #[inline]
    fn load_torque(&self, x: f64) -> f64 {
        self.torques.at(x) + self.push_now
    }

    /// Returns the present torque that drives a body against its friction, N m.
    fn driving(&self, body: usize) -> f64 {
        let shaft = self.shaft.torque(&self.ends);
        if body == MOTOR { self.lag.now() - shaft } else { shaft + self.load_torque(self.ends[2]) }
    }

    /// Updates the range of the driving torque within which a body stays at rest.
    fn settle(&mut self, body: usize) {
        let x = self.ends[2 * body];
        let stick = self.bodies[body].surface.stick(x);
        let stops = if body == LOAD { self.stops } else { Stops::default() };
        self.bodies[body].range = stops.range(x, stick);
    }

    /// Returns the torque in the shaft (on the load, N m) with which both bodies rest under no
    /// effort: the middle of
    ///
    /// ```text
    /// max(0, |d| - F_l) <= |T| <= min(|d|, F_m)      T against d
    /// ```
    ///
    /// with the load's torque d and the stick friction F_l of the load and F_m of the motor. `None`
    /// if both frictions together do not hold the load; 0 if the load's friction alone holds it.
    fn torque_at_rest(&self) -> Option<f64> {
        let d = self.load_torque(self.ends[2]);
        let [motor, load] = &self.bodies;
        if load.holds(d) {
            return Some(0.0);
        }
        let holds = |range: [f64; 2]| if d > 0.0 { range[1] } else { -range[0] };
        let (least, most) =
            ((d.abs() - holds(load.range)).max(0.0), d.abs().min(holds(motor.range)));
        (least <= most).then(|| -d.signum() * 0.5 * (least + most))
    }

    /// Returns the rates of the ends at a stage of a step, without the rest of the former effort.
    #[inline]
    fn rate(&self, stage: usize, y: &Ends) -> Ends {
        let [motor, load] = &self.bodies;
        let mut ends = *y;
        let mut rates = [y[1], 0.0, y[3], 0.0];
        if motor.sense != 0.0 {
            let [impulse, way] = self.lag.impulse(stage);
            ends[0] += way / motor.inertia;
            ends[1] += impulse / motor.inertia;
        }
        let torque = self.shaft.torque(&ends);
        if motor.sense != 0.0 {
            let friction = motor.sense * motor.surface.slip(motor.sense * ends[1], ends[0]);
            rates[1] = (self.lag.target() - torque - friction) / motor.inertia;
        }
        if load.sense != 0.0 {
            let friction = load.sense * load.surface.slip(load.sense * ends[3], ends[2]);
            rates[3] = (torque + self.load_torque(ends[2]) - friction) / load.inertia;
        }
        rates
    }

    /// Computes a step of `h` (s), with the lag.
    #[inline]
    fn attempt(&mut self, first: &Ends, h: f64) -> StepAttempt<4> {
        self.lag.prepare(h);
        let mut attempt = attempt(|stage, y| self.rate(stage, y), &self.ends, first, h);
        let motor = &self.bodies[MOTOR];
        if motor.sense != 0.0 {
            let [impulse, way] = self.lag.impulse(6);
            attempt.end[0] += way / motor.inertia;
            attempt.end[1] += impulse / motor.inertia;
            attempt.rate[0] = attempt.end[1];
            attempt.rate[1] += self.lag.left_at_end() / motor.inertia;
        }
        attempt
    }

    /// Returns the switch functions, which are positive until the next switch, for ends with these
    /// rates: two for the motor, two for the load, two for the contact. `left` is the rest of the
    /// former effort, N m.
    #[inline]
    fn watched(&self, ends: &Ends, rates: &Ends, left: f64) -> [SwitchFunction; 6] {
        let [motor, load] = &self.bodies;
        let (torque, torque_rate) = (self.shaft.torque(ends), self.shaft.torque_rate(rates));
        let [a, b] = if motor.sense != 0.0 {
            motor.watched_in_motion(ends[1], rates[1], [f64::INFINITY, 0.0])
        } else {
            let effort_rate = self.lag.rate_of(left);
            motor.watched_at_rest(self.lag.target() + left - torque, effort_rate - torque_rate)
        };
        let [c, d] = if load.sense != 0.0 {
            let wall = if load.sense > 0.0 { self.stops.upper } else { self.stops.lower };
            let wall = [load.sense * (wall - ends[2]), -load.sense * rates[2]];
            load.watched_in_motion(ends[3], rates[3], wall)
        } else {
            load.watched_at_rest(torque + self.load_torque(ends[2]), torque_rate)
        };
        let [e, f] = self.shaft.watched(ends, rates);
        [a, b, c, d, e, f]
    }

    /// Returns the largest value of a switch function that counts as zero.
    fn located(&self, which: usize) -> f64 {
        let is_torque = |body: usize| self.bodies[body].sense == 0.0;
        let torque = self.shaft.stiffness * self.pace.position;
        LOCATED
            * match which {
                0 | 1 if is_torque(MOTOR) => torque,
                2 | 3 if is_torque(LOAD) => torque,
                0 | 2 => self.pace.velocity,
                4 | 5 => self.shaft.scale(which - 4, torque, self.pace.position),
                _ => self.pace.position,
            }
    }

    /// Makes one step that ends at its first switch at the latest. Returns its length, s.
    fn step(&mut self, longest_s: f64, on: &mut impl FnMut(EventKind, f64)) -> f64 {
        let first = self.rate(0, &self.ends);
        let mut begin_rates = first;
        if self.bodies[MOTOR].sense != 0.0 {
            begin_rates[1] += self.lag.left() / self.bodies[MOTOR].inertia;
        }
        let begin = self.watched(&self.ends, &begin_rates, self.lag.left());
        let mut limit_s = longest_s;
        loop {
            let (step, h) = self.accepted(&first, limit_s);
            if !step.end.iter().all(|x| x.is_finite()) {
                self.ends = step.end;
                return longest_s;
            }
            let end = self.watched(&step.end, &step.rate, self.lag.left_at_end());
            let mut switch: Option<(usize, f64)> = None;
            for which in 0..6 {
                if let Some(part) = first_fall(begin[which], end[which], h)
                    && switch.is_none_or(|(_, first)| part < first)
                {
                    switch = Some((which, part));
                }
            }
            let Some((which, part)) = switch else {
                self.arrive(&step, h);
                return h;
            };
            // A body that breaks away can halt again within the step: its first acceleration is
            // zero, and only a shorter step shows that it moves.
            let has_just_broken = self.bodies[which / 2 % 2].sense != 0.0;
            if part == 0.0 && begin[which] == [0.0; 2] && has_just_broken && h > SHORTEST_S {
                limit_s = (0.5 * h).max(SHORTEST_S);
                continue;
            }
            if let Some((step, h)) = self.locate(&first, [part * h, h], which) {
                self.arrive(&step, h);
                self.switch(which, longest_s - h, on);
                return h;
            }
            // The cubic predicted a switch that does not exist; it is more accurate in a shorter
            // step.
            if h <= SHORTEST_S {
                self.arrive(&step, h);
                return h;
            }
            limit_s = (0.5 * h).max(SHORTEST_S);
        }
    }

    #[inline]
    fn arrive(&mut self, step: &StepAttempt<4>, h: f64) {
        let motor = &self.bodies[MOTOR];
        if motor.sense != 0.0 {
            let speed = 0.5 * (self.ends[1] + step.end[1]) * motor.sense;
            let way = step.end[0] - self.ends[0];
            self.heat += (motor.surface.slip(speed, self.ends[0]) * way).abs();
        }
        self.lag.prepare(h);
        self.lag.pass();
        self.ends = step.end;
        for body in [MOTOR, LOAD] {
            if self.bodies[body].sense == 0.0 && self.bodies[body].surface.grows_at_rest() {
                self.bodies[body].surface.rest(h);
                self.settle(body);
            }
        }
    }

    /// Returns a step whose error is allowed, and its length of at most `longest_s`, s.
    #[inline]
    fn accepted(&mut self, first: &Ends, longest_s: f64) -> (StepAttempt<4>, f64) {
        let mut h = self.pace.step_s.min(longest_s);
        loop {
            let step = self.attempt(first, h);
            match self.pace.shorter(&step.error, h, longest_s) {
                None => return (step, h),
                Some(shorter) => h = shorter,
            }
        }
    }

    /// Integrates up to a switch near the time `h`; `None` if there is no switch.
    fn locate(
        &mut self,
        first: &Ends,
        [mut h, longest_s]: [f64; 2],
        which: usize,
    ) -> Option<(StepAttempt<4>, f64)> {
        let near = self.located(which);
        for _ in 0..12 {
            let step = self.attempt(first, h);
            let [left, slope] = self.watched(&step.end, &step.rate, self.lag.left_at_end())[which];
            // Where another switch was located this one may have been passed by a hair.
            if left.abs() <= near || (h == 0.0 && left <= 0.0) {
                return Some((step, h));
            }
            if slope >= 0.0 {
                return None;
            }
            h = (h - left / slope).clamp(0.0, longest_s);
        }
        None
    }

    /// Handles a switch function that has fallen to zero.
    fn switch(&mut self, which: usize, left_s: f64, on: &mut impl FnMut(EventKind, f64)) {
        let body = which / 2;
        match which {
            0..4 if self.bodies[body].sense == 0.0 => {
                self.bodies[body].sense = if which.is_multiple_of(2) { 1.0 } else { -1.0 };
                if body == MOTOR {
                    on(EventKind::Break, left_s);
                }
            }
            0..4 => {
                if which == 3 {
                    let upper = self.bodies[LOAD].sense > 0.0;
                    self.ends[2] = if upper { self.stops.upper } else { self.stops.lower };
                }
                self.halt(body, left_s, on);
            }
            _ => self.shaft.switch(which - 4),
        }
        self.release(left_s, on);
    }

    /// Handles the halt of a body: it sticks, or moves in the direction of the torque.
    fn halt(&mut self, body: usize, left_s: f64, on: &mut impl FnMut(EventKind, f64)) {
        self.ends[2 * body + 1] = 0.0;
        self.bodies[body].surface.halt();
        self.settle(body);
        let torque = self.driving(body);
        let side = &mut self.bodies[body];
        let before = std::mem::replace(
            &mut side.sense,
            if torque > side.range[1] {
                1.0
            } else if torque < side.range[0] {
                -1.0
            } else {
                0.0
            },
        );
        if body == MOTOR && side.sense != before {
            on(if side.sense == 0.0 { EventKind::Stick } else { EventKind::Reverse }, left_s);
        }
    }

    /// Starts the slip of each stuck body whose driving torque is outside the range in which the
    /// body stays at rest. Reports the motor's break to `on`, with `left_s`, the rest of the
    /// stretch, s.
    fn release(&mut self, left_s: f64, on: &mut impl FnMut(EventKind, f64)) {
        for body in [MOTOR, LOAD] {
            let torque = self.driving(body);
            let side = &mut self.bodies[body];
            if side.sense == 0.0 && !side.holds(torque) {
                side.sense = if torque > side.range[1] { 1.0 } else { -1.0 };
                if body == MOTOR {
                    on(EventKind::Break, left_s);
                }
            }
        }
    }

    /// Advances the time with both bodies at rest, up to the motor's break. Returns that time, s.
    fn rest(&mut self, longest_s: f64, on: &mut impl FnMut(EventKind, f64)) -> f64 {
        let torque = self.shaft.torque(&self.ends);
        let range = self.bodies[MOTOR].range.map(|limit| limit + torque);
        let breaks_at = self.lag.leaves(range, longest_s);
        let time_s = breaks_at.unwrap_or(longest_s);
        let rises = self.lag.left() < 0.0;
        self.lag.prepare(time_s);
        self.lag.pass();
        for body in [MOTOR, LOAD] {
            if self.bodies[body].surface.grows_at_rest() {
                self.bodies[body].surface.rest(time_s);
                self.settle(body);
            }
        }
        if breaks_at.is_some() {
            self.bodies[MOTOR].sense = if rises { 1.0 } else { -1.0 };
            on(EventKind::Break, longest_s - time_s);
        }
        time_s
    }

    /// Advances the joint over a time (s) in which the push is constant.
    fn stretch(&mut self, duration_s: f64, on: &mut impl FnMut(EventKind, f64)) {
        self.release(duration_s, on);
        let mut left_s = duration_s;
        for _ in 0..MOST_STEPS {
            left_s -= if self.is_stuck() { self.rest(left_s, on) } else { self.step(left_s, on) };
            if left_s <= 0.0 {
                return;
            }
        }
        self.unfollowed_s += left_s;
    }
}

/// Largest number of steps and switches in a sample; the rest of the sample is skipped.
const MOST_STEPS: usize = 10 * MOST_SWITCHES;

impl Joint for FlexibleJoint {
    #[inline]
    fn hold_and_report(&mut self, effort: f64, duration_s: f64, on: &mut impl FnMut(Event)) {
        self.lag.set(effort);
        if self.is_stuck() && self.lag.left() == 0.0 && !self.is_busy {
            let torque = effort - self.shaft.torque(&self.ends);
            if self.bodies[MOTOR].holds(torque) && self.bodies[LOAD].holds(self.driving(LOAD)) {
                self.time_s += duration_s;
                return;
            }
        }
        self.heat = 0.0;
        let mut passed_s = 0.0;
        while passed_s < duration_s {
            let (torque, stretch_s) = self.push.within(self.time_s, duration_s - passed_s);
            self.push_now = torque;
            let end_s = passed_s + stretch_s;
            self.stretch(stretch_s, &mut |kind, left_s| {
                on(Event { time_s: end_s - left_s, kind });
            });
            self.time_s += stretch_s;
            passed_s = end_s;
        }
        self.bodies[MOTOR].surface.warm(self.heat, duration_s);
        if self.bodies[MOTOR].surface.varies() {
            self.settle(MOTOR);
        }
    }

    #[inline]
    fn motor(&self) -> Turn {
        Turn { position: self.ends[0], velocity: self.ends[1] }
    }

    #[inline]
    fn load(&self) -> Turn {
        Turn { position: self.ends[2], velocity: self.ends[3] }
    }

    fn effort_left(&self) -> f64 {
        self.lag.left()
    }

    #[inline]
    fn is_stuck(&self) -> bool {
        self.bodies[MOTOR].sense == 0.0 && self.bodies[LOAD].sense == 0.0
    }

    fn unfollowed_s(&self) -> f64 {
        self.unfollowed_s
    }

    fn open_winding(&mut self, viscous: f64) {
        self.bodies[MOTOR].surface.open_winding(viscous);
    }

    fn set_brake(&mut self, torque: f64) {
        self.bodies[MOTOR].surface.set_brake(torque);
        self.settle(MOTOR);
    }

    fn put(&mut self, turn: Turn) {
        let x = turn.position.clamp(self.stops.lower, self.stops.upper);
        self.ends = [x, turn.velocity, x, turn.velocity];
        self.shaft.put(&self.ends);
        for body in [MOTOR, LOAD] {
            let v = turn.velocity;
            self.bodies[body].sense = if v == 0.0 { 0.0 } else { v.signum() };
            self.settle(body);
        }
    }

    fn wind_up(&mut self, seen: DiscSide) {
        if !self.is_stuck() {
            return;
        }
        // The load's torque depends on the load's final position, and changes less in each pass.
        for _ in 0..WIND_UP_PASSES {
            let Some(torque) = self.torque_at_rest().filter(|torque| *torque != 0.0) else {
                return;
            };
            let twist = self.shaft.twist_of(torque);
            match seen {
                DiscSide::Motor => self.ends[2] = self.ends[0] - twist,
                DiscSide::Load => self.ends[0] = self.ends[2] + twist,
            }
            self.shaft.put(&self.ends);
            self.settle(MOTOR);
            self.settle(LOAD);
        }
    }
}

/// Passes of [`Joint::wind_up`]. On any gear that can carry the load, the slope of the load's
/// torque over its angle is less than a tenth of the stiffness, so each pass gains a digit.
const WIND_UP_PASSES: usize = 8;
