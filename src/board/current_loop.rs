//! The current loop between the control task and the converter's interrupt.
//!
//! ```text
//! control task, once a tick   -> target (one word) ->  interrupt, once a period of the PWM
//!                             <- voltage           <-  reading -> core's current loop -> duty
//! ```
//!
//! The interrupt is above the control task. A word is written and read at once, so neither waits
//! for the other. A loop that begins comes through a queue.

use core::sync::atomic::{AtomicU32, Ordering};

use heapless::spsc::Consumer;
use stiction::control::current_loop::{CurrentLoop, CurrentLoopState, CurrentTarget};

use super::{bridge, converter};

/// Target of the last tick, in one word.
static TARGET: AtomicU32 = AtomicU32::new(0);

/// Code of the voltage of the last period.
static VOLTAGE: AtomicU32 = AtomicU32::new(0);

/// Current loops that can begin before the interrupt takes them.
pub const WAITING: usize = 4;

/// Sets the code of the voltage to none: a loop begins.
pub fn rest() {
    VOLTAGE.store(0, Ordering::Relaxed);
}

/// Sets the target until the next tick.
pub fn aim(target: CurrentTarget) {
    TARGET.store(target.pack(), Ordering::Relaxed);
}

/// Returns the code of the voltage that the loop has put out last.
#[inline]
pub fn voltage() -> i16 {
    VOLTAGE.load(Ordering::Relaxed) as i16
}

/// The current loop of the present motion, in the converter's interrupt.
pub struct RunningLoop {
    /// Loops that begin.
    begins: Consumer<'static, CurrentLoop>,
    running: Option<(CurrentLoop, CurrentLoopState)>,
}

impl RunningLoop {
    /// Waits for the first loop.
    pub const fn new(begins: Consumer<'static, CurrentLoop>) -> Self {
        Self { begins, running: None }
    }

    /// Runs a period: reads the current, and sets the duty that acts from the lower end of the
    /// count on.
    pub fn period(&mut self) {
        let reading = converter::take_conversion();
        // The last one, if the bridge was turned off before its first period.
        while let Some(with) = self.begins.dequeue() {
            self.running = Some((with, CurrentLoopState::default()));
        }
        let Some((with, state)) = &mut self.running else { return };
        let target = CurrentTarget::unpack(TARGET.load(Ordering::Relaxed));
        let code = with.step(state, target, reading);
        bridge::set_duty(with.duty(code));
        VOLTAGE.store(code as u32, Ordering::Relaxed);
    }
}
