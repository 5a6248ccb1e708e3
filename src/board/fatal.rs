//! The end of a program that cannot continue: the bridge is turned off, the reason is kept, and the
//! microcontroller is reset and then reports it.

use core::panic::PanicInfo;
use core::sync::atomic::{Ordering, compiler_fence};

use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;
use stiction::Fault;
use stm32f4xx_hal::pac;

use super::retained::{RetainedFault, keep, set_armed};
use super::{brake_resistor, bridge};

/// Ends this run of the program: the bridge is off, the fault is kept, and the microcontroller is
/// reset.
pub fn stop(record: RetainedFault) -> ! {
    off_for_good();
    keep(record);
    set_armed(false);
    compiler_fence(Ordering::SeqCst);
    SCB::sys_reset()
}

/// Turns the bridge and the brake resistor off, and disables the interrupts, so that no task can
/// turn them on again.
fn off_for_good() {
    cortex_m::interrupt::disable();
    bridge::off_now();
    brake_resistor::off_now();
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    off_for_good();
    let mut record = RetainedFault::of(Fault::Panic);
    if let Some(location) = info.location() {
        record = record.with_text(location.file()).at(location.line(), 0);
    }
    stop(record)
}

/// Stops at an exception or interrupt that nothing here enables. Its number in the vector table is
/// reported in place of a line.
#[exception]
unsafe fn DefaultHandler(interrupt: i16) -> ! {
    off_for_good();
    let number = (interrupt + 16) as u32;
    stop(RetainedFault::of(Fault::Panic).with_text("an exception without a handler").at(number, 0))
}

/// Stops when the clock security system reports that the crystal has stopped.
#[exception]
unsafe fn NonMaskableInt() {
    off_for_good();
    // SAFETY: acknowledges the only source of this exception.
    unsafe { (*pac::RCC::ptr()).cir().modify(|_, w| w.cssc().set_bit()) };
    stop(RetainedFault::of(Fault::ClockLost))
}
