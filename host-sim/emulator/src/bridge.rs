//! State of the bridge from TIM1's outputs and the two pins beside them, and the pulse of the brake
//! resistor from TIM8's.
//!
//! Centre-aligned outputs are read from the registers, not from the pins: their 44 000 edges a
//! second have the same information.

use rigless::soc::stm32f427::generated::tim1::Register;
use stiction::control::drive::{Drive, Duty, PwmMode};

use super::board::{EmulatedBoard, GpioPort};

/// TIM1, by its place in the emulator's table of advanced timers.
const TIM1: usize = 0;
const TIM1_FUNCTION: u8 = 1;
const ENABLE_PIN: u8 = 0;
const DIRECTION_PIN: u8 = 1;
/// TIM8, its function on PC6, and the steps of its count in a tick of the firmware.
const TIM8: usize = 1;
const TIM8_FUNCTION: u8 = 3;
const CEN_OPM: u64 = 1 | 1 << 3;
const CC1E: u64 = 1;
const MOE: u64 = 1 << 15;

/// The bridge's inputs at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BridgeInputs {
    /// Compare value of TIM1's channel 1.
    pub compare: u16,
    /// Count at which the timer turns around.
    pub top: u16,
    /// Level of the direction pin.
    pub reverse: bool,
    /// Whether the timer drives its outputs, and they are connected to their pins.
    pub outputs: bool,
    /// Steps of the brake resistor's pulse that runs: from the compare value to the end of the
    /// count.
    pub brake_steps: u16,
    /// Level of the bridge's enable: that of the pin, behind the contact of the emergency stop.
    pub enable: bool,
}

impl BridgeInputs {
    /// Reads the inputs of the bridge.
    pub fn read(board: &mut EmulatedBoard) -> Self {
        let connected = board.function(GpioPort::A, 8) == Some(TIM1_FUNCTION);
        // The contact of the emergency stop is in the line of the enable pin.
        let enable = board.is_high(GpioPort::B, ENABLE_PIN) && !board.is_contact_open();
        let reverse = board.is_high(GpioPort::B, DIRECTION_PIN);
        let brake_steps = brake_steps(board);
        let (_, registers) = board.mcu.advanced_timer(TIM1);
        let driven =
            registers.get(Register::Bdtr) & MOE != 0 && registers.get(Register::Ccer) & CC1E != 0;
        Self {
            compare: registers.get(Register::Ccr1) as u16,
            top: registers.get(Register::Arr) as u16,
            reverse,
            outputs: connected && driven,
            brake_steps,
            enable,
        }
    }

    /// Returns whether the bridge drives the motor.
    pub const fn is_on(&self) -> bool {
        self.outputs && self.enable
    }

    /// Returns the duty in the core's form. Locked antiphase has no direction pin.
    pub const fn duty(&self, mode: PwmMode) -> Duty {
        let reverse = matches!(mode, PwmMode::SignMagnitude) && self.reverse;
        Duty { compare: self.compare, reverse }
    }
}

/// Returns the steps of the brake resistor's pulse that runs; zero if none runs.
fn brake_steps(board: &mut EmulatedBoard) -> u16 {
    let connected = board.function(GpioPort::C, 6) == Some(TIM8_FUNCTION);
    let (_, registers) = board.mcu.advanced_timer(TIM8);
    let is_on = registers.get(Register::Bdtr) & MOE != 0
        && registers.get(Register::Ccer) & CC1E != 0
        && registers.get(Register::Cr1) & CEN_OPM == CEN_OPM;
    let [end, from] =
        [Register::Arr, Register::Ccr1].map(|register| registers.get(register) as u16);
    if connected && is_on { (end + 1).saturating_sub(from) } else { 0 }
}

/// Returns the code of a duty: `near` if it has this duty, or else the smallest code that has it;
/// `None` if there is none.
pub fn code_of(duty: Duty, drive: &Drive, near: i16) -> Option<i16> {
    let max = drive.max_code();
    std::iter::once(near).chain(-max..=max).find(|code| drive.duty(*code) == duty)
}

/// Returns the code whose duty is nearest to a duty that no code has.
pub fn nearest_code(duty: Duty, drive: &Drive) -> i16 {
    let max = drive.max_code();
    let distance = |code: &i16| {
        let other = drive.duty(*code);
        (other.reverse != duty.reverse && duty.compare != 0, other.compare.abs_diff(duty.compare))
    };
    (-max..=max).min_by_key(distance).unwrap_or(0)
}
