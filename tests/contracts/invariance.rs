//! These must not matter: a law without gain, the side, the sense of the encoder, the place of its
//! origin.

use proptest::prelude::*;

use stiction::parameters;

use super::fixture::*;

/// The mirror image of a position in the origin.
fn mirrored(position: Position) -> Position {
    let Position { counts, fraction } = position;
    if fraction == 0.0 {
        Position::from_counts(-counts)
    } else {
        Position { counts: -counts - 1, fraction: 1.0 - fraction }
    }
}

/// The law with zero for the gain that stands before all of its output.
fn without_gain(mut law: Gains) -> Gains {
    let gain = match law.name() {
        "ri" | "rvi" => "ki_v_per_deg_s",
        "roi" => "v_roi_deg_per_s",
        "feedforward" => "v_slip_v",
        "dnpf" => "theta_b_deg",
        "srnf" => "v_ms_v",
        "observer" => "observer_largest_v",
        "pid" | "two-reset-pid" => "ki_v_per_deg_s",
        "impulsive" => "pulse_effort_v",
        other => unreachable!("{other}: say here which gain it is"),
    };
    let key =
        keys(&law).into_iter().find(|key| parameters::about(*key).unwrap().name == gain).unwrap();
    assert_eq!(law.set(key, 0f32.to_bits()), Ok(true));
    law
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn law_with_a_gain_of_zero_is_pd_to_the_bit(reference in reference(), lags in lags()) {
        let beside = laws().filter(|law| !law.2.replaces_pd());
        let zeroed: Vec<_> = beside.map(|law| without_gain(law.2)).collect();
        let counts = near(&reference, &lags);
        let output = |laws: &[Gains]| {
            let controller = Controller::new(&configured(0.17, laws), &STM32F405).unwrap();
            outputs(&run(&controller, &reference, &counts, low_half))
        };
        let pd = output(&[]);
        for &law in &zeroed {
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
        mode in modes(),
    ) {
        let counts = near(&reference, &lags);
        let negated: Vec<_> = counts.iter().map(|counts| -counts).collect();
        for (name, config) in controllers() {
            let config = changed(&config, |config| config.drive.mode = mode);
            let controller = Controller::new(&config, &STM32F405).unwrap();
            let ticks = run(&controller, &reference, &counts, low_half);
            for (tick, image) in ticks.iter().zip(run(&controller, &image, &negated, low_half)) {
                prop_assert_eq!(
                    (image.v_pd, image.v_c, image.v, image.v_applied, image.code, image.saturated),
                    (-tick.v_pd, -tick.v_c, -tick.v, -tick.v_applied, -tick.code, tick.saturated),
                    "{}: tick {}", name, tick.tick
                );
                let Duty { compare, reverse } = tick.duty();
                let duty = match mode {
                    PwmMode::LockedAntiphase | PwmMode::Analog => {
                        Duty { compare: 3818 - compare, reverse }
                    }
                    PwmMode::SignMagnitude => Duty { compare, reverse: tick.code > 0 },
                };
                prop_assert_eq!(image.duty(), duty, "{}: tick {}", name, tick.tick);
            }
        }
    }

    #[test]
    fn reversed_encoder_is_the_same_joint(reference in reference(), lags in lags()) {
        let counts = near(&reference, &lags);
        for (name, config) in controllers() {
            let forward = Controller::new(&config, &STM32F405).unwrap();
            let reverse = changed(&config, |config| config.encoder.direction = Direction::Reverse);
            let reverse = Controller::new(&reverse, &STM32F405).unwrap();
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
                let controller = Controller::new(&config, &STM32F405).unwrap();
                let counter =
                    |counts: i32| (counts.wrapping_sub(shift) as u32).wrapping_add(origin);
                let moved_back: Vec<_> = run(&controller, &shifted, &shifted_counts, counter)
                    .into_iter()
                    .map(|mut tick| {
                        tick.counts = tick.counts.wrapping_sub(shift);
                        tick.reference_counts = tick.reference_counts.wrapping_sub(shift);
                        tick
                    })
                    .collect();
                let ticks = run(&controller, &reference, &counts, |counts| counts as u32);
                prop_assert_eq!(moved_back, ticks, "{}", name);
            }
        }
    }
}
