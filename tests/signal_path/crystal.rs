//! The judgement of the crystal, over the tolerances of both oscillators: the file is the
//! firmware's own.

use proptest::prelude::*;

use super::config;

#[path = "../../src/board/crystal.rs"]
mod of_the_board;

use of_the_board::{CAPTURES, Crystal, DIVIDER, FITTED_MHZ};

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
    fn each_of_the_four_crystals_is_recognised_with_any_part(
        mhz in prop::sample::select(FITTED_MHZ.to_vec()),
        internal in INTERNAL, crystal in -0.005..=0.005f64, edge in 0.0..1.0f64
    ) {
        let counts = counts(f64::from(mhz) * 1e6 * (1.0 + crystal), internal, edge);
        prop_assert_eq!(Crystal::of(Some(counts)), Crystal::Measured(mhz), "{} counts", counts);
    }

    #[test]
    fn a_usual_crystal_of_another_frequency_is_refused_with_any_part(
        megahertz in prop::sample::select(vec![1.0, 4.0, 6.0, 10.0, 20.0, 30.0]),
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
fn a_crystal_of_another_frequency_is_reported_as_such_whatever_the_pll_would_do() {
    for megahertz in [4.0, 10.0, 20.0] {
        let judged = Crystal::of(Some(counts(megahertz * 1e6, 0.0, 0.5)));
        let started = judged.with_pll(|_| panic!("the PLL is started on {megahertz} MHz"));
        assert!(
            matches!(started, Crystal::Wrong(_)) && started == judged,
            "{megahertz}: {started:?}"
        );
    }
}

#[test]
fn the_pll_locks_with_the_divider_of_the_measured_crystal_or_the_crystal_counts_as_absent() {
    let measured = FITTED_MHZ.map(|mhz| (Some(counts(f64::from(mhz) * 1e6, 0.0, 0.5)), mhz));
    // One that could not be measured is taken for that of the wiring page.
    for (counts, expected) in measured.into_iter().chain([(None, 8), (Some(0), 8)]) {
        let judged = Crystal::of(counts);
        assert_eq!(judged.mhz(), Some(expected));
        let with = |locks| judged.with_pll(|mhz| mhz == expected && locks);
        assert_eq!([with(true), with(false)], [judged, Crystal::Absent]);
    }
}

#[test]
fn a_crystal_that_was_not_captured_is_used_and_reported_as_not_measured() {
    for counts in [None, Some(0)] {
        assert_eq!(Crystal::of(counts), Crystal::NotMeasured);
    }
    assert_eq!([Crystal::Absent.mhz(), Crystal::Wrong(10.0).mhz()], [None, None]);
}
