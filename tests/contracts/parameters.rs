//! No parameter does nothing, and no state is large.

use std::mem::size_of;

use stiction::compensator::{rate_variable_integral, reset_integral, reset_offset_integral};

use super::fixture::*;

/// A joint that wanders about a trajectory, always the same way: within half a degree for the most part, so that
/// every threshold is crossed both ways, and once so far away that the drive saturates.
fn excitation() -> (Reference, Vec<i32>) {
    let corners = [(50, 0), (300, 10_331), (350, 10_331), (600, 0)]
        .map(|(tick, counts)| corner(tick, Position::from_counts(counts)));
    let reference = through(&corners, 0.25);
    let (mut random, mut lag, mut increment) = (1u32, 0i32, 0i32);
    let lags: Vec<_> = (0..700)
        .map(|k| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match random >> 29 {
                0 => increment = 0,
                1 => increment = (random >> 8) as i32 % 60 - 30,
                _ => {}
            }
            if (lag + increment).abs() > 280 {
                increment = -increment;
            }
            lag += increment;
            if (400..420).contains(&k) { lag + 2600 } else { lag }
        })
        .collect();
    let counts = near(&reference, &lags);
    (reference, counts)
}

#[test]
fn every_parameter_of_the_controller_changes_the_output() {
    let (reference, counts) = excitation();
    let output = |config: &ControllerConfig| {
        outputs(&run(&Controller::new(config).unwrap(), &reference, &counts, low_half))
    };
    type Change = (&'static str, fn(&mut ControllerConfig));
    let changes: [Change; 11] = [
        ("sample_time", |config| config.sample_time *= 1.05),
        ("encoder.resolution", |config| config.encoder.resolution *= 1.05),
        ("encoder.counter_bits", |config| config.encoder.counter_bits = CounterBits::ThirtyTwo),
        ("encoder.direction", |config| config.encoder.direction = Direction::Reverse),
        ("velocity_window", |config| config.velocity_window = 6),
        ("pd.kp", |config| config.pd.kp *= 1.05),
        ("pd.kd", |config| config.pd.kd *= 1.05),
        ("drive.full_scale", |config| config.drive.full_scale *= 0.95),
        ("drive.lsb", |config| config.drive.lsb *= 1.05),
        ("drive.mode", |config| config.drive.mode = PwmMode::SignMagnitude),
        ("drive.pwm_top", |config| config.drive.pwm_top = 3820),
    ];
    for (name, config) in controllers() {
        let unchanged = output(&config);
        assert_eq!(output(&config), unchanged);
        for (parameter, change) in changes {
            assert_ne!(output(&changed(&config, change)), unchanged, "{name}: {parameter} does nothing");
        }
    }
}

#[test]
fn every_gain_of_a_law_changes_the_output() {
    let (reference, counts) = excitation();
    let output = |law: Gains| {
        let controller = Controller::new(&configured(0.17, &[law])).unwrap();
        outputs(&run(&controller, &reference, &counts, low_half))
    };
    let changes = [
        (RI, Gains::ResetIntegral(ResetIntegralGains { ki: 4.2, theta_ri: 0.5 })),
        (RI, Gains::ResetIntegral(ResetIntegralGains { ki: 4.0, theta_ri: 0.525 })),
        (RVI, Gains::RateVariableIntegral(RateVariableIntegralGains { ki: 157.5, gamma: 0.05 })),
        (RVI, Gains::RateVariableIntegral(RateVariableIntegralGains { ki: 150.0, gamma: 0.0525 })),
        (ROI, Gains::ResetOffsetIntegral(ResetOffsetIntegralGains { t_roi: 0.16, v_roi: 2.33 })),
        (ROI, Gains::ResetOffsetIntegral(ResetOffsetIntegralGains { t_roi: 0.14, v_roi: 2.45 })),
        (FEEDFORWARD, Gains::Feedforward(FeedforwardGains { v_slip: 0.39, v_ff: 0.001 })),
        // The first blend passes 0.1 deg/s in its first tick.
        (FEEDFORWARD, Gains::Feedforward(FeedforwardGains { v_slip: 0.37, v_ff: 0.2 })),
        (
            DNPF,
            Gains::DiscontinuousNonlinearProportional(DiscontinuousNonlinearProportionalGains {
                theta_b: 0.42,
            }),
        ),
        (SRNF, Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms: 0.42, alpha: 100.0 })),
        (SRNF, Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms: 0.40, alpha: 105.0 })),
    ];
    let pd = outputs(&run(&Controller::new(&configured(0.17, &[])).unwrap(), &reference, &counts, low_half));
    for (law, changed) in changes {
        assert_ne!(output(law), pd, "{law:?} does nothing");
        assert_ne!(output(law), output(changed), "{law:?} is the same as {changed:?}");
    }
}

/// What a law takes from the loop around it, apart from what the loop does by itself.
#[test]
fn laws_depend_on_their_loop_where_their_equations_say_so() {
    let (reference, counts) = excitation();
    let samples: Vec<_> =
        run(&Controller::new(&configured(0.17, &[])).unwrap(), &reference, &counts, low_half)
            .iter()
            .map(sample_of)
            .collect();
    let output = |law: &Gains, around: &Loop| {
        let law = Law::new(law, around).unwrap();
        let mut state = law.rest();
        samples.iter().map(|sample| law.update(&mut state, sample)).collect::<Vec<_>>()
    };
    let base = Loop { sample_time: 0.02, full_scale: 0.5, kp: 1.0 };
    // Sample time, full scale, Kp.
    let depends = [
        (RI, [true, true, false]),
        (RVI, [true, true, false]),
        (ROI, [true, true, false]),
        (FEEDFORWARD, [false, false, false]),
        (DNPF, [false, false, true]),
        (SRNF, [false, false, false]),
    ];
    let changes =
        [Loop { sample_time: 0.018, ..base }, Loop { full_scale: 0.45, ..base }, Loop { kp: 1.05, ..base }];
    for (law, expected) in depends {
        let changes = changes.map(|around| output(&law, &around) != output(&law, &base));
        assert_eq!(changes, expected, "{law:?}");
    }
}

#[test]
fn states_are_small_enough_to_be_copied_in_a_tick() {
    // What each remembers, without any padding: an integral, an integral, an offset and a timer.
    assert_eq!(size_of::<reset_integral::State>(), 4);
    assert_eq!(size_of::<rate_variable_integral::State>(), 4);
    assert_eq!(size_of::<reset_offset_integral::State>(), 8);
    // The largest of them and which it is.
    assert_eq!(size_of::<LawState>(), 12);
    assert_eq!(size_of::<CompensatorState>(), MAX_TERMS * 12);
    // And the encoder's two words, the velocity's fifteen and the tick.
    assert_eq!(size_of::<ControllerState>(), 4 * (12 + 2 + 15 + 1));
    const { assert!(size_of::<LawState>() <= 64 && size_of::<ControllerState>() <= 256) };
}
