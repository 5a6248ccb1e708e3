//! The fault matrix: one table of faults, judged on two benches, under every law, at rest, moving
//! and saturated.
//!
//! A row says what is done to the joint, its wires or its supply, and within how many ticks the
//! device has to detect it. A [`Bench`] does it: the device around the simulated joint, or the
//! flash image on the emulated board. A case asserts the fault's code and value, the bound, that
//! the bridge is off in the tick of the detection, that nothing is driven afterwards whatever is
//! commanded, and that arming again takes a cleared fault and a joint at rest.

mod bench;
mod encoder_index;
mod motor_current;
mod rows;

use files::encoder::Wires;
use stiction::Fault;
use stiction::link::StateCode;
use stiction::motion::home::{HomeRequest, Sense};

pub use bench::{Bench, BenchSample, SITUATIONS, Situation, bring, harder, pass, plan, start_over};
pub use encoder_index::{INDEX, index_rows};
pub use motor_current::{SENSOR, current_rows};
pub use rows::{Row, Within, all, rows};

use crate::controllers;

/// The number of cases that were judged, and of those that cannot be.
#[derive(Clone, Copy, Debug, Default)]
pub struct Count {
    /// Cases that were judged.
    pub cases: usize,
    /// Row and situation of cases that cannot be, each with its reason in the table.
    pub impossible: usize,
}

impl std::ops::AddAssign for Count {
    fn add_assign(&mut self, other: Self) {
        self.cases += other.cases;
        self.impossible += other.impossible;
    }
}

/// Injects a row's cause until the bridge goes off. Returns the ticks that this took.
pub fn detect<B: Bench>(bench: &mut B, row: &Row<B>, name: &str, [least, most]: [u32; 2]) -> u32 {
    for tick in 0..most {
        (row.inject)(bench, tick);
        if row.fault != Fault::LinkTimeout {
            bench.heard(tick);
        }
        if !bench.ticks(1).is_on {
            assert!(tick + 1 >= least, "{name}: detected after {} ticks already", tick + 1);
            return tick + 1;
        }
    }
    panic!("{name}: not detected within {most} ticks");
}

/// Asserts that the device reports the fault of the tick that has turned the bridge off, and drives
/// nothing, whatever is commanded.
pub fn assert_latched<B: Bench>(
    bench: &mut B,
    name: &str,
    law: &str,
    (fault, value): (Fault, [f32; 2]),
) {
    let report = bench.client().status().unwrap().fault;
    assert_eq!(report.code, fault as u8, "{name}");
    assert!((value[0]..=value[1]).contains(&report.value.abs()), "{name}: {report:?}");
    bench.assert_kept(name, &report);
    let client = bench.client();
    assert!(client.arm().is_err(), "{name}");
    assert!(client.step_to(1.0).is_err() && client.hold().is_err(), "{name}");
    bench.ticks(25);
    bench.assert_off_since_detection(name, law);
    assert_eq!(bench.client().status().unwrap().fault.code, fault as u8, "{name}");
}

/// Asserts that a cleared device is not armed, that a joint that moves is not armed, and that one
/// at rest starts with a law that has forgotten its state.
pub fn assert_armed_again_only_at_rest<B: Bench>(bench: &mut B, name: &str) {
    bench.client().clear().unwrap();
    assert!(!bench.ticks(2).is_on, "{name}");
    assert_eq!(bench.client().status().unwrap().state, StateCode::Stopped, "{name}");
    let position = bench.position_deg();
    bench.push(position, 5.0);
    bench.ticks(2);
    assert!(bench.client().arm().unwrap_err().to_string().contains("at rest"), "{name}");
    bench.push(position, 0.0);
    bench.ticks(10);
    bench.client().arm().unwrap();
    // Two ticks: one can be under way when the device arms.
    assert!(bench.ticks(2).is_on, "{name}: {:?}", bench.client().status());
    let tick = bench.last_tick();
    assert_eq!((tick.error, tick.v_c, tick.code), (0.0, 0.0, 0), "{name}");
}

/// Judges one row under every law and in every situation that it can be in.
pub fn assert_row<B: Bench>(bench: &mut B, row: &Row<B>) -> Count {
    let mut count = Count::default();
    let mut is_first = true;
    for (situation, within) in SITUATIONS.into_iter().zip(row.within) {
        let Ok([least, most]) = within else {
            count.impossible += 1;
            continue;
        };
        let within = [least + row.late[0] * B::LATE, most + row.late[1] * B::LATE];
        let (mut slowest, mut cases) = (0, 0);
        for law in controllers().filter(|law| !(row.cannot)(law, situation)) {
            let name = format!("{} ({}), {law}, {situation:?}", row.fault.describe(), row.what);
            start_over(bench, law, &[row.set, harder(law, situation)].concat());
            bring(bench, situation);
            slowest = slowest.max(detect(bench, row, &name, within));
            assert_latched(bench, &name, law, (row.fault, row.value));
            if std::mem::take(&mut is_first) {
                bench.assert_kept_across_a_reset(&name, row.fault);
            }
            start_over(bench, law, row.set);
            // Four time constants of the motor's model, after the row that heats it.
            bench.ticks(if row.fault == Fault::Overheat { 200 } else { 1 });
            assert_armed_again_only_at_rest(bench, &name);
            cases += 1;
        }
        B::report(row.fault, row.what, situation, cases, [slowest, within[1]]);
        count.cases += cases;
    }
    count
}

/// Faults of rows that a homing on its way shows within the ticks of a joint that moves.
const IN_A_HOMING: [Fault; 4] =
    [Fault::EncoderJump, Fault::SupplyLow, Fault::SupplyHigh, Fault::LinkTimeout];

/// Judges rows under every law while a homing moves the joint: the fault ends the homing, and the
/// joint is not referenced. Returns the number of cases.
pub fn assert_faults_in_a_homing<B: Bench>(bench: &mut B) -> usize {
    let request = HomeRequest { sense: Sense::Plus, ..HomeRequest::default() };
    let mut cases = 0;
    for row in rows::<B>().iter().filter(|row| IN_A_HOMING.contains(&row.fault)) {
        let Ok([least, most]) = row.within[1] else { panic!("{}: no bounds in motion", row.what) };
        let within = [least + row.late[0] * B::LATE, most + row.late[1] * B::LATE];
        for law in controllers() {
            let name = format!("{} ({}), {law}, homing", row.fault.describe(), row.what);
            start_over(bench, law, row.set);
            assert!(bench.client().status().unwrap().is_referenced, "{name}");
            bench.client().home(request).unwrap();
            pass(bench, 100);
            assert!(bench.position_deg() > 0.5, "{name}: {} deg", bench.position_deg());
            let status = bench.client().status().unwrap();
            assert!(status.state == StateCode::Armed && !status.is_referenced, "{name}");
            detect(bench, row, &name, within);
            assert_latched(bench, &name, law, (row.fault, row.value));
            assert!(bench.client().homed().unwrap().is_none(), "{name}");
            assert!(!bench.client().status().unwrap().is_referenced, "{name}");
            bench.supply(0.5);
            bench.client().clear().unwrap();
            // A hand proves the encoder again.
            let position = bench.position_deg();
            bench.push(position + 1.0, 0.0);
            bench.ticks(10);
            cases += 1;
        }
    }
    cases
}

/// Swapped wires make the loop push away from the target. Asserts that the monitor detects that
/// within the first hundredths of a degree, under every law. Returns the longest way, deg, and the
/// most ticks.
pub fn assert_reversed_in_the_first_move<B: Bench>(bench: &mut B) -> (f64, u32) {
    let (mut furthest, mut slowest) = (0.0f64, 0);
    for law in controllers() {
        start_over(bench, law, &[]);
        bench.rewire(Wires::Swapped);
        bench.ticks(10);
        bench.client().arm().unwrap();
        bench.client().step_to(5.0).unwrap();
        let from = bench.position_deg();
        let ticks = (1..=60).find(|tick| {
            bench.heard(*tick);
            !bench.ticks(1).is_on
        });
        slowest = slowest.max(ticks.unwrap_or_else(|| panic!("{law}: not detected")));
        // Eight counts are 0.019 deg; at the speed that the joint has by then, a tick is a little
        // more.
        let travel = bench.position_deg() - from;
        assert!((0.01..0.2).contains(&travel), "{law}: {travel} deg");
        furthest = furthest.max(travel);
        assert_latched(bench, law, law, (Fault::EncoderReversed, [0.019, 0.2]));
        start_over(bench, law, &[]);
        assert_armed_again_only_at_rest(bench, law);
    }
    (furthest, slowest)
}

/// Asserts that each fault is in a row, or elsewhere for a reason, and not both.
pub fn assert_none_is_forgotten<B: Bench>(reported: &[Fault], elsewhere: &[(Fault, &str)]) {
    let (rows, of_current, of_index) = (rows::<B>(), current_rows::<B>(), index_rows::<B>());
    for fault in Fault::ALL {
        let mut all_rows = rows.iter().chain(&of_current).chain(&of_index);
        let is_in_a_row = all_rows.any(|row| row.fault == *fault) || reported.contains(fault);
        let is_elsewhere = elsewhere.iter().any(|(other, _)| other == fault);
        assert!(is_in_a_row != is_elsewhere, "{fault:?}");
    }
}
