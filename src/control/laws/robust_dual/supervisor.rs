//! The supervisor: it selects the part that acts.
//!
//! Positions are angles from origins that the law moves, in deg of the joint; efforts are V. No
//! equation here depends on the unit of the angles.

mod attempt;

use super::super::Loop;
use super::super::robust::Rules;
use super::super::robust::extended_state_observer::{ExtendedStateObserver, ObserverState};
use super::super::robust::give_up::{Attempts, GiveUp};
use super::super::robust::hold_effort::{Held, HoldEffort};
use super::super::robust::load_rule::LoadRule;
use super::super::robust::oscillation_guard::{LEAST_IN_MOTION, OscillationGuard, SwingState};
use super::super::robust::pulse_planner::{PulseMemory, PulsePlanner};
use super::super::robust::rest_detector::{Rest, RestDetector};
use super::super::robust::sliding_friction::SlidingFriction;
use super::bump_memory::{BumpMemory, MemoryState};
use super::load_integral::LoadIntegral;
use super::motor_bump::{BumpState, MotorBump, MotorSeen};
use super::parameters::{COAST_S, RobustDualGains};
use super::push::{Push, PushState};
use super::twist_levels::{BothSides, TwistLevels, TwistState};
use crate::control::profile::bounded_acceleration::{BoundedAcceleration, LimitedReference};
use crate::units::saturation::bounded;
use attempt::Attempt;

/// State of the supervisor, as its signal reports it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// The profile moves, or the joint has not come to rest after it.
    #[default]
    Move = 0,
    /// Both sides rest, and the next attempt or HOLD is decided.
    Stuck = 1,
    /// A pulse is on.
    Pulse = 2,
    /// The attempt is over, and both sides come to rest.
    Coast = 3,
    /// The effort is latched within the stop band.
    Hold = 4,
    /// The attempts have ended without success.
    GiveUp = 5,
    /// The motor goes up to a twist, and back.
    Bump = 6,
}

/// The state from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SupervisorState {
    pub profile: LimitedReference,
    /// Rest of the motor and of the load.
    pub rest: [Rest; 2],
    pub estimate: ObserverState,
    pub guarded: SwingState,
    pub held: Held,
    pub levels: TwistState,
    pub memory: MemoryState,
    bump: BumpState,
    push: PushState,
    /// Sliding friction R_i, V, and memory of the pulses: backwards and forwards.
    pub friction: [f32; 2],
    learned: [PulseMemory; 2],
    attempt: Attempt,
    /// Positions of motor and load in the two ticks before, deg.
    before: [[f32; 2]; 2],
    /// Twist that is added to the set point of the motor, deg.
    twist: f32,
    /// Position at which the load rested when the motion began, deg.
    set_out: f32,
    /// Effort u_hold that a HOLD keeps, V.
    latched: f32,
    /// Effort w that the motion needs beyond the model, V.
    needed: f32,
    /// Sign of the profile's speed in the last tick of MOVE.
    direction: f32,
    /// Distance from the profile to the set point of the motor, deg.
    pub to_go: f32,
    /// Error within which a joint that swings around its target is left alone, deg.
    accepted: f32,
    /// Ticks in which the motor moved after bumps.
    restless: u16,
    /// Ticks beyond the stop band in a HOLD.
    outside: u16,
    pub attempts: Attempts,
    pub mode: Mode,
    /// Whether the joint has been within the stop band since the last attempt.
    inside: bool,
    /// Whether the load has left its rest in this motion.
    has_left: bool,
    /// Whether a tick has set the origins of the law's positions.
    pub has_begun: bool,
}

/// Inputs of one tick; positions are in deg from the origins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub motor: f32,
    pub load: f32,
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
    sample_time: f32,
    per_sample_time: f32,
    limit: f32,
    /// Angle q of one count of the load's encoder, deg.
    count: f32,
    /// 1 / (8 q), 1/deg.
    per_eight: f32,
    /// Largest error at rest that is left alone, deg.
    stop_band: f32,
    /// Error beyond which a HOLD is left at once, deg.
    far_band: f32,
    profile: BoundedAcceleration,
    rest: [RestDetector; 2],
    observer: ExtendedStateObserver,
    friction: SlidingFriction,
    guard: OscillationGuard,
    planner: PulsePlanner,
    hold_effort: HoldEffort,
    levels: TwistLevels,
    integral: LoadIntegral,
    bump: MotorBump,
    memory: BumpMemory,
    load_rule: LoadRule,
    give_up: GiveUp,
    /// Multiple of an attempt's error beyond which the joint is lost.
    lost: f32,
    /// The configured hold effort, V.
    configured_hold: f32,
    /// N_z, N_c, N_h, N_r and N_g, ticks.
    rest_ticks: u16,
    coast_ticks: u16,
    hold_ticks: u16,
    leave_ticks: u16,
    guard_ticks: u16,
    push: Push,
    /// Attempts after which the error that is accepted grows.
    patience: u16,
    /// Whether the law can give up.
    gives_up: bool,
}

const MOTOR: usize = 0;
const LOAD: usize = 1;

/// Least gain g_b of the motor's loop in a bump, and the factor that lowers the gain.
const LEAST_BUMP_GAIN: f32 = 0.2;
const LOWERED: f32 = 0.7;

/// First gain of a joint that a load drives. Before the guard has lowered the gain of a light motor
/// that swings, such a load drives the joint away: with a first gain of 1, 30 of 3000 simulated
/// joints tripped, and with this one 18. A HOLD raises it.
const LOADED_GAIN: f32 = 0.7;

/// Part of S by which the motor goes ahead of a load that follows it.
const TRAILS: f32 = 0.4;

/// Factor from the attempts of `give_up_attempts` to those after which an error is accepted.
const PATIENCE: u32 = 2;

impl SupervisorState {
    /// Clears the counts of attempts for a new motion, and leaves GIVE_UP for MOVE.
    pub fn try_again(&mut self) {
        self.attempts = Attempts::default();
        if self.mode == Mode::GiveUp {
            self.mode = Mode::Move;
        }
    }
}

impl Supervisor {
    pub fn new(gains: &RobustDualGains, around: &Loop) -> Self {
        let rules = gains.rules(around);
        let Loop { sample_time, resolution: count, full_scale: limit, lsb, .. } = *around;
        let RobustDualGains { inertia, viscous, .. } = *gains;
        let motor_count = around.motor.count().unwrap_or(count);
        let range = [gains.breakaway_low, gains.breakaway_high];
        let friction = SlidingFriction::new(sample_time, range, rules.learned_to, motor_count);
        let most_held = 0.8 * gains.breakaway_high + gains.load;
        let most_disturbance = 1.5 * gains.breakaway_high + gains.load;
        let Rules { bandwidth, .. } = rules;
        let strong = most_disturbance.min(limit);
        let rest_of_levels = ((COAST_S / sample_time + 0.5) as u16).max(rules.rest);
        Self {
            proportional: inertia * bandwidth * bandwidth,
            derivative: (2.0 * 0.9 * inertia * bandwidth - viscous).max(0.0),
            inertia,
            per_inertia: 1.0 / inertia,
            viscous,
            sample_time,
            per_sample_time: 1.0 / sample_time,
            limit,
            count,
            per_eight: 1.0 / (8.0 * count),
            stop_band: gains.stop_band * count,
            far_band: (gains.stop_band + 2.25) * count,
            profile: BoundedAcceleration::new(rules.speed, rules.acceleration, sample_time),
            rest: [
                RestDetector::new(gains.motor_jitter, motor_count),
                RestDetector::new(gains.jitter, count),
            ],
            observer: ExtendedStateObserver::new(
                sample_time,
                [inertia, viscous],
                rules.observer,
                most_disturbance,
            ),
            friction,
            guard: OscillationGuard::new(
                rules.guard,
                rules.least_gain,
                gains.motor_jitter,
                sample_time,
                motor_count,
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
            levels: TwistLevels::new(rest_of_levels, gains.first_level(count)),
            integral: LoadIntegral::new(sample_time, count),
            bump: MotorBump::new(sample_time, limit, motor_count, gains.breakaway_high),
            memory: BumpMemory::new([inertia, gains.motor_inertia], range, [count, motor_count]),
            load_rule: LoadRule::new(gains.load, friction.first, most_held, sample_time),
            lost: if gains.load > 0.0 { 1.0 } else { 3.0 },
            give_up: GiveUp::new(gains.attempts, strong, true, [count, sample_time]),
            configured_hold: gains.hold_effort,
            rest_ticks: rules.rest,
            coast_ticks: rules.coast,
            hold_ticks: rules.hold,
            leave_ticks: rules.leave,
            guard_ticks: rules.guard,
            patience: gains.attempts.saturating_mul(PATIENCE).min(u16::MAX.into()) as u16,
            gives_up: gains.attempts > 0,
            push: Push::new(strong, sample_time, count, gains.jitter),
        }
    }

    /// Resets the state, for a joint whose sides rest at their origins.
    pub fn start(&self, state: &mut SupervisorState) {
        let mut guarded = self.guard.start();
        if self.load_rule.acts {
            guarded.gain = LOADED_GAIN;
        }
        *state = SupervisorState {
            guarded,
            held: self.hold_effort.start(self.configured_hold),
            friction: [self.friction.first; 2],
            learned: [PulseMemory { gain: 1.0, least: self.planner.least }; 2],
            levels: self.levels.start(),
            memory: self.memory.start(),
            ..SupervisorState::default()
        };
    }

    /// Returns whether both sides rest.
    pub fn rests(&self, state: &SupervisorState) -> bool {
        state.rest.iter().all(|rest| rest.ticks >= self.rest_ticks)
    }

    /// Moves the origins of motor and load by distances, deg. They are not quite the same, since
    /// each is a whole number of its own counts.
    pub fn rebase(&self, state: &mut SupervisorState, by: [f32; 2]) {
        let [motor, load] = by;
        let twist = load - motor;
        state.profile.position -= motor;
        state.estimate.position -= motor;
        state.guarded.extreme -= motor;
        for ((rest, before), by) in state.rest.iter_mut().zip(&mut state.before).zip(by) {
            rest.anchor -= by;
            rest.mean -= by;
            before.iter_mut().for_each(|position| *position -= by);
        }
        state.set_out -= load;
        state.twist += twist;
        state.levels.rebase(load, twist);
        state.memory.rebase(twist);
        state.bump.rebase(motor, load);
    }

    /// Runs a tick, and returns the effort, V.
    #[inline]
    pub fn update(&self, s: &mut SupervisorState, seen: &Seen) -> f32 {
        let Seen { motor, load, reference, velocity, applied } = *seen;
        let speeds = self.speeds(s, [motor, load]);
        for ((detector, rest), position) in self.rest.iter().zip(&mut s.rest).zip([motor, load]) {
            detector.update(rest, position);
        }
        self.observer.update(&mut s.estimate, applied, motor);
        let sides = BothSides {
            twist: motor - load,
            load: [load, s.rest[LOAD].mean],
            rested_ticks: s.rest.map(|rest| rest.ticks),
            load_rests: s.rest[LOAD].ticks >= self.rest_ticks,
        };
        self.levels.update(&mut s.levels, &sides);
        let half_width = s.levels.half_width();

        let awaited = !matches!(s.mode, Mode::Move | Mode::Pulse | Mode::Bump);
        let most = self.lost * s.attempt.error.abs() + 64.0 * self.count + 2.0 * half_width;
        if awaited && (reference - load).abs() > most {
            self.find(s, motor, reference);
        }
        let wanted = reference + s.twist;
        self.profile.update(&mut s.profile, wanted, velocity);
        s.to_go = wanted - s.profile.position;

        let runs = s.profile.velocity != 0.0;
        let rests = self.rests(s);
        let error = reference - if rests { s.rest[LOAD].mean } else { load };
        let least = if runs { LEAST_IN_MOTION } else { 0.0 };
        let guard = if s.guarded.gain < least { least } else { s.guarded.gain };
        let gains = LoopGains {
            guard,
            proportional: self.proportional * guard * guard,
            derivative: self.derivative * guard,
        };
        if runs && s.mode != Mode::Move {
            self.set_out(s);
        }
        let long = s.rest[MOTOR].ticks > 3 * self.rest_ticks;
        if rests && (!runs || long) {
            s.estimate.position = s.rest[MOTOR].mean;
            s.estimate.velocity = 0.0;
            if !runs {
                s.estimate.disturbance = self.disturbance_at_rest(s);
            }
        }
        if runs {
            // The guard's count goes on where that at rest has ended.
            s.guarded.motion = s.guarded.motion.max(s.restless);
            s.restless = 0;
            let speeds = [s.profile.velocity, s.estimate.velocity];
            self.guard.in_motion(&mut s.guarded, motor, speeds, rests && velocity != 0.0);
            if velocity == 0.0 {
                // In a step the motor is so fast that a load that breaks away makes it swing.
                s.guarded.ignore_width();
            }
        } else {
            // The guard's count of the motion continues at rest.
            s.restless = s.restless.max(s.guarded.motion);
            self.guard.at_rest(&mut s.guarded, motor, true);
            self.guard_bumps(s, long);
        }

        let moving = MotorSeen {
            position: motor,
            speed: speeds[MOTOR],
            load_speed: speeds[LOAD],
            half_width,
        };
        // One after the other: several transitions can happen in one tick.
        let mut effort = 0.0;
        if s.mode == Mode::Move {
            effort = if runs {
                self.follow(s, seen, gains)
            } else {
                self.settle(s, wanted - motor, velocity, rests, gains)
            };
        }
        if s.mode == Mode::Hold {
            effort = self.hold(s, error, half_width);
        }
        if s.mode == Mode::Stuck {
            effort = self.decide(s, seen, (error, half_width), gains);
        }
        match s.mode {
            Mode::Pulse => effort = self.pulse(s, &moving, load),
            Mode::Bump => effort = self.bump(s, &moving),
            Mode::Coast => effort = self.coast(s, &moving, error, gains),
            Mode::GiveUp => effort = bounded(s.held.effort, self.hold_effort.most),
            Mode::Move | Mode::Stuck | Mode::Hold => {}
        }
        bounded(effort, self.limit)
    }

    /// Returns the speeds of motor and load over two ticks, deg/s.
    #[inline]
    fn speeds(&self, s: &mut SupervisorState, positions: [f32; 2]) -> [f32; 2] {
        let mut speeds = [0.0; 2];
        for ((speed, before), position) in speeds.iter_mut().zip(&mut s.before).zip(positions) {
            let [last, oldest] = *before;
            *speed = (position - oldest) * 0.5 * self.per_sample_time;
            *before = [position, last];
        }
        speeds
    }

    /// Lowers the gain of the motor's loop if the motor does not come to rest after bumps.
    fn guard_bumps(&self, s: &mut SupervisorState, long: bool) {
        let is_counted = !matches!(s.mode, Mode::Hold | Mode::Pulse | Mode::Bump);
        if s.rest[MOTOR].ticks == 0 && is_counted {
            s.restless = s.restless.saturating_add(1);
            if s.restless >= self.guard_ticks {
                s.restless = 0;
                if s.mode == Mode::Coast && s.attempt.is_bump() {
                    let gain = &mut s.memory.motor.gain;
                    *gain = (LOWERED * *gain).max(LEAST_BUMP_GAIN);
                } else {
                    self.guard.lower(&mut s.guarded);
                }
            }
        } else if long {
            s.restless = 0;
        }
    }

    /// Begins a motion.
    fn set_out(&self, s: &mut SupervisorState) {
        s.mode = Mode::Move;
        s.attempts = Attempts::default();
        self.hold_effort.begin_move(&mut s.held);
        s.has_left = false;
        s.set_out = s.rest[LOAD].mean;
        s.twist = s.levels.neutral;
        self.memory.forget_place(&mut s.memory);
        s.push = PushState::default();
        s.levels.ease();
    }

    /// Handles a lost load: the profile moves the motor back from its present position.
    #[cold]
    fn find(&self, s: &mut SupervisorState, motor: f32, reference: f32) {
        let pushed = (reference + s.twist - s.profile.position).abs() < self.count;
        s.profile.position = motor;
        s.profile.velocity = 0.0;
        if !self.load_rule.acts {
            s.held.effort *= 0.5;
        } else if !self.rests(s) {
            // The joint slides, so that the effort of its sliding shows the load.
            let sign = if s.estimate.velocity > 0.0 { 1.0 } else { -1.0 };
            s.held.effort = self.load_rule.held(-self.inertia * s.estimate.disturbance, sign);
        }
        s.held.springs = false;
        if s.mode == Mode::GiveUp {
            s.attempts = Attempts::default();
        }
        s.mode = Mode::Move;
        s.twist = s.levels.neutral;
        self.guard.lost(&mut s.guarded, pushed);
    }

    /// Returns the observer's disturbance x3 for a joint at rest, deg/s^2: zero, or with a
    /// configured load that of the hold effort.
    #[inline]
    fn disturbance_at_rest(&self, s: &SupervisorState) -> f32 {
        if self.load_rule.acts { -s.held.effort * self.per_inertia } else { 0.0 }
    }

    /// MOVE while the profile runs, as `robust` does it on the motor.
    #[inline]
    fn follow(&self, s: &mut SupervisorState, seen: &Seen, gains: LoopGains) -> f32 {
        let LimitedReference { position, velocity, acceleration } = s.profile;
        let forward = velocity > 0.0;
        let sign = if forward { 1.0 } else { -1.0 };
        let friction = &mut s.friction[usize::from(forward)];
        let held = if self.load_rule.acts { s.held.effort } else { 0.0 };
        let expected = *friction * sign + held;
        if sign != s.direction {
            s.direction = sign;
            s.needed = expected;
            s.estimate.disturbance = -expected * self.per_inertia;
        }
        if !s.has_left && sign * (seen.load - s.set_out) > 1.5 * self.count {
            // From now on the load trails the motor.
            s.has_left = true;
            s.twist = s.levels.neutral + sign * TRAILS * s.levels.half_width();
        }
        if s.has_left && seen.velocity != 0.0 {
            let lag = position - s.twist - seen.load;
            self.integral.update(&mut s.twist, lag, &s.levels);
        }
        let disturbance = -self.inertia * s.estimate.disturbance;
        let effort = gains.proportional * (position - seen.motor)
            + s.guarded.damping * gains.derivative * (velocity - s.estimate.velocity)
            + self.inertia * acceleration
            + self.viscous * velocity
            + gains.guard * disturbance
            + (1.0 - gains.guard) * expected;
        if s.rest[MOTOR].ticks < self.rest_ticks {
            let speed = sign * s.estimate.velocity;
            self.friction.learn(friction, disturbance * sign, speed, velocity.abs());
        }
        if self.load_rule.acts {
            self.load_rule.follow(&mut s.needed, disturbance);
        }
        effort
    }

    /// MOVE after the profile, until both sides rest. `error` is that of the motor.
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
    fn hold(&self, s: &mut SupervisorState, error: f32, half_width: f32) -> f32 {
        let error = error.abs();
        s.outside = if error > self.stop_band { s.outside.saturating_add(1) } else { 0 };
        let far = error > self.far_band;
        if s.outside >= self.leave_ticks || far {
            s.mode = Mode::Stuck;
            s.held.springs = !self.memory.is_soft(&s.memory, half_width);
            if far {
                s.rest[MOTOR].ticks = 0;
            }
        }
        s.latched
    }

    /// STUCK: `u = u_b + Kp e - Kd x2`, without `Kp e` where the gear is soft. At rest the joint is
    /// held, or the next attempt begins.
    #[inline]
    fn decide(
        &self,
        s: &mut SupervisorState,
        seen: &Seen,
        (error, half_width): (f32, f32),
        gains: LoopGains,
    ) -> f32 {
        let is_soft = self.memory.is_soft(&s.memory, half_width);
        let proportional = if is_soft { 0.0 } else { gains.proportional };
        let effort = s.held.effort + proportional * error - gains.derivative * s.estimate.velocity;
        let [motor, load] = s.rest.map(|rest| rest.ticks);
        if motor < self.rest_ticks || load < self.rest_ticks || is_soft && load < self.coast_ticks {
            return effort;
        }
        if error.abs() <= self.stop_band {
            s.inside = true;
            if motor.min(load) >= self.hold_ticks {
                s.mode = Mode::Hold;
                s.latched = effort;
                s.outside = 0;
                s.attempts = Attempts::default();
                self.guard.holds(&mut s.guarded);
            }
            return effort;
        }
        // A joint that was inside and drifted out has sprung back.
        if s.inside && !is_soft {
            s.held.springs = true;
        }
        s.inside = false;
        self.guard.clear(&mut s.guarded, seen.motor);
        self.attempt(s, seen, error, is_soft);
        effort
    }
}
