//! Mishaps of the hardware: bridge off, the reason told, and no motion after.

use std::sync::Arc;

use host_sim::emulator::FirmwareImage;
use host_sim::emulator::bench::{Mishap, Observed, observe};
use host_sim::emulator::board::Fitted;
use host_sim::emulator::parameters::blob;

use crate::common::{image, plans};

const MS: u64 = 1_000_000;
/// By then a healthy board drives its motor: it arms in its fourth tick of 20 ms.
const AT: u64 = 300 * MS;

fn parameters() -> Vec<u8> {
    blob(&plans("step-response", &["pd"], &[])[0]).unwrap()
}

fn bench(parameters: Option<&[u8]>, fitted: Fitted, mishaps: &[(u64, Mishap)]) -> Observed {
    let image = Arc::new(FirmwareImage::open(&image()).unwrap());
    observe(&image, parameters, fitted, mishaps, 1_200 * MS).unwrap()
}

fn assert_off_after(observed: &Observed, at: u64, limit: u64) {
    assert!(observed.on_ns.iter().any(|[from, _]| *from < at), "it was never on: {:?}", observed.log);
    assert!(!observed.on_after(at + limit), "on at {:?}, log {:?}", observed.on_ns, observed.log);
}

#[test]
fn nothing_happens_to_a_healthy_board() {
    let observed = bench(Some(&parameters()), Fitted::default(), &[]);
    assert!(observed.on_after(1_100 * MS) && observed.on_ns.len() == 1, "{observed:?}");
    assert!(observed.resets.is_empty());
}

#[test]
fn the_break_input_turns_the_bridge_off_and_it_stays_off() {
    let observed = bench(
        Some(&parameters()),
        Fitted::default(),
        &[(AT, Mishap::Break), (AT + 100 * MS, Mishap::BreakReleased)],
    );
    assert_off_after(&observed, AT, MS / 10);
    assert!(observed.log.iter().any(|line| line.text.to_lowercase().contains("break")), "{:?}", observed.log);
}

#[test]
fn a_lost_crystal_turns_the_bridge_off() {
    let observed = bench(Some(&parameters()), Fitted::default(), &[(AT, Mishap::CrystalLost)]);
    assert_off_after(&observed, AT, MS / 10);
    let told = observed.log.iter().any(|line| {
        let text = line.text.to_lowercase();
        text.contains("crystal") && (text.contains("lost") || text.contains("stopped"))
    });
    assert!(told, "{:?}", observed.log);
}

#[test]
fn without_a_crystal_nothing_moves() {
    let fitted = Fitted { crystal: false, ..Fitted::default() };
    let observed = bench(Some(&parameters()), fitted, &[]);
    assert!(observed.on_ns.is_empty(), "{observed:?}");
    assert!(observed.log.iter().any(|line| line.text.contains("crystal")), "{:?}", observed.log);
}

#[test]
fn a_reset_in_mid_move_is_told_and_nothing_moves_after() {
    let observed = bench(Some(&parameters()), Fitted::default(), &[(AT, Mishap::Reset)]);
    assert_eq!(observed.resets.len(), 1, "{:?}", observed.resets);
    assert_off_after(&observed, AT, MS / 10);
    assert!(observed.says("reset pin"), "{:?}", observed.log);
}

#[test]
fn without_parameters_or_with_damaged_ones_nothing_moves() {
    let mut damaged = parameters();
    damaged[40] ^= 1;
    for parameters in [None, Some(&damaged[..])] {
        let observed = bench(parameters, Fitted::default(), &[]);
        assert!(observed.on_ns.is_empty(), "{observed:?}");
        assert!(observed.says("parameters"), "{:?}", observed.log);
    }
}
