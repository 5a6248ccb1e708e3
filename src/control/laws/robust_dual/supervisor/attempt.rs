//! An attempt at rest, from its plan to its judgement: a bump of the motor where the gear is soft,
//! else a step of the hold effort or a pulse.

use super::super::bump_memory::Outcome;
use super::super::motor_bump::{BumpState, MotorSeen, Wanted};
use super::super::push::Pushed;
use super::{LOAD, LoopGains, MOTOR, Mode, Seen, Supervisor, SupervisorState};
use crate::units::saturation::bounded;

/// Kind of an attempt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Kind {
    #[default]
    Pulse,
    /// A step of the hold effort.
    Step,
    /// A step that went too far, and was taken back.
    Undone,
    /// A bump of the motor.
    Bump,
    /// A slow push, after attempts that did not move the load.
    Push,
}

/// The attempt that runs, or the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Attempt {
    /// Error e_b from which it began, deg.
    pub error: f32,
    /// The farthest distance towards the target, deg.
    peak: f32,
    /// Effort of the whole pulse, u_b included, V.
    output: f32,
    /// Ticks to wait before the attempt can be judged.
    wait: u16,
    /// Ticks that are left of a pulse.
    left: u8,
    kind: Kind,
}

impl Attempt {
    /// Returns whether the motor is moved back after the attempt.
    pub fn is_bump(&self) -> bool {
        matches!(self.kind, Kind::Bump | Kind::Push)
    }
}

impl Supervisor {
    /// Begins an attempt.
    #[inline]
    pub(super) fn attempt(&self, s: &mut SupervisorState, seen: &Seen, error: f32, is_soft: bool) {
        let sign = if error > 0.0 { 1.0 } else { -1.0 };
        let started = Attempt { error, ..Attempt::default() };
        if s.push.is_due() && self.gives_up {
            s.push.begin();
            s.bump.from = [seen.motor, s.rest[LOAD].mean];
            s.attempt = Attempt { kind: Kind::Push, ..started };
            s.mode = Mode::Pulse;
        } else if is_soft {
            self.begin_bump(s, seen, error);
            s.attempt = Attempt { kind: Kind::Bump, ..started };
            s.mode = Mode::Bump;
        } else if self.hold_effort.step(&mut s.held, sign) {
            s.attempt = Attempt { kind: Kind::Step, wait: s.held.wait, ..started };
            s.rest[MOTOR].ticks = 0;
            s.mode = Mode::Coast;
        } else {
            let forward = usize::from(error > 0.0);
            s.memory.pulses = s.memory.pulses.saturating_sub(1);
            let distance = error.abs() * s.learned[forward].gain;
            let pulse = self.planner.plan(s.friction[forward], distance, s.learned[forward].least);
            s.attempt = Attempt {
                output: s.held.effort + sign * pulse.effort,
                left: pulse.ticks,
                ..started
            };
            s.mode = Mode::Pulse;
        }
    }

    /// Plans a bump: its peak by what was learned from earlier bumps, its end beyond the neutral
    /// twist at the target.
    fn begin_bump(&self, s: &mut SupervisorState, seen: &Seen, error: f32) {
        let sign = if error > 0.0 { 1.0 } else { -1.0 };
        let forward = usize::from(error > 0.0);
        let half_width = s.levels.half_width();
        let load = s.rest[LOAD].mean;
        let travel = self.memory.travel(&s.memory, error);
        let peak = self.memory.peak(&mut s.memory, &s.levels, sign, travel);
        let way = (sign * (peak - (seen.motor - load))).max(2.0 * self.bump.motor_count);
        let end = seen.reference + s.levels.neutral + sign * s.memory.overshoot * half_width;
        let wanted = Wanted {
            from: [seen.motor, load],
            way: sign * way,
            end: seen.motor + bounded(end - seen.motor, half_width),
            gain: s.memory.learned[forward].gain,
            friction: s.friction[forward],
        };
        s.bump = self.bump.plan(&wanted, &s.memory.motor);
    }

    /// PULSE: returns the effort of the pulse, and ends the pulse after its ticks; or runs a push.
    #[inline]
    pub(super) fn pulse(&self, s: &mut SupervisorState, seen: &MotorSeen, load: f32) -> f32 {
        if s.attempt.kind == Kind::Push {
            return self.push(s, seen, load);
        }
        s.attempt.left = s.attempt.left.saturating_sub(1);
        if s.attempt.left == 0 {
            s.mode = Mode::Coast;
            s.attempt.wait = self.coast_ticks;
        }
        s.attempt.output
    }

    /// Runs a tick of a push: returns its effort until the load moves. If the load does not move,
    /// something is in the way, and the law gives up.
    fn push(&self, s: &mut SupervisorState, seen: &MotorSeen, load: f32) -> f32 {
        let sign = if s.attempt.error > 0.0 { 1.0 } else { -1.0 };
        let [_, rested] = s.bump.from;
        match self.push.update(&mut s.push, sign * (load - rested)) {
            Pushed::On(effort) => s.held.effort + sign * effort,
            Pushed::Moved => {
                let end = load + s.levels.neutral;
                s.bump = BumpState::led_back(s.bump.from, sign, end);
                s.mode = Mode::Coast;
                s.attempt.wait = self.coast_ticks;
                self.hold_after_bump(s, seen)
            }
            Pushed::Blocked => {
                s.mode = Mode::GiveUp;
                bounded(s.held.effort, self.hold_effort.most)
            }
        }
    }

    /// BUMP: returns the effort that moves the motor along its path.
    #[inline]
    pub(super) fn bump(&self, s: &mut SupervisorState, seen: &MotorSeen) -> f32 {
        let friction = s.friction[usize::from(s.attempt.error > 0.0)];
        let (effort, is_over) = self.bump.update(&mut s.bump, &s.memory.motor, seen, friction);
        if is_over {
            s.mode = Mode::Coast;
            s.attempt.wait = self.coast_ticks;
        }
        self.load_held(s) + effort
    }

    /// Returns the effort that holds a configured load, V. Without a load, a bump begins at the
    /// neutral twist, where the gear needs no effort.
    const fn load_held(&self, s: &SupervisorState) -> f32 {
        if self.load_rule.acts { s.held.effort } else { 0.0 }
    }

    /// COAST: `u = u_b - Kd x2` (`+ Kp e` after a step), or the motor held after a bump, until both
    /// sides have rested and the attempt is judged.
    #[inline]
    pub(super) fn coast(
        &self,
        s: &mut SupervisorState,
        seen: &MotorSeen,
        error: f32,
        gains: LoopGains,
    ) -> f32 {
        let sign = if s.attempt.error > 0.0 { 1.0 } else { -1.0 };
        let wanted = s.attempt.error.abs();
        let moved = (s.attempt.error - error) * sign;
        let effort = if s.attempt.is_bump() {
            self.hold_after_bump(s, seen)
        } else {
            let step = if s.attempt.kind == Kind::Step { gains.proportional * error } else { 0.0 };
            s.held.effort - gains.derivative * s.estimate.velocity + step
        };
        s.attempt.peak = s.attempt.peak.max(moved);
        if s.attempt.kind == Kind::Step && moved > 2.0 * wanted + 8.0 * self.count {
            self.hold_effort.undo(&mut s.held, sign);
            s.attempt.kind = Kind::Undone;
        }
        if s.attempt.wait > 0 {
            s.attempt.wait -= 1;
        } else if s.rest.iter().all(|rest| rest.ticks >= self.coast_ticks) {
            let gives_up = self.judge(s, sign, wanted, moved) | self.accepts(s, error.abs());
            s.mode = if gives_up { Mode::GiveUp } else { Mode::Stuck };
            s.rest[MOTOR].ticks = s.rest[MOTOR].ticks.max(self.rest_ticks);
        }
        effort
    }

    fn hold_after_bump(&self, s: &mut SupervisorState, seen: &MotorSeen) -> f32 {
        let rest = &s.rest[LOAD];
        let rested_at = (rest.ticks >= self.rest_ticks).then_some(rest.mean);
        let motor = &s.memory.motor;
        let (effort, waits) = self.bump.hold(&mut s.bump, motor, seen, rested_at, s.levels.neutral);
        if waits && s.attempt.wait < 3 && s.bump.count_led_tick() {
            s.attempt.wait = 3;
        }
        self.load_held(s) + effort
    }

    /// Returns whether a joint that swings around its target is left where it rests. After
    /// `patience` attempts, that is a rest whose error is at most the smallest one so far. Each
    /// further attempt raises that limit by a tenth.
    fn accepts(&self, s: &mut SupervisorState, error: f32) -> bool {
        if s.attempts.all <= 1 {
            s.accepted = error;
        }
        let is_over = self.gives_up && s.attempts.all > self.patience;
        // Within the stop band a HOLD follows.
        let is_accepted = is_over && error <= s.accepted && error > self.stop_band;
        s.accepted = s.accepted.min(error) * if is_over { 1.1 } else { 1.0 };
        is_accepted
    }

    /// Learns from an attempt after which both sides rest. Returns whether it is time to give up.
    fn judge(&self, s: &mut SupervisorState, sign: f32, wanted: f32, moved: f32) -> bool {
        let peak = s.attempt.peak;
        // A step waits for a load that is held by the gear, and is no evidence of a wall.
        let travel = if s.attempt.kind == Kind::Step { f32::INFINITY } else { peak };
        self.push.judge(&mut s.push, travel);
        match s.attempt.kind {
            Kind::Bump => {
                let half_width = s.levels.half_width();
                let outcome = Outcome { sign, moved, peak, half_width };
                let SupervisorState { memory, levels, bump, .. } = s;
                self.memory.learn(memory, levels, bump, &outcome, self.sample_time);
                self.give_up.step(&mut s.attempts)
            }
            Kind::Step => {
                self.hold_effort.judge(&mut s.held, wanted, moved);
                self.give_up.step(&mut s.attempts)
            }
            Kind::Undone | Kind::Push => false,
            Kind::Pulse => {
                if !self.hold_effort.sprang_back(&mut s.held, wanted, moved, peak) {
                    let learned = &mut s.learned[usize::from(sign > 0.0)];
                    self.planner.learn(learned, wanted, moved, peak);
                    self.memory.pulse(&mut s.memory, peak < 0.5 * self.count);
                }
                self.give_up.step(&mut s.attempts)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::super::Loop;
    use super::super::super::RobustDualGains;
    use super::*;
    use crate::units::value::Table;

    /// Returns the attempt at which a joint is left at rest whose errors are 50 counts to either
    /// side, and once 5.
    fn left_after(attempts: u32) -> Option<u16> {
        let gains = RobustDualGains { attempts, ..RobustDualGains::EXAMPLE };
        let around = Loop {
            sample_time: 0.001,
            resolution: 0.01,
            full_scale: 5.0,
            lsb: 0.001,
            kp: 0.0,
            motor: crate::control::motor_encoder::MotorEncoder::NONE,
        };
        let law = Supervisor::new(&gains, &around);
        let mut state = SupervisorState::default();
        law.start(&mut state);
        (1..1000).find(|number| {
            state.attempts.all = *number;
            law.accepts(&mut state, if *number == 7 { 0.05 } else { 0.5 })
        })
    }

    /// From attempt 101 on the accepted error grows from 5 counts by a tenth an attempt: it exceeds
    /// 50 after `ln 10 / ln 1.1`, 24.2 attempts.
    #[test]
    fn joint_that_swings_about_its_target_is_left_close_to_it() {
        assert_eq!(left_after(50), Some(126));
        assert_eq!(left_after(20), Some(66));
        assert_eq!(left_after(0), None);
    }

    /// Also while the law looks for a lost joint, in MOVE.
    #[test]
    fn new_command_clears_the_attempts_of_the_last_one() {
        for mode in [Mode::GiveUp, Mode::Move] {
            let mut state = SupervisorState { mode, ..SupervisorState::default() };
            state.attempts.all = 101;
            state.try_again();
            assert_eq!((state.attempts.all, state.mode), (0, Mode::Move));
        }
    }
}
