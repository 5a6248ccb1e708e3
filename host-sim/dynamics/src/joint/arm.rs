//! The two-link manipulator of the thesis's Chapter 2 as a geared arm: the links and their gravity
//! of [`TwoLinkArm`], the rotors behind their gears, and set-valued friction on both joints.
//!
//! ```text
//! (M(q) + diag(N_i^2 J_i)) q'' = u - c(q, q') - g(q) - F(q')
//! ```
//!
//! A rotor turns N times as fast as its joint. The effect of one joint's motion on the other's
//! rotor is 1/N of that on the link, and is neglected (Spong, ASME J. Dynamic Systems 109, 1987).
//! The remaining coupling is the kick-back of the thesis's section 2.2.2.2: an accelerating joint
//! pushes the other one, and can break it away.
//!
//! Which joints stick is decided for both at once ([`crate::solver::modes`]); between two switches
//! the motion is integrated as that of [`super::RigidJoint`]. Guarantees: the velocity of a stuck
//! joint is exactly zero; no assumption on the other joint's acceleration. Limits: efforts have no
//! lag; a stuck joint whose reaction exceeds its limit and returns within a step stays stuck.

use super::Turn;
use super::description::StribeckCurve;
use super::runge_kutta::{StepAttempt, attempt};
use super::step::{LOCATED, MOST_SWITCHES, Pace, SHORTEST_S, first_fall};
use super::surface::Surface;
use crate::friction::SetValued;
use crate::mechanism::{Mechanism, Terms, TwoLinkArm};
use crate::refused::{InvalidModel, shown};
use crate::solver::modes::{BodyMode, accelerations, decide};

/// Description of a geared arm. Arrays have one entry per joint, from the base on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmDescription {
    /// Weights at the ends of the links, kg.
    pub mass: [f64; 2],
    /// Lengths of the links, m.
    pub length: [f64; 2],
    /// Inertias of the rotors at their joints, N^2 J, kg m^2.
    pub rotor: [f64; 2],
    /// Frictions at the joints.
    pub friction: [StribeckCurve; 2],
    /// Angles at the start, rad; at zero the arm hangs down, the second is relative to the first.
    pub start: [f64; 2],
    /// Angle of one count, rad.
    pub count: f64,
}

impl ArmDescription {
    /// Returns the largest torque of gravity on each joint, N m.
    pub fn gravity(&self) -> [f64; 2] {
        let ([m1, m2], [l1, l2]) = (self.mass, self.length);
        let outer = m2 * l2;
        [(m1 + m2) * l1 + outer, outer].map(|moment| moment * crate::mechanism::GRAVITY)
    }

    /// Makes the arm, at rest at its start.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn build(&self) -> Result<GearedArm, InvalidModel> {
        let refuse = |what: &str, found: f64, allowed: &str| {
            let found = shown(found);
            Err(InvalidModel(format!("arm: the {what} is {found}; it must be {allowed}")))
        };
        for i in 0..2 {
            for (what, value) in [
                ("mass", self.mass[i]),
                ("length", self.length[i]),
                ("rotor's inertia", self.rotor[i]),
                ("angle of a count", self.count),
            ] {
                if !(value > 0.0 && value.is_finite()) {
                    return refuse(what, value, "a number above zero");
                }
            }
            let StribeckCurve { coulomb, stick, stribeck_velocity, viscous } = self.friction[i];
            for (what, value) in [
                ("slip level", coulomb),
                ("stick level above the slip level", stick - coulomb),
                ("Stribeck velocity", stribeck_velocity),
                ("viscous friction", viscous),
            ] {
                if !(value >= 0.0 && value.is_finite()) {
                    return refuse(what, value, "zero or a number above it");
                }
            }
            if !self.start[i].is_finite() {
                return refuse("start", self.start[i], "a finite number");
            }
        }
        Ok(GearedArm {
            links: TwoLinkArm {
                mass: self.mass,
                length: self.length,
                torque: [0.0; 2],
                start: self.start,
            },
            rotor: self.rotor,
            surfaces: self.friction.map(|curve| Surface::new(&curve.into())),
            pace: Pace::of_count(self.count),
            state: [self.start[0], 0.0, self.start[1], 0.0],
            mode: [0; 2],
            unfollowed_s: 0.0,
            is_coupled: true,
        })
    }
}

/// Geared arm with two links.
#[derive(Clone, Debug)]
pub struct GearedArm {
    links: TwoLinkArm,
    rotor: [f64; 2],
    surfaces: [Surface; 2],
    pace: Pace,
    state: State,
    mode: BodyMode<2>,
    unfollowed_s: f64,
    is_coupled: bool,
}

/// Position and velocity of the first joint, then of the second; or their rates.
type State = [f64; 4];

/// Largest number of steps and switches in a sample; the rest of the sample is skipped.
const MOST_STEPS: usize = 10 * MOST_SWITCHES;

/// Friction of a joint at a position (rad).
struct Here<'a>(&'a Surface, f64);

impl SetValued for Here<'_> {
    #[inline]
    fn stick(&self) -> f64 {
        self.0.stick(self.1)
    }

    #[inline]
    fn slip(&self, speed: f64) -> f64 {
        self.0.slip(speed, self.1)
    }
}

impl GearedArm {
    /// Returns the arm without coupling between the motions of its joints: no kick-back, no
    /// centrifugal and no Coriolis force. Inertia and gravity still depend on the pose. This arm is
    /// for comparison.
    #[must_use]
    pub fn without_coupling(self) -> Self {
        Self { is_coupled: false, ..self }
    }

    /// Moves the arm for a time (s) under held efforts (N m, at the joints).
    #[inline]
    pub fn hold(&mut self, efforts: [f64; 2], duration_s: f64) {
        let is_same = efforts == self.links.torque;
        self.links.torque = efforts;
        if self.is_stuck() && is_same {
            return;
        }
        self.decide([0; 2]);
        let mut left_s = duration_s;
        for _ in 0..MOST_STEPS {
            if self.is_stuck() || !self.state.iter().all(|x| x.is_finite()) {
                return;
            }
            left_s -= self.step(left_s);
            if left_s <= 0.0 {
                return;
            }
        }
        self.unfollowed_s += left_s;
    }

    /// Returns the simulated time (s) that was skipped because the switches of a step did not end,
    /// as [`super::Joint::unfollowed_s`]. A motion with such a time is invalid.
    pub const fn unfollowed_s(&self) -> f64 {
        self.unfollowed_s
    }

    /// Returns angle and speed of a joint, 0 or 1.
    #[inline]
    pub const fn turn(&self, joint: usize) -> Turn {
        Turn { position: self.state[2 * joint], velocity: self.state[2 * joint + 1] }
    }

    /// Returns whether both joints are at rest.
    #[inline]
    pub fn is_stuck(&self) -> bool {
        self.mode == [0; 2]
    }

    /// Returns whether a joint is at rest.
    #[inline]
    pub const fn is_joint_stuck(&self, joint: usize) -> bool {
        self.mode[joint] == 0
    }

    #[inline]
    fn terms(&self, state: &State) -> Terms<2> {
        let speeds = if self.is_coupled { [state[1], state[3]] } else { [0.0; 2] };
        let mut terms = self.links.terms(0.0, &[state[0], state[2]], &speeds);
        if !self.is_coupled {
            (terms.mass[0][1], terms.mass[1][0]) = (0.0, 0.0);
        }
        for i in 0..2 {
            terms.mass[i][i] += self.rotor[i];
        }
        terms
    }

    /// Returns the accelerations and the frictions of both joints.
    #[inline]
    fn instant(&self, state: &State) -> ([f64; 2], [f64; 2]) {
        let friction = [0, 1].map(|i| Here(&self.surfaces[i], state[2 * i]));
        accelerations(&self.terms(state), &friction, &[state[1], state[3]], &self.mode)
    }

    #[inline]
    fn rate(&self, state: &State) -> State {
        let ([a, b], _) = self.instant(state);
        [state[1], a, state[3], b]
    }

    /// Returns a value that is positive while a joint stays in its mode: in motion its speed, at
    /// rest its stick level minus its friction.
    #[inline]
    fn left(&self, joint: usize, state: &State) -> f64 {
        let (position, velocity) = (state[2 * joint], state[2 * joint + 1]);
        if self.mode[joint] == 0 {
            self.surfaces[joint].stick(position) - self.instant(state).1[joint].abs()
        } else {
            f64::from(self.mode[joint]) * velocity
        }
    }

    /// Makes one step that ends at its first switch at the latest. Returns its length, s.
    fn step(&mut self, longest_s: f64) -> f64 {
        let first = self.rate(&self.state);
        let mut limit_s = longest_s;
        loop {
            let (step, h) = self.accepted(&first, limit_s);
            let Some((joint, part)) = self.first_switch(&first, &step, h) else {
                self.state = step.end;
                return h;
            };
            // A joint that breaks away can halt again within the step: its first acceleration is
            // zero, and only a shorter step shows that it moves.
            let has_just_broken = self.mode[joint] != 0 && self.left(joint, &self.state) == 0.0;
            if part == 0.0 && has_just_broken && h > SHORTEST_S {
                limit_s = (0.5 * h).max(SHORTEST_S);
                continue;
            }
            let Some(time_s) = self.locate(&first, joint, [part * h, h]) else {
                self.state = step.end;
                return h;
            };
            let step = self.attempt(&first, time_s);
            self.state = step.end;
            self.switch(joint, &step.rate);
            return time_s;
        }
    }

    /// Returns a step whose error is allowed, and its length of at most `longest_s`, s.
    #[inline]
    fn accepted(&mut self, first: &State, longest_s: f64) -> (StepAttempt<4>, f64) {
        let mut h = self.pace.step_s.min(longest_s);
        loop {
            let step = self.attempt(first, h);
            match self.pace.shorter(&step.error, h, longest_s) {
                None => return (step, h),
                Some(shorter) => h = shorter,
            }
        }
    }

    /// Returns the joint that leaves its mode first in a step of `h` (s), and the part of the step
    /// at which it does.
    #[inline]
    fn first_switch(&self, first: &State, step: &StepAttempt<4>, h: f64) -> Option<(usize, f64)> {
        let mut switch: Option<(usize, f64)> = None;
        for joint in 0..2 {
            let (begin, end) = (self.left(joint, &self.state), self.left(joint, &step.end));
            let sense = f64::from(self.mode[joint]);
            let slopes = if sense == 0.0 {
                [(end - begin) / h; 2]
            } else {
                [*first, step.rate].map(|rate| sense * rate[2 * joint + 1])
            };
            // A joint that has just broken away is at its limit except for rounding: it does not
            // halt.
            let begin_slope =
                if sense != 0.0 && begin == 0.0 { slopes[0].max(0.0) } else { slopes[0] };
            if let Some(part) = first_fall([begin, begin_slope], [end, slopes[1]], h)
                && switch.is_none_or(|(_, first)| part < first)
            {
                switch = Some((joint, part));
            }
        }
        switch
    }

    #[inline]
    fn attempt(&self, first: &State, h: f64) -> StepAttempt<4> {
        attempt(|_, state| self.rate(state), &self.state, first, h)
    }

    /// Returns the time near `near_s` (s) at which the value `left` of a joint falls to zero within
    /// a step of `h` (s); `None` if it does not.
    fn locate(&self, first: &State, joint: usize, [near_s, h]: [f64; 2]) -> Option<f64> {
        let left = |time_s: f64| self.left(joint, &self.attempt(first, time_s).end);
        let allowed = LOCATED
            * if self.mode[joint] == 0 {
                self.pace.velocity * self.rotor[joint]
            } else {
                self.pace.velocity
            };
        if near_s == 0.0 {
            return Some(0.0);
        }
        let mut from = [0.0, left(0.0)];
        if from[1] <= allowed {
            // A joint that has just broken away is fastest about halfway to its halt.
            from = [0.5 * near_s, left(0.5 * near_s)];
            if from[1] <= allowed {
                return Some(near_s);
            }
        }
        let mut until = [near_s, left(near_s)];
        if until[1] > allowed {
            (from, until) = (until, [h, left(h)]);
            if until[1] > 0.0 {
                return None;
            }
        }
        // Illinois variant of the regula falsi: it keeps its bracket.
        for _ in 0..60 {
            if until[1].abs() <= allowed {
                break;
            }
            let time_s = (from[0] * until[1] - until[0] * from[1]) / (until[1] - from[1]);
            let value = left(time_s);
            if value > 0.0 && value > allowed {
                from = [time_s, value];
                until[1] *= 0.5;
            } else {
                until = [time_s, value];
                from[1] *= 0.5;
            }
        }
        Some(until[0])
    }

    /// Handles a joint that has halted or reached its stick level.
    fn switch(&mut self, joint: usize, rate: &State) {
        let mut breaking: BodyMode<2> = [0; 2];
        if self.mode[joint] == 0 {
            let reaction = self.instant(&self.state).1[joint];
            breaking[joint] = if reaction > 0.0 { 1 } else { -1 };
        } else {
            self.state[2 * joint + 1] = 0.0;
        }
        // The other joint can halt at the same instant.
        let other = 1 - joint;
        let ahead = f64::from(self.mode[other]);
        let [v, a] = [self.state[2 * other + 1], rate[2 * other + 1]];
        if self.mode[other] != 0 && ahead * v <= LOCATED * self.pace.velocity && ahead * a < 0.0 {
            self.state[2 * other + 1] = 0.0;
        }
        self.decide(breaking);
    }

    /// Decides which of the joints at rest stick.
    fn decide(&mut self, breaking: BodyMode<2>) {
        let friction = [0, 1].map(|i| Here(&self.surfaces[i], self.state[2 * i]));
        let v = [self.state[1], self.state[3]];
        let terms = self.terms(&self.state);
        // Only rounding can leave a joint that reached its limit without a mode: it may stick then.
        if let Some(mode) = decide(&terms, &friction, &v, &breaking)
            .or_else(|| decide(&terms, &friction, &v, &[0; 2]))
        {
            self.mode = mode;
        }
    }
}
