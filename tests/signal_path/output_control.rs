//! The control of TIM1's outputs, held against RM0090: the file is the firmware's own.

use stiction::control::drive::PwmMode;

#[path = "../../src/board/output_control.rs"]
mod of_the_board;

use of_the_board::OutputControl;

const CLOCK_HZ: f32 = 168e6;

/// The dead time of a code, in clocks: RM0090, `DTG` of TIMx_BDTR, and the step of its range.
fn clocks(code: u8) -> (u32, u32) {
    let low = |bits: u32| u32::from(code) & ((1 << bits) - 1);
    match code >> 5 {
        0..=3 => (low(7), 1),
        4 | 5 => ((64 + low(6)) * 2, 2),
        6 => ((32 + low(5)) * 8, 8),
        _ => ((32 + low(5)) * 16, 16),
    }
}

#[test]
fn a_dead_time_is_never_shorter_than_asked_for_and_never_a_step_longer() {
    let code = |dead_time| OutputControl::of(PwmMode::LockedAntiphase, dead_time, CLOCK_HZ);
    // RM0090's own examples at 8 MHz, the ends of its ranges: 15 875 ns, 31 750 ns, 63 us, 126 us.
    for (ns, ends) in [(15_875.0, 127), (31_750.0, 0xBF), (63_000.0, 0xDF), (126_000.0, 0xFF)] {
        let control = OutputControl::of(PwmMode::LockedAntiphase, ns * 1e-9, 8e6);
        assert_eq!(control.dead_time_code, ends, "{ns} ns");
    }
    for wanted in 0..=1008u32 {
        // In the middle of a clock, which no rounding of `f32` leaves.
        let dead_time = (f64::from(wanted) - 0.5).max(0.0) / f64::from(CLOCK_HZ);
        let (made, step) = clocks(code(dead_time as f32).dead_time_code);
        assert!((wanted..wanted + step).contains(&made), "{wanted} clocks: {made}");
    }
    // The longest that `Hardware::dead_time_max` lets through.
    assert_eq!(code(6e-6).dead_time_code, 0xFF);
}

#[test]
fn only_locked_antiphase_has_a_complement_and_a_dead_time() {
    let [antiphase, magnitude, analog] =
        [PwmMode::LockedAntiphase, PwmMode::SignMagnitude, PwmMode::Analog]
            .map(|mode| OutputControl::of(mode, 1e-6, CLOCK_HZ));
    assert_eq!((antiphase.complement, clocks(antiphase.dead_time_code).0), (true, 168));
    for control in [magnitude, analog, OutputControl::UNKNOWN] {
        assert!(!control.complement && control.dead_time_code == 0, "{control:?}");
    }
}

#[test]
fn no_mode_drives_a_pin_to_a_level_that_is_an_effort() {
    // Low is the off of a bridge, and full negative effort of an analog amplifier.
    for (mode, low_is_off) in
        [(PwmMode::LockedAntiphase, true), (PwmMode::SignMagnitude, true), (PwmMode::Analog, false)]
    {
        let control = OutputControl::of(mode, 1e-6, CLOCK_HZ);
        assert_eq!(control.driven_when_off, low_is_off, "{mode:?}");
        assert_eq!(control.neutral_when_off, !low_is_off, "{mode:?}");
    }
    // An output without a configured wiring drives nothing.
    let OutputControl { driven_when_off, neutral_when_off, .. } = OutputControl::UNKNOWN;
    assert!(!driven_when_off && !neutral_when_off);
}
