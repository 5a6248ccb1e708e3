//! The last tick, at an address that other programs can read: a debugger, or an emulated board
//! that compares it with the same core on a host, bit for bit.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use stiction::servo::Output;

struct Published(UnsafeCell<MaybeUninit<Output>>);

// SAFETY: written by the control task only; nothing in the program reads it.
unsafe impl Sync for Published {}

/// The output of the last tick, whose first part is the tick itself. Other programs find it by its
/// name in the ELF file. The layout of both is that of C. Its bytes are zero until the first tick.
///
/// `#[used]` and an exported name mark it as read from outside, so that the compiler keeps plain
/// writes. Volatile writes would first spill every term, for about twice the instructions.
#[used]
#[unsafe(no_mangle)]
static STICTION_LAST_TICK: Published = Published(UnsafeCell::new(MaybeUninit::zeroed()));

/// Publishes an output for other programs. Only the control task may call this.
// The whole output, whose 100 bytes are three blocks of the copy routine and a word. It moves the
// 92 bytes of a tick as two blocks and seven words, for 20 instructions more.
#[inline]
pub fn publish(output: &Output) {
    // SAFETY: within the static, and aligned as it is; see `Published`.
    unsafe { STICTION_LAST_TICK.0.get().write(MaybeUninit::new(*output)) };
}
