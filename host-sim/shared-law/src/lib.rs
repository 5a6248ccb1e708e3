//! Laws in shared libraries: the functions of `stiction_law.h` as a [`GuestLaw`].
//!
//! The library is trusted: it runs in this process, and a fault in it ends the process. It is never
//! unloaded.
// Calls of another language.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_void};
use std::path::Path;
use std::ptr::NonNull;
use std::sync::Arc;

use libloading::{Library, Symbol};

use files::error::Error;
use simulator::guest::{Controller, GuestLaw, JointFacts, Sample};

/// Version of the functions.
const ABI: u32 = 2;

type Start = unsafe extern "C" fn(*const JointFacts) -> *mut c_void;
type Tick = unsafe extern "C" fn(*mut c_void, *const Sample) -> f64;
type End = unsafe extern "C" fn(*mut c_void);
type FollowingError = unsafe extern "C" fn(*const JointFacts) -> f64;

/// A law in a shared library.
struct SharedLaw {
    name: String,
    version: String,
    start: Start,
    tick: Tick,
    end: End,
    following_error: Option<FollowingError>,
}

/// A controller of a shared library.
struct SharedController {
    controller: NonNull<c_void>,
    tick: Tick,
    end: End,
}

/// Opens the law of a shared library.
///
/// # Errors
/// Returns an error with the file, and the function that is missing or of another version.
pub fn open(path: &Path) -> Result<Arc<dyn GuestLaw>, Error> {
    let refuse = |why: String| Error::Input(format!("--law {}: {why}", path.display()));
    // A bare name would be looked up in the system's directories.
    let path = std::path::absolute(path).map_err(|error| refuse(error.to_string()))?;
    // SAFETY: a library may run code when it is opened. The user has named it to be run.
    let library = unsafe { Library::new(&path) }.map_err(|error| refuse(error.to_string()))?;
    // Its functions and texts are used as long as the program runs.
    let library: &'static Library = Box::leak(Box::new(library));
    let law = law(library).map_err(refuse)?;
    Ok(Arc::new(law))
}

/// Looks up the functions.
fn law(library: &'static Library) -> Result<SharedLaw, String> {
    // SAFETY: the functions have the types of the header, which its version stands for.
    unsafe {
        let abi: Symbol<unsafe extern "C" fn() -> u32> = function(library, "stiction_law_abi")?;
        let abi = abi();
        if abi != ABI {
            return Err(format!("its functions are of version {abi}; must be {ABI}"));
        }
        let text = |name: &'static str| -> Result<String, String> {
            let text: Symbol<unsafe extern "C" fn() -> *const c_char> = function(library, name)?;
            let text = text();
            if text.is_null() {
                return Err(format!("`{name}` returns null"));
            }
            Ok(CStr::from_ptr(text).to_string_lossy().into_owned())
        };
        Ok(SharedLaw {
            name: text("stiction_law_name")?,
            version: text("stiction_law_version")?,
            start: *function::<Start>(library, "stiction_law_start")?,
            tick: *function::<Tick>(library, "stiction_law_tick")?,
            end: *function::<End>(library, "stiction_law_end")?,
            following_error: function::<FollowingError>(library, "stiction_law_following_error")
                .ok()
                .map(|found| *found),
        })
    }
}

/// # Safety
/// The function has the type `F`.
unsafe fn function<F>(
    library: &'static Library,
    name: &'static str,
) -> Result<Symbol<'static, F>, String> {
    // SAFETY: as above.
    let found = unsafe { library.get(name.as_bytes()) };
    found.map_err(|_| format!("it has no function `{name}` (see stiction_law.h)"))
}

impl GuestLaw for SharedLaw {
    fn name(&self) -> &str {
        &self.name
    }

    fn version(&self) -> &str {
        &self.version
    }

    fn following_error(&self, joint: &JointFacts) -> f64 {
        // SAFETY: the joint lives until the function returns.
        self.following_error.map_or(0.0, |function| unsafe { function(joint) })
    }

    fn start(&self, joint: &JointFacts) -> Result<Box<dyn Controller>, String> {
        // SAFETY: the joint lives until the function returns.
        let controller = unsafe { (self.start)(joint) };
        let controller = NonNull::new(controller).ok_or("stiction_law_start returned null")?;
        Ok(Box::new(SharedController { controller, tick: self.tick, end: self.end }))
    }
}

impl Controller for SharedController {
    fn tick(&mut self, sample: &Sample) -> Result<f64, String> {
        // SAFETY: the controller is from `start` and has not ended.
        Ok(unsafe { (self.tick)(self.controller.as_ptr(), sample) })
    }
}

impl Drop for SharedController {
    fn drop(&mut self) {
        // SAFETY: the controller is from `start`, and is not used any more.
        unsafe { (self.end)(self.controller.as_ptr()) }
    }
}

#[cfg(test)]
mod tests;
