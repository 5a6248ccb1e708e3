//! An attempt at rest, from its plan to its judgement: a step of the hold effort, or a pulse.

use super::super::pulse_planner::{Pulse, PulseMemory};
use super::{LoopGains, Mode, Supervisor, SupervisorState};
use crate::units::saturation::bounded;

/// Kind of an attempt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Kind {
    #[default]
    Pulse,
    /// A step of the hold effort.
    Step,
    /// A step that went too far, and was taken back.
    Undone,
}

/// The attempt that runs, or the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Attempt {
    /// Error e_b from which it began, deg.
    pub error: f32,
    /// Position from which it began y_f, deg.
    pub from: f32,
    /// The farthest distance towards the target, deg.
    pub peak: f32,
    /// Effort of the whole pulse, u_b included, V.
    pub output: f32,
    /// Effort A of its pulse towards the target, V.
    pub effort: f32,
    /// Ticks to wait before the attempt can be judged.
    pub wait: u16,
    /// Ticks of its pulse towards the target.
    pub ticks: u8,
    /// Ticks that are left of a pulse.
    pub left: u8,
    pub kind: Kind,
    /// Whether a reverse pulse has started.
    pub braked: bool,
}

impl Supervisor {
    /// Begins an attempt: a step of the hold effort, or a pulse.
    #[inline]
    pub(super) fn attempt(&self, s: &mut SupervisorState, error: f32) {
        let sign = if error > 0.0 { 1.0 } else { -1.0 };
        let started = Attempt { error, from: s.rest.mean, ..Attempt::default() };
        if self.hold_effort.step(&mut s.held, sign) {
            s.attempt = Attempt { kind: Kind::Step, wait: s.held.wait, ..started };
            s.rest.ticks = 0;
            s.mode = Mode::Coast;
            return;
        }
        let forward = error > 0.0;
        let PulseMemory { least, .. } = s.learned[usize::from(forward)];
        let pulse =
            self.planner.plan(s.friction[usize::from(forward)], self.distance(s, error), least);
        s.attempt = Attempt { effort: pulse.effort, ticks: pulse.ticks, ..started };
        self.fire(s, sign, pulse);
    }

    /// Returns the distance that a pulse for an error is planned for, deg.
    fn distance(&self, s: &SupervisorState, error: f32) -> f32 {
        let size = error.abs();
        let wanted = match &self.reverse {
            Some(rule) if size > rule.farthest => rule.farthest,
            _ => size,
        };
        wanted * s.learned[usize::from(error > 0.0)].gain
    }

    fn fire(&self, s: &mut SupervisorState, sign: f32, Pulse { effort, ticks }: Pulse) {
        s.attempt.output = s.held.effort + sign * effort;
        s.attempt.left = ticks;
        s.mode = Mode::Pulse;
    }

    /// PULSE: returns the effort of the pulse, and ends the pulse after its ticks.
    #[inline]
    pub(super) fn pulse(&self, s: &mut SupervisorState) -> f32 {
        s.attempt.left = s.attempt.left.saturating_sub(1);
        if s.attempt.left == 0 {
            s.mode = Mode::Coast;
            s.attempt.wait = self.patience(s)[0];
        }
        s.attempt.output
    }

    /// Returns the ticks to wait after a pulse, and the ticks of rest after which it is judged.
    #[inline]
    const fn patience(&self, s: &SupervisorState) -> [u16; 2] {
        if s.inching.active { self.inching_ticks } else { [self.coast_ticks; 2] }
    }

    /// COAST: `u = u_b - Kd x2`, and `+ Kp e` after a step, until the joint has rested and the
    /// attempt is judged.
    #[inline]
    pub(super) fn coast(
        &self,
        s: &mut SupervisorState,
        position: f32,
        error: f32,
        gains: LoopGains,
    ) -> f32 {
        let sign = if s.attempt.error > 0.0 { 1.0 } else { -1.0 };
        let wanted = s.attempt.error.abs();
        let closer =
            if s.inching.active { position - s.attempt.from } else { s.attempt.error - error };
        let moved = closer * sign;
        let mut effort = s.held.effort - gains.derivative * s.estimate.velocity;
        if s.attempt.kind == Kind::Step {
            effort += gains.proportional * error;
        }
        if moved > s.attempt.peak {
            s.attempt.peak = moved;
        }
        if let Some(rule) = &self.reverse
            && s.attempt.kind == Kind::Pulse
            && !s.attempt.braked
            && rule.is_due(moved, sign * error, sign * s.estimate.velocity)
        {
            let distance = rule.distance(s.reverse, self.distance(s, s.attempt.error));
            let against = s.friction[usize::from(s.attempt.error < 0.0)];
            let pulse = self.planner.plan(against, distance, 0.0);
            s.attempt.braked = true;
            self.fire(s, -sign, pulse);
            effort = self.pulse(s);
        }
        if s.attempt.kind == Kind::Step && moved > 2.0 * wanted + 8.0 * self.count {
            self.hold_effort.undo(&mut s.held, sign);
            s.attempt.kind = Kind::Undone;
        }
        if s.mode != Mode::Coast {
            return effort;
        }
        if s.attempt.wait > 0 {
            s.attempt.wait -= 1;
        } else if s.rest.ticks >= self.patience(s)[1] {
            let gives_up = match s.attempt.kind {
                Kind::Pulse => self.judge_pulse(s, sign, wanted, moved, sign * error),
                Kind::Step => {
                    self.hold_effort.judge(&mut s.held, wanted, moved);
                    self.give_up.step(&mut s.attempts)
                }
                Kind::Undone => false,
            };
            s.mode = if gives_up && !s.inching.active { Mode::GiveUp } else { Mode::Stuck };
            s.rest.ticks = self.rest_ticks;
        }
        effort
    }

    /// Learns from a pulse after which the joint has come to rest. `moved` is its travel towards
    /// the target, and `ahead` the remaining distance, deg. Returns whether it is time to give up.
    fn judge_pulse(
        &self,
        s: &mut SupervisorState,
        sign: f32,
        wanted: f32,
        moved: f32,
        ahead: f32,
    ) -> bool {
        let peak = s.attempt.peak;
        if let Some(rule) = &self.reverse
            && s.attempt.braked
        {
            rule.learn(&mut s.reverse, wanted, moved, ahead);
        }
        if !self.hold_effort.sprang_back(&mut s.held, wanted, moved, peak) {
            let learned = &mut s.learned[usize::from(sign > 0.0)];
            let exhausted = learned.least >= self.limit;
            self.planner.learn(learned, wanted, moved, peak);
            if let Some(rule) = &self.reverse {
                if peak >= 0.5 * self.count {
                    if rule.is_beyond(ahead) {
                        s.held.effort *= 0.5;
                    }
                } else if exhausted {
                    // The whole effort does not move the load: wind the transmission up, and start
                    // again with six tenths of the effort.
                    let stepped = s.held.effort + sign * s.held.step;
                    s.held.effort = bounded(stepped, self.hold_effort.most);
                    learned.least = 0.6 * self.limit;
                    learned.gain *= 0.5;
                }
            }
        }
        self.give_up.pulse(&mut s.attempts, [s.attempt.effort, peak], s.attempt.ticks)
    }
}
