//! A board with a blocked joint that drives its motor, until a fault is injected.

use emulator::board::FittedParts;
use emulator::fault_injection::{BoardObservation, Injection, observe};
use emulator::parameters::blob;

use crate::common::{firmware, plans};

pub const MS: u64 = 1_000_000;
/// By then a healthy board drives its motor: it arms in its fourth tick of 20 ms.
pub const AT: u64 = 300 * MS;
/// How long a board is looked at. The slowest watchdog resets it within 190 ms, and the latest
/// reset of a test is at 600 ms. One that comes out of it without a report starts within 55 ms, and
/// is armed 80 ms later.
pub const UNTIL: u64 = 800 * MS;

/// A step under PD: the joint does not move, so the duty stays where the first error put it.
pub fn parameters() -> Vec<u8> {
    parameters_with(&[])
}

pub fn parameters_with(set: &[&str]) -> Vec<u8> {
    blob(&plans("step-response", &["pd"], set)[0]).unwrap()
}

pub fn inject(
    parameters: Option<&[u8]>,
    fitted: FittedParts,
    injections: &[(u64, Injection)],
) -> BoardObservation {
    observe(&firmware(), [parameters, None], fitted, injections, UNTIL).unwrap()
}

pub fn assert_off_after(observed: &BoardObservation, at: u64, limit: u64) {
    assert!(
        observed.on_ns.iter().any(|[from, _]| *from < at),
        "it was never on: {:?}",
        observed.log
    );
    assert!(!observed.on_after(at + limit), "on at {:?}, log {:?}", observed.on_ns, observed.log);
}
