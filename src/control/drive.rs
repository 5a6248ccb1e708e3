//! The drive's conversions: from volts to its integer code, and from a code to a PWM compare value.
//!
//! ```text
//! code    = round(v / lsb), half away from zero, within +-floor(full scale / lsb)
//! compare = top/2 + round(code * top / (2 max)), half away from zero  (locked antiphase, analog)
//!         = round(|code| * top / max), half away from zero, and the direction   (sign-magnitude)
//! ```
//!
//! The thesis's D/A has an LSB of 0.00488 V (10 V / 2048) and a full scale of 5 V (section 3.2):
//! codes of +-1024. A PWM whose top equals the number of codes is the same thing configured
//! otherwise. Both maps are odd, so a drive without offset error favours no direction. The quotient
//! is computed as a product with the reciprocal of the LSB: at an exact half, the code can be the
//! neighbouring one.

use crate::control::hardware::Hardware;
use crate::units::error::{Allowed, HUGE, InvalidValue};
use crate::units::value::{Key, Table, Values, choice, key, table};

choice! {
    /// How the code reaches the bridge.
    pub enum PwmMode {
        /// Half duty is zero volts. The output and its complement drive a half-bridge each, with a
        /// dead time between them.
        LockedAntiphase = 0 "locked-antiphase",
        /// The duty is the magnitude, and a second pin is the direction. There is no complement.
        SignMagnitude = 1 "sign-magnitude",
        /// Half duty is zero volts. The output alone goes through a filter into an analog servo
        /// amplifier. Off is the amplifier's inhibit, and the output stays at half duty: a low
        /// output would be full negative effort.
        Analog = 2 "analog",
    }
}

table! {
    /// The configuration of a drive, in a user's units.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct DriveConfig (drive) "drive" {
        /// Largest output of the controller, V. It scales the duty and does not limit it: full duty
        /// is this output.
        full_scale: f32 = 0x0301 "full_scale_v", Above(0.0, HUGE), Needed(5.0);
        /// Volts of one code: one to 32767 codes a side.
        lsb: f32 =
            0x0302 "lsb_v", Above(drive.full_scale / 32_768.0, drive.full_scale), Needed(0.00488);
        /// Frequency of the PWM, Hz. The board's timer sets its bounds: 1300 to 5250000 at 168 MHz.
        pwm_hz: f32 = 0x0303 "pwm_hz", Above(0.0, 1e9), Needed(22e3);
        /// How the code reaches the bridge.
        mode: PwmMode = 0x0304 "mode", Any, Needed(PwmMode::LockedAntiphase);
        /// Largest share of the full duty that the output stage lets through: what the motor bears
        /// of the supply.
        duty_max: f32 = 0x0305 "duty_max", Above(0.0, 1.0), Default(1.0);
    }
}

/// A drive that is prepared for its ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    codes_per_volt: f32,
    /// Largest code. It fits an `i16`, and is stored in 32 bits, since the processor computes in 32
    /// bits alone.
    max_code: i32,
    mode: PwmMode,
    pwm_top: u16,
}

/// PWM setting of the timer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Duty {
    /// Compare value, from 0 to the top.
    pub compare: u16,
    /// Level of the direction pin (sign-magnitude only; false in the other modes).
    pub reverse: bool,
}

const PWM_HZ: Key = key(DriveConfig::ABOUT, "pwm_hz");

/// Returns the compare value of full duty: the even timer top nearest to `pwm_hz`. The timer counts
/// up and down (centre-aligned: one period is `2 top` clocks). The top is even, so that half duty
/// is a whole number.
///
/// # Errors
/// Refuses a frequency whose top does not fit 16 bits, or that leaves fewer than 16 duties a side.
///
/// ```
/// let (pwm_clock_hz, supply_top, dead_time_max) = (168e6, 4095, 6e-6);
/// let sample_time = [1e-4, 0.02];
/// let hardware = stiction::Hardware { pwm_clock_hz, supply_top, dead_time_max, sample_time };
/// assert_eq!(stiction::control::drive::pwm_top(&hardware, 22e3), Ok(3818)); // 22.001 kHz
/// ```
pub fn pwm_top(hardware: &Hardware, pwm_hz: f32) -> Result<u16, InvalidValue> {
    // The bound is a whole hundred, so that a person can read the message.
    let lowest = libm::ceilf(hardware.pwm_clock_hz / (4.0 * 32_767.0) / 100.0) * 100.0;
    let allowed = Allowed::Between(lowest, hardware.pwm_clock_hz / 32.0);
    if !allowed.includes(pwm_hz) {
        return Err(InvalidValue { key: PWM_HZ, found: pwm_hz, allowed });
    }
    Ok((libm::roundf(hardware.pwm_clock_hz / (4.0 * pwm_hz)) as u16).clamp(1, 32_767) * 2)
}

impl Drive {
    /// Validates and prepares a drive.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn new(config: &DriveConfig, hardware: &Hardware) -> Result<Self, InvalidValue> {
        let pwm_top = pwm_top(hardware, config.pwm_hz)?;
        config.validate()?;
        Ok(Self {
            codes_per_volt: 1.0 / config.lsb,
            max_code: max_code(config.full_scale / config.lsb).into(),
            mode: config.mode,
            pwm_top,
        })
    }

    /// Returns the largest code.
    ///
    /// ```
    /// use stiction::{Hardware, control::drive::{Drive, DriveConfig}, units::value::Table};
    /// let (pwm_clock_hz, supply_top, dead_time_max) = (168e6, 4095, 6e-6);
    /// let sample_time = [1e-4, 0.02];
    /// let hardware = Hardware { pwm_clock_hz, supply_top, dead_time_max, sample_time };
    /// let config = DriveConfig { full_scale: 1.0, lsb: 0.004, ..DriveConfig::EXAMPLE };
    /// assert_eq!(Drive::new(&config, &hardware).unwrap().max_code(), 250);
    /// ```
    pub const fn max_code(&self) -> i16 {
        self.max_code as i16
    }

    /// Returns how the code reaches the bridge.
    pub const fn mode(&self) -> PwmMode {
        self.mode
    }

    /// Returns the compare value of full duty.
    pub const fn pwm_top(&self) -> u16 {
        self.pwm_top
    }

    /// Returns the code of `v` volts: rounded half away from zero, within
    /// +-[`max_code`](Self::max_code).
    ///
    /// ```
    /// use stiction::{Hardware, control::drive::{Drive, DriveConfig, PwmMode}};
    /// let (pwm_clock_hz, supply_top, dead_time_max) = (168e6, 4095, 6e-6);
    /// let sample_time = [1e-4, 0.02];
    /// let hardware = Hardware { pwm_clock_hz, supply_top, dead_time_max, sample_time };
    /// let mode = PwmMode::LockedAntiphase;
    /// let [full_scale, lsb, pwm_hz, duty_max] = [5.0, 0.00488, 22e3, 1.0];
    /// let config = DriveConfig { full_scale, lsb, pwm_hz, mode, duty_max };
    /// let drive = Drive::new(&config, &hardware).unwrap();
    /// assert_eq!((drive.code(0.40), drive.code(-0.40)), (82, -82)); // 0.40016 V
    /// assert_eq!(drive.code(5.0), 1024);
    /// ```
    pub fn code(&self, v: f32) -> i16 {
        self.whole_code(v) as i16
    }

    /// Returns the code of `v` volts, as [`code`](Self::code) does, in 32 bits.
    #[inline]
    pub(crate) fn whole_code(&self, v: f32) -> i32 {
        let scaled = v * self.codes_per_volt;
        // Conversion truncates towards zero and saturates; the difference is exact in that range.
        let whole = scaled as i32;
        let rest = scaled - whole as f32;
        let step = i32::from(rest >= 0.5) - i32::from(rest <= -0.5);
        whole.saturating_add(step).max(-self.max_code).min(self.max_code)
    }

    /// Returns the PWM setting of a code.
    ///
    /// ```
    /// use stiction::{Hardware, control::drive::{Drive, DriveConfig, Duty, PwmMode}};
    /// let (pwm_clock_hz, supply_top, dead_time_max) = (168e6, 4095, 6e-6);
    /// let sample_time = [1e-4, 0.02];
    /// let hardware = Hardware { pwm_clock_hz, supply_top, dead_time_max, sample_time };
    /// let mode = PwmMode::LockedAntiphase;
    /// let [full_scale, lsb, pwm_hz, duty_max] = [5.0, 0.00488, 22e3, 1.0];
    /// let config = DriveConfig { full_scale, lsb, pwm_hz, mode, duty_max };
    /// let drive = Drive::new(&config, &hardware).unwrap();
    /// assert_eq!(drive.pwm_top(), 3818);
    /// assert_eq!(drive.duty(0), Duty { compare: 1909, reverse: false });
    /// assert_eq!(drive.duty(-1024), Duty { compare: 0, reverse: false });
    /// ```
    pub fn duty(&self, code: i16) -> Duty {
        self.duty_of(i32::from(code).max(-self.max_code).min(self.max_code))
    }

    /// Returns the PWM setting of a code whose magnitude is at most the largest code.
    #[inline]
    pub(crate) fn duty_of(&self, code: i32) -> Duty {
        let (max, magnitude) = (self.max_code.unsigned_abs(), code.unsigned_abs());
        let top = u32::from(self.pwm_top);
        match self.mode {
            PwmMode::LockedAntiphase | PwmMode::Analog => {
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

/// Returns the number of whole codes in `ratio`, full scale over LSB. If a decimal full scale is a
/// multiple of a decimal LSB (1.0 and 0.004), the rounding of three `f32`s can leave the ratio just
/// below the whole number. The whole number is then returned, since the last code would be lost
/// otherwise.
fn max_code(ratio: f32) -> i16 {
    let nearest = libm::roundf(ratio);
    let whole = if (ratio - nearest).abs() <= 1.5 * f32::EPSILON * ratio { nearest } else { ratio };
    whole as i16
}

/// Returns `numerator / denominator`, rounded half up. Neither sum overflows: both factors of the
/// numerator are 16 bits.
const fn rounded_ratio(numerator: u32, denominator: u32) -> u32 {
    match denominator {
        0 => 0,
        _ => (numerator + denominator / 2) / denominator,
    }
}
