//! Work of minutes, beside which the studio stays awake.

#[cfg(not(target_family = "wasm"))]
use std::sync::OnceLock;

use rayon::ThreadPool;

use crate::error::Error;

/// The threads of all such work, so that two of them together leave a core free, too.
#[cfg(not(target_family = "wasm"))]
static SPARE: OnceLock<ThreadPool> = OnceLock::new();

/// Runs what computes in parallel on all cores but one, and on one at least: the thread that talks
/// to the device, the connections and the predictions have the other.
///
/// If there is one thread for two of them, the second waits for the end of the first, unless that
/// [lets others in](let_others_in).
///
/// # Errors
/// Says that no thread could be had.
pub fn on_spare_cores<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Error> {
    Ok(pool()?.install(work))
}

/// Lets work that waits for these threads go first. Work of minutes calls it now and then, so that
/// work of seconds is done meanwhile. It may return as late as the end of that work: who calls it
/// looks before and after whether it is still to go on.
pub fn let_others_in() {
    rayon::yield_now();
}

/// Begins work on a thread of its own. A page has no threads: there the work is dropped, and who
/// waits for it sees that.
pub fn begin(work: impl FnOnce() + Send + 'static) {
    #[cfg(not(target_family = "wasm"))]
    std::thread::spawn(work);
    // The C library of WebAssembly need not even have the names of threads.
    #[cfg(target_family = "wasm")]
    drop(work);
}

#[cfg(target_family = "wasm")]
fn pool() -> Result<&'static ThreadPool, Error> {
    Err(Error::Input("studio: a page has no threads to compute on".into()))
}

#[cfg(not(target_family = "wasm"))]
fn pool() -> Result<&'static ThreadPool, Error> {
    if let Some(pool) = SPARE.get() {
        return Ok(pool);
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(cores.saturating_sub(1).max(1)).build();
    let failed = |error| Error::Input(format!("studio: no thread to compute on: {error}"));
    // Of two that were made at once one is dropped.
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
        // Far more than that takes, and an end where it is not let in.
        const PATIENCE: Duration = Duration::from_secs(20);
        // With two threads the short work would need nobody's leave.
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
