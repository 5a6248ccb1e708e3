//! The faults that the emulated board's hardware can have, under the laws, at rest, moving,
//! saturated: the image finds them on its own pins, and a client on its USART sees to them.
//!
//! Each row says what is done to the joint, its wires or the board, and within how many ticks it
//! has to be seen. Asserted are the code, the tick and the value, as reported over the link and as
//! kept for the time after a reset; that the bridge (MOE and enable pin) goes off in the very tick
//! of the detection, before the budget of that interrupt is used up; that nothing is driven from
//! then on, whatever is asked; and that arming again takes a cleared fault and a joint at rest.
//! Once per fault: that a reset reports it again and drives nothing.
//!
//! What a monitor sees: all laws. What the board reports itself: PD alone, since no law has a part
//! in it. What cannot happen is listed with its reason. `tests/device/matrix/` has the same in
//! process.

mod driven;
mod rows;

use emulator::board::CLOCK_HZ;
use emulator::coupling::ImageSample;
use emulator::fault_injection::Injection;
use emulator::firmware::budgets::{INTERRUPT_INSTRUCTIONS, INTERRUPT_INSTRUCTIONS_ALONE};
use files::encoder::Wires;
use stiction::Fault;
use stiction::link::StateCode;

use crate::fault_injection::MS;
use driven::{Driven, SITUATIONS, Situation, harder, sound};
use experiments::controllers;
use rows::{Reported, Row, reported};

/// The control interrupt's budget, ns: from the read of the counter to the end, an instruction
/// being a cycle here.
const INTERRUPT_NS: u64 = ns(INTERRUPT_INSTRUCTIONS);

const fn ns(instructions: u32) -> u64 {
    instructions as u64 * 1_000_000_000 / CLOCK_HZ.get()
}

/// What a monitor sees.
const ROWS: [&Row; 14] = [
    &rows::JUMP,
    &rows::STALL,
    &rows::HELD,
    &rows::CUT,
    &rows::ONE_CUT,
    &rows::DEAD,
    &rows::FOLLOWING,
    &rows::OVERSPEED,
    &rows::POSITION,
    &rows::SUPPLY_LOW,
    &rows::SUPPLY_HIGH,
    &rows::OVERHEAT,
    &rows::NON_FINITE,
    &rows::SILENCE,
];

/// Why the others are in no row.
const ELSEWHERE: [(Fault, &str); 5] = [
    (Fault::NoParameters, "only at boot: tests/image/hardware_faults.rs"),
    (Fault::BadParameters, "only at boot: tests/image/hardware_faults.rs"),
    (Fault::ClockAbsent, "only at boot: tests/image/hardware_faults.rs"),
    (Fault::ClockWrong, "only at boot: tests/image/supply_and_crystal.rs"),
    (Fault::EncoderReversed, "only in the first move: a test of its own, below"),
];

/// From the injection on: the tick in which the bridge has gone off.
fn seen(row: &Row, driven: &mut Driven, name: &str, [least, most]: [u32; 2]) -> (u32, ImageSample) {
    let inject = row.inject;
    for tick in 0..most {
        driven.act(move |halted| inject(halted, tick));
        // A client that is there.
        if row.fault != Fault::LinkTimeout && tick % 10 == 5 {
            driven.status();
        }
        let sample = driven.samples(1);
        if !sample.bridge.is_on() {
            assert!(tick + 1 >= least, "{name}: seen after {} ticks already", tick + 1);
            return (tick + 1, sample);
        }
    }
    panic!("{name}: not seen within {most} ticks");
}

/// Asserts that the device reports and keeps the fault of the tick that has turned the bridge off,
/// and drives nothing, whatever is commanded.
fn assert_latched(
    driven: &mut Driven,
    name: &str,
    (fault, value): (Fault, [f32; 2]),
    sample: ImageSample,
) {
    let (kept, reported) = (driven.kept(), driven.status().fault);
    assert_eq!((kept.fault, Some(kept.tick)), (Some(fault), sample.clock), "{name}");
    assert_eq!(
        (reported.code, reported.tick, reported.value),
        (fault as u8, kept.tick, kept.value),
        "{name}"
    );
    assert!((value[0]..=value[1]).contains(&reported.value.abs()), "{name}: {reported:?}");
    let client = driven.client();
    assert!(
        client.arm().is_err() && client.step_to(1.0).is_err() && client.hold().is_err(),
        "{name}"
    );
    driven.samples(25);
    let (off, now) = driven.off_and_now();
    assert!(now > sample.at_ns + 400 * MS, "{name}");
    // The name of a case has its law.
    let robust = name.contains("robust");
    let most = if robust { ns(INTERRUPT_INSTRUCTIONS_ALONE) } else { INTERRUPT_NS };
    assert!(off <= sample.at_ns + most, "{name}: off at {off}, and {sample:?}");
}

/// The reset after a fault reports it and drives nothing.
fn assert_kept_across_a_reset(driven: &mut Driven, name: &str, fault: Fault) {
    let (off, _) = driven.off_and_now();
    driven.act(|halted| {
        sound(halted);
        halted.push(0.0, 0.0);
    });
    driven.samples(2);
    driven.act(|halted| halted.inject(Injection::Reset));
    driven.wait(200 * MS);
    driven.connect_anew();
    assert_eq!(driven.status().fault.code, fault as u8, "{name}");
    assert!(driven.client().arm().is_err(), "{name}");
    driven.samples(10);
    assert_eq!(driven.off_and_now().0, off, "{name}: driven after the reset");
    let last = format!("reset by reset pin; last fault: {}", fault.describe());
    assert!(driven.log().contains(&last), "{name}: {:?}", driven.log());
}

/// Cleared is not armed, a joint that moves is not armed, and one at rest begins with a law that
/// has forgotten.
fn assert_armed_again_only_as_it_should(driven: &mut Driven, name: &str) {
    driven.client().clear().unwrap();
    assert!(!driven.samples(2).bridge.is_on(), "{name}");
    assert_eq!(driven.state(), StateCode::Stopped, "{name}");
    driven.act(|halted| halted.push(0.0, 5.0));
    driven.samples(2);
    assert!(driven.client().arm().unwrap_err().to_string().contains("at rest"), "{name}");
    driven.act(|halted| halted.push(0.0, 0.0));
    driven.samples(10);
    driven.client().arm().unwrap();
    // The one that was under way, and an armed one.
    assert!(driven.samples(2).bridge.is_on(), "{name}: {:?}", driven.status());
    let tick = driven.last_tick();
    assert_eq!((tick.error, tick.v_c, tick.code), (0.0, 0.0, 0), "{name}");
}

/// For tests/evidence/reliability.md, as `cargo xtask reliability` reads it.
fn print_row(fault: Fault, what: &str, situation: Situation, cases: usize, slowest: &str) {
    let (fault, situation) = (fault.describe(), format!("{situation:?}").to_lowercase());
    println!(
        "reliability: image | fault={fault} | what={what} | situation={situation} | \
         cases={cases} | slowest={slowest}"
    );
}

fn assert_rows(rows: &[&Row]) {
    let mut driven = Driven::boot();
    for row in rows {
        let mut first = true;
        for (situation, within) in SITUATIONS.into_iter().zip(row.within) {
            let Ok(within) = within else { continue };
            let (mut slowest, mut cases) = (0, 0);
            for law in controllers() {
                // In its HOLD the effort is a constant, which no gain changes: nothing to be seen
                // before the next move, and nothing wrong.
                let holds = law == "robust" && situation == Situation::Rest;
                if row.fault == Fault::NonFinite && holds {
                    continue;
                }
                cases += 1;
                let name = format!("{} ({}), {law}, {situation:?}", row.fault.describe(), row.what);
                driven.take(law, &[row.set, harder(law, situation)].concat());
                driven.bring(situation);
                let (ticks, sample) = seen(row, &mut driven, &name, within);
                slowest = slowest.max(ticks);
                assert_latched(&mut driven, &name, (row.fault, row.value), sample);
                if std::mem::take(&mut first) {
                    assert_kept_across_a_reset(&mut driven, &name, row.fault);
                }
                driven.take(law, row.set);
                if row.fault == Fault::Overheat {
                    // Four of its time constants.
                    driven.samples(200);
                }
                assert_armed_again_only_as_it_should(&mut driven, &name);
            }
            print_row(row.fault, row.what, situation, cases, &format!("{slowest} ticks"));
        }
    }
}

#[test]
fn a_joint_that_does_not_follow() {
    assert_rows(&[&rows::STALL, &rows::HELD, &rows::FOLLOWING]);
}

#[test]
fn a_joint_out_of_its_bounds() {
    // The position first: what comes after it moves the place that the board calls zero.
    assert_rows(&[&rows::POSITION, &rows::OVERSPEED]);
}

#[test]
fn wires_of_the_encoder() {
    assert_rows(&[&rows::JUMP, &rows::CUT, &rows::ONE_CUT]);
}

#[test]
fn supply_and_heat() {
    assert_rows(&[&rows::SUPPLY_LOW, &rows::SUPPLY_HIGH, &rows::OVERHEAT]);
}

#[test]
fn memory_and_link() {
    assert_rows(&[&rows::NON_FINITE, &rows::SILENCE]);
}

/// Swapped wires make the loop push away from the target: seen within the first hundredths of a
/// degree.
#[test]
fn a_reversed_encoder_is_seen_in_the_first_move_under_every_law() {
    let mut driven = Driven::boot();
    let mut slowest = 0;
    for law in controllers() {
        driven.take(law, &[]);
        driven.act(|halted| halted.rewire(Wires::Swapped));
        driven.samples(10);
        driven.client().arm().unwrap();
        driven.client().step_to(5.0).unwrap();
        driven.samples(1);
        let from = driven.act(|halted| halted.plant().position_deg());
        let off = (1..=20).find_map(|tick| {
            let sample = driven.samples(1);
            (!sample.bridge.is_on()).then_some((tick, sample))
        });
        let (ticks, off) = off.unwrap();
        slowest = slowest.max(ticks);
        // Eight counts are 0.019 deg; a tick at the speed that it has by then is a little more.
        let travel = driven.act(|halted| halted.plant().position_deg()) - from;
        assert!((0.01..0.2).contains(&travel), "{law}: {travel}");
        assert_latched(&mut driven, law, (Fault::EncoderReversed, [0.019, 0.2]), off);
        driven.take(law, &[]);
        assert_armed_again_only_as_it_should(&mut driven, law);
    }
    let (fault, what) = (Fault::EncoderReversed, "swapped wires, a step of 5 deg");
    print_row(fault, what, Situation::Rest, controllers().count(), &format!("{slowest} ticks"));
}

/// An encoder that is dead from rest has no edge that could be missed: what is seen is the effort
/// that the law asks for. Where the joint is by then, the impulse bounds.
#[test]
fn an_encoder_that_is_dead_at_rest_is_seen_in_the_next_step_under_every_law() {
    let (row, mut driven, mut slowest) = (&rows::DEAD, Driven::boot(), 0);
    for law in controllers() {
        let name = format!("{}, {law}", row.what);
        driven.take(law, row.set);
        driven.client().arm().unwrap();
        // The soft start is over, and the joint stays where it is.
        driven.pass(30);
        driven.act(|halted| halted.rewire(Wires::Cut));
        // Pull-ups hold the ends of cut wires, which may make two counts; they are no speed any
        // more when the step comes.
        driven.pass(10);
        driven.client().step_to(0.41).unwrap();
        let from = driven.act(|halted| halted.plant().position_deg());
        let (ticks, sample) = seen(row, &mut driven, &name, row.within[0].unwrap());
        slowest = slowest.max(ticks);
        // 0.05 V beyond the breakaway for 4 s move the joint (27 deg/s^2 for a volt, 0.02 V s/deg)
        // by less than 9 deg, and more effort less far.
        let travel = driven.act(|halted| halted.plant().position_deg()) - from;
        assert!(travel > 0.0 && travel < 9.0, "{name}: {travel} deg");
        assert_latched(&mut driven, &name, (row.fault, row.value), sample);
        driven.take(law, row.set);
        assert_armed_again_only_as_it_should(&mut driven, &name);
    }
    print_row(
        row.fault,
        row.what,
        Situation::Rest,
        controllers().count(),
        &format!("{slowest} ticks"),
    );
}

fn assert_reported(situation: Situation) {
    let mut driven = Driven::boot();
    for Reported { fault, injections, limit } in reported() {
        let name = format!("{}, {situation:?}", fault.describe());
        driven.take("pd", &[]);
        driven.bring(situation);
        let (_, begin) = driven.off_and_now();
        for (at, injection) in injections {
            let (_, now) = driven.off_and_now();
            driven.wait(begin + at - now);
            driven.act(move |halted| halted.inject(injection));
        }
        let (_, now) = driven.off_and_now();
        driven.wait(begin + 400 * MS - now);
        let (off, now) = driven.off_and_now();
        assert!(
            off <= begin + limit && now >= begin + 400 * MS,
            "{name}: off after {} ns",
            off - begin
        );
        let report = format!("faulted: {} (code {})", fault.describe(), fault as u8);
        assert!(
            driven.log().iter().any(|line| line.starts_with(&report)),
            "{name}: {:?}",
            driven.log()
        );
        // The emulator's hardware takes no time, or less than it can resolve; the injection itself
        // looks at the pins. That is no measurement.
        let slowest = match off.saturating_sub(begin) {
            0..1000 => "in hardware".to_owned(),
            ns => format!("{:.2} ms", ns as f64 / MS as f64),
        };
        print_row(fault, "the board reports it", situation, 1, &slowest);
        driven.connect_anew();
        assert_eq!(driven.status().fault.code, fault as u8, "{name}");
        assert!(driven.client().arm().is_err() && driven.client().step_to(1.0).is_err(), "{name}");
        driven.samples(10);
        assert_eq!(driven.off_and_now().0, off, "{name}: driven again");
        if !fault.is_clearable() {
            assert!(driven.client().clear().is_err(), "{name}");
            continue;
        }
        driven.take("pd", &[]);
        assert_armed_again_only_as_it_should(&mut driven, &name);
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

#[test]
fn no_fault_is_forgotten_by_the_matrix() {
    let reported = reported();
    for &fault in Fault::ALL {
        let in_a_row = ROWS.iter().any(|row| row.fault == fault)
            || reported.iter().any(|row| row.fault == fault);
        let elsewhere = ELSEWHERE.iter().any(|(other, _)| *other == fault);
        assert!(in_a_row != elsewhere, "{fault:?}");
    }
}
