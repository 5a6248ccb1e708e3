//! Thread pool for jobs that run for minutes. It leaves a core for the studio.

#[cfg(not(target_family = "wasm"))]
use std::sync::OnceLock;

use rayon::ThreadPool;

use files::error::Error;

/// Pool that all such jobs share, so that two jobs at once leave a core free, too.
#[cfg(not(target_family = "wasm"))]
static SPARE: OnceLock<ThreadPool> = OnceLock::new();

/// Runs parallel work on all cores but one, at least one: the thread of the device, the connections
/// and the predictions have the remaining core.
///
/// If two jobs share one thread, the second waits for the end of the first, unless the first
/// [lets others in](let_others_in).
///
/// # Errors
/// Returns an error if no thread can be started.
pub fn on_spare_cores<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Error> {
    Ok(pool()?.install(work))
}

/// Runs another job that waits for these threads. A job of minutes calls this function repeatedly,
/// so that a job of seconds can run meanwhile. The call can last until the other job ends, so the
/// caller must check before and after it whether it was cancelled.
pub fn let_others_in() {
    rayon::yield_now();
}

/// Starts work on a thread of its own. In WebAssembly, which has no threads, the work is dropped,
/// and a receiver of its result is disconnected.
pub fn begin(work: impl FnOnce() + Send + 'static) {
    #[cfg(not(target_family = "wasm"))]
    std::thread::spawn(work);
    // The C library of WebAssembly may not even declare threads.
    #[cfg(target_family = "wasm")]
    drop(work);
}

#[cfg(target_family = "wasm")]
fn pool() -> Result<&'static ThreadPool, Error> {
    Err(Error::Input("studio: a page in a browser cannot start threads".into()))
}

#[cfg(not(target_family = "wasm"))]
fn pool() -> Result<&'static ThreadPool, Error> {
    if let Some(pool) = SPARE.get() {
        return Ok(pool);
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(cores.saturating_sub(1).max(1)).build();
    let failed = |error| {
        Error::Input(format!(
            "studio: cannot start the threads of a long computation: {error}; close other \
             programs, and try again"
        ))
    };
    // If two pools were made at once, one is dropped.
    let pool = pool.map_err(failed)?;
    Ok(SPARE.get_or_init(|| pool))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::collections::BTreeSet;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc::channel;
    use std::thread::{ThreadId, current};
    use std::time::{Duration, Instant};

    use rayon::prelude::*;

    use super::*;

    #[test]
    fn two_jobs_share_the_threads_and_leave_a_core_free() {
        let threads = || -> BTreeSet<String> {
            let id = |_| -> ThreadId { current().id() };
            let all: Vec<_> = (0..200).into_par_iter().map(id).collect();
            all.into_iter().map(|id| format!("{id:?}")).collect()
        };
        let other = std::thread::spawn(move || on_spare_cores(threads).unwrap());
        let (mut all, others) = (on_spare_cores(threads).unwrap(), other.join().unwrap());
        all.extend(others);
        let cores = std::thread::available_parallelism().unwrap().get();
        assert!((1..=(cores - 1).max(1)).contains(&all.len()), "{all:?}");
        assert!(!all.contains(&format!("{:?}", current().id())), "the caller only waits");
    }

    #[test]
    fn short_work_is_done_while_long_work_lets_it_in() {
        // A limit far above the time of the work, for the case that it never runs.
        const PATIENCE: Duration = Duration::from_secs(20);
        // With two threads the short work would not have to wait.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (begun, has_begun) = channel();
        let is_done = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let long = scope.spawn(|| {
                pool.install(|| {
                    begun.send(()).unwrap();
                    let begin = Instant::now();
                    while !is_done.load(Ordering::SeqCst) {
                        assert!(begin.elapsed() < PATIENCE, "it keeps the thread to itself");
                        let_others_in();
                    }
                })
            });
            has_begun.recv().unwrap();
            pool.install(|| is_done.store(true, Ordering::SeqCst));
            long.join().unwrap();
        });
    }
}
