//! Homing to a switch: the edge that it finds, and what leaves no reference.

use experiments::axis_with_stops::COUNT_DEG;
use experiments::controllers;
use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::motion::home::{HomeEnd, HomeFindings, HomeRequest, HomeTarget};
use stiction::servo::State;

use crate::homing::{self, EFFORT_V, begin, counts, end_at_any_moment, joint, pass, until_off};

const UP: HomeRequest = HomeRequest { to: HomeTarget::Switch, ..homing::UP };
const DOWN: HomeRequest = HomeRequest { to: HomeTarget::Switch, ..homing::DOWN };

const CLOSED: &str = "device.home_switch=\"normally-closed\"";
const OPEN: &str = "device.home_switch=\"normally-open\"";

/// Travel of a tick of 20 ms at a quarter of the 4 deg/s of a jog, deg: the resolution of the edge.
/// A joint that sets out again is faster than its set point, up to twice.
const TICK_DEG: f64 = 2.0 * 0.25 * 4.0 * 0.02;

/// A joint without stops, and a switch with its edge at an angle.
fn with_switch(law: &str, contact: &str, edge_deg: Option<f64>) -> SimulatedDevice {
    let mut device = joint(law, [-1e3, 1e3], &[contact]);
    device.home_switch.edge_deg = edge_deg;
    device
}

/// Asserts that the joint is referenced, with the edge of its switch at `at_deg`.
fn assert_referenced(device: &mut SimulatedDevice, name: &str, [edge_deg, at_deg]: [f64; 2]) {
    device.ticks(100);
    let servo_deg = f64::from(device.device.servo().position()) * COUNT_DEG;
    // The edge is seen in the first tick beyond it.
    let late_deg = device.position_deg() + at_deg - edge_deg - servo_deg;
    let late_deg = late_deg * if edge_deg < 0.0 { -1.0 } else { 1.0 };
    assert!((-COUNT_DEG..TICK_DEG + 2.0 * COUNT_DEG).contains(&late_deg), "{name}: {late_deg} deg");
    assert!(device.device.servo().is_referenced(), "{name}");
}

#[test]
fn under_every_law_the_switch_is_found_both_ways_with_both_contacts() {
    for (law, contact) in controllers().flat_map(|law| [(law, CLOSED), (law, OPEN)]) {
        for (asked, edge_deg, at_deg) in [(UP, 12.0, 40.0), (DOWN, -7.0, -10.0)] {
            let name = format!("{law}, {contact}, {edge_deg} deg");
            let mut device = with_switch(law, contact, Some(edge_deg));
            begin(&mut device, HomeRequest { at: counts(at_deg), ..asked }).unwrap();
            let (found, effort_v) = until_off(&mut device);
            let latched = device.device.servo().latched();
            let found = found.unwrap_or_else(|| panic!("{name}: {latched:?}"));
            assert_eq!((found.ended, found.touches), (HomeEnd::Switch, 2), "{name}");
            assert!(effort_v <= EFFORT_V, "{name}: {effort_v} V");
            assert_referenced(&mut device, &name, [edge_deg, at_deg]);
            // It ends a degree before the edge, within the range, and can be armed from there.
            assert!((device.position_deg() - edge_deg).abs() > 1.0 - TICK_DEG, "{name}");
            device.device.servo().arm_for_link(None).unwrap();
        }
    }
}

/// From deep in the switch, it goes back to where the switch lets go, and finds the edge from there
/// twice.
#[test]
fn a_joint_that_is_at_the_switch_leaves_it_first() {
    for (deep_deg, touches) in [(0.0, 2), (2.5, 3)] {
        for contact in [CLOSED, OPEN] {
            let mut device = with_switch("srnf", contact, Some(0.0));
            let steps = (deep_deg / 0.05) as i32;
            for step in 1..=steps {
                device.push(0.05 * f64::from(step), 0.0);
                device.tick();
            }
            device.ticks(20);
            begin(&mut device, HomeRequest { at: counts(40.0), ..UP }).unwrap();
            let found = until_off(&mut device).0.unwrap();
            let name = format!("{deep_deg} deg, {contact}");
            assert_eq!((found.ended, found.touches), (HomeEnd::Switch, touches), "{name}");
            assert_referenced(&mut device, &name, [0.0, 40.0]);
        }
    }
}

/// The tolerance is that of a stop, 0.125 deg, and a tick at 4 deg/s: 0.2 deg.
#[test]
fn two_edges_that_do_not_agree_set_no_reference_and_the_next_two_do() {
    for (moves_deg, touches) in [(0.15, 2), (0.3, 3), (-0.3, 3)] {
        let mut device = with_switch("srnf", CLOSED, Some(3.0));
        begin(&mut device, HomeRequest { at: counts(40.0), ..UP }).unwrap();
        for _ in 0..3000 {
            device.device.servo().heard();
            let has_come = device.position_deg() >= 3.0;
            if device.tick().state != State::Armed {
                break;
            }
            if has_come {
                device.home_switch.edge_deg = Some(3.0 + moves_deg);
            }
        }
        let found = device.device.servo().homed().unwrap();
        assert_eq!((found.ended, found.touches), (HomeEnd::Switch, touches), "{moves_deg}");
        assert_referenced(&mut device, &moves_deg.to_string(), [3.0 + moves_deg, 40.0]);
    }
}

/// The switch lets go 0.5 deg behind its edge, or 1.5 deg, which is farther than the degree of the
/// way back. Both edges of a homing are those at which the joint comes to the switch.
#[test]
fn a_hysteresis_does_not_shift_the_edge() {
    for (hysteresis_deg, contact) in [(0.5, CLOSED), (1.5, CLOSED), (1.5, OPEN)] {
        for (asked, edge_deg, at_deg) in [(UP, 12.0, 40.0), (DOWN, -7.0, -10.0)] {
            let name = format!("{hysteresis_deg}, {contact}, {edge_deg} deg");
            let mut device = with_switch("srnf", contact, Some(edge_deg));
            device.home_switch.hysteresis_deg = hysteresis_deg;
            begin(&mut device, HomeRequest { at: counts(at_deg), ..asked }).unwrap();
            let found = until_off(&mut device).0.unwrap();
            assert_eq!((found.ended, found.touches), (HomeEnd::Switch, 2), "{name}");
            assert_referenced(&mut device, &name, [edge_deg, at_deg]);
        }
    }
}

/// The contact alternates from tick to tick. With a filter of a tick, the first change counts. With
/// one of three, the level counts from the last tick of the bounces on. The slow way is that of a
/// degree a second, and up to twice as fast. The edge of the fast one is 4 deg/s late: after 0.3 s,
/// both do not agree, and the next slow way is the second edge.
#[test]
fn a_bounce_beyond_the_filter_shifts_the_edge_by_its_time_at_the_slow_speed() {
    for (filter, bounce_s, touches, late_s) in
        [("0.02", 0.1, 2, 0.0), ("0.06", 0.1, 2, 0.1), ("0.06", 0.3, 3, 0.3)]
    {
        let name = format!("device.home_switch_filter_s={filter}");
        let mut device = joint("srnf", [-1e3, 1e3], &[CLOSED, &name]);
        device.home_switch.edge_deg = Some(12.0);
        device.home_switch.bounce_s = bounce_s;
        begin(&mut device, HomeRequest { at: counts(40.0), ..UP }).unwrap();
        let found = until_off(&mut device).0.unwrap();
        assert_eq!((found.ended, found.touches), (HomeEnd::Switch, touches), "{name}, {bounce_s}");
        let late_deg = f64::from(found.moved) * COUNT_DEG - 12.0;
        let bounds = late_s - 0.02 - COUNT_DEG..2.0 * late_s + TICK_DEG;
        assert!(bounds.contains(&late_deg), "{name}, {bounce_s}: {late_deg} deg");
    }
}

/// What ends a homing: its contact, what happens after 80 ticks, and what it reports.
type Failure = (&'static str, &'static str, fn(&mut SimulatedDevice), Option<HomeEnd>);

/// The edge is at 30 deg. After 80 ticks, of which 25 are the soft start, the joint has gone some 3
/// deg. The joint was referenced before.
#[test]
fn a_switch_or_an_encoder_that_fails_leaves_no_reference() {
    let failures: [Failure; 8] = [
        ("never comes", CLOSED, |device| device.home_switch.edge_deg = None, Some(HomeEnd::Travel)),
        ("open wire", OPEN, |device| device.home_switch.is_cut = true, Some(HomeEnd::Travel)),
        // It looks like the switch until the way back.
        ("cut wire", CLOSED, |device| device.home_switch.is_cut = true, Some(HomeEnd::SwitchStuck)),
        ("blocked", CLOSED, |device| device.brake_v = 5.0, None),
        ("dead encoder", CLOSED, |device| device.wires = Wires::Cut, None),
        ("stop", CLOSED, |device| device.device.servo().stop(), None),
        ("brake", CLOSED, |device| device.device.servo().come_to_rest(), None),
        ("fault", CLOSED, |device| device.device.servo().fault(Fault::Watchdog), None),
    ];
    for (name, contact, fail, expected) in failures {
        let mut device = with_switch("srnf", contact, Some(30.0));
        device.device.servo().set_reference(0).unwrap();
        begin(&mut device, HomeRequest { travel: Some(35.0), ..UP }).unwrap();
        pass(&mut device, 80);
        fail(&mut device);
        let found: Option<HomeFindings> = until_off(&mut device).0;
        assert_eq!(found.map(|found| found.ended), expected, "{name}");
        assert!(!device.device.servo().is_referenced(), "{name}");
        device.ticks(100);
        assert!(!device.device.servo().is_referenced(), "{name}");
        assert!(device.position_deg().abs() < 36.0, "{name}: {}", device.position_deg());
    }
}

/// A joint that does not start is held with the effort of the homing, which is no stall.
#[test]
fn a_joint_that_is_blocked_from_the_start_ends_as_blocked_and_a_stuck_switch_as_stuck() {
    for (is_cut, expected) in [(false, HomeEnd::Blocked), (true, HomeEnd::SwitchStuck)] {
        let mut device = with_switch("srnf", CLOSED, Some(3.0));
        device.home_switch.is_cut = is_cut;
        device.brake_v = if is_cut { 0.0 } else { 5.0 };
        begin(&mut device, HomeRequest { travel: Some(5.0), ..UP }).unwrap();
        let found = until_off(&mut device).0.unwrap();
        assert_eq!(found.ended, expected);
        assert!(!device.device.servo().is_referenced());
    }
}

#[test]
fn no_moment_at_which_a_homing_to_a_switch_is_ended_leaves_a_reference() {
    let asked = HomeRequest { at: counts(40.0), ..UP };
    let joint = || with_switch("srnf", CLOSED, Some(3.0));
    let ended = end_at_any_moment(joint, asked, HomeEnd::Switch);
    assert!(ended > 60, "{ended}");
}

#[test]
fn a_homing_to_a_switch_needs_one() {
    let device = joint("srnf", [-1e3, 1e3], &[]);
    let refused = device.device.parameters().unwrap().home(&UP).unwrap_err();
    assert_eq!(stiction::parameters::about(refused.key).unwrap().name, "home_switch");
}
