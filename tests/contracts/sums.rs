//! A sum of laws gives what its laws give.

use proptest::prelude::*;
use stiction::control::laws::FIRST_LAW;

use super::fixture::*;

proptest! {
    #![proptest_config(config())]

    #[test]
    fn sum_of_laws_is_the_sum_of_their_parts(reference in reference(), lags in lags()) {
        let counts = near(&reference, &lags);
        let ticks = |laws: &[Gains]| {
            let controller = Controller::new(&configured(0.17, laws), &STM32F405).unwrap();
            run(&controller, &reference, &counts, low_half)
        };
        // A law that replaces PD stands alone. The observer and the laws that live on the host look
        // at what was applied, which is that of the sum.
        let in_sums = |law: &Gains| {
            !law.replaces_pd() && law.on_the_device() && law.name() != "observer"
        };
        let laws: Vec<_> = laws().map(|(_, _, law)| law).filter(in_sums).collect();
        let parts: Vec<_> = laws.iter().map(|law| ticks(&[*law])).collect();
        for (i, a) in laws.iter().enumerate() {
            for (j, b) in laws.iter().enumerate().skip(i + 1) {
                let sum = ticks(&[*a, *b]);
                for (k, tick) in sum.iter().enumerate() {
                    let sum = parts[i][k].v_c + parts[j][k].v_c;
                    prop_assert_eq!(tick.v_c, sum, "{:?} and {:?}", a, b);
                }
                // Two floats add up to the same in either order.
                prop_assert_eq!(ticks(&[*b, *a]), sum, "{:?} and {:?}", b, a);
            }
        }
    }

    #[test]
    fn order_of_four_laws_changes_no_more_than_the_rounding(
        reference in reference(), lags in lags(),
    ) {
        let counts = near(&reference, &lags);
        let ticks = |laws: &[Gains]| {
            let controller = Controller::new(&configured(0.17, laws), &STM32F405).unwrap();
            run(&controller, &reference, &counts, low_half)
        };
        let laws = [RI, ROI, FEEDFORWARD, SRNF];
        let parts = laws.map(|law| ticks(&[law]));
        let orders = [[0, 1, 2, 3], [3, 2, 1, 0], [1, 3, 0, 2]];
        let orders = orders.map(|order| ticks(&order.map(|i: usize| laws[i])));
        for k in 0..counts.len() {
            let sum: f64 = parts.iter().map(|part| f64::from(part[k].v_c)).sum();
            for order in &orders {
                // Three additions of numbers that stay below 16 V, each to half a unit in the last
                // place.
                let off = (f64::from(order[k].v_c) - sum).abs();
                prop_assert!(off <= 3.0 * 5e-7, "{:?}, not {sum}", order[k]);
                // Across an edge between two codes that makes a difference of one code.
                prop_assert!((order[k].code - orders[0][k].code).abs() <= 1);
            }
        }
    }
}

/// Two of the same law have no defined sum: integrate twice as fast, or each up to the full
/// scale.
#[test]
fn a_law_may_not_be_there_twice() {
    for (name, _, law) in laws() {
        let before = if law == SRNF { RI } else { SRNF };
        for (laws, place) in
            [(vec![law, law], 1), (vec![before, law, law], 2), (vec![law, before, law], 2)]
        {
            if law.replaces_pd() {
                continue;
            }
            let error = Controller::new(&configured(0.17, &laws), &STM32F405).unwrap_err();
            let id = f32::from(law.id());
            assert_eq!(
                (error.key, error.found),
                (Key(FIRST_LAW.0 + place), id),
                "{name}: {laws:?}"
            );
        }
    }
}
