//! Work of minutes, beside which the studio stays awake.

use crate::error::Error;

/// Runs what computes in parallel on all cores but one, and on one at least: the thread that talks
/// to the device, the connections and the predictions have the other.
///
/// # Errors
/// Says that no thread could be had.
pub fn on_spare_cores<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Error> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(cores.saturating_sub(1).max(1)).build();
    let failed = |error| Error::Input(format!("studio: no thread to compute on: {error}"));
    Ok(pool.map_err(failed)?.install(work))
}
