//! Memory of the caller: what can be checked of a pointer before it is used.

use core::mem;

use stiction::positioner::Refused;

/// Returns whether a pointer is neither null nor misaligned.
pub fn is_usable<T>(at: *const T) -> bool {
    !at.is_null() && at.is_aligned()
}

/// Content of a struct whose size alone is known to C.
pub trait Content: Sized {
    /// The struct.
    type Outside;
    /// Number at its start, which shows that it was initialised.
    const READY: u32;
    /// Returns the number at the start.
    fn ready(at: *const Self) -> *const u32;

    /// Fails to compile if the content is larger than the struct, or aligned more strictly.
    const FITS: () = assert!(
        size_of::<Self>() <= size_of::<Self::Outside>()
            && align_of::<Self>() <= align_of::<Self::Outside>()
    );
}

/// Returns the content of a struct that was initialised.
///
/// # Safety
/// The pointer is null, or nothing else uses the struct during the call.
pub unsafe fn content<'a, C: Content>(at: *mut C::Outside) -> Option<&'a mut C> {
    const { C::FITS };
    let content = at.cast::<C>();
    if !is_usable(at) {
        return None;
    }
    // SAFETY: the struct can be read, and the content fits into it. Only a struct that
    // `initialise` wrote has the number, so the content is valid.
    unsafe { (C::ready(content).read() == C::READY).then(|| &mut *content) }
}

/// Writes the content of a struct.
///
/// # Safety
/// The pointer is usable, and nothing else uses the struct during the call.
pub unsafe fn initialise<C: Content>(at: *mut C::Outside, content: C) {
    const { C::FITS };
    // SAFETY: the content fits into the struct, which the caller owns.
    unsafe { at.cast::<C>().write(content) };
}

/// Marks a struct as not initialised.
///
/// # Safety
/// The pointer is usable, and nothing else uses the struct during the call.
pub unsafe fn invalidate<C: Content>(at: *mut C::Outside) {
    // SAFETY: the number is within the struct, which the caller owns.
    unsafe { C::ready(at.cast::<C>()).cast_mut().write(0) };
}

/// Reads a struct whose first field is its size.
///
/// # Safety
/// The pointer is null, or its first field can be read; and all of it, if that field is the size
/// of this struct.
pub unsafe fn sized<T: Copy>(at: *const T) -> Option<Result<T, Refused>> {
    if !is_usable(at) {
        return None;
    }
    let expected = mem::size_of::<T>() as u32;
    // SAFETY: as the caller promises.
    let size = unsafe { at.cast::<u32>().read() };
    if size != expected {
        let (found, only) = (size as f32, expected as f32);
        return Some(Err(Refused { field: "size", found, low: only, high: only }));
    }
    // SAFETY: it has the size of this struct.
    Some(Ok(unsafe { at.read() }))
}
