//! The last tick, at an address that other programs can read: a debugger, or an emulated board
//! that compares it with the same core on a host, bit for bit.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use stiction::servo::Output;

struct Published(UnsafeCell<MaybeUninit<Output>>);

// SAFETY: written by the control task only; nothing in the program reads it.
unsafe impl Sync for Published {}

/// The last tick, found by its name in the ELF file, and the output that it is the first part of.
/// The layout of both is that of C. It is zero until the servo is armed.
///
/// `#[used]` and a name for the outside mark it as read from outside, so plain writes to it stay.
/// Volatile writes would first spill every term, for about twice the instructions.
#[used]
#[unsafe(no_mangle)]
static STICTION_LAST_TICK: Published = Published(UnsafeCell::new(MaybeUninit::zeroed()));

/// Leaves an output where it can be read. Only the control task may call this.
// The whole output, whose 100 bytes are three blocks of the copy routine and a word. It moves the
// 92 bytes of a tick as two blocks and seven words, for 20 instructions more.
#[inline]
pub fn publish(output: &Output) {
    // SAFETY: within the static, and aligned as it is; see `Published`.
    unsafe { STICTION_LAST_TICK.0.get().write(MaybeUninit::new(*output)) };
}
