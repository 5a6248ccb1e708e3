//! Whatever comes in, the output stays within the drive, and no value that is not finite reaches
//! it.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::subsequence;
use stiction::Allowed;
use stiction::control::drive::pwm_top;
use stiction::parameters;

use super::fixture::*;

/// References that are not finite in the position, or, for hundreds of ticks, in the acceleration
/// alone.
fn poisoned() -> impl Strategy<Value = Reference> {
    let poison = prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY)];
    let step = poison.prop_map(|fraction| step_to(Position { counts: 0, fraction }));
    // The loop is so fast that degrees per second squared are beyond an `f32`. Its time is a power
    // of two, and exact.
    let sample_time = 0.5f32.powi(83);
    let corners = [corner(512, Position::from_counts(0)), corner(2048, Position::from_counts(1))];
    let violent = Trajectory::new(&corners, 512.0 * sample_time, sample_time, RESOLUTION);
    let violent = violent.into_iter().map(Reference::Trajectory).collect::<Vec<_>>();
    prop_oneof![step, proptest::sample::select(violent)]
}

/// Draws floats from one to another (neither negative), each bit pattern as likely as the next.
fn floats(low: f32, high: f32) -> impl Strategy<Value = f32> {
    (low.to_bits()..=high.to_bits()).prop_map(f32::from_bits)
}

fn any_gain() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0), floats(0.0, LARGEST), floats(1e-3, 1e3)]
}

fn any_positive(high: f32) -> impl Strategy<Value = f32> {
    prop_oneof![floats(0f32.next_up(), high), floats(1e-3, high.min(1e3))]
}

/// The bits of any value that a gain may have.
fn any_bits(kind: Kind, allowed: Allowed) -> BoxedStrategy<u32> {
    match (kind, allowed) {
        (Kind::Number, Allowed::Between(0.0, LARGEST)) => any_gain().prop_map(f32::to_bits).boxed(),
        (Kind::Number, Allowed::Between(low, high)) => (low..=high).prop_map(f32::to_bits).boxed(),
        (Kind::Number, Allowed::OrOff(0.0, LARGEST)) => any_gain().prop_map(f32::to_bits).boxed(),
        (Kind::Number, Allowed::Above(0.0, high)) => {
            any_positive(high).prop_map(f32::to_bits).boxed()
        }
        (Kind::Whole, Allowed::Between(low, high)) => (low as u32..=high as u32).boxed(),
        (Kind::Flag, _) => (0u32..=1).boxed(),
        (Kind::Choice(words), _) => (0..words.len() as u32).boxed(),
        other => unreachable!("{other:?}: say here what it may be"),
    }
}

/// Draws a law with any gains, as they are declared.
fn any_gains(law: Gains) -> impl Strategy<Value = Gains> {
    let keys = keys(&law);
    let bits =
        |key: &Key| any_bits(parameters::about(*key).unwrap().kind, law.allowed(*key).unwrap());
    let drawn = keys.iter().map(bits).collect::<Vec<_>>().prop_map(move |values| {
        let mut law = law;
        for (key, bits) in keys.iter().zip(values) {
            assert_eq!(law.set(*key, bits), Ok(true), "{key:?}");
        }
        law
    });
    // The bounds of one value may be another one.
    drawn.prop_filter("a range in order", |law| law.validate().is_ok())
}

/// Draws up to four laws in any order, each of them once; one that replaces PD stands alone.
fn any_laws() -> impl Strategy<Value = Vec<Gains>> {
    let some = subsequence(Gains::EXAMPLES, 0..=MAX_TERMS).prop_shuffle();
    some.prop_flat_map(|laws| match laws.iter().find(|law| law.replaces_pd()) {
        Some(alone) => vec![any_gains(*alone)],
        None => laws.into_iter().map(any_gains).collect(),
    })
}

fn any_drive() -> impl Strategy<Value = DriveConfig> {
    let mode = modes();
    // Often the whole duty, as most machines have it.
    let duty_max = prop_oneof![Just(1.0), floats(f32::MIN_POSITIVE, 1.0)];
    let drive = (any_positive(LARGEST), mode, floats(1300.0, 5.25e6), duty_max);
    drive.prop_flat_map(|(full_scale, mode, pwm_hz, duty_max)| {
        floats((full_scale / 32_768.0).next_up(), full_scale).prop_map(move |lsb| DriveConfig {
            full_scale,
            lsb,
            mode,
            pwm_hz,
            duty_max,
        })
    })
}

/// Draws any configuration that validation lets pass.
fn any_config() -> impl Strategy<Value = ControllerConfig> {
    let counter_bits = prop_oneof![Just(CounterBits::Sixteen), Just(CounterBits::ThirtyTwo)];
    let direction = prop_oneof![Just(Direction::Forward), Just(Direction::Reverse)];
    let encoder = (any_positive(LARGEST), counter_bits, direction).prop_map(
        |(resolution, counter_bits, direction)| Encoder {
            resolution,
            counter_bits,
            direction,
            output: EncoderOutput::Unknown,
        },
    );
    let pd = (any_gain(), any_gain()).prop_map(|(kp, kd)| PdGains { kp, kd });
    (any_positive(1.0), encoder, 2u32..=16, pd, any_laws(), any_drive()).prop_map(
        |(sample_time, encoder, velocity_window, pd, laws, drive)| ControllerConfig {
            sample_time,
            encoder,
            velocity_window,
            effort: EffortMode::Voltage,
            motor: MotorEncoder::NONE,
            pd,
            compensator: laws.into_iter().collect(),
            drive,
        },
    )
}

/// Draws any counts at all, and any bit pattern for the fraction.
fn any_position() -> impl Strategy<Value = Position> {
    let fraction = prop_oneof![
        4 => fraction(),
        2 => any::<u32>().prop_map(f32::from_bits),
        1 => Just(f32::NAN),
        1 => Just(f32::NEG_INFINITY),
    ];
    (prop_oneof![any::<i32>(), -500..=500], fraction)
        .prop_map(|(counts, fraction)| Position { counts, fraction })
}

fn any_reference() -> impl Strategy<Value = Reference> {
    let step = (any_position(), any_position(), 0u32..40)
        .prop_map(|(from, to, at_tick)| Reference::Step(Step { from, to, at_tick }));
    let corners = vec((6u32..20, any_position()), 1..=8);
    let trajectory = (corners, any_positive(1.0), any_positive(LARGEST)).prop_filter_map(
        "corners that blends leave room for",
        |(corners, sample_time, resolution)| {
            let mut tick = 0;
            let corners: Vec<_> = corners
                .into_iter()
                .map(|(gap, position)| {
                    tick += gap;
                    corner(tick, position)
                })
                .collect();
            Trajectory::new(&corners, 2.5 * sample_time, sample_time, resolution)
                .ok()
                .map(Reference::Trajectory)
        },
    );
    prop_oneof![step, trajectory]
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn output_stays_within_the_drive_whatever_comes_in(
        config in any_config(),
        reference in any_reference(),
        (mut counter, counts) in any::<(u32, i32)>(),
        travels in vec(prop_oneof![any::<i32>(), -300..=300, Just(0)], 1..40),
    ) {
        let controller = Controller::new(&config, &STM32F405).unwrap();
        let DriveConfig { full_scale, lsb, mode, pwm_hz, duty_max } = config.drive;
        let pwm_top = pwm_top(&STM32F405, pwm_hz).unwrap();
        let max_code = controller.drive().max_code();
        let cap = (f64::from(duty_max) * f64::from(max_code)).floor() as i16;
        // Two decimals are rounded to `f32`, so their quotient may be a whole number to 3e-7 only.
        let reach = f64::from(full_scale) / f64::from(lsb);
        let unused = reach - f64::from(max_code);
        // The quotient of two floats counts as whole when it is so to 3e-7, one and a half units in
        // the last place.
        let is_one = unused >= -3e-7 * reach && unused < 1.0 + 3e-7 * reach;
        prop_assert!(is_one, "{max_code} of {reach}");
        let mut joint = Joint::start(&controller, counter, counts);
        for travel in travels {
            counter = counter.wrapping_add_signed(travel);
            let tick = joint.tick(counter, &reference);
            let sum = tick.v_pd + tick.v_c;
            prop_assert_eq!(tick.non_finite, !(sum.is_finite() && tick.setpoint().is_finite()));
            let (v, limited) = match tick.non_finite {
                true => (0.0, false),
                false => (sum.clamp(-full_scale, full_scale), sum.abs() > full_scale),
            };
            let code = controller.drive().code(v);
            let capped = code.clamp(-cap, cap);
            prop_assert_eq!((tick.v, tick.saturated), (v, limited || capped != code), "{:?}", tick);
            prop_assert_eq!(tick.code, capped, "{:?}", tick);
            prop_assert_eq!(tick.v_applied, f32::from(tick.code) * lsb, "{:?}", tick);
            prop_assert_eq!(tick.duty(), controller.drive().duty(tick.code), "{:?}", tick);
            prop_assert!(tick.code.abs() <= max_code && tick.compare <= pwm_top, "{tick:?}");
            if tick.non_finite {
                prop_assert_eq!(tick.code, 0);
            }
            if tick.code == 0 {
                let compare = if mode == PwmMode::SignMagnitude { 0 } else { pwm_top / 2 };
                prop_assert_eq!(tick.duty(), Duty { compare, reverse: false });
            }
        }
    }

    #[test]
    fn set_point_that_is_not_finite_stops_the_drive_and_clears_the_compensator(
        reference in reference(),
        lags in lags(),
        at in 0usize..60,
        poisoned in poisoned(),
        mode in modes(),
    ) {
        let counts = near(&reference, &lags);
        let at = at % counts.len();
        for (name, config) in controllers() {
            let config = changed(&config, |config| config.drive.mode = mode);
            let controller = Controller::new(&config, &STM32F405).unwrap();
            let undisturbed = run(&controller, &reference, &counts, low_half);

            let mut joint = Joint::start(&controller, low_half(counts[0]), counts[0]);
            for &counts in &counts[..at] {
                joint.tick(low_half(counts), &reference);
            }
            let tick = joint.tick(low_half(counts[at]), &poisoned);
            prop_assert!(tick.non_finite && tick.v == 0.0 && tick.code == 0, "{name}: {tick:?}");
            let compare = if mode == PwmMode::SignMagnitude { 0 } else { 1909 };
            prop_assert_eq!(tick.duty(), Duty { compare, reverse: false });

            let afresh = Compensator::new(&config.compensator, &config.around());
            let mut compensator = afresh.rest();
            let mut before = tick;
            for (&counts, expected) in counts.iter().zip(&undisturbed).skip(at + 1) {
                let tick = joint.tick(low_half(counts), &reference);
                let expected = (expected.v_pd, expected.velocity);
                prop_assert_eq!((tick.v_pd, tick.velocity), expected, "{}", name);
                let v_c = afresh.update(&mut compensator, &sample_of(&before, &tick));
                before = tick;
                prop_assert_eq!(tick.v_c, v_c, "{}: tick {}", name, tick.tick);
            }
        }
    }
}

/// The joint moves one count in so short a sample that its velocity times the gain is beyond an
/// `f32`.
#[test]
fn effort_beyond_a_float_gives_none() {
    let config = changed(&configured(1e6, &[SRNF]), |config| config.sample_time = 1e-36);
    let controller = Controller::new(&config, &STM32F405).unwrap();
    let mut joint = Joint::start(&controller, 0, 0);
    let here = step_to(Position::default());
    let ticks = [0, 1, 1, 1, 1, 1].map(|counter| joint.tick(counter, &here));
    assert_eq!(ticks.map(|tick| tick.non_finite), [false, true, true, true, true, false]);
    // 0.40 tanh(100 * -0.00242) V, and PD.
    assert_eq!(ticks.map(|tick| tick.code), [0, 0, 0, 0, 0, -20]);
}
