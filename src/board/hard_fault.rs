//! The hard fault: the handler turns the outputs off, restores a working stack, and keeps the
//! reason.
//!
//! A stack that overflows leaves the RAM (memory.x). The processor cannot save its registers there,
//! and enters this exception with the stack pointer where it was. A compiled handler begins with a
//! push, which would fault again: the processor would lock up, and the last duty would stay until
//! the watchdog resets the microcontroller. So the entry is written in assembly, and uses the stack
//! only after the stack pointer has been moved back to its start. Nothing returns from here, so the
//! contents of the stack are lost without harm.

use cortex_m::peripheral::SCB;
use stiction::Fault;

use super::fatal::stop;
use super::retained::RetainedFault;

/// Register that sets and resets the pins of port B (RM0090 section 8.4.7), and the bit that pulls
/// PB0 low: the bridge's enable pin.
const GPIOB_BSRR: u32 = 0x4002_0400 + 0x18;
const ENABLE_LOW: u32 = 1 << 16;

/// Register of TIM1 with the main output enable MOE (RM0090 section 17.4.18), and that bit.
const TIM1_BDTR: u32 = 0x4001_0000 + 0x44;
const MOE: u32 = 1 << 15;

/// Floating-point context control (PM0214 section 4.6.2), and its bit for registers that still have
/// to be saved, to a stack that may be lost.
const FPCCR: u32 = 0xE000_EF34;
const LSPACT: u32 = 1;

/// Largest offset from the first address of the RAM at which the eight saved words fit, bytes.
const LAST_FRAME: u32 = 128 * 1024 - 32;

/// The handler in the vector table.
///
/// # Safety
/// Only the processor enters it.
#[unsafe(naked)]
#[unsafe(export_name = "HardFault")]
#[unsafe(link_section = ".HardFault.user")]
unsafe extern "C" fn hard_fault() -> ! {
    core::arch::naked_asm!(
        // The enable pin low, and the outputs off.
        "movw r0, #{bsrr_low}",
        "movt r0, #{bsrr_high}",
        "mov  r1, #{enable_low}",
        "str  r1, [r0]",
        "movw r0, #{bdtr_low}",
        "movt r0, #{bdtr_high}",
        "ldr  r1, [r0]",
        "bic  r1, r1, #{moe}",
        "str  r1, [r0]",
        "cpsid i",
        // No register is saved late any more.
        "movw r0, #{fpccr_low}",
        "movt r0, #{fpccr_high}",
        "ldr  r1, [r0]",
        "bic  r1, r1, #{lspact}",
        "str  r1, [r0]",
        // The program counter of the fault, if the saved words are in the RAM; otherwise 0.
        "mrs  r2, msp",
        "movw r3, #:lower16:_stack_end",
        "movt r3, #:upper16:_stack_end",
        "subs r1, r2, r3",
        "movw r3, #{last_low}",
        "movt r3, #{last_high}",
        "cmp  r1, r3",
        "ite  ls",
        "ldrls r0, [r2, #24]",
        "movhi r0, #0",
        "movw r3, #:lower16:_stack_start",
        "movt r3, #:upper16:_stack_start",
        "msr  msp, r3",
        "b    {report}",
        bsrr_low = const GPIOB_BSRR & 0xFFFF,
        bsrr_high = const GPIOB_BSRR >> 16,
        enable_low = const ENABLE_LOW,
        bdtr_low = const TIM1_BDTR & 0xFFFF,
        bdtr_high = const TIM1_BDTR >> 16,
        moe = const MOE,
        fpccr_low = const FPCCR & 0xFFFF,
        fpccr_high = const FPCCR >> 16,
        lspact = const LSPACT,
        last_low = const LAST_FRAME & 0xFFFF,
        last_high = const LAST_FRAME >> 16,
        report = sym report,
    )
}

/// Keeps the program counter of the fault (0 if the stack was lost) and the processor's status, and
/// resets the microcontroller.
extern "C" fn report(place: u32) -> ! {
    // SAFETY: reads a status register.
    let status = unsafe { (*SCB::PTR).cfsr.read() };
    stop(RetainedFault::of(Fault::HardFault).at(place, status))
}
