//! A controller that is reset begins anew.

use std::iter::repeat_n;

use proptest::prelude::*;

use super::fixture::*;

proptest! {
    #![proptest_config(config())]

    #[test]
    fn start_in_mid_run_is_a_new_beginning(
        reference in reference(),
        before in lags(),
        after in lags(),
    ) {
        let before = near(&reference, &before);
        let after = near(&reference, &after);
        for (name, config) in controllers() {
            let controller = Controller::new(&config, &STM32F405).unwrap();
            let mut joint = Joint::start(&controller, low_half(before[0]), before[0]);
            for &counts in &before {
                joint.tick(low_half(counts), &reference);
            }
            joint = Joint::start(&controller, low_half(after[0]), after[0]);
            let restarted: Vec<_> =
                after.iter().map(|&counts| joint.tick(low_half(counts), &reference)).collect();
            let new = Controller::new(&config, &STM32F405).unwrap();
            prop_assert_eq!(restarted, run(&new, &reference, &after, low_half), "{}", name);
        }
    }

    /// At rest, where the velocity window holds zeros before and after, a reset takes away what the
    /// law had gathered and nothing else. In motion the window has to fill again, and nothing is
    /// promised.
    #[test]
    fn reset_at_rest_takes_away_only_what_the_law_had_gathered(
        fraction in fraction(),
        lags in lags(),
        lag in -250..=250i32,
    ) {
        let reference = step_to(Position { counts: 0, fraction });
        let mut counts = near(&reference, &lags);
        counts.extend(repeat_n(lag, 20));
        for (name, config) in controllers() {
            let controller = Controller::new(&config, &STM32F405).unwrap();
            let before = run(&controller, &reference, &counts, low_half)[counts.len() - 1];
            let after = Joint::start(&controller, low_half(lag), lag).tick(low_half(lag), &reference);
            prop_assert_eq!(
                (after.tick, after.counts, after.error, after.velocity, after.v_pd),
                (0, before.counts, before.error, before.velocity, before.v_pd),
                "{}", name
            );
            prop_assert_eq!(after.velocity, 0.0);
            let first = match name {
                "ri" if after.error.abs() > 0.5 => 0.0,
                "ri" => 4.0 * SAMPLE_TIME * after.error,
                "rvi" => 150.0 * SAMPLE_TIME * after.error,
                "roi" | "impulsive" | "observer" => 0.0,
                "pid" => 1.0 * SAMPLE_TIME * after.error,
                "two-reset-pid" => 4.0 * SAMPLE_TIME * after.error,
                // al/g, with al = 1.0 * 0.02 + 1.0 + 0.17/0.02 and g = 1 + 0.1/0.02.
                "proxy-sliding-mode" => (9.52 / 6.0 * after.error).clamp(-5.0, 5.0),
                // However large the error is, a profile sets out: J a_m (1.25 V), R_0 = 0.354 V,
                // and after a change D = 0.675 deg/s of its speed Kd D + B D = 0.315 V and Kp D h =
                // 0.025 V. What was before may have been a pulse.
                "robust" => {
                    prop_assert!(after.v_c.abs() <= 1.945, "{:?}", after);
                    continue;
                }
                // Nothing is gathered: the tick is the same in all but its number.
                _ => {
                    prop_assert_eq!(Tick { tick: before.tick, ..after }, before, "{}", name);
                    continue;
                }
            };
            prop_assert!((after.v_c - first).abs() <= 1e-6, "{name}: {after:?}, not {first}");
            let lost = (before.v_c - after.v_c).abs();
            prop_assert!((before.v - after.v).abs() <= lost + 1e-6, "{name}: from {before:?} to {after:?}");
        }
    }
}
