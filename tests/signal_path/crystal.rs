//! The judgement of the crystal, over the tolerances of both oscillators: the file is the
//! firmware's own.

use proptest::prelude::*;

use super::config;

#[path = "../../src/board/crystal.rs"]
mod of_the_board;

use of_the_board::{CAPTURES, Crystal, DIVIDER};

/// Counts of an internal oscillator (relative error) in the captures of a crystal (Hz), whose edges
/// come anywhere within a count.
fn counts(crystal_hz: f64, internal_error: f64, edge: f64) -> u32 {
    let seconds = f64::from(CAPTURES) * 8.0 * f64::from(DIVIDER) / crystal_hz;
    (seconds * 16e6 * (1.0 + internal_error) + edge) as u32
}

/// The data sheet's limits of the internal oscillator from -40 to 105 C.
const INTERNAL: std::ops::RangeInclusive<f64> = -0.08..=0.045;

proptest! {
    #![proptest_config(config())]

    #[test]
    fn eight_megahertz_is_accepted_with_any_part(
        internal in INTERNAL, crystal in -0.005..=0.005f64, edge in 0.0..1.0f64
    ) {
        let counts = counts(8e6 * (1.0 + crystal), internal, edge);
        prop_assert_eq!(Crystal::of(Some(counts)), Crystal::Right, "{} counts", counts);
    }

    #[test]
    fn a_usual_crystal_of_another_frequency_is_refused_with_any_part(
        megahertz in prop::sample::select(vec![1.0, 4.0, 6.0, 10.0, 12.0, 16.0, 20.0, 25.0, 26.0]),
        internal in INTERNAL, crystal in -0.005..=0.005f64, edge in 0.0..1.0f64
    ) {
        let counts = counts(megahertz * 1e6 * (1.0 + crystal), internal, edge);
        let Crystal::Wrong(measured) = Crystal::of(Some(counts)) else {
            return Err(TestCaseError::fail(format!("{megahertz} MHz passes: {counts} counts")));
        };
        // The measured value is off by the two oscillators' errors, and two counts.
        let error = f64::from(measured) / megahertz - 1.0;
        prop_assert!((-0.055..0.095).contains(&error), "{megahertz} MHz: {measured}");
    }
}

#[test]
fn a_crystal_of_another_frequency_is_told_as_such_whatever_the_pll_would_do() {
    // 4 and 25 MHz: the PLL's input would be 0.5 and 3.1 MHz, out of its range.
    for megahertz in [4.0, 12.0, 25.0] {
        let judged = Crystal::of(Some(counts(megahertz * 1e6, 0.0, 0.5)));
        // The PLL is not started on it.
        let started = judged.with_pll(|| panic!("the PLL is started on {megahertz} MHz"));
        assert!(
            matches!(started, Crystal::Wrong(_)) && started == judged,
            "{megahertz}: {started:?}"
        );
    }
    // One of the right frequency, and one that could not be measured, have to carry the PLL.
    for counts in [Some(counts(8e6, 0.0, 0.5)), None] {
        let judged = Crystal::of(counts);
        assert_eq!(judged.with_pll(|| true), judged);
        assert_eq!(judged.with_pll(|| false), Crystal::Absent);
    }
}

#[test]
fn a_crystal_that_was_not_captured_is_used_and_said_to_be_not_measured() {
    for counts in [None, Some(0)] {
        assert_eq!(Crystal::of(counts), Crystal::NotMeasured);
    }
    assert!(Crystal::NotMeasured.is_used() && Crystal::Right.is_used());
    assert!(!Crystal::Absent.is_used() && !Crystal::Wrong(12.0).is_used());
}
