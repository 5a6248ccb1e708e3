//! The supervisor: it selects the part that acts, and computes the gains of a tick.
//!
//! Positions are angles from an origin that the law moves; efforts are V. The unit of the angles is
//! deg, and no equation here depends on it.

mod attempt;

use super::extended_state_observer::{ExtendedStateObserver, ObserverState};
use super::give_up::{Attempts, GiveUp};
use super::hold_effort::{Held, HoldEffort};
use super::inching::{Change, Following, Inching, InchingState};
use super::load_rule::LoadRule;
use super::oscillation_guard::{LEAST_IN_MOTION, OscillationGuard, SwingState};
use super::parameters::{RobustGains, Rules, SLOW};
use super::pulse_planner::{PulseMemory, PulsePlanner};
use super::rest_detector::{Rest, RestDetector};
use super::reverse_pulse::ReversePulse;
use super::sliding_friction::SlidingFriction;
use crate::control::laws::Loop;
use crate::control::profile::bounded_acceleration::{BoundedAcceleration, LimitedReference};
use crate::units::saturation::bounded;
use attempt::Attempt;

/// State of the supervisor, as its signal reports it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// The profile moves, or the joint has not come to rest after it.
    #[default]
    Move = 0,
    /// The joint rests, and the next attempt or HOLD is decided.
    Stuck = 1,
    /// A pulse is on.
    Pulse = 2,
    /// The pulse or step is over, and the joint comes to rest.
    Coast = 3,
    /// The effort is latched within the stop band.
    Hold = 4,
    /// The attempts have ended without success.
    GiveUp = 5,
}

/// The state from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SupervisorState {
    pub profile: LimitedReference,
    pub rest: Rest,
    pub estimate: ObserverState,
    pub guarded: SwingState,
    pub held: Held,
    /// Sliding friction R_i, V, and memory of the pulses: backwards and forwards.
    pub friction: [f32; 2],
    learned: [PulseMemory; 2],
    /// Gain of reverse pulses kb.
    reverse: f32,
    attempt: Attempt,
    /// Effort u_hold that a HOLD keeps, V.
    latched: f32,
    /// Effort w that the motion needs beyond the model, V.
    needed: f32,
    /// Sign of the profile's speed in the last tick of MOVE.
    direction: f32,
    /// Distance from the profile to the set point, deg.
    pub to_go: f32,
    pub inching: InchingState,
    /// Ticks beyond the stop band in a HOLD.
    outside: u16,
    pub attempts: Attempts,
    pub mode: Mode,
    /// Whether the joint has been within the stop band since the last attempt.
    inside: bool,
}

/// Inputs of one tick; positions are in deg from the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub position: f32,
    pub reference: f32,
    pub velocity: f32,
    /// Effort that the joint had since the last tick, V.
    pub applied: f32,
}

/// The gains of a tick: those of the whole bandwidth, lowered by the guard.
#[derive(Clone, Copy)]
struct LoopGains {
    guard: f32,
    proportional: f32,
    derivative: f32,
}

/// The supervisor, prepared for a joint and a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Supervisor {
    proportional: f32,
    derivative: f32,
    /// Inertia J, V s^2/deg.
    inertia: f32,
    /// 1 / J.
    per_inertia: f32,
    /// Viscous friction B, V s/deg.
    viscous: f32,
    limit: f32,
    /// Angle q of one count, deg.
    count: f32,
    /// 1 / (8 q), 1/deg.
    per_eight: f32,
    /// Largest error at rest that is left alone, deg.
    stop_band: f32,
    /// Error beyond which a HOLD is left at once, deg.
    far_band: f32,
    profile: BoundedAcceleration,
    rest: RestDetector,
    observer: ExtendedStateObserver,
    /// The observer in motion, and while the joint swings out after an attempt.
    observer_in_motion: ExtendedStateObserver,
    /// The observer while the set point moves; none with the encoder on the load.
    observer_tracking: Option<ExtendedStateObserver>,
    inching: Inching,
    friction: SlidingFriction,
    guard: OscillationGuard,
    planner: PulsePlanner,
    hold_effort: HoldEffort,
    /// Rule of the reverse pulse, which brakes a load that has broken away. None if the encoder is
    /// on the motor.
    reverse: Option<ReversePulse>,
    load_rule: LoadRule,
    give_up: GiveUp,
    /// Multiple of an attempt's error beyond which the joint is lost.
    lost: f32,
    /// The configured hold effort, V.
    configured_hold: f32,
    /// N_z, N_c, N_h and N_r, ticks.
    rest_ticks: u16,
    coast_ticks: u16,
    /// Ticks to wait and ticks of rest after an attempt of inching.
    inching_ticks: [u16; 2],
    hold_ticks: u16,
    leave_ticks: u16,
}

impl SupervisorState {
    /// Leaves GIVE_UP for MOVE, and clears the counts of attempts.
    pub fn try_again(&mut self) {
        if self.mode == Mode::GiveUp {
            self.mode = Mode::Move;
            self.attempts = Attempts::default();
        }
    }
}

impl Supervisor {
    pub fn new(gains: &RobustGains, around: &Loop) -> Self {
        let rules = Rules::new(gains, around);
        let Loop { sample_time, resolution: count, full_scale: limit, lsb, .. } = *around;
        let RobustGains { inertia, viscous, .. } = *gains;
        let range = [gains.breakaway_low, gains.breakaway_high];
        let friction = SlidingFriction::new(sample_time, range, rules.learned_to, count);
        let most_held = 0.8 * gains.breakaway_high + gains.load;
        let most_disturbance = 1.5 * gains.breakaway_high + gains.load;
        let Rules { bandwidth, on_load, .. } = rules;
        let observer = |bandwidth: f32| {
            ExtendedStateObserver::new(sample_time, [inertia, viscous], bandwidth, most_disturbance)
        };
        Self {
            proportional: inertia * bandwidth * bandwidth,
            derivative: (2.0 * gains.damping * inertia * bandwidth - viscous).max(0.0),
            inertia,
            per_inertia: 1.0 / inertia,
            viscous,
            limit,
            count,
            per_eight: 1.0 / (8.0 * count),
            stop_band: gains.stop_band * count,
            far_band: (gains.stop_band + 2.25) * count,
            profile: BoundedAcceleration::new(rules.speed, rules.acceleration, sample_time),
            rest: RestDetector::new(gains.jitter, count),
            observer: observer(rules.observer),
            observer_in_motion: observer(rules.observer_in_motion),
            observer_tracking: (!on_load).then(|| observer(rules.observer_tracking)),
            inching: Inching::new([sample_time, count], sample_time > SLOW, on_load),
            friction,
            guard: OscillationGuard::new(
                rules.guard,
                rules.least_gain,
                gains.jitter,
                sample_time,
                count,
                rules.wide_swing,
            ),
            planner: PulsePlanner::new(sample_time, inertia, range, limit, count),
            hold_effort: HoldEffort::new(
                [rules.hold_step, lsb],
                range,
                most_held,
                count,
                [rules.first_wait, rules.longest_wait],
            ),
            reverse: on_load
                .then(|| ReversePulse::new(inertia, friction.first, sample_time, count)),
            load_rule: LoadRule::new(gains.load, friction.first, most_held, sample_time),
            give_up: GiveUp::new(
                gains.attempts,
                most_disturbance.min(limit),
                on_load,
                [count, sample_time],
            ),
            lost: if gains.load > 0.0 { 1.0 } else { 3.0 },
            configured_hold: gains.hold_effort,
            rest_ticks: rules.rest,
            coast_ticks: rules.coast,
            inching_ticks: rules.inching,
            hold_ticks: rules.hold,
            leave_ticks: rules.leave,
        }
    }

    /// Resets the state, for a joint at rest at the origin.
    pub fn start(&self, state: &mut SupervisorState) {
        let gain = if self.reverse.is_some() { 0.5 } else { 1.0 };
        *state = SupervisorState {
            guarded: self.guard.start(),
            held: self.hold_effort.start(self.configured_hold),
            friction: [self.friction.first; 2],
            learned: [PulseMemory { gain, least: self.planner.least }; 2],
            reverse: 1.0,
            ..SupervisorState::default()
        };
    }

    /// Returns whether the joint rests.
    pub fn rests(&self, state: &SupervisorState) -> bool {
        state.rest.ticks >= self.rest_ticks
    }

    /// Moves the origin by a distance, deg.
    pub fn rebase(&self, state: &mut SupervisorState, by: f32) {
        state.profile.position -= by;
        state.rest.anchor -= by;
        state.rest.mean -= by;
        state.estimate.position -= by;
        state.guarded.extreme -= by;
        state.attempt.from -= by;
    }

    /// Runs a tick, and returns the effort, V.
    #[inline]
    pub fn update(&self, s: &mut SupervisorState, seen: &Seen) -> f32 {
        let Seen { position, reference, velocity, applied } = *seen;
        self.rest.update(&mut s.rest, position);
        self.observer_of(s, velocity).update(&mut s.estimate, applied, position);
        let awaited = !matches!(s.mode, Mode::Move | Mode::Pulse);
        if awaited
            && (reference - position).abs() > self.lost * s.attempt.error.abs() + 64.0 * self.count
        {
            self.find(s, position, reference);
        }
        self.profile.update(&mut s.profile, reference, velocity);
        s.to_go = reference - s.profile.position;

        let moves = s.profile.velocity != 0.0;
        let rests = s.rest.ticks >= self.rest_ticks;
        let slow = self.inch(s, seen, rests);
        let runs = moves && !s.inching.active;
        let mut error = reference - if rests { s.rest.mean } else { position };
        let inches = slow && self.inching.is_speed(velocity);
        let least = if runs && !inches { LEAST_IN_MOTION } else { 0.0 };
        let guard = if s.guarded.gain < least { least } else { s.guarded.gain };
        let gains = LoopGains {
            guard,
            proportional: self.proportional * guard * guard,
            derivative: self.derivative * guard,
        };
        if runs && s.mode != Mode::Move {
            s.mode = Mode::Move;
            self.hold_effort.begin_move(&mut s.held);
        }
        let long = s.rest.ticks > 3 * self.rest_ticks;
        let stands = velocity == 0.0 || self.inching.is_count_overdue(&s.inching);
        if rests && (!runs || long && stands) {
            s.estimate.position = s.rest.mean;
            s.estimate.velocity = 0.0;
            if !runs {
                s.estimate.disturbance = self.disturbance_at_rest(s);
            }
        }
        if moves {
            s.attempts = Attempts::default();
        }
        if runs && !slow {
            let sticks = rests && velocity != 0.0;
            let speeds = [s.profile.velocity, s.estimate.velocity];
            self.guard.in_motion(&mut s.guarded, position, speeds, sticks);
        } else {
            self.guard.at_rest(&mut s.guarded, position, long || s.mode == Mode::Hold);
        }

        // One after the other: several transitions can happen in one tick.
        let mut effort = 0.0;
        if s.mode == Mode::Move {
            effort = if runs {
                self.follow(s, seen, gains)
            } else {
                self.settle(s, error, velocity, rests, gains)
            };
        }
        if s.mode == Mode::Hold {
            effort = self.hold(s, error);
        }
        if s.mode == Mode::Stuck {
            effort = self.decide(s, position, (&mut error, velocity), gains);
        }
        if s.mode == Mode::Pulse {
            effort = self.pulse(s);
        } else if s.mode == Mode::Coast {
            effort = self.coast(s, position, error, gains);
        }
        if s.mode == Mode::GiveUp {
            effort = bounded(s.held.effort, self.hold_effort.most);
        }
        bounded(effort, self.limit)
    }

    /// Returns the observer of this tick: the fast one shows a pulse and its effect at once, and
    /// the one for a moving set point is faster still.
    #[inline]
    fn observer_of(&self, s: &SupervisorState, velocity: f32) -> &ExtendedStateObserver {
        if let Some(tracking) = &self.observer_tracking
            && velocity != 0.0
        {
            return tracking;
        }
        let swings = s.mode == Mode::Move || s.mode == Mode::Coast && s.attempt.wait == 0;
        if swings { &self.observer_in_motion } else { &self.observer }
    }

    /// Begins or ends inching, and returns whether the set point is slow.
    #[inline]
    fn inch(&self, s: &mut SupervisorState, seen: &Seen, rests: bool) -> bool {
        let Seen { position, reference, velocity, .. } = *seen;
        let slow = self.inching.is_slow(&s.profile, reference, velocity);
        let following = Following {
            velocity,
            error: reference - position,
            slow,
            in_move: s.mode == Mode::Move,
            counted: s.rest.ticks == 0,
            rests,
        };
        match self.inching.update(&mut s.inching, &following) {
            Some(Change::Begins) => {
                s.mode = Mode::Stuck;
                s.held.springs = false;
                s.inside = false;
                s.direction = 0.0;
            }
            Some(Change::Ends) if velocity != 0.0 => {
                s.mode = Mode::Move;
                s.direction = 0.0;
            }
            Some(Change::Ends) | None => {}
        }
        slow
    }

    /// Handles a lost joint: the profile moves the joint back from its present position. The joint
    /// was pushed away unless the set point has left the profile.
    #[cold]
    fn find(&self, s: &mut SupervisorState, position: f32, reference: f32) {
        let pushed = (reference - s.profile.position).abs() < self.count;
        s.profile.position = position;
        s.profile.velocity = 0.0;
        if !self.load_rule.acts {
            s.held.effort *= 0.5;
        } else if !self.rests(s) {
            // L6: the joint slides, so that the effort of its sliding shows the load.
            let sign = if s.estimate.velocity > 0.0 { 1.0 } else { -1.0 };
            s.held.effort = self.load_rule.held(-self.inertia * s.estimate.disturbance, sign);
        }
        s.held.springs = false;
        s.mode = Mode::Move;
        self.guard.lost(&mut s.guarded, pushed);
    }

    /// Returns the observer's disturbance x3 for a joint at rest, deg/s^2: zero, or with a
    /// configured load that of the hold effort (L5).
    #[inline]
    fn disturbance_at_rest(&self, s: &SupervisorState) -> f32 {
        if self.load_rule.acts { -s.held.effort * self.per_inertia } else { 0.0 }
    }

    /// MOVE while the profile runs: `u = Kp (p - y) + d Kd (p' - x2) + J p'' + B p' - g_e J x3 +
    /// (1 - g_e) R_i s`.
    #[inline]
    fn follow(&self, s: &mut SupervisorState, seen: &Seen, gains: LoopGains) -> f32 {
        let LimitedReference { position, velocity, acceleration } = s.profile;
        let forward = velocity > 0.0;
        let sign = if forward { 1.0 } else { -1.0 };
        let friction = &mut s.friction[usize::from(forward)];
        let held = if self.load_rule.acts { s.held.effort } else { 0.0 };
        if sign != s.direction {
            s.direction = sign;
            s.needed = *friction * sign + held;
            s.estimate.disturbance = -s.needed * self.per_inertia;
        }
        let disturbance = -self.inertia * s.estimate.disturbance;
        let expected = *friction * sign + held;
        let effort = gains.proportional * (position - seen.position)
            + s.guarded.damping * gains.derivative * (velocity - s.estimate.velocity)
            + self.inertia * acceleration
            + self.viscous * velocity
            + gains.guard * disturbance
            + (1.0 - gains.guard) * expected;
        if s.rest.ticks < self.rest_ticks {
            let speed = sign * s.estimate.velocity;
            self.friction.learn(friction, disturbance * sign, speed, velocity.abs());
        }
        if self.load_rule.acts {
            self.load_rule.follow(&mut s.needed, disturbance);
        }
        effort
    }

    /// MOVE after the profile: `u = Kp e + Kd (r' - x2) + u_b + 0.8 g R_i sat(e / 8 q)`, until the
    /// joint rests.
    #[inline]
    fn settle(
        &self,
        s: &mut SupervisorState,
        error: f32,
        velocity: f32,
        rests: bool,
        gains: LoopGains,
    ) -> f32 {
        if self.load_rule.acts && s.direction != 0.0 {
            s.held.effort = self.load_rule.held(s.needed, s.direction);
        }
        s.direction = 0.0;
        if rests {
            s.mode = Mode::Stuck;
            s.held.springs = false;
            s.inside = false;
        }
        let friction = s.friction[usize::from(error > 0.0)];
        gains.proportional * error
            + gains.derivative * (velocity - s.estimate.velocity)
            + s.held.effort
            + 0.8 * friction * bounded(error * self.per_eight, 1.0) * s.guarded.gain
    }

    /// HOLD: the latched effort, until the error is beyond the stop band for long, or by far.
    #[inline]
    fn hold(&self, s: &mut SupervisorState, error: f32) -> f32 {
        let error = error.abs();
        s.outside = if error > self.stop_band { s.outside.saturating_add(1) } else { 0 };
        let far = error > self.far_band;
        if s.outside >= self.leave_ticks || far {
            s.mode = Mode::Stuck;
            s.held.springs = true;
            if far {
                s.rest.ticks = 0;
            }
        }
        s.latched
    }

    /// STUCK: `u = u_b + Kp e - Kd x2`. At rest the joint is held, or the next attempt begins.
    #[inline]
    fn decide(
        &self,
        s: &mut SupervisorState,
        position: f32,
        (error, velocity): (&mut f32, f32),
        gains: LoopGains,
    ) -> f32 {
        let effort =
            s.held.effort + gains.proportional * *error - gains.derivative * s.estimate.velocity;
        if s.rest.ticks < self.rest_ticks {
            return effort;
        }
        if s.inching.active {
            *error = self.inching.aim(*error, velocity);
            if self.inching.is_due(*error, velocity) {
                self.guard.clear(&mut s.guarded, position);
                self.attempt(s, *error);
            }
            s.inside = false;
            return effort;
        }
        if error.abs() <= self.stop_band {
            s.inside = true;
            if s.rest.ticks >= self.hold_ticks {
                s.mode = Mode::Hold;
                s.latched = effort;
                s.outside = 0;
                s.attempts = Attempts::default();
                self.guard.holds(&mut s.guarded);
            }
            return effort;
        }
        // With the encoder on the motor, a joint that was inside and drifted out has sprung back.
        if s.inside && self.reverse.is_none() {
            s.held.springs = true;
        }
        s.inside = false;
        self.guard.clear(&mut s.guarded, position);
        self.attempt(s, *error);
        effort
    }
}
