//! The drive maps volts to a code, and a code to a compare value of the timer.

use proptest::prelude::*;
use stiction::control::drive::{Drive, DriveConfig, Duty, PwmMode, pwm_top};
use stiction::parameters::names::ValuePath;
use stiction::{Hardware, InvalidValue};

use super::{HALF_ULP, config};

/// The figures of the board.
const STM32F405: Hardware = Hardware {
    pwm_clock_hz: 168e6,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};

/// A timer of which 65 534 is the top at 100 Hz, exactly: the longest period that is allowed.
const TIMER: Hardware = Hardware {
    pwm_clock_hz: 4.0 * 32_767.0 * 100.0,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};

/// A drive whose timer has this top.
fn drive(full_scale: f32, lsb: f32, mode: PwmMode, top: u16) -> Result<Drive, InvalidValue> {
    let pwm_hz = TIMER.pwm_clock_hz / (2.0 * f32::from(top));
    let drive = Drive::new(&DriveConfig { full_scale, lsb, mode, pwm_hz, duty_max: 1.0 }, &TIMER)?;
    assert_eq!(drive.pwm_top(), top);
    Ok(drive)
}

#[test]
fn pwm_top_is_the_even_one_nearest_to_the_frequency() {
    for hz in [1300.0, 1301.0, 9_999.0, 20e3, 22e3, 100e3, 1e6, 5.25e6f32] {
        let exact = 168e6 / (2.0 * f64::from(hz));
        let top = pwm_top(&STM32F405, hz).unwrap();
        // The next even ones are two away.
        let off = (f64::from(top) - exact).abs();
        assert!(top.is_multiple_of(2) && off <= 1.0 + 1e-6 * exact, "{hz} Hz: {top}, {exact}");
    }
    assert_eq!(
        [1300.0, 22e3, 5.25e6].map(|hz| pwm_top(&STM32F405, hz)),
        [Ok(64_616), Ok(3818), Ok(16)]
    );
    assert_eq!(pwm_top(&TIMER, 100.0), Ok(65_534));
    for (hardware, hz) in
        [(STM32F405, 1299.0), (STM32F405, 5.26e6), (TIMER, 99.9), (TIMER, f32::NAN)]
    {
        let error = pwm_top(&hardware, hz).unwrap_err();
        assert_eq!(ValuePath(error.key).to_string(), "drive.pwm_hz", "{hz} Hz");
    }
}

#[test]
fn code_rounds_an_exact_half_away_from_zero() {
    // With an LSB of 2^-8 V every half is a float, and so is its neighbour.
    let drive = drive(5.0, 1.0 / 256.0, PwmMode::LockedAntiphase, 3818).unwrap();
    assert_eq!(drive.max_code(), 1280);
    for k in 0..1280i16 {
        let half = (f32::from(k) + 0.5) / 256.0;
        assert_eq!((drive.code(half), drive.code(-half)), (k + 1, -k - 1), "{half} V");
        let below = half.next_down();
        assert_eq!((drive.code(below), drive.code(-below)), (k, -k), "{below} V");
    }
    for beyond in [1280.5 / 256.0, 1281.0 / 256.0, 1e9, f32::MAX, f32::INFINITY] {
        assert_eq!((drive.code(beyond), drive.code(-beyond)), (1280, -1280), "{beyond} V");
    }
    assert_eq!(drive.code(f32::NAN), 0);
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn code_is_nearest_odd_and_monotone(
        full_scale in 0.1f32..100.0,
        codes in 1.0f32..32_767.0,
        shares in (-1.5f32..1.5, -1.5f32..1.5),
        bits in any::<(u32, u32)>(),
    ) {
        let lsb = full_scale / codes;
        let drive = drive(full_scale, lsb, PwmMode::LockedAntiphase, 3818).unwrap();
        let max = f64::from(drive.max_code());
        let volts = (shares.0 * full_scale, shares.1 * full_scale);
        let exact = (f64::from(volts.0) / f64::from(lsb)).clamp(-max, max);
        let code = f64::from(drive.code(volts.0));
        // The reciprocal and the product are each rounded to half a unit in the last place.
        let off = (code - exact).abs();
        prop_assert!(off <= 0.5 + 2.1 * HALF_ULP * exact.abs(), "{volts:?}: {exact}, not {code}");

        for (a, b) in [volts, (f32::from_bits(bits.0), f32::from_bits(bits.1))] {
            for x in [a, b] {
                prop_assert_eq!(drive.code(-x), -drive.code(x), "{} V", x);
                prop_assert!(x.is_nan() || drive.code(x.next_up()) >= drive.code(x), "{x} V");
            }
            if a <= b {
                prop_assert!(drive.code(a) <= drive.code(b), "{a} V and {b} V");
            }
        }
    }

    #[test]
    fn code_of_a_power_of_two_is_the_rounded_quotient_itself(
        exponent in 2i32..14, share in -1.5f32..1.5,
    ) {
        let lsb = 0.5f32.powi(exponent);
        let drive = drive(1.0, lsb, PwmMode::LockedAntiphase, 3818).unwrap();
        // Rounded to a tenth of a code, so that many are exact halves.
        let v = (share * 10.0 / lsb).round() / 10.0 * lsb;
        for v in [v, share] {
            let expected = (v / lsb).round().clamp(-1.0 / lsb, 1.0 / lsb);
            prop_assert_eq!(f32::from(drive.code(v)), expected, "{} V", v);
        }
    }
}

#[test]
fn duty_is_the_rounded_share_of_the_top_for_every_code() {
    /// Numerator over denominator (both positive), rounded half up.
    fn rounded(numerator: i64, denominator: i64) -> i64 {
        (2 * numerator + denominator).div_euclid(2 * denominator)
    }
    for (codes, top) in [
        (1, 16),
        (1, 65_534),
        (3, 16),
        (1024, 3818),
        (1024, 2048),
        (1000, 1000),
        (32_767, 65_534),
        (32_767, 16),
    ] {
        let of = |mode| drive(f32::from(codes), 1.0, mode, top).unwrap();
        let (antiphase, magnitude) = (of(PwmMode::LockedAntiphase), of(PwmMode::SignMagnitude));
        let analog = of(PwmMode::Analog);
        assert_eq!((antiphase.max_code(), magnitude.max_code()), (codes, codes));
        for code in i16::MIN..=i16::MAX {
            let size = i64::from(code).abs().min(i64::from(codes));
            let (top, codes) = (i64::from(top), i64::from(codes));

            let Duty { compare, reverse } = antiphase.duty(code);
            let swing = i64::from(code.signum()) * rounded(size * top, 2 * codes);
            assert_eq!(
                (i64::from(compare), reverse),
                (top / 2 + swing, false),
                "{code} of {codes}, top {top}"
            );
            // The filter behind it makes the same volts of it.
            assert_eq!(analog.duty(code), antiphase.duty(code));

            let Duty { compare, reverse } = magnitude.duty(code);
            assert_eq!(
                (i64::from(compare), reverse),
                (rounded(size * top, codes), code < 0),
                "{code} of {codes}, top {top}"
            );
        }
        assert_eq!([-codes, codes].map(|code| antiphase.duty(code).compare), [0, top]);
    }
}
