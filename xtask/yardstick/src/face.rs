//! The face for a firmware of your own, around a joint that sticks.

use stiction::control::laws::{SmoothRobustNonlinear, SmoothRobustNonlinearGains};
use stiction::positioner::{
    EncoderSide, MonitorConfig, PdConfig, PdPositioner, PdState, Position, Positioner,
    PositionerConfig, PositionerState, RunawayMonitors, RunawayState, Target,
};

const COUNTS_PER_TURN: f32 = 100_000.0;
const COUNT: f32 = core::f32::consts::TAU / COUNTS_PER_TURN;

const JOINT: PositionerConfig = PositionerConfig {
    sample_time: 1e-3,
    counts_per_turn: COUNTS_PER_TURN,
    largest_effort: 16.0,
    effort_step: 0.015_625,
    inertia: 0.12,
    viscous: 0.9,
    breakaway: [0.9, 3.0],
    load: 0.0,
    hold_effort: 0.0,
    jitter: 0.0,
    speed: 0.0,
    acceleration: 0.0,
    encoder_side: EncoderSide::Motor,
};

const WATCH: MonitorConfig =
    MonitorConfig { range: [-1.0, 1.0], continuous_effort: 6.0, thermal_time: 10.0 };

/// 8 Hz with a damping of 0.9 on that joint.
const PD: PdConfig = PdConfig {
    sample_time: 1e-3,
    counts_per_turn: COUNTS_PER_TURN,
    largest_effort: 16.0,
    effort_step: 0.015_625,
    kp: 303.0,
    kd: 10.0,
    velocity_window: 5,
};

/// Ticks of a step of 0.3 rad, and of a ramp behind it. A step back follows.
const STEP: u32 = 200;
const RAMP: u32 = 400;

/// Two joints: one under `robust` with its monitors, one under PD.
pub struct Face {
    robust: (Positioner, PositionerState),
    monitors: (RunawayMonitors, RunawayState),
    pd: (PdPositioner<SmoothRobustNonlinear>, PdState<()>),
    joints: [Joint; 2],
    tick: u32,
}

/// A rigid joint with static friction 2.4 and sliding friction 2, a fifth lighter than configured.
#[derive(Clone, Copy, Default)]
struct Joint {
    /// Position, counts, and speed, rad/s.
    position: f32,
    speed: f32,
}

impl Face {
    pub fn new() -> Option<Self> {
        let robust = Positioner::new(&JOINT).ok()?;
        let monitors = RunawayMonitors::new(&JOINT, &WATCH).ok()?;
        let gains = SmoothRobustNonlinearGains { v_ms: 2.0, alpha: 30.0 };
        let pd = PdPositioner::new(&PD, &gains).ok()?;
        Some(Self {
            robust: (robust.clone(), robust.start()),
            monitors: (monitors.clone(), monitors.start(0)),
            pd: (pd.clone(), pd.start()),
            joints: [Joint::default(); 2],
            tick: 0,
        })
    }

    /// Runs one tick of each.
    pub fn step(&mut self) {
        let target = self.target();
        let counts = self.joints.map(|joint| joint.counter());
        let effort = robust_step(&self.robust.0, &mut self.robust.1, counts[0], target);
        let (monitors, watch) = &mut self.monitors;
        // A tripped monitor ends the run, which the count of the calls then shows.
        if monitors_step(monitors, watch, counts[0], target, effort) {
            return;
        }
        self.joints[0].advance(effort);
        let effort = pd_step(&self.pd.0, &mut self.pd.1, counts[1], target);
        self.joints[1].advance(effort);
        self.tick += 1;
    }

    fn target(&self) -> Target {
        let at = |counts: f32| Position::default().displaced(counts);
        let begin = 0.3 / COUNT;
        if self.tick < STEP {
            Target::at_rest(at(begin))
        } else if self.tick < RAMP {
            // 200 counts/s.
            let position = at(begin + 0.2 * (self.tick - STEP) as f32);
            Target { position, velocity: 200.0 * COUNT, acceleration: 0.0 }
        } else {
            Target::at_rest(at(-0.2 / COUNT))
        }
    }
}

#[inline(never)]
fn robust_step(law: &Positioner, state: &mut PositionerState, counts: i32, target: Target) -> f32 {
    law.tick(state, counts, target)
}

#[inline(never)]
fn monitors_step(
    monitors: &RunawayMonitors,
    state: &mut RunawayState,
    counts: i32,
    target: Target,
    effort: f32,
) -> bool {
    monitors.check(state, counts, target, effort).is_some()
}

#[inline(never)]
fn pd_step(
    law: &PdPositioner<SmoothRobustNonlinear>,
    state: &mut PdState<()>,
    counts: i32,
    target: Target,
) -> f32 {
    law.tick(state, counts, target)
}

impl Joint {
    fn counter(&self) -> i32 {
        libm::floorf(self.position) as i32
    }

    /// Moves for 1 ms in steps of 50 us.
    fn advance(&mut self, effort: f32) {
        for _ in 0..20 {
            let force = effort - 0.9 * self.speed;
            let before = self.speed;
            if before == 0.0 && force.abs() <= 2.4 {
                continue;
            }
            let direction = if before == 0.0 { force } else { before };
            let friction = if direction < 0.0 { -2.0 } else { 2.0 };
            self.speed += (force - friction) / 0.1 * 5e-5;
            if before != 0.0 && self.speed * before <= 0.0 {
                self.speed = 0.0;
            }
            self.position += self.speed / COUNT * 5e-5;
        }
    }
}
