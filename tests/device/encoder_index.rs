//! The encoder's index: homing to it, and the check of the counts.

use experiments::axis_with_stops::COUNT_DEG;
use experiments::controllers;
use simulator::device::simulated::SimulatedDevice;
use stiction::Fault;
use stiction::control::reference::{Reference, Step};
use stiction::motion::home::{HomeEnd, HomeRequest, HomeTarget};
use stiction::servo::State;
use stiction::units::position::Position;

use crate::homing::{self, EFFORT_V, begin, counts, joint, until_off};

const UP: HomeRequest = HomeRequest { to: HomeTarget::Index, ..homing::UP };
const DOWN: HomeRequest = HomeRequest { to: HomeTarget::Index, ..homing::DOWN };

/// An encoder of 500 lines: 2000 counts of 0.00242 deg, 4.84 deg, from one index to the next.
const EVERY: i32 = 2000;
const WIDTH: i32 = 4;
const INDEX: &str = "device.index_counts=2000";

/// The simulated index is a quarter of a turn from power-on.
const FIRST: i32 = EVERY / 4;

fn with_index(law: &str, set: &[&str]) -> SimulatedDevice {
    joint(law, [-1e3, 1e3], &[&[INDEX], set].concat())
}

fn faulted(device: &mut SimulatedDevice) -> Option<(Fault, f32)> {
    device.device.servo().latched().map(|latched| (latched.fault, latched.value))
}

/// Moves the joint by hand, by 10 counts a tick.
fn push_to(device: &mut SimulatedDevice, to: i32) {
    push(device, to, 10);
}

/// Moves the joint by hand, by this number of counts a tick.
fn push(device: &mut SimulatedDevice, to: i32, counts: i32) {
    let mut at = (device.position_deg() / COUNT_DEG).round() as i32;
    while at != to {
        at += (to - at).clamp(-counts, counts);
        device.push(f64::from(at) * COUNT_DEG, 0.0);
        device.tick();
    }
    device.ticks(2);
}

/// Upwards the index rises at its first count, downwards at its last one. The capture is that
/// count, whatever the speed is: of a tick at 4 deg/s, 33 counts.
#[test]
fn under_every_law_the_index_is_found_to_the_count_both_ways() {
    for law in controllers() {
        for (asked, index, at) in [(UP, FIRST, 400), (DOWN, FIRST - EVERY + WIDTH - 1, -400)] {
            let name = format!("{law}, {index}");
            let mut device = with_index(law, &[]);
            begin(&mut device, HomeRequest { at, ..asked }).unwrap();
            assert!(!device.device.servo().is_referenced(), "{name}");
            let (found, effort_v) = until_off(&mut device);
            let latched = faulted(&mut device);
            let found = found.unwrap_or_else(|| panic!("{name}: {latched:?}"));
            let of_index = (found.ended, found.moved, found.touches, found.from_switch);
            assert_eq!(of_index, (HomeEnd::Index, index, 1, 0), "{name}");
            assert!(effort_v <= EFFORT_V, "{name}: {effort_v} V");
            device.ticks(100);
            let off = f64::from(device.device.servo().position()) * COUNT_DEG
                - (device.position_deg() + f64::from(at - index) * COUNT_DEG);
            assert!(off.abs() <= COUNT_DEG, "{name}: {off} deg");
            assert!(device.device.servo().is_referenced(), "{name}");
        }
    }
}

/// An index that comes late by t is captured v t farther in the sense of the motion: so far is the
/// zero off. v is the speed of the joint in the tick of the edge.
#[test]
fn a_lag_of_the_index_shifts_the_zero_by_the_travel_in_it() {
    for (asked, index) in [(UP, FIRST), (DOWN, FIRST - EVERY + WIDTH - 1)] {
        for lag_us in [0, 1000, 2000] {
            let mut device = with_index("srnf", &[&format!("encoder.index_lag_us={lag_us}")]);
            begin(&mut device, asked).unwrap();
            let at_index_deg = f64::from(index) * COUNT_DEG;
            let mut speeds = None;
            let mut is_armed = true;
            while is_armed {
                let before = [device.position_deg(), device.velocity_deg_per_s()];
                device.device.servo().heard();
                is_armed = device.tick().state == State::Armed;
                let after = [device.position_deg(), device.velocity_deg_per_s()];
                if (before[0] - at_index_deg) * (after[0] - at_index_deg) < 0.0 {
                    // The first pass: the joint goes back over the index.
                    speeds.get_or_insert([before[1], after[1]]);
                }
            }
            let found = device.device.servo().homed().unwrap();
            assert_eq!(found.ended, HomeEnd::Index);
            let travel = speeds.unwrap().map(|speed| speed * 1e-6 * f64::from(lag_us) / COUNT_DEG);
            let travel = 0.5 * (travel[0] + travel[1]);
            let shift = f64::from(found.moved - index);
            // Whole counts are captured, and the speed in a tick is known to a twentieth.
            let left = travel.abs() - shift.abs();
            assert!((-0.15..1.15).contains(&left), "{lag_us} us: {shift}, {travel}");
            assert!(shift * travel >= 0.0 && (lag_us > 0 || shift == 0.0), "{shift}, {travel}");
            assert!(lag_us < 2000 || travel.abs() > 2.5, "{travel}");
            // The joint is farther than the position that the device has set, by the same counts.
            device.ticks(100);
            let position = f64::from(device.device.servo().position());
            let at = device.position_deg() / COUNT_DEG - f64::from(index);
            assert!((at - position - shift).abs() <= 1.0, "{lag_us} us: {position}, {at}");
        }
    }
}

/// The joint goes back over the index that it has found. In 4 ms it goes farther than half of the
/// tolerance, so that the homing itself shows the lag.
#[test]
fn a_homing_with_a_long_lag_of_the_index_is_a_fault() {
    let mut device = with_index("srnf", &["encoder.index_lag_us=4000"]);
    begin(&mut device, UP).unwrap();
    assert_eq!(until_off(&mut device).0.map(|found| found.ended), None);
    assert_eq!(faulted(&mut device).map(|(fault, _)| fault), Some(Fault::IndexDeviation));
    assert!(!device.device.servo().is_referenced());
}

/// Up, the index is captured at its first count and v t more; down, at its last one and v t less:
/// both differ by the width less one count and 2 v t. Beyond the width and 2 counts that is a fault.
#[test]
fn a_lag_of_the_index_is_a_fault_once_both_ways_differ_by_more_than_the_tolerance() {
    // 12 counts a tick are 600 counts/s. Whole counts of the travel are captured.
    for (lag_us, travel, is_fault) in [(0, 0, false), (7000, 4, false), (9000, 5, true)] {
        let mut device = with_index("srnf", &[&format!("encoder.index_lag_us={lag_us}")]);
        device.device.servo().set_reference(0).unwrap();
        push(&mut device, FIRST + 100, 12);
        assert_eq!(device.device.servo().index_passes(), (1, 0), "{lag_us} us");
        push(&mut device, FIRST - 100, 12);
        let deviation = WIDTH - 1 - 2 * travel;
        let expected = is_fault.then_some((Fault::IndexDeviation, deviation as f32));
        assert_eq!(faulted(&mut device), expected, "{lag_us} us");
        assert_eq!(device.device.servo().is_referenced(), !is_fault);
        if !is_fault {
            assert_eq!(device.device.servo().index_passes(), (2, deviation), "{lag_us} us");
            // In one sense the lag is the same in each pass.
            push(&mut device, FIRST + 3 * EVERY + 100, 12);
            assert_eq!(device.device.servo().index_passes(), (6, 0), "{lag_us} us");
        }
    }
}

/// The switch decides which of the turns it is, the index where in it. The edge is at 3 deg, count
/// 1240, between the indices at 500 and 2500: back from it, the first one is at 500, at its last
/// count.
#[test]
fn the_index_next_to_the_switch_is_the_same_from_wherever_the_joint_starts() {
    // The way back to the place where the edges are compared is 413 counts.
    let near = [393, 433].map(|counts| f64::from(FIRST + 3 + counts) * COUNT_DEG);
    let starts = [-3000, -1200, 0, 600, 1000, 1300, 2700].map(|start| (start, 3.0, "0"));
    let edges = near.into_iter().flat_map(|edge_deg| [(0, edge_deg, "0"), (-1200, edge_deg, "0")]);
    for (start, edge_deg, test_deg) in starts.into_iter().chain(edges).chain([(0, 3.0, "0.5")]) {
        let test = format!("device.arming_test_deg={test_deg}");
        let mut device = with_index("srnf", &["device.home_switch=\"normally-closed\"", &test]);
        device.home_switch.edge_deg = Some(edge_deg);
        push_to(&mut device, start);
        device.ticks(20);
        let asked = HomeRequest { to: HomeTarget::SwitchIndex, at: 4000, ..UP };
        begin(&mut device, asked).unwrap();
        let found = until_off(&mut device).0.unwrap();
        assert_eq!(found.ended, HomeEnd::Index, "{start} {edge_deg}");
        // A test at arming shifts the zero.
        let is_there = found.moved + start == FIRST + 3;
        assert!(is_there || test_deg != "0", "{start} {edge_deg}: {found:?}");
        // The edge is seen within two ticks of the slow way, 17 counts.
        let from_edge = FIRST + 3 - counts(edge_deg);
        assert!((from_edge - 17..=from_edge).contains(&found.from_switch), "{found:?}");
        assert!(device.device.servo().is_referenced(), "{start}");
        device.ticks(100);
        let position = device.device.servo().position();
        let expected = (device.position_deg() / COUNT_DEG).round() as i32 - (FIRST + 3) + 4000;
        assert!((position - expected).abs() <= 1, "{start}: {position}, {expected}");
    }
}

#[test]
fn an_index_that_does_not_come_leaves_no_reference() {
    // Less than a turn: the travel ends it. More: a turn without an index is a fault.
    let fault = Some((Fault::IndexDeviation, (EVERY + WIDTH + 2) as f32));
    for (travel_deg, ended, expected) in [(3.0, Some(HomeEnd::Travel), None), (9.0, None, fault)] {
        let mut device = with_index("srnf", &[]);
        device.index = None;
        device.device.servo().set_reference(0).unwrap();
        begin(&mut device, HomeRequest { travel: Some(travel_deg), ..UP }).unwrap();
        let found = until_off(&mut device).0;
        assert_eq!(found.map(|found| found.ended), ended);
        let latched = faulted(&mut device);
        assert_eq!(latched.map(|(fault, _)| fault), expected.map(|(fault, _)| fault));
        // In the first tick beyond.
        let beyond = latched.map_or(0.0, |(_, value)| value - expected.unwrap().1);
        assert!((0.0..70.0).contains(&beyond), "{latched:?}");
        assert!(!device.device.servo().is_referenced());
    }
}

#[test]
fn a_homing_to_an_index_needs_one() {
    let device = joint("srnf", [-1e3, 1e3], &[]);
    let refused = device.device.parameters().unwrap().home(&UP).unwrap_err();
    assert_eq!(stiction::parameters::about(refused.key).unwrap().name, "index_counts");
}

/// The tolerance is the width of 4 counts and 2. Each pass is in the same sense, a count lost in
/// each turn: seven are one more.
#[test]
fn counts_that_are_lost_slowly_are_a_fault_once_they_are_more_than_the_tolerance() {
    let mut device = with_index("srnf", &[]);
    device.device.servo().set_reference(0).unwrap();
    push_to(&mut device, FIRST + 100);
    assert_eq!(device.device.servo().index_passes(), (1, 0));
    for turn in 1..=7 {
        device.jump(-1);
        assert_eq!(faulted(&mut device), None, "{turn}");
        assert!(device.device.servo().is_referenced(), "{turn}");
        push_to(&mut device, FIRST + 100 + turn * EVERY);
        if turn < 7 {
            assert_eq!(device.device.servo().index_passes(), (turn as u32 + 1, -turn));
        }
    }
    assert_eq!(faulted(&mut device), Some((Fault::IndexDeviation, -7.0)));
    assert!(!device.device.servo().is_referenced());
    // Cleared, the check starts anew: the counts that are lost stay lost.
    device.device.servo().clear().unwrap();
    push_to(&mut device, FIRST + 100 + 9 * EVERY);
    assert_eq!((faulted(&mut device), device.device.servo().index_passes()), (None, (2, 0)));
}

/// The other fault stays the first. Once it is cleared, the deviation is still there.
#[test]
fn a_deviation_behind_another_fault_is_the_fault_after_it() {
    let mut device = with_index("srnf", &["device.reference=\"command\""]);
    device.device.servo().set_reference(0).unwrap();
    push_to(&mut device, FIRST + 100);
    device.device.servo().fault(Fault::Watchdog);
    device.jump(-200);
    push_to(&mut device, FIRST + EVERY + 100);
    assert_eq!(faulted(&mut device).map(|(fault, _)| fault), Some(Fault::Watchdog));
    assert!(!device.device.servo().is_referenced());
    device.device.servo().clear().unwrap();
    push_to(&mut device, FIRST + 2 * EVERY + 100);
    assert_eq!(faulted(&mut device), Some((Fault::IndexDeviation, -200.0)));
}

/// To and fro over the index, and across several: its width of 4 counts is no deviation.
#[test]
fn a_joint_that_passes_its_index_in_both_senses_keeps_its_reference() {
    let mut device = with_index("srnf", &[]);
    device.device.servo().set_reference(0).unwrap();
    for to in [600, 400, 502, 499, 5000, -5000, 501, 498, 505, 9000, 0] {
        push_to(&mut device, to);
        assert_eq!(faulted(&mut device), None, "{to}");
    }
    let (passes, deviation) = device.device.servo().index_passes();
    assert!(passes > 15 && deviation.abs() <= WIDTH, "{passes}, {deviation}");
    assert!(device.device.servo().is_referenced());
}

/// The loop follows a step of two turns when 40 counts are lost, 0.1 deg: the next pass of the
/// index is the fault, with the output off, within a turn.
#[test]
fn counts_that_a_driven_joint_loses_are_a_fault_within_a_turn() {
    for law in controllers() {
        let limits = [
            "limits.encoder_jump_deg=1",
            "limits.following_error_deg=0",
            "limits.progress_gain_deg_per_s2_per_v=off",
        ];
        let mut device = with_index(law, &limits);
        device.device.servo().set_reference(0).unwrap();
        device.device.servo().arm_for_link(None).unwrap();
        let to = Position::from_counts(2 * EVERY);
        let step = Step { to, ..Step::default() };
        device.tick();
        device.device.servo().follow(Reference::Step(step)).unwrap();
        let mut lost_at = None;
        for _ in 0..3000 {
            device.device.servo().heard();
            let output = device.tick();
            let at = (device.position_deg() / COUNT_DEG) as i32;
            if lost_at.is_none() && at > FIRST + 100 {
                device.jump(-40);
                lost_at = Some(at);
            }
            if output.state != State::Armed {
                break;
            }
        }
        assert_eq!(faulted(&mut device), Some((Fault::IndexDeviation, -40.0)), "{law}");
        // The next index is at 2500; the fault is seen in the tick after.
        let at = (device.position_deg() / COUNT_DEG) as i32;
        assert!((2500..2500 + EVERY).contains(&at), "{law}: {at}, lost at {lost_at:?}");
        assert!(!device.device.servo().is_referenced(), "{law}");
    }
}

/// 2000 counts are configured as 500, the lines, or as 4000: the first passes are the fault.
#[test]
fn a_wrong_number_of_counts_is_a_fault_before_two_turns_are_over() {
    for wrong in [500, 1000, 3000, 4000] {
        let mut device = with_index("srnf", &[&format!("device.index_counts={wrong}")]);
        device.index.as_mut().unwrap().every = i64::from(EVERY);
        device.device.servo().set_reference(0).unwrap();
        push_to(&mut device, 2 * EVERY + FIRST + 10);
        let fault = faulted(&mut device).map(|(fault, _)| fault);
        // A divisor of the counts is found by the turn without an index, a multiple by the pass.
        assert_eq!(fault, Some(Fault::IndexDeviation), "{wrong}");
    }
}
