//! The current loop between the control task and the converter's interrupt.
//!
//! ```text
//! control task, once a tick   -> target (one word) ->  interrupt, once a period of the PWM
//!                             <- voltage           <-  reading -> core's current loop -> duty
//! ```
//!
//! The interrupt is above the control task. A word is written and read at once, so neither waits
//! for the other. A loop that begins is written while the interrupt is disabled.
//!
//! In a measurement of the winding, the interrupt makes pulses in the place of the loop, and hands
//! their readings over once they are over.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use stiction::control::current_loop::CurrentTarget;
use stiction::control::period_work::{PeriodState, PeriodWork};
use stiction::control::winding_pulses::{GROUPS, GroupSums, PulseState, WindingPulses};

use super::{bridge, converter};

/// Target of the last tick, in one word.
static TARGET: AtomicU32 = AtomicU32::new(0);

/// Code of the voltage of the last period.
static VOLTAGE: AtomicU32 = AtomicU32::new(0);

/// A loop that begins, on its way to the interrupt.
struct Begins(UnsafeCell<Option<PeriodWork>>);

// SAFETY: the control task writes the cell while the converter's interrupt is disabled, and the
// interrupt alone reads it.
unsafe impl Sync for Begins {}

static BEGINS: Begins = Begins(UnsafeCell::new(None));

/// Whether the interrupt has not taken that loop.
static IS_NEW: AtomicBool = AtomicBool::new(false);

/// Readings of pulses that are over, on their way to the control task.
struct Sums(UnsafeCell<GroupSums>);

// SAFETY: the interrupt writes the cell before it sets `HAS_SUMS`, and never afterwards; the
// control task reads it only then, and resets the flag while the interrupt is disabled.
unsafe impl Sync for Sums {}

static SUMS: Sums = Sums(UnsafeCell::new([0; GROUPS]));

/// Whether these readings are there.
static HAS_SUMS: AtomicBool = AtomicBool::new(false);

/// Begins the work of a motion. The converter's interrupt must be disabled.
pub fn begin(with: PeriodWork) {
    // SAFETY: the interrupt is disabled, and the control task is the only one that calls this.
    unsafe { *BEGINS.0.get() = Some(with) };
    HAS_SUMS.store(false, Ordering::Relaxed);
    VOLTAGE.store(0, Ordering::Relaxed);
    IS_NEW.store(true, Ordering::Release);
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

/// Returns the readings of the motion's pulses, once they are over.
#[inline]
pub fn sums() -> Option<GroupSums> {
    // SAFETY: the interrupt does not write them any more.
    HAS_SUMS.load(Ordering::Acquire).then(|| unsafe { *SUMS.0.get() })
}

/// The work of the present motion, in the converter's interrupt.
pub struct RunningLoop {
    work: Option<PeriodWork>,
    state: PeriodState,
}

impl RunningLoop {
    /// Waits for the first motion.
    pub const NONE: Self = Self { work: None, state: PeriodState::NONE };

    /// Runs a period: reads the current, and sets the duty that acts from the lower end of the
    /// count on.
    pub fn period(&mut self) {
        let reading = converter::take_conversion();
        if IS_NEW.load(Ordering::Acquire) {
            IS_NEW.store(false, Ordering::Relaxed);
            // SAFETY: the control task does not write while this interrupt is enabled.
            self.work = unsafe { *BEGINS.0.get() };
            self.state.restart();
        }
        match &self.work {
            Some(PeriodWork::Regulate(of)) => {
                let target = CurrentTarget::unpack(TARGET.load(Ordering::Relaxed));
                let code = of.step(&mut self.state.regulated, target, reading);
                bridge::set_duty(of.duty(code));
                VOLTAGE.store(code as u32, Ordering::Relaxed);
            }
            Some(PeriodWork::Pulse(pulses)) => pulse(pulses, &mut self.state.pulsed, reading),
            None => {}
        }
    }
}

/// Runs a period of the pulses, and hands their readings over once they are over.
// Out of line: a period of the loop does not pay for it.
#[cold]
#[inline(never)]
fn pulse(pulses: &WindingPulses, state: &mut PulseState, reading: u16) {
    let code = pulses.step(state, reading);
    bridge::set_duty(pulses.duty(code));
    VOLTAGE.store(code as u32, Ordering::Relaxed);
    if let Some(sums) = pulses.sums(state)
        && !HAS_SUMS.load(Ordering::Relaxed)
    {
        // SAFETY: the control task reads them only after the flag.
        unsafe { *SUMS.0.get() = *sums };
        HAS_SUMS.store(true, Ordering::Release);
    }
}
