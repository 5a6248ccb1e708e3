//! From volts to the drive's integer code, and from a code to a PWM compare value.
//!
//! ```text
//! code    = round(v / lsb), half away from zero, within +-floor(full scale / lsb)
//! compare = top/2 + round(code * top / (2 max)), half away from zero          (locked antiphase)
//!         = round(|code| * top / max), half away from zero, and the direction   (sign-magnitude)
//! ```
//!
//! The thesis's D/A has an LSB of 0.00488 V (10 V / 2048) and a full scale of 5 V (section 3.2): codes of
//! +-1024. A PWM whose top equals the number of codes is the same thing configured otherwise. Both maps are odd,
//! so a drive without offset error favours no direction. The quotient is computed as a product with
//! the reciprocal of the LSB: at an exact half it may fall to the neighbouring code.

use crate::error::{Allowed, Error, HUGE, above};
use serde::{Deserialize, Serialize};

/// How the code reaches the bridge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PwmMode {
    /// Half duty is zero volts; one output and its complement. Also the form for an RC filter into an analog
    /// servo amplifier.
    LockedAntiphase,
    /// The duty is the magnitude, a second pin the direction.
    SignMagnitude,
}

/// A drive, in a user's units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveConfig {
    /// Largest output, V.
    pub full_scale: f32,
    /// Volts of one code.
    pub lsb: f32,
    /// How the code reaches the bridge.
    pub mode: PwmMode,
    /// Compare value of full duty; even, so that half duty is a whole number.
    pub pwm_top: u16,
}

impl DriveConfig {
    /// The even timer top nearest to `pwm_hz` for a timer clocked at `timer_hz` that counts up and down
    /// (centre-aligned: one period is `2 top` clocks), within 2 to 65534.
    ///
    /// ```
    /// use stiction::drive::DriveConfig;
    /// assert_eq!(DriveConfig::centre_aligned_top(168e6, 22e3), 3818); // 22.001 kHz
    /// ```
    pub fn centre_aligned_top(timer_hz: f32, pwm_hz: f32) -> u16 {
        let half = libm::roundf(timer_hz / (4.0 * pwm_hz)) as u16;
        half.clamp(1, 32_767) * 2
    }

    /// Refuses values that are not positive, an LSB that gives fewer than one or more than 32767 codes a side,
    /// and an odd PWM top.
    ///
    /// # Errors
    /// Names the key.
    pub fn validate(&self) -> Result<(), Error> {
        above("full_scale_v", self.full_scale, 0.0, HUGE)?;
        above("lsb_v", self.lsb, self.full_scale / 32_768.0, self.full_scale)?;
        if self.pwm_top == 0 || !self.pwm_top.is_multiple_of(2) {
            let allowed = Allowed::EvenBetween(2.0, 65_534.0);
            return Err(Error { key: "pwm_top", found: f32::from(self.pwm_top), allowed });
        }
        Ok(())
    }
}

/// A drive, ready to be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    codes_per_volt: f32,
    max_code: i16,
    mode: PwmMode,
    pwm_top: u16,
}

/// What the timer is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Duty {
    /// Compare value, from 0 to the top.
    pub compare: u16,
    /// The direction pin (sign-magnitude only; false in locked antiphase).
    pub reverse: bool,
}

impl Drive {
    /// Validates and prepares a drive.
    ///
    /// # Errors
    /// As [`DriveConfig::validate`].
    pub fn new(config: &DriveConfig) -> Result<Self, Error> {
        config.validate()?;
        Ok(Self {
            codes_per_volt: 1.0 / config.lsb,
            max_code: max_code(config.full_scale / config.lsb),
            mode: config.mode,
            pwm_top: config.pwm_top,
        })
    }

    /// The largest code.
    ///
    /// ```
    /// use stiction::drive::{Drive, DriveConfig, PwmMode};
    /// let config = DriveConfig { full_scale: 1.0, lsb: 0.004, mode: PwmMode::SignMagnitude, pwm_top: 500 };
    /// assert_eq!(Drive::new(&config).unwrap().max_code(), 250);
    /// ```
    pub const fn max_code(&self) -> i16 {
        self.max_code
    }

    /// How the code reaches the bridge.
    pub const fn mode(&self) -> PwmMode {
        self.mode
    }

    /// Compare value of full duty.
    pub const fn pwm_top(&self) -> u16 {
        self.pwm_top
    }

    /// The code of `v` volts: rounded half away from zero, within +-[`max_code`](Self::max_code).
    ///
    /// ```
    /// use stiction::drive::{Drive, DriveConfig, PwmMode};
    /// let config = DriveConfig { full_scale: 5.0, lsb: 0.00488, mode: PwmMode::LockedAntiphase, pwm_top: 3818 };
    /// let drive = Drive::new(&config).unwrap();
    /// assert_eq!((drive.code(0.40), drive.code(-0.40)), (82, -82)); // 0.40016 V
    /// assert_eq!(drive.code(5.0), 1024);
    /// ```
    #[cfg_attr(not(target_os = "none"), inline)]
    pub fn code(&self, v: f32) -> i16 {
        let scaled = v * self.codes_per_volt;
        // Conversion truncates towards zero and saturates; the difference is exact in that range.
        let whole = scaled as i32;
        let rest = scaled - whole as f32;
        let step = i32::from(rest >= 0.5) - i32::from(rest <= -0.5);
        let max = i32::from(self.max_code);
        whole.saturating_add(step).max(-max).min(max) as i16
    }

    /// The PWM setting of a code.
    ///
    /// ```
    /// use stiction::drive::{Drive, DriveConfig, Duty, PwmMode};
    /// let config = DriveConfig { full_scale: 5.0, lsb: 0.00488, mode: PwmMode::LockedAntiphase, pwm_top: 3818 };
    /// let drive = Drive::new(&config).unwrap();
    /// assert_eq!(drive.duty(0), Duty { compare: 1909, reverse: false });
    /// assert_eq!(drive.duty(-1024), Duty { compare: 0, reverse: false });
    /// ```
    #[cfg_attr(not(target_os = "none"), inline)]
    pub fn duty(&self, code: i16) -> Duty {
        let max = u32::from(self.max_code.unsigned_abs());
        let magnitude = u32::from(code.unsigned_abs()).min(max);
        let top = u32::from(self.pwm_top);
        match self.mode {
            PwmMode::LockedAntiphase => {
                let neutral = top / 2;
                let swing = rounded_ratio(magnitude * neutral, max);
                let compare = if code < 0 { neutral - swing } else { neutral + swing };
                Duty { compare: compare as u16, reverse: false }
            }
            PwmMode::SignMagnitude => {
                Duty { compare: rounded_ratio(magnitude * top, max) as u16, reverse: code < 0 }
            }
        }
    }
}

/// The number of whole codes in `ratio`. A decimal full scale that is a multiple of a decimal LSB (1.0 and 0.004) may
/// fall short of it by the rounding of three `f32`s, and would lose its last code.
fn max_code(ratio: f32) -> i16 {
    let nearest = libm::roundf(ratio);
    let whole = if (ratio - nearest).abs() <= 1.5 * f32::EPSILON * ratio { nearest } else { ratio };
    whole as i16
}

/// `numerator / denominator`, rounded half up. Neither sum overflows: both factors of the numerator are 16 bits.
const fn rounded_ratio(numerator: u32, denominator: u32) -> u32 {
    match denominator {
        0 => 0,
        _ => (numerator + denominator / 2) / denominator,
    }
}
