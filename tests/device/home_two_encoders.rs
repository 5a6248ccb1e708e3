//! Homing to the index of a motor with its own encoder: the position of the load that it sets.

use experiments::both_encoders::both_encoders;
use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::control::reference::{Reference, Step};
use stiction::motion::home::{HomeEnd, HomeRequest, HomeTarget, Sense};
use stiction::servo::{Boot, State};
use stiction::units::position::Position;

use crate::fixture::parameters;
use crate::homing::{self, begin};

/// At 20 deg/s, the motor turns by 6 counts in a tick, and the load by one.
const UP: HomeRequest =
    HomeRequest { to: HomeTarget::Index, at: AT, speed: Some(20.0), ..homing::UP };
const DOWN: HomeRequest = HomeRequest { sense: Sense::Minus, ..UP };

/// The index on the way back from a switch.
const BACK: HomeRequest = HomeRequest { to: HomeTarget::SwitchIndex, ..UP };

/// Position of the load at the index, counts.
const AT: i32 = 4000;
/// A count of the load, and one of the motor, deg of the joint.
const COUNT_DEG: f64 = 360.0 / 16384.0;
const MOTOR_DEG: f64 = 360.0 / 100_000.0;
/// Angle from one index to the next: 2000 counts of the motor, deg.
const EVERY_DEG: f64 = 7.2;
/// Half of the slack, deg.
const SLACK_DEG: f64 = 0.15;

/// A joint at rest at a place, deg, whose gear is in the middle of its slack.
fn at_rest(start_deg: f64, set: &[&str]) -> SimulatedDevice {
    let index = ["device.index_counts=2000", "device.reference=\"command\""];
    let plan = &both_encoders(&["robust"], &[&index, set].concat())[0];
    let mut device = SimulatedDevice::running(plan, &parameters(plan), Boot::default()).unwrap();
    device.push(start_deg, 0.0);
    device.ticks(300);
    device
}

/// Runs a homing to its end, and returns the position of the load in which it found the index, deg.
fn homed(device: &mut SimulatedDevice, asked: HomeRequest) -> f64 {
    let start_deg = device.position_deg();
    begin(device, asked).unwrap();
    let ended = (0..400_000).find(|_| {
        device.device.servo().heard();
        device.tick().state != State::Armed
    });
    assert!(ended.is_some());
    let found = device.device.servo().homed().unwrap();
    assert_eq!(found.ended, HomeEnd::Index, "{found:?}");
    start_deg + f64::from(found.moved) * COUNT_DEG
}

/// The load is behind the motor by half of the slack and the wind-up, wherever the motion begins.
/// The friction of the joint, 4.9 N m, winds 1000 N m/rad up by 0.28 deg at most. On the way back
/// from a switch, the load is on the other side of the slack. What differs is the wind-up, by a
/// fraction of the slack, and the rounding.
#[test]
fn index_of_the_motor_sets_the_position_that_the_load_has_there() {
    let rise_deg = |counts: f64| counts * MOTOR_DEG;
    for (asked, sense, index_deg) in
        [(UP, 1.0, rise_deg(500.0)), (DOWN, -1.0, rise_deg(503.0)), (BACK, -1.0, rise_deg(503.0))]
    {
        let mut lags = Vec::new();
        for start_deg in [-2.0, -1.05, 0.0, 1.31] {
            let name = format!("{:?}, {sense}, {start_deg} deg", asked.to);
            let mut device = at_rest(start_deg, &["device.home_switch=\"normally-closed\""]);
            device.home_switch.edge_deg = Some(3.0);
            let place_deg = homed(&mut device, asked);
            // Any of the indices in a turn of the joint.
            let lag_deg = (sense * (index_deg - place_deg)).rem_euclid(EVERY_DEG);
            lags.push(lag_deg);
            // What the joint counts from there on: half a count of rounding at either end.
            device.ticks(500);
            let counted_deg = f64::from(device.device.servo().position() - AT) * COUNT_DEG;
            let error_deg = counted_deg - (device.position_deg() - place_deg);
            assert!(error_deg.abs() < 1.01 * COUNT_DEG, "{name}: {error_deg} deg");
            assert!(device.device.servo().is_referenced(), "{name}");
        }
        let bounds = SLACK_DEG - COUNT_DEG..SLACK_DEG + 0.28 + COUNT_DEG;
        assert!(lags.iter().all(|lag| bounds.contains(lag)), "{asked:?}: {lags:?}");
        let most = lags.iter().fold(0.0_f64, |most, lag| most.max(*lag));
        let least = lags.iter().fold(f64::MAX, |least, lag| least.min(*lag));
        assert!(most - least < 0.3 * SLACK_DEG + COUNT_DEG, "{asked:?}: {lags:?}");
    }
}

/// The motor takes up the slack: its index is 0.07 deg from the start, and the load rests there.
/// The next one is at 7.27 deg, with the load behind. In a tick of 5 deg/s, the motor turns by 15
/// counts of the finer encoder: more than the load has to move.
#[test]
fn a_pass_before_the_load_moves_is_not_the_place() {
    for counts in [16384.0, 1_048_576.0] {
        let set = format!("load_encoder.counts_per_turn={counts}");
        for (asked, sense, first) in [(UP, 1.0, 20), (DOWN, -1.0, -23)] {
            let mut device = at_rest(0.0, &[&set]);
            device.index.as_mut().unwrap().first = first;
            // The place is in counts of 16384 a turn.
            let place_deg = sense * homed(&mut device, asked) * 16384.0 / counts;
            let name = format!("{counts}, {sense}");
            assert!((6.8..7.27 - SLACK_DEG).contains(&place_deg), "{name}: {place_deg} deg");
        }
    }
}

/// Three answers are missing, from each of 40 ticks around the pass on. A pass that they precede
/// does not count: the next one is a turn of the motor further, with the load behind as ever. With
/// the old count of the load, the place would be off by 1 to 3 ticks of 20 deg/s, 0.02 deg each.
#[test]
fn a_pass_after_a_missing_answer_is_not_the_place() {
    let chip = ["load_encoder.kind=as5047p", "load_encoder.zero_counts=8000"];
    // Returns the place, deg, and the first tick in which the load is near the index.
    let found = |missing: std::ops::Range<u32>| {
        let mut device = at_rest(0.0, &chip);
        begin(&mut device, UP).unwrap();
        let mut near = None;
        for tick in 0..20_000 {
            device.device.servo().heard();
            let is_missing = missing.contains(&tick);
            device.load_wires = if is_missing { Wires::Cut } else { Wires::Sound };
            if near.is_none() && device.position_deg() > 500.0 * MOTOR_DEG - 0.4 {
                near = Some(tick);
            }
            if device.tick().state != State::Armed {
                break;
            }
        }
        let found = device.device.servo().homed().unwrap();
        assert_eq!(found.ended, HomeEnd::Index, "{missing:?}: {found:?}");
        (f64::from(found.moved) * COUNT_DEG, near.unwrap())
    };
    let (place_deg, near) = found(0..0);
    let mut further = 0;
    for begin in near..near + 40 {
        let way_deg = found(begin..begin + 3).0 - place_deg;
        let turns = (way_deg / EVERY_DEG).round();
        assert!((way_deg - turns * EVERY_DEG).abs() < 2.5 * COUNT_DEG, "{begin}: {way_deg} deg");
        further += turns as u32;
    }
    assert_eq!(further, 3);
}

/// The check of the counts starts at the index, in counts of the motor: three turns on, each pass
/// agrees, and 40 counts that the motor's encoder loses are a fault.
#[test]
fn the_counts_of_the_motor_are_checked_from_the_index_on() {
    let mut device = at_rest(0.0, &[]);
    homed(&mut device, UP);
    let go = |device: &mut SimulatedDevice, turns: f64| {
        device.ticks(500);
        device.device.servo().arm_for_link(None).unwrap();
        device.tick();
        let to = Position::from_counts((7.2 * turns / COUNT_DEG) as i32);
        device.device.servo().follow(Reference::Step(Step { to, ..Step::default() })).unwrap();
        for _ in 0..6000 {
            device.device.servo().heard();
            device.tick();
        }
        device.device.servo().stop();
        let latched = device.device.servo().latched();
        latched.map(|latched| (latched.fault, latched.value))
    };
    assert_eq!(go(&mut device, 3.0), None);
    let (passes, deviation) = device.device.servo().index_passes();
    assert!(passes >= 2 && deviation.abs() <= 4, "{passes}, {deviation}");
    device.jump(-40);
    let (fault, value) = go(&mut device, 2.0).unwrap();
    assert_eq!(fault, Fault::IndexDeviation);
    assert!((value + 40.0).abs() <= 4.0, "{value}");
}
