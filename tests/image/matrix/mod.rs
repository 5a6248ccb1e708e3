//! The fault matrix in the flash image. The table is in `tests/matrix/`; a dead encoder at rest, a
//! spoiled gain and what the board itself reports are rows of this bench alone.

mod bench;
mod misleading_inputs;
mod reported;

use experiments::controllers;
use experiments::matrix::{
    Bench as _, INDEX, Row, SENSOR, Situation, all, assert_armed_again_only_at_rest,
    assert_faults_in_a_homing, assert_latched, assert_none_is_forgotten,
    assert_reversed_in_the_first_move, assert_row, current_rows, detect, index_rows, pass, rows,
    start_over,
};
use files::encoder::Wires;
use stiction::Fault;

use bench::{ImageBench, print_row};

/// Why the other faults are in no row.
const ELSEWHERE: [(Fault, &str); 11] = [
    (Fault::MotorHot, "it takes a sensor of its own: tests/image/motor_temperature.rs"),
    (Fault::MotorSensor, "the same"),
    (Fault::EncodersDisagree, "it takes two encoders: both_encoders.rs beside this folder"),
    (Fault::EncoderSilent, "it takes an absolute encoder: tests/image/both_encoders.rs"),
    (Fault::EncoderOpen, "at rest only: tests/image/open_line.rs"),
    (Fault::Oscillation, "it takes gains of its own: a test of its own, below"),
    (Fault::NoParameters, "only at boot: tests/image/hardware_faults.rs"),
    (Fault::BadParameters, "only at boot: tests/image/hardware_faults.rs"),
    (Fault::ClockAbsent, "only at boot: tests/image/hardware_faults.rs"),
    (Fault::ClockWrong, "only at boot: tests/image/supply_and_crystal.rs"),
    (Fault::EncoderReversed, "only in the first move: a test of its own, below"),
];

/// A bit error in the RAM, which parameters cannot cause.
fn spoiled_gain() -> Row<ImageBench> {
    Row {
        fault: Fault::NonFinite,
        what: "a bit error in the RAM makes a gain not a number",
        set: &[],
        inject: |bench, tick| {
            if tick == 0 {
                bench.spoil_gain();
            }
        },
        within: all([1, 1]),
        late: [0, 0],
        value: [0.0, 0.0],
        // In its HOLD the effort is a constant, which no gain changes: nothing is wrong before the
        // next move.
        cannot: |law, situation| law == "robust" && situation == Situation::Rest,
    }
}

/// Judges the rows of some faults on one board.
fn assert_rows(faults: &[Fault]) {
    let mut bench = ImageBench::boot();
    for row in rows().iter().filter(|row| faults.contains(&row.fault)) {
        assert_row(&mut bench, row);
    }
}

// The rows of the stall are in two tests, and so share the two processors with the others.
#[test]
fn a_joint_that_does_not_follow() {
    let mut bench = ImageBench::boot();
    let blocked = |row: &&Row<_>| row.fault == Fault::Stall && row.late == [0, 0];
    for row in rows().iter().filter(blocked) {
        assert_row(&mut bench, row);
    }
    assert_rows(&[Fault::FollowingError]);
}

#[test]
fn a_joint_out_of_its_bounds() {
    assert_rows(&[Fault::PositionLimit, Fault::Overspeed]);
}

#[test]
fn wires_of_the_encoder() {
    let mut bench = ImageBench::boot();
    let cut = |row: &&Row<_>| row.fault == Fault::Stall && row.late == [0, 1];
    for row in rows().iter().filter(cut) {
        assert_row(&mut bench, row);
    }
    assert_rows(&[Fault::EncoderJump]);
}

#[test]
fn supply_and_heat() {
    assert_rows(&[Fault::SupplyLow, Fault::SupplyHigh, Fault::Overheat]);
}

#[test]
fn current_of_the_motor() {
    let mut bench = ImageBench::of(SENSOR);
    for row in current_rows() {
        assert_row(&mut bench, &row);
    }
}

#[test]
fn counts_between_two_indices() {
    let mut bench = ImageBench::of(INDEX);
    for row in index_rows() {
        assert_row(&mut bench, &row);
    }
}

#[test]
fn memory_and_link() {
    assert_row(&mut ImageBench::boot(), &spoiled_gain());
    assert_rows(&[Fault::LinkTimeout]);
}

#[test]
fn a_fault_ends_a_homing_in_time_and_leaves_the_joint_unreferenced() {
    let cases = assert_faults_in_a_homing(&mut ImageBench::boot());
    assert_eq!(cases, 4 * controllers().count());
}

#[test]
fn a_reversed_encoder_is_seen_in_the_first_move_under_every_law() {
    let (_, slowest) = assert_reversed_in_the_first_move(&mut ImageBench::boot());
    let (fault, what) = (Fault::EncoderReversed, "swapped wires, a step of 5 deg");
    print_row(fault, what, Situation::Rest, controllers().count(), &format!("{slowest} ticks"));
}

/// An encoder that is dead from rest has no edge that could be missed: what is seen is the effort
/// that the law demands. The impulse bounds where the joint is by then.
#[test]
fn an_encoder_that_is_dead_at_rest_is_seen_in_the_next_step_under_every_law() {
    let row = Row {
        fault: Fault::Stall,
        what: "both encoder wires cut at rest, then a step of 0.41 deg",
        set: &[],
        inject: |_: &mut ImageBench, _| {},
        within: all([1, 206]),
        late: [0, 0],
        value: [0.0, 5.0],
        cannot: |_, _| false,
    };
    // 0.2 V s are 2049 codes of a tick, and the least excess that counts is 10 of them, an eighth
    // of 0.4 V: 205 ticks. A tick can be under way when the step is received.
    let within = [1, 206];
    let (mut bench, mut slowest) = (ImageBench::boot(), 0);
    for law in controllers() {
        let name = format!("{}, {law}", row.what);
        start_over(&mut bench, law, row.set);
        bench.client().arm().unwrap();
        // The soft start is over, and the joint stays where it is.
        pass(&mut bench, 30);
        bench.rewire(Wires::Cut);
        // Pull-ups hold the ends of cut wires, which can make two counts; they are no speed any
        // more when the step comes.
        pass(&mut bench, 10);
        bench.client().step_to(0.41).unwrap();
        let from = bench.position_deg();
        slowest = slowest.max(detect(&mut bench, &row, &name, within));
        // 0.05 V beyond the breakaway for 4 s move the joint (27 deg/s^2 for a volt, 0.02 V s/deg)
        // by less than 9 deg, and more effort less far.
        let travel = bench.position_deg() - from;
        assert!(travel > 0.0 && travel < 9.0, "{name}: {travel} deg");
        assert_latched(&mut bench, &name, law, (row.fault, row.value));
        start_over(&mut bench, law, row.set);
        assert_armed_again_only_at_rest(&mut bench, &name);
    }
    let cases = controllers().count();
    print_row(row.fault, row.what, Situation::Rest, cases, &format!("{slowest} ticks"));
}

/// DNPF with eight times the thesis's gain, as in tests/device/oscillation.rs.
#[test]
fn a_loop_that_oscillates_is_reported_and_then_a_fault() {
    let mut bench = ImageBench::boot();
    start_over(&mut bench, "dnpf", &["controller.dnpf.kp_v_per_deg=8"]);
    bench.client().arm().unwrap();
    bench.client().step_to(0.5).unwrap();
    // The warning comes after 3 s of 20 ms, the fault after 30 s, each of a series that begins with
    // the swings of the first 3 s.
    pass(&mut bench, 300);
    let status = bench.client().status().unwrap();
    assert!(status.oscillates && status.faults == 0, "{status:?}");
    let ticks = (300..1650).find(|tick| {
        bench.heard(*tick);
        !bench.ticks(1).is_on
    });
    let ticks = ticks.unwrap();
    assert!(ticks > 1500, "{ticks}");
    assert_latched(&mut bench, "dnpf", "dnpf", (Fault::Oscillation, [0.0, 180.0]));
    let what = "DNPF of eight times the gain swings around a set point that rests";
    print_row(Fault::Oscillation, what, Situation::Rest, 1, &format!("{ticks} ticks"));
}

#[test]
fn no_fault_is_forgotten_by_the_matrix() {
    let reported = reported::rows().into_iter().map(|row| row.fault);
    let here: Vec<Fault> = reported.chain([Fault::NonFinite]).collect();
    assert_none_is_forgotten::<ImageBench>(&here, &ELSEWHERE);
}
