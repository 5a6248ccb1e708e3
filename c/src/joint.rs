//! A joint: the positioner and its state in one struct of the caller.

use stiction::positioner::{Positioner, PositionerState, Target};

use crate::config::{StictionConfig, StictionRefusal, StictionTarget, refuse};
use crate::owned::{self, Content};
use crate::{STICTION_BAD_POINTER, STICTION_NOT_READY, STICTION_OK};

/// A joint and its law. The caller owns it, and reads nothing of it.
#[repr(C)]
pub struct Stiction {
    content: [u64; 76],
}

#[cfg(test)]
impl Stiction {
    /// Memory of a caller that has not been initialised.
    pub(crate) const EMPTY: Self = Self { content: [0; 76] };
}

#[repr(C)]
pub(crate) struct Joint {
    ready: u32,
    positioner: Positioner,
    state: PositionerState,
}

impl Content for Joint {
    type Outside = Stiction;
    const READY: u32 = u32::from_le_bytes(*b"stic");

    fn ready(at: *const Self) -> *const u32 {
        // It is the first field.
        at.cast()
    }
}

/// Runs something with a joint that was initialised.
///
/// # Safety
/// As of [`owned::content`].
unsafe fn with<T>(at: *mut Stiction, otherwise: T, run: impl FnOnce(&mut Joint) -> T) -> T {
    // SAFETY: as the caller promises.
    unsafe { owned::content::<Joint>(at) }.map_or(otherwise, run)
}

/// Validates a configuration and initialises a joint at rest. Returns `STICTION_OK`,
/// `STICTION_REFUSED` with the reason in `why` (which can be NULL), or `STICTION_BAD_POINTER`.
///
/// # Safety
/// `joint` is the caller's, `config` can be read, `why` is NULL or can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_init(
    joint: *mut Stiction,
    config: *const StictionConfig,
    why: *mut StictionRefusal,
) -> i32 {
    if !owned::is_usable(joint) {
        return STICTION_BAD_POINTER;
    }
    // SAFETY: the joint is the caller's, and all pointers are as they promise.
    unsafe {
        owned::invalidate::<Joint>(joint);
        let Some(config) = StictionConfig::read(config) else { return STICTION_BAD_POINTER };
        match config.and_then(|config| Positioner::new(&config)) {
            Ok(positioner) => {
                let state = positioner.start();
                owned::initialise(joint, Joint { ready: Joint::READY, positioner, state });
                STICTION_OK
            }
            Err(refused) => refuse(&refused, why),
        }
    }
}

/// Writes the target at rest at an angle (rad) from the counter's zero. After many turns, add to
/// `target->counts` instead: a float keeps an angle to 6e-8 of itself.
///
/// # Safety
/// `joint` is the caller's, and `target` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_target(
    joint: *const Stiction,
    angle: f32,
    target: *mut StictionTarget,
) -> i32 {
    if !owned::is_usable(target) {
        return STICTION_BAD_POINTER;
    }
    // SAFETY: the joint is only read, and `target` is usable.
    unsafe {
        with(joint.cast_mut(), STICTION_NOT_READY, |joint| {
            target.write(StictionTarget::of(joint.positioner.position(angle)));
            STICTION_OK
        })
    }
}

/// Runs one tick towards an angle (rad) at which the joint should rest. Returns the effort until
/// the next tick, which must be applied at once and in full. Returns 0 if the joint is not
/// initialised. `counts` can wrap.
///
/// # Safety
/// `joint` is the caller's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_tick(joint: *mut Stiction, counts: i32, angle: f32) -> f32 {
    // SAFETY: as the caller promises.
    unsafe {
        with(joint, 0.0, |Joint { positioner, state, .. }| {
            let target = Target::at_rest(positioner.position(angle));
            #[cfg(feature = "deliberate-panic")]
            assert!(counts != i32::MAX, "planted");
            positioner.tick(state, counts, target)
        })
    }
}

/// Runs one tick towards a target that can move, and returns as `stiction_tick` does.
///
/// # Safety
/// `joint` is the caller's, and `target` can be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_follow(
    joint: *mut Stiction,
    counts: i32,
    target: *const StictionTarget,
) -> f32 {
    if !owned::is_usable(target) {
        return 0.0;
    }
    // SAFETY: `target` is usable, and the rest as the caller promises.
    unsafe {
        let target = target.read().target();
        with(joint, 0.0, |joint| joint.positioner.tick(&mut joint.state, counts, target))
    }
}

/// Does the same for an amplifier that has limited the last effort: `applied` is the mean effort
/// that the joint has had since the last tick.
///
/// # Safety
/// `joint` is the caller's, and `target` can be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_follow_applied(
    joint: *mut Stiction,
    counts: i32,
    target: *const StictionTarget,
    applied: f32,
) -> f32 {
    if !owned::is_usable(target) {
        return 0.0;
    }
    // SAFETY: `target` is usable, and the rest as the caller promises.
    unsafe {
        let target = target.read().target();
        with(joint, 0.0, |Joint { positioner, state, .. }| {
            positioner.tick_applied(state, counts, target, applied)
        })
    }
}

/// Forgets what was learned. To be called before the next tick when the output has been off, or the
/// counter was set.
///
/// # Safety
/// `joint` is the caller's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_restart(joint: *mut Stiction) -> i32 {
    // SAFETY: as the caller promises.
    unsafe {
        with(joint, STICTION_NOT_READY, |joint| {
            joint.positioner.restart(&mut joint.state);
            STICTION_OK
        })
    }
}

/// Has a law in `STICTION_GIVE_UP` try again. A target that moves does so, too.
///
/// # Safety
/// `joint` is the caller's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_try_again(joint: *mut Stiction) -> i32 {
    // SAFETY: as the caller promises.
    unsafe {
        with(joint, STICTION_NOT_READY, |joint| {
            joint.positioner.try_again(&mut joint.state);
            STICTION_OK
        })
    }
}

/// Returns what the law did in the last tick: `STICTION_MOVE` to `STICTION_GIVE_UP`, or
/// `STICTION_NOT_READY`.
///
/// # Safety
/// `joint` is the caller's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn stiction_mode(joint: *const Stiction) -> i32 {
    let mode = |joint: &mut Joint| joint.positioner.mode(&joint.state) as i32;
    // SAFETY: the joint is only read.
    unsafe { with(joint.cast_mut(), STICTION_NOT_READY, mode) }
}
