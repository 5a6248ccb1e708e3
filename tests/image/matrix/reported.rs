//! The faults that the board reports itself: the image finds them on its own pins. PD alone, since
//! no law has a part in them.

use emulator::fault_injection::Injection;
use experiments::matrix::{
    Bench as _, Situation, assert_armed_again_only_at_rest, bring, start_over,
};
use stiction::Fault;

use super::bench::{INTERRUPT_NS, ImageBench, print_row};
use crate::fault_injection::MS;

/// A fault that the board reports.
pub struct Reported {
    pub fault: Fault,
    /// Keys of the device.
    pub set: &'static [&'static str],
    /// Injections, each with its time after the first, ns.
    pub injections: Vec<(u64, Injection)>,
    /// Time within which the bridge has to be off, ns.
    pub limit: u64,
}

pub fn rows() -> Vec<Reported> {
    let corrupt = |(address, length)| (0, Injection::Corrupts { address, length, to: 1 });
    let lock: Vec<_> =
        crate::common::firmware().variable("RTT_ENCODER").into_iter().map(corrupt).collect();
    let row = |fault, injections: &[(u64, Injection)], limit| Reported {
        fault,
        set: &[],
        injections: injections.to_vec(),
        limit,
    };
    let broken = [(0, Injection::Break), (100 * MS, Injection::BreakReleased)];
    let opened = [(0, Injection::ContactOpens), (100 * MS, Injection::ContactCloses)];
    let stalled = [(0, Injection::CoreStalls), (30 * MS, Injection::CoreGoesOn)];
    vec![
        // In hardware.
        row(Fault::BreakInput, &broken, 0),
        Reported { set: &["device.emergency_stop=true"], ..row(Fault::EmergencyStop, &opened, 0) },
        // The first control tick after the stall is reported as late.
        row(Fault::Overrun, &stalled, 30 * MS + INTERRUPT_NS),
        // 60 ms of the fastest oscillator are 88 ms of a typical one.
        row(Fault::Watchdog, &[(0, Injection::TickStops)], 89 * MS),
        // The next control tick's first access.
        row(Fault::HardFault, &[(0, Injection::BusError { address: 0x4000_0024 })], 20 * MS),
        // The next line of the log, of which there are ten a second.
        row(Fault::Panic, &lock, 120 * MS),
        row(Fault::ResetWhileArmed, &[(0, Injection::Reset)], 0),
        row(Fault::BrownOut, &[(0, Injection::BrownOut)], 0),
        // In hardware; the clock security system takes a few cycles. The last one: the crystal is
        // gone for good.
        row(Fault::ClockLost, &[(0, Injection::CrystalLost)], 100),
    ]
}

fn assert_reported(situation: Situation) {
    let mut bench = ImageBench::boot();
    for Reported { fault, set, injections, limit } in rows() {
        let name = format!("{}, {situation:?}", fault.describe());
        start_over(&mut bench, "pd", set);
        bring(&mut bench, situation);
        let (_, begin) = bench.off_and_now();
        for (at, injection) in injections {
            let (_, now) = bench.off_and_now();
            bench.wait(begin + at - now);
            bench.act(move |halted| halted.inject(injection));
        }
        let (_, now) = bench.off_and_now();
        bench.wait(begin + 400 * MS - now);
        let (off, now) = bench.off_and_now();
        assert!(
            off <= begin + limit && now >= begin + 400 * MS,
            "{name}: off after {} ns",
            off - begin
        );
        let report = format!("faulted: {} (code {})", fault.describe(), fault as u8);
        assert!(
            bench.log().iter().any(|line| line.starts_with(&report)),
            "{name}: {:?}",
            bench.log()
        );
        // The emulator's hardware takes no time, or less than it can resolve; the injection itself
        // looks at the pins. That is no measurement.
        let slowest = match off.saturating_sub(begin) {
            0..1000 => "in hardware".to_owned(),
            ns => format!("{:.2} ms", ns as f64 / MS as f64),
        };
        print_row(fault, "the board reports it", situation, 1, &slowest);
        bench.connect_anew();
        assert_eq!(bench.client().status().unwrap().fault.code, fault as u8, "{name}");
        assert!(bench.client().arm().is_err() && bench.client().step_to(1.0).is_err(), "{name}");
        bench.ticks(10);
        assert_eq!(bench.off_and_now().0, off, "{name}: driven again");
        if !fault.is_clearable() {
            assert!(bench.client().clear().is_err(), "{name}");
            continue;
        }
        start_over(&mut bench, "pd", set);
        assert_armed_again_only_at_rest(&mut bench, &name);
    }
}

#[test]
fn what_the_board_reports_at_rest() {
    assert_reported(Situation::Rest);
}

#[test]
fn what_the_board_reports_while_it_moves() {
    assert_reported(Situation::Moving);
}

#[test]
fn what_the_board_reports_at_full_effort() {
    assert_reported(Situation::Saturated);
}
