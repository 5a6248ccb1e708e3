//! Control of TIM1's outputs in each mode of the drive. Nothing here accesses a register, so that a
//! test on a host compares it with the manual. The names are those of RM0090, "Output control bits
//! for complementary OCx and OCxN channels with break feature" (table 94 of revision 11) and
//! TIMx_BDTR.
//!
//! | mode | PB13 | dead time | with MOE clear (break, reset by software, halted by a probe) |
//! |---|---|---|---|
//! | locked antiphase | the complement | inserted | both pins are driven low |
//! | sign-magnitude | low | none | both pins are driven low |
//! | analog | low | none | neither pin is driven |
//!
//! To an analog amplifier a low pin is full negative effort, and no level of a pin is its zero. So
//! if the hardware has to end the PWM, the pin is released, and a divider on the board holds the
//! filter at half scale, as it does in reset (docs/reference/wiring.md). If the program turns the
//! output off, the PWM continues at half duty.

use stiction::control::drive::PwmMode;

/// The control of TIM1's channel 1 and its complement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutputControl {
    /// Whether the complement is switched (`CC1NE`). Only then does the timer insert a dead time.
    pub complement: bool,
    /// Whether the pins are driven low while `MOE` is clear (`OSSI`). If not, they are released.
    pub driven_when_off: bool,
    /// Whether the PWM continues at a neutral duty while the output is off, so that only the enable
    /// pin turns the bridge off.
    pub neutral_when_off: bool,
    /// The code of the dead time (`DTG`).
    pub dead_time_code: u8,
}

impl OutputControl {
    /// The control without parameters, when the wiring is unknown: the pins are released, as in
    /// reset.
    pub const UNKNOWN: Self = Self {
        complement: false,
        driven_when_off: false,
        neutral_when_off: false,
        dead_time_code: 0,
    };

    /// Returns the control for a mode, with a dead time (s) at the timer's clock (Hz).
    pub fn of(mode: PwmMode, dead_time: f32, clock_hz: f32) -> Self {
        match mode {
            PwmMode::LockedAntiphase => Self {
                complement: true,
                driven_when_off: true,
                neutral_when_off: false,
                dead_time_code: dead_time_code(dead_time, clock_hz),
            },
            PwmMode::SignMagnitude => Self { driven_when_off: true, ..Self::UNKNOWN },
            PwmMode::Analog => Self { neutral_when_off: true, ..Self::UNKNOWN },
        }
    }
}

/// Returns the code of a dead time (s), `DTG` of RM0090: four ranges of the timer's clock (Hz), of
/// 1, 2, 8 and 16 clocks a step, up to 1008 clocks. It is rounded up, since too short a dead time
/// burns the bridge.
fn dead_time_code(dead_time: f32, clock_hz: f32) -> u8 {
    let clocks = libm::ceilf(dead_time * clock_hz) as u32;
    let code = match clocks {
        0..=127 => clocks,
        128..=254 => 0x80 | (clocks.div_ceil(2) - 64),
        255..=504 => 0xC0 | (clocks.div_ceil(8) - 32),
        _ => 0xE0 | (clocks.div_ceil(16).min(63) - 32),
    };
    code as u8
}
