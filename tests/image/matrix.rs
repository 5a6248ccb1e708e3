//! The faults that the emulated board's hardware can have, under the laws, at rest, moving, saturated: the image finds them
//! on its own pins.
//!
//! Each row says what is done to the joint, its wires or the board, and within how many ticks it has to be seen. Asserted
//! are the code, the tick and the value that the image keeps for the time after a reset; that the bridge (MOE and enable
//! pin) goes off in the very tick of the detection, before the budget of that interrupt is used up; and that nothing is
//! driven from then on. Once per fault: that a reset tells it again and drives nothing, and the reset after that does.
//!
//! All seven laws where the law decides on the detection (blocked, pushed, thrown, full effort, reversed); PD alone where
//! it does not (a jump, cut wires, a limit, the supply, a bit of the RAM, and what the board reports itself).
//! `tests/device/matrix.rs` has all laws in every row, and that arming again takes a cleared fault, in process.

use host_sim::device::simulated::Wires;
use host_sim::emulator::bench::Mishap;
use host_sim::emulator::powered::Held;
use stiction::Fault;

use crate::bench::MS;
use crate::joint::{Driven, Moving, Rest, SITUATIONS, Saturated, Situation};

const LAWS: &[&str] = &["pd", "ri", "rvi", "roi", "feedforward", "dnpf", "srnf"];
const PD: &[&str] = &["pd"];

/// The control interrupt's budget of 900 instructions at 168 MHz, ns: from the read of the counter to the end.
const INTERRUPT_NS: u64 = 5_400;

/// What the bridge's supply has to be measured for: 12 V are half of the pin's range.
const SUPPLY: &[&str] = &["device.supply_full_scale_v=24", "device.nominal_supply_v=12"];

struct Row {
    fault: Fault,
    what: &'static str,
    laws: &'static [&'static str],
    /// Keys that take the row's fault out of the shadow of those that would be seen earlier.
    set: &'static [&'static str],
    /// What is done in every tick from the injection on.
    inject: fn(&mut Held<'_>, u32),
    /// Ticks from the injection to the detection, at least and at most, by situation; or why it cannot be.
    within: [Result<[u32; 2], &'static str>; 3],
    /// What the value that tripped it may be, without its sign.
    value: [f32; 2],
}

/// A fault that has no value keeps zero.
const NONE: [f32; 2] = [0.0, 0.0];

const fn all(within: [u32; 2]) -> [Result<[u32; 2], &'static str>; 3] {
    [Ok(within), Ok(within), Ok(within)]
}

const NO_EDGE: &str = "without motion there is no edge that could be missed";

const STALL: Row = Row {
    fault: Fault::Stall,
    what: "the joint is blocked",
    laws: LAWS,
    set: &[],
    inject: |held, _| held.rig.brake_v = 100.0,
    within: [
        Err("a joint at rest is not asked to move: blocked or not is the same"),
        // From 0.5 V of cruising effort to 0.8 V at 5 deg/s is up to 0.3 s; then 0.2 s.
        Ok([10, 30]),
        Ok([10, 12]),
    ],
    // Twice the breakaway effort of 0.4 V, to the full scale.
    value: [0.8 - 0.005, 5.0],
};

const CUT: Row = Row {
    what: "both encoder wires cut",
    laws: PD,
    inject: |held, tick| {
        if tick == 0 {
            held.rewire(Wires::Cut);
        }
    },
    within: [Err(NO_EDGE), Ok([10, 30]), Ok([10, 12])],
    ..STALL
};

const ONE_CUT: Row = Row {
    what: "one encoder wire cut",
    inject: |held, tick| {
        if tick == 0 {
            held.rewire(Wires::OneCut);
        }
    },
    ..CUT
};

const JUMP: Row = Row {
    fault: Fault::EncoderJump,
    what: "3000 edges of noise within a tick",
    laws: PD,
    set: &[],
    inject: |held, tick| {
        if tick == 0 {
            held.jump(3000);
        }
    },
    within: all([1, 1]),
    // 3000 counts of 0.00242 deg, and what the joint moves in a tick: 20 deg/s at most.
    value: [7.26 - 0.4, 7.26 + 0.4],
};

const FOLLOWING: Row = Row {
    fault: Fault::FollowingError,
    what: "pushed away from its set point, 15 deg/s",
    laws: LAWS,
    set: &["limits.stall_v=0"],
    inject: |held, _| {
        let position = held.rig.joint.position_deg();
        held.push(position - 0.3, -15.0);
    },
    within: [
        // 5 deg at 0.3 deg a tick, less what the joint gives way by itself.
        Ok([8, 18]),
        Ok([6, 18]),
        // Also the way that it had gone since the jump.
        Ok([8, 40]),
    ],
    // The full scale's 5 deg at 1 V/deg, to a tick's way beyond, and the step of 20 deg.
    value: [5.0, 26.0],
};

const OVERSPEED: Row = Row {
    fault: Fault::Overspeed,
    what: "driven to 1.3 times the limit from outside",
    laws: LAWS,
    set: &["limits.overspeed_deg_per_s=40", "limits.encoder_jump_deg=3"],
    inject: |held, _| {
        let position = held.rig.joint.position_deg();
        held.push(position, 52.0);
    },
    within: [
        Err("a joint at rest has no speed; one that is thrown is not at rest: the next column"),
        // Within the window of the regression.
        Ok([2, 6]),
        Ok([2, 6]),
    ],
    value: [40.0, 60.0],
};

const POSITION: Row = Row {
    fault: Fault::PositionLimit,
    what: "put beyond the range",
    laws: PD,
    set: &[
        "limits.position_min_deg=-30",
        "limits.position_max_deg=30",
        "encoder.counter_bits=32",
        "limits.encoder_jump_deg=0",
        "limits.overspeed_deg_per_s=0",
        "limits.following_error_deg=0",
    ],
    inject: |held, tick| {
        if tick == 0 {
            held.push(30.1, 0.0);
        }
    },
    within: all([1, 1]),
    value: [30.0, 30.2],
};

const SUPPLY_LOW: Row = Row {
    fault: Fault::SupplyLow,
    what: "6 V of 12 V",
    laws: PD,
    set: SUPPLY,
    inject: |held, _| held.board().supply(825),
    // Three readings in a row, and the one that had been taken before.
    within: all([4, 4]),
    value: [5.99, 6.01],
};

const SUPPLY_HIGH: Row = Row {
    fault: Fault::SupplyHigh,
    what: "18 V of 12 V",
    inject: |held, _| held.board().supply(2475),
    value: [17.99, 18.01],
    ..SUPPLY_LOW
};

const OVERHEAT: Row = Row {
    fault: Fault::Overheat,
    what: "full effort against a block",
    laws: LAWS,
    set: &["limits.stall_v=0", "limits.thermal_s=1", "limits.continuous_v=2.5"],
    inject: |held, _| held.rig.brake_v = 100.0,
    within: [
        Err("the effort that a joint can rest with is less than any motor bears for ever"),
        Err("a blocked joint is saturated in the end: the next column"),
        // 1 s ln(1 / (1 - 1/4)) = 0.288 s from cold; some heat is there already.
        Ok([8, 16]),
    ],
    value: [2.5, 2.6],
};

const NON_FINITE: Row = Row {
    fault: Fault::NonFinite,
    what: "a bit error in the RAM makes a gain not a number",
    laws: PD,
    set: &[],
    inject: |held, tick| {
        if tick == 0 {
            spoil_gain(held);
        }
    },
    within: all([1, 1]),
    value: NONE,
};

/// Kd of the thesis, V s/deg.
const KD: f32 = 0.15;

/// No parameters that are accepted lead to a value that is not finite, so the servo's own copy of a gain is changed.
fn spoil_gain(held: &mut Held<'_>) {
    let mut spoiled = 0;
    for (address, length) in crate::bench::firmware().variable("resource_servo") {
        let words = held.words(address, length / 4).unwrap();
        for (index, _) in words.iter().enumerate().filter(|(_, word)| **word == KD.to_bits()) {
            held.overwrite(address + 4 * index as u64, f32::NAN.to_bits()).unwrap();
            spoiled += 1;
        }
    }
    assert!(spoiled > 0, "the servo holds no Kd");
}

/// Everything that a monitor sees, in the order in which it is listed in `docs/faults.md`.
const ROWS: [&Row; 11] = [
    &JUMP,
    &STALL,
    &CUT,
    &ONE_CUT,
    &FOLLOWING,
    &OVERSPEED,
    &POSITION,
    &SUPPLY_LOW,
    &SUPPLY_HIGH,
    &OVERHEAT,
    &NON_FINITE,
];

/// Why the others are in no row.
const ELSEWHERE: [(Fault, &str); 5] = [
    (Fault::NoParameters, "only at boot: tests/image/mishaps.rs"),
    (Fault::BadParameters, "only at boot: tests/image/mishaps.rs"),
    (Fault::ClockAbsent, "only at boot: tests/image/mishaps.rs"),
    (Fault::EncoderReversed, "only in the first move: a test of its own, below"),
    (Fault::LinkTimeout, "wants a link"),
];

/// A monitor's fault from its injection on, in the situation that the joint is in.
fn assert_seen(row: &Row, driven: &mut Driven, name: &str, [least, most]: [u32; 2]) {
    let inject = row.inject;
    let off = (1..=most).find_map(|tick| {
        driven.powered.act(move |held| inject(held, tick - 1)).unwrap();
        let sample = driven.samples(1);
        (!sample.bridge.is_on()).then_some((tick, sample))
    });
    let (ticks, sample) = off.unwrap_or_else(|| panic!("{name}: not seen within {most} ticks"));
    assert!(ticks >= least, "{name}: seen after {ticks} ticks already");
    assert_latched(driven, name, row.fault, row.value, (sample.at_ns, sample.clock.unwrap()));
}

/// Kept is what tripped in the tick that has turned the bridge off, and nothing is driven from then on.
fn assert_latched(driven: &mut Driven, name: &str, fault: Fault, value: [f32; 2], (at, tick): (u64, u32)) {
    let kept = driven.kept();
    assert_eq!((kept.fault, kept.tick), (Some(fault), tick), "{name}");
    assert!((value[0]..=value[1]).contains(&kept.value.abs()), "{name}: {kept:?}");
    driven.pass(300 * MS);
    let (off, now) = driven.off_and_now();
    assert!(off <= at + INTERRUPT_NS && now >= at + 300 * MS, "{name}: off at {off}, the tick was at {at}");
    let told = format!("faulted: {} (code {})", fault.describe(), fault as u8);
    assert!(driven.log().iter().any(|line| line.starts_with(&told)), "{name}: {:?}", driven.log());
}

/// The reset after a fault tells it and drives nothing; the one after that starts clean, and shows that the board still
/// could.
fn assert_kept_across_a_reset(driven: &mut Driven, name: &str, fault: Fault) {
    let (off, _) = driven.off_and_now();
    let lines = driven.log().len();
    driven.powered.act(|held| held.rig.brake_v = 0.0).unwrap();
    driven.mishap(Mishap::Reset);
    // A board that comes out of a reset with nothing to tell is armed 80 ms later.
    driven.pass(200 * MS);
    assert_eq!(driven.off_and_now().0, off, "{name}: driven after the reset");
    let log = driven.log();
    let [again, last] = [
        format!("faulted: {}", fault.describe()),
        format!("reset by reset pin; last fault: {}", fault.describe()),
    ];
    assert!(log[lines..].iter().any(|line| line.starts_with(&again)), "{name}: {log:?}");
    assert!(log[lines..].contains(&last), "{name}: {log:?}");
    driven.mishap(Mishap::Reset);
    let sound = |held: &mut Held<'_>| {
        held.board().supply(1650);
        held.push(0.0, 0.0);
    };
    driven.powered.act(sound).unwrap();
    driven.pass(200 * MS);
    let (on, now) = driven.off_and_now();
    assert!(now - on < 40 * MS, "{name}: not driven after the second reset: {:?}", driven.log());
}

fn assert_row(row: &Row) {
    let mut first = true;
    for (situation, within) in SITUATIONS.into_iter().zip(row.within) {
        let Ok(within) = within else { continue };
        for law in row.laws {
            let name = format!("{} ({}), {law}, {situation:?}", row.fault.describe(), row.what);
            let mut driven = Driven::into(situation, law, row.set);
            assert_seen(row, &mut driven, &name, within);
            if std::mem::take(&mut first) {
                assert_kept_across_a_reset(&mut driven, &name, row.fault);
            }
        }
    }
}

#[test]
fn a_blocked_joint_under_every_law() {
    assert_row(&STALL);
}

#[test]
fn a_joint_that_is_pushed_away_under_every_law() {
    assert_row(&FOLLOWING);
}

#[test]
fn a_joint_that_is_thrown_under_every_law() {
    assert_row(&OVERSPEED);
}

#[test]
fn a_motor_at_full_effort_under_every_law() {
    assert_row(&OVERHEAT);
}

#[test]
fn encoder_and_range_whatever_the_law() {
    for row in [&JUMP, &CUT, &ONE_CUT, &POSITION] {
        assert_row(row);
    }
}

#[test]
fn supply_and_memory_whatever_the_law() {
    for row in [&SUPPLY_LOW, &SUPPLY_HIGH, &NON_FINITE] {
        assert_row(row);
    }
}

/// Swapped wires make the loop push away from the target: seen within the first hundredths of a degree.
#[test]
fn a_reversed_encoder_is_seen_in_the_first_move_under_every_law() {
    for law in LAWS {
        let mut driven = Driven::boot(&Saturated.plan(law, &[]));
        driven.powered.act(|held| held.rewire(Wires::Swapped)).unwrap();
        driven.arm();
        let off = (0..60).map(|_| driven.samples(1)).find(|sample| !sample.bridge.is_on()).unwrap();
        // Eight counts are 0.019 deg; a tick at the speed that it has by then is a little more.
        let travel = driven.powered.act(|held| held.rig.joint.position_deg()).unwrap();
        assert!((0.01..0.2).contains(&travel), "{law}: {travel}");
        assert_latched(
            &mut driven,
            law,
            Fault::EncoderReversed,
            [0.019, 0.2],
            (off.at_ns, off.clock.unwrap()),
        );
    }
}

/// What the board reports itself.
struct Reported {
    fault: Fault,
    /// What happens, each so long after the first, ns.
    mishaps: Vec<(u64, Mishap)>,
    /// Within what time the bridge has to be off, ns.
    limit: u64,
}

fn reported() -> Vec<Reported> {
    let corrupt = |(address, length)| (0, Mishap::Corrupts { address, length, to: 1 });
    let lock: Vec<_> = crate::bench::firmware().variable("RTT_ENCODER").into_iter().map(corrupt).collect();
    let row = |fault, mishaps: &[(u64, Mishap)], limit| Reported { fault, mishaps: mishaps.to_vec(), limit };
    let broken = [(0, Mishap::Break), (100 * MS, Mishap::BreakReleased)];
    let stalled = [(0, Mishap::CoreStalls), (30 * MS, Mishap::CoreGoesOn)];
    vec![
        // In hardware; the clock security system takes a few cycles.
        row(Fault::BreakInput, &broken, 0),
        row(Fault::ClockLost, &[(0, Mishap::CrystalLost)], 100),
        // The first control tick after the stall is told that it comes late.
        row(Fault::Overrun, &stalled, 30 * MS + INTERRUPT_NS),
        // 60 ms of the fastest oscillator are 88 ms of a typical one.
        row(Fault::Watchdog, &[(0, Mishap::TickStops)], 89 * MS),
        // The next control tick's first access.
        row(Fault::HardFault, &[(0, Mishap::BusError { address: 0x4000_0024 })], 20 * MS),
        // The next line of the log, of which there are ten a second.
        row(Fault::Panic, &lock, 120 * MS),
        row(Fault::ResetWhileArmed, &[(0, Mishap::Reset)], 0),
        row(Fault::BrownOut, &[(0, Mishap::BrownOut)], 0),
    ]
}

fn assert_reported(situation: Situation) {
    for Reported { fault, mishaps, limit } in reported() {
        let name = format!("{}, {situation:?}", fault.describe());
        let mut driven = Driven::into(situation, "pd", &[]);
        let (_, begin) = driven.off_and_now();
        for (at, mishap) in mishaps {
            let (_, now) = driven.off_and_now();
            driven.pass(begin + at - now);
            driven.mishap(mishap);
        }
        let (_, now) = driven.off_and_now();
        driven.pass(begin + 500 * MS - now);
        let (off, now) = driven.off_and_now();
        assert!(off <= begin + limit && now >= begin + 500 * MS, "{name}: off after {} ns", off - begin);
        let told = format!("faulted: {} (code {})", fault.describe(), fault as u8);
        assert!(driven.log().iter().any(|line| line.starts_with(&told)), "{name}: {:?}", driven.log());
    }
}

#[test]
fn what_the_board_reports_at_rest() {
    assert_reported(Rest);
}

#[test]
fn what_the_board_reports_while_it_moves() {
    assert_reported(Moving);
}

#[test]
fn what_the_board_reports_at_full_effort() {
    assert_reported(Saturated);
}

#[test]
fn no_fault_is_forgotten_by_the_matrix() {
    let reported = reported();
    for fault in Fault::ALL {
        let in_a_row =
            ROWS.iter().any(|row| row.fault == fault) || reported.iter().any(|row| row.fault == fault);
        let elsewhere = ELSEWHERE.iter().any(|(other, _)| *other == fault);
        assert!(in_a_row != elsewhere, "{fault:?}");
    }
}
