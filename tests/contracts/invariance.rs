//! What must not matter: a law without gain, the side, the sense of the encoder, the place of its origin.

use proptest::prelude::*;

use super::fixture::*;

/// Mirror image in the origin.
fn mirrored(position: Position) -> Position {
    let Position { counts, fraction } = position;
    if fraction == 0.0 {
        Position::from_counts(-counts)
    } else {
        Position { counts: -counts - 1, fraction: 1.0 - fraction }
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn law_with_a_gain_of_zero_is_pd_to_the_bit(reference in reference(), lags in lags()) {
        let zeroed = [
            Gains::ResetIntegral(ResetIntegralGains { ki: 0.0, theta_ri: 0.5 }),
            Gains::RateVariableIntegral(RateVariableIntegralGains { ki: 0.0, gamma: 0.05 }),
            Gains::ResetOffsetIntegral(ResetOffsetIntegralGains { t_roi: 0.14, v_roi: 0.0 }),
            Gains::Feedforward(FeedforwardGains { v_slip: 0.0, v_ff: 0.001 }),
            Gains::DiscontinuousNonlinearProportional(DiscontinuousNonlinearProportionalGains {
                theta_b: 0.0,
            }),
            Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms: 0.0, alpha: 100.0 }),
        ];
        let counts = near(&reference, &lags);
        let output = |laws: &[Gains]| {
            outputs(&run(&Controller::new(&configured(0.17, laws)).unwrap(), &reference, &counts, low_half))
        };
        let pd = output(&[]);
        for law in zeroed {
            prop_assert_eq!(&output(&[law]), &pd, "{:?}", law);
        }
        prop_assert_eq!(&output(&zeroed[..MAX_TERMS]), &pd);
    }

    #[test]
    fn mirrored_motion_gives_the_mirrored_effort(
        (reference, image) in prop_oneof![
            place().prop_map(|to| (step_to(to), step_to(mirrored(to)))),
            corners().prop_map(|corners| {
                let image: Vec<_> = corners
                    .iter()
                    .map(|&Corner { tick, position }| corner(tick, mirrored(position)))
                    .collect();
                (through(&corners, HALF_BLEND_S), through(&image, HALF_BLEND_S))
            }),
        ],
        lags in lags(),
        mode in prop_oneof![Just(PwmMode::LockedAntiphase), Just(PwmMode::SignMagnitude)],
    ) {
        let counts = near(&reference, &lags);
        let negated: Vec<_> = counts.iter().map(|counts| -counts).collect();
        for (name, config) in controllers() {
            let config = changed(&config, |config| config.drive.mode = mode);
            let controller = Controller::new(&config).unwrap();
            let ticks = run(&controller, &reference, &counts, low_half);
            for (tick, image) in ticks.iter().zip(run(&controller, &image, &negated, low_half)) {
                prop_assert_eq!(
                    (image.v_pd, image.v_c, image.v, image.code, image.saturated),
                    (-tick.v_pd, -tick.v_c, -tick.v, -tick.code, tick.saturated),
                    "{}: tick {}", name, tick.tick
                );
                let Duty { compare, reverse } = tick.duty;
                let duty = match mode {
                    PwmMode::LockedAntiphase => Duty { compare: 3818 - compare, reverse },
                    PwmMode::SignMagnitude => Duty { compare, reverse: tick.code > 0 },
                };
                prop_assert_eq!(image.duty, duty, "{}: tick {}", name, tick.tick);
            }
        }
    }

    #[test]
    fn reversed_encoder_is_the_same_joint(reference in reference(), lags in lags()) {
        let counts = near(&reference, &lags);
        for (name, config) in controllers() {
            let forward = Controller::new(&config).unwrap();
            let reverse = changed(&config, |config| config.encoder.direction = Direction::Reverse);
            let reverse = Controller::new(&reverse).unwrap();
            let counts_down = |counts: i32| low_half(-counts);
            prop_assert_eq!(
                run(&reverse, &reference, &counts, counts_down),
                run(&forward, &reference, &counts, low_half),
                "{}", name
            );
        }
    }

    #[test]
    fn shift_of_the_origin_changes_nothing_else(
        (from, to) in (place(), place()),
        lags in lags(),
        shift in prop_oneof![any::<i32>(), Just(i32::MAX), Just(i32::MIN)],
        origin in prop_oneof![any::<u32>(), Just(0xFFFF), Just(0x7FFF_FFFF), Just(0xFFFF_FFFF)],
        bits in prop_oneof![Just(CounterBits::Sixteen), Just(CounterBits::ThirtyTwo)],
    ) {
        let moved = |Position { counts, fraction }: Position, shift: i32| {
            Position { counts: counts.wrapping_add(shift), fraction }
        };
        let step = |shift| step_to(moved(to, shift));
        let trajectory = |shift| {
            through(&[corner(20, moved(from, shift)), corner(140, moved(to, shift))], 0.25)
        };
        for (reference, shifted) in [(step(0), step(shift)), (trajectory(0), trajectory(shift))] {
            let counts = near(&reference, &lags);
            let shifted_counts = near(&shifted, &lags);
            for (name, config) in controllers() {
                let config = changed(&config, |config| config.encoder.counter_bits = bits);
                let controller = Controller::new(&config).unwrap();
                let counter = |counts: i32| (counts.wrapping_sub(shift) as u32).wrapping_add(origin);
                let moved_back: Vec<_> = run(&controller, &shifted, &shifted_counts, counter)
                    .into_iter()
                    .map(|mut tick| {
                        tick.counts = tick.counts.wrapping_sub(shift);
                        tick.setpoint.position.counts = tick.setpoint.position.counts.wrapping_sub(shift);
                        tick
                    })
                    .collect();
                let ticks = run(&controller, &reference, &counts, |counts| counts as u32);
                prop_assert_eq!(moved_back, ticks, "{}", name);
            }
        }
    }
}
