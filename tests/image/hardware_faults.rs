//! Mishaps of the hardware: bridge off, the reason reported, and no motion after.

use emulator::board::{CLOCK_HZ, FittedParts};
use emulator::fault_injection::Injection;
use emulator::firmware::budgets::INTERRUPT_INSTRUCTIONS;

use crate::common::firmware;
use crate::fault_injection::{AT, MS, UNTIL, assert_off_after, inject, parameters};

#[test]
fn nothing_happens_to_a_healthy_board() {
    let observed = inject(Some(&parameters()), FittedParts::default(), &[]);
    assert!(observed.on_after(UNTIL - MS) && observed.on_ns.len() == 1, "{observed:?}");
    assert!(observed.resets.is_empty());
}

#[test]
fn the_break_input_turns_the_bridge_off_and_it_stays_off() {
    let observed = inject(
        Some(&parameters()),
        FittedParts::default(),
        &[(AT, Injection::Break), (AT + 100 * MS, Injection::BreakReleased)],
    );
    assert_off_after(&observed, AT, MS / 10);
    assert!(observed.says("faulted: break input"), "{:?}", observed.log);
}

#[test]
fn a_glitch_of_the_break_input_while_the_outputs_are_being_turned_on_is_not_lost() {
    let observed =
        inject(Some(&parameters()), FittedParts::default(), &[(0, Injection::BreakAtArming)]);
    // The end of that control task.
    let control_ns = u64::from(INTERRUPT_INSTRUCTIONS) * 1_000_000_000 / CLOCK_HZ.get();
    for [from, until] in &observed.on_ns {
        assert!(until - from < control_ns, "on at {:?}", observed.on_ns);
    }
    assert!(!observed.on_after(AT), "on at {:?}", observed.on_ns);
    assert!(observed.says("faulted: break input"), "{:?}", observed.log);
}

#[test]
fn a_lost_crystal_turns_the_bridge_off() {
    let observed =
        inject(Some(&parameters()), FittedParts::default(), &[(AT, Injection::CrystalLost)]);
    assert_off_after(&observed, AT, MS / 10);
    let reported = observed.log.iter().any(|line| {
        let text = line.text.to_lowercase();
        text.contains("crystal") && (text.contains("lost") || text.contains("stopped"))
    });
    assert!(reported, "{:?}", observed.log);
}

#[test]
fn without_a_crystal_nothing_moves() {
    let fitted = FittedParts { crystal: false, ..FittedParts::default() };
    let observed = inject(Some(&parameters()), fitted, &[]);
    assert!(observed.on_ns.is_empty(), "{observed:?}");
    // "from crystal" is what a whole board says.
    assert!(observed.says("internal oscillator, crystal absent"), "{:?}", observed.log);
    assert!(observed.says("faulted: crystal absent"), "{:?}", observed.log);
}

#[test]
fn a_reset_in_mid_move_is_reported_and_nothing_moves_after() {
    let observed = inject(Some(&parameters()), FittedParts::default(), &[(AT, Injection::Reset)]);
    assert_eq!(observed.resets.len(), 1, "{:?}", observed.resets);
    assert_off_after(&observed, AT, MS / 10);
    assert!(observed.says("reset pin"), "{:?}", observed.log);
    assert!(observed.says("faulted: reset while armed"), "{:?}", observed.log);
}

#[test]
fn a_record_of_a_fault_that_the_reset_has_damaged_is_not_believed() {
    let [(address, _)] = firmware().variable("KEPT")[..] else { panic!("not in one piece") };
    // Its third word is the tick of the fault; a single byte of it has changed.
    let damage = Injection::Corrupts { address: address + 8, length: 1, to: 0xA5 };
    let faulted = [(AT, Injection::Break), (AT + 100 * MS, Injection::Reset)];
    let damaged = [faulted[0], (AT + 100 * MS, damage), faulted[1]];
    for (injections, fault) in [(&faulted[..], "break input"), (&damaged, "none")] {
        let observed = inject(Some(&parameters()), FittedParts::default(), injections);
        let said = format!("reset by reset pin; last fault: {fault}");
        assert!(observed.says(&said), "{said}: {:?}", observed.log);
    }
}

#[test]
fn without_parameters_or_with_damaged_ones_nothing_moves() {
    let mut damaged = parameters();
    damaged[40] ^= 1;
    for (parameters, refusal, fault) in [
        (None, "no parameters: the motor stays off", "faulted: no parameters"),
        (Some(&damaged[..]), "damaged (checksum)", "faulted: bad parameters"),
    ] {
        let observed = inject(parameters, FittedParts::default(), &[]);
        assert!(observed.on_ns.is_empty(), "{observed:?}");
        assert!(observed.says(refusal) && observed.says(fault), "{:?}", observed.log);
    }
}
