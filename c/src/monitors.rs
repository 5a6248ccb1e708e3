//! The monitors of a joint that need no board.

use stiction::positioner::{RunawayMonitors, RunawayState};

use crate::config::{
    StictionConfig, StictionMonitorConfig, StictionRefusal, StictionTarget, refuse,
};
use crate::owned::{self, Content};
use crate::{STICTION_BAD_POINTER, STICTION_NO_FAULT, STICTION_NOT_READY, STICTION_OK};

/// Monitors of a joint. The caller owns them, and reads nothing of them.
#[repr(C)]
pub struct StictionMonitors {
    content: [u64; 86],
}

#[cfg(test)]
impl StictionMonitors {
    /// Memory of a caller that has not been initialised.
    pub(crate) const EMPTY: Self = Self { content: [0; 86] };
}

#[repr(C)]
pub(crate) struct Watch {
    ready: u32,
    monitors: RunawayMonitors,
    state: RunawayState,
}

impl Content for Watch {
    type Outside = StictionMonitors;
    const READY: u32 = u32::from_le_bytes(*b"moni");

    fn ready(at: *const Self) -> *const u32 {
        // It is the first field.
        at.cast()
    }
}

/// Runs something with monitors that were initialised.
///
/// # Safety
/// As of [`owned::content`].
unsafe fn with(at: *mut StictionMonitors, run: impl FnOnce(&mut Watch) -> i32) -> i32 {
    // SAFETY: as the caller promises.
    unsafe { owned::content::<Watch>(at) }.map_or(STICTION_NOT_READY, run)
}

/// Validates both configurations and initialises monitors of a joint at `counts` with a cold motor.
/// Returns as `stiction_init` does.
///
/// # Safety
/// `monitors` are the caller's, both configurations can be read, `why` is NULL or can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_monitors_init(
    monitors: *mut StictionMonitors,
    joint: *const StictionConfig,
    config: *const StictionMonitorConfig,
    counts: i32,
    why: *mut StictionRefusal,
) -> i32 {
    if !owned::is_usable(monitors) {
        return STICTION_BAD_POINTER;
    }
    // SAFETY: the monitors are the caller's, and all pointers are as they promise.
    unsafe {
        owned::invalidate::<Watch>(monitors);
        let joint = StictionConfig::read(joint);
        let config = StictionMonitorConfig::read(config);
        let (Some(joint), Some(config)) = (joint, config) else { return STICTION_BAD_POINTER };
        let made = joint.and_then(|joint| RunawayMonitors::new(&joint, &config?));
        match made {
            Ok(made) => {
                let state = made.start(counts);
                let watch = Watch { ready: Watch::READY, monitors: made, state };
                owned::initialise(monitors, watch);
                STICTION_OK
            }
            Err(refused) => refuse(&refused, why),
        }
    }
}

/// Looks at a tick with output: the counter, the target, and the effort that is about to be
/// applied. Returns 0 if all is well. Otherwise turn the output off in this tick: it returns the
/// fault and writes the value that tripped it (deg for angles) into `value`, which can be NULL.
///
/// # Safety
/// `monitors` are the caller's, `target` can be read, `value` is NULL or can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_monitors_check(
    monitors: *mut StictionMonitors,
    counts: i32,
    target: *const StictionTarget,
    effort: f32,
    value: *mut f32,
) -> i32 {
    if !owned::is_usable(target) {
        return STICTION_NOT_READY;
    }
    // SAFETY: `target` is usable, and the rest as the caller promises.
    unsafe {
        let target = target.read().target();
        with(monitors, |Watch { monitors, state, .. }| {
            let Some(runaway) = monitors.check(state, counts, target, effort) else {
                return STICTION_NO_FAULT;
            };
            if owned::is_usable(value) {
                value.write(runaway.value);
            }
            runaway.fault as i32
        })
    }
}

/// Looks at a tick without output: the motor cools.
///
/// # Safety
/// `monitors` are the caller's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_monitors_idle(
    monitors: *mut StictionMonitors,
    counts: i32,
) -> i32 {
    // SAFETY: as the caller promises.
    unsafe {
        with(monitors, |Watch { monitors, state, .. }| {
            monitors.idle(state, counts);
            STICTION_OK
        })
    }
}

/// Prepares the monitors for the output to be turned on again at `counts`: the heat stays.
///
/// # Safety
/// `monitors` are the caller's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_monitors_arm(
    monitors: *mut StictionMonitors,
    counts: i32,
) -> i32 {
    // SAFETY: as the caller promises.
    unsafe {
        with(monitors, |Watch { monitors, state, .. }| {
            *state = monitors.armed(state, counts);
            STICTION_OK
        })
    }
}
