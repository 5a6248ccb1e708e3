//! Controllers (plain PD and every law on it), references, and joints that keep near them.

use std::iter::repeat_n;

use proptest::collection::vec;
use proptest::prelude::*;
pub use stiction::control::controller::EffortMode;
pub use stiction::control::drive::{DriveConfig, Duty, PwmMode};
pub use stiction::control::encoder::{
    CounterBits, Direction, Encoder, EncoderOutput, EncoderState,
};
#[cfg(feature = "rivals")]
pub use stiction::control::laws::ImpulsiveGains;
pub use stiction::control::laws::{
    Compensator, CompensatorState, DiscontinuousNonlinearProportionalGains,
    DisturbanceObserverGains, FeedforwardGains, Gains, LawInput, LawState, Loop, MAX_TERMS,
    PreparedLaw, RateVariableIntegralGains, ResetIntegralGains, ResetOffsetIntegralGains,
    SmoothRobustNonlinearGains,
};
pub use stiction::control::motor_encoder::MotorEncoder;
pub use stiction::control::pd::PdGains;
pub use stiction::control::reference::{Corner, Reference, Setpoint, Step, Trajectory};
pub use stiction::units::position::Position;
pub use stiction::units::value::{Key, Kind, Values};
pub use stiction::{Controller, ControllerConfig, ControllerState, Hardware, Reading, Tick};

/// The figures of the board that the thesis's loop runs on here.
pub const STM32F405: Hardware = Hardware {
    pwm_clock_hz: 168e6,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};

/// Every mode of the drive.
pub fn modes() -> impl Strategy<Value = PwmMode> {
    prop_oneof![Just(PwmMode::LockedAntiphase), Just(PwmMode::SignMagnitude), Just(PwmMode::Analog)]
}

/// Joint angle of one count, deg.
pub const RESOLUTION: f32 = 0.00242;

/// Time between samples, s.
pub const SAMPLE_TIME: f32 = 0.02;

/// The largest gain, limit or length that is allowed.
pub const LARGEST: f32 = 1e6;

// These are the thesis's gains at 20 ms.
pub const RI: Gains = Gains::ResetIntegral(ResetIntegralGains { ki: 4.0, theta_ri: 0.5 });

pub const RVI: Gains =
    Gains::RateVariableIntegral(RateVariableIntegralGains { ki: 150.0, gamma: 0.05 });

pub const ROI: Gains =
    Gains::ResetOffsetIntegral(ResetOffsetIntegralGains { t_roi: 0.14, v_roi: 2.33 });

pub const FEEDFORWARD: Gains =
    Gains::Feedforward(FeedforwardGains { v_slip: 0.37, v_ff: 0.001, viscous: 0.0, inertia: 0.0 });

pub const DNPF: Gains =
    Gains::DiscontinuousNonlinearProportional(DiscontinuousNonlinearProportionalGains {
        theta_b: 0.40,
    });
pub const SRNF: Gains =
    Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms: 0.40, alpha: 100.0 });

/// Every law with the thesis's derivative gain for it (Tables 17 and 18), V/(deg/s): 0.17, and 0.25
/// for SRNF.
pub fn laws() -> impl Iterator<Item = (&'static str, f32, Gains)> {
    Gains::EXAMPLES.iter().map(|&law| (law.name(), if law == SRNF { 0.25 } else { 0.17 }, law))
}

/// The configuration of the thesis's loop with a derivative gain and a sum of laws.
pub fn configured(kd: f32, laws: &[Gains]) -> ControllerConfig {
    ControllerConfig {
        sample_time: SAMPLE_TIME,
        encoder: Encoder {
            resolution: RESOLUTION,
            counter_bits: CounterBits::Sixteen,
            direction: Direction::Forward,
            output: EncoderOutput::Unknown,
        },
        velocity_window: 5,
        effort: EffortMode::Voltage,
        motor: MotorEncoder::NONE,
        pd: PdGains { kp: 1.0, kd },
        compensator: laws.iter().copied().collect(),
        drive: DriveConfig {
            full_scale: 5.0,
            lsb: 0.00488,
            mode: PwmMode::LockedAntiphase,
            pwm_hz: 22e3,
            duty_max: 1.0,
        },
    }
}

/// Every controller: plain PD, and each law by itself. With the laws of the thesis they are its
/// seven.
pub fn controllers() -> Vec<(&'static str, ControllerConfig)> {
    let plain = ("pd", configured(0.15, &[]));
    let laws = laws().map(|(name, kd, law)| (name, configured(kd, &[law])));
    std::iter::once(plain).chain(laws).collect()
}

pub fn changed(
    base: &ControllerConfig,
    change: impl FnOnce(&mut ControllerConfig),
) -> ControllerConfig {
    let mut config = base.clone();
    change(&mut config);
    config
}

/// Positions of a joint, tick by tick; it is at rest on the first before the motion begins.
pub fn run(
    controller: &Controller,
    reference: &Reference,
    counts: &[i32],
    counter: impl Fn(i32) -> u32,
) -> Vec<Tick> {
    let first = counts.first().copied().unwrap_or_default();
    let mut joint = Joint::start(controller, counter(first), first);
    counts.iter().map(|&counts| joint.tick(counter(counts), reference)).collect()
}

/// A controller at a joint, of which it sees the encoder's counter alone.
pub struct Joint<'a> {
    controller: &'a Controller,
    encoder: EncoderState,
    state: ControllerState,
}

impl<'a> Joint<'a> {
    /// Begins at rest at `counts`, where the counter reads `counter`.
    pub fn start(controller: &'a Controller, counter: u32, counts: i32) -> Self {
        let encoder = EncoderState::start(counter, counts);
        Self { controller, encoder, state: controller.start(counts) }
    }

    pub fn tick(&mut self, counter: u32, reference: &Reference) -> Tick {
        self.controller.encoder().update(&mut self.encoder, counter);
        let reading = Reading::position(self.encoder.counts());
        self.controller.tick(&mut self.state, reading, reference)
    }
}

/// The numbers of values, in their order.
pub fn keys(values: &impl Values) -> Vec<Key> {
    let mut keys = Vec::new();
    let _ = values.each(&mut |key, _| -> Result<(), ()> {
        keys.push(key);
        Ok(())
    });
    keys
}

/// A 16-bit counter that reads zero where the joint does.
pub fn low_half(counts: i32) -> u32 {
    u32::from(counts as u16)
}

/// The duty that reaches the bridge.
pub fn outputs(ticks: &[Tick]) -> Vec<(i16, Duty)> {
    ticks.iter().map(|tick| (tick.code, tick.duty())).collect()
}

/// Positions of a joint that keeps near its reference.
pub fn near(reference: &Reference, lags: &[i32]) -> Vec<i32> {
    (0..)
        .zip(lags)
        .map(|(tick, lag)| reference.at(tick).position.counts.wrapping_add(*lag))
        .collect()
}

/// What the laws saw of each of these ticks. Before the first one there was no effort.
pub fn samples_of(ticks: &[Tick]) -> Vec<LawInput> {
    let first = ticks.first().map(|first| Tick { counts: first.counts, ..Tick::default() });
    let before = first.iter().chain(ticks);
    before.zip(ticks).map(|(before, tick)| sample_of(before, tick)).collect()
}

/// What the laws saw of a tick that followed another.
pub fn sample_of(before: &Tick, tick: &Tick) -> LawInput {
    LawInput {
        counts: tick.counts,
        travel: tick.counts.wrapping_sub(before.counts),
        applied: before.v_applied,
        saturated: before.saturated,
        error: tick.error,
        velocity: tick.velocity,
        setpoint: tick.setpoint(),
        velocity_error: tick.reference_velocity - tick.velocity,
        v_pd: tick.v_pd,
        #[cfg(feature = "two-encoders")]
        motor_counts: tick.counts,
    }
}

/// Draws how far a joint is from its reference, tick by tick, in counts: it rests, creeps and runs
/// by turns.
pub fn lags() -> impl Strategy<Value = Vec<i32>> {
    let stretch = (prop_oneof![Just(0), -2..=2, -60..=60], 1usize..20);
    (-400..=400, vec(stretch, 1..20)).prop_map(|(mut lag, stretches): (i32, Vec<(i32, usize)>)| {
        let increments =
            stretches.into_iter().flat_map(|(increment, ticks)| repeat_n(increment, ticks));
        std::iter::once(0)
            .chain(increments)
            .map(|increment| {
                lag += increment;
                lag
            })
            .collect()
    })
}

/// Draws a fraction whose complement to one is without error, too.
pub fn fraction() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0), (0u32..1 << 24).prop_map(|n| n as f32 / 16_777_216.0)]
}

pub fn place() -> impl Strategy<Value = Position> {
    (-3000..=3000, fraction()).prop_map(|(counts, fraction)| Position { counts, fraction })
}

pub fn step_to(to: Position) -> Reference {
    Reference::Step(Step { to, ..Step::default() })
}

/// Corners of a trajectory whose every position is a whole number of 128ths of a count: `f32`
/// rounds none of them.
pub fn corners() -> impl Strategy<Value = Vec<Corner>> {
    let positions = vec((-300..=300i32).prop_map(|n| n * 16), 4);
    (positions, prop_oneof![Just(0.0), Just(0.5)]).prop_map(|(positions, fraction)| {
        (0u32..)
            .zip(positions)
            .map(|(i, counts)| corner(16 + 64 * i, Position { counts, fraction }))
            .collect()
    })
}

pub const fn corner(tick: u32, position: Position) -> Corner {
    Corner { tick, position }
}

pub fn through(corners: &[Corner], half_blend_s: f32) -> Reference {
    match Trajectory::new(corners, half_blend_s, SAMPLE_TIME, RESOLUTION) {
        Ok(trajectory) => Reference::Trajectory(trajectory),
        Err(error) => unreachable!("{error}"),
    }
}

/// Half a blend of [`corners`]: eight ticks.
pub const HALF_BLEND_S: f32 = 8.0 * SAMPLE_TIME;

pub fn reference() -> impl Strategy<Value = Reference> {
    prop_oneof![
        place().prop_map(step_to),
        corners().prop_map(|corners| through(&corners, HALF_BLEND_S))
    ]
}

pub fn config() -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::default() }
}
