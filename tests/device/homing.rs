//! Homing to a hard stop: the place that it sets, its bounds, and what leaves no reference.

use experiments::axis_with_stops::{COUNT_DEG, axis_with_stops};
use experiments::controllers;
use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::experiment::RunPlan;
use stiction::control::reference::{Reference, Step};
use stiction::motion::home::{HomeEnd, HomeFindings, HomeRequest, HomeTarget, Sense};
use stiction::servo::{Boot, Refusal, State};
use stiction::units::position::Position;
use stiction::{Fault, Parameters};

use crate::fixture::{parameters, plans};

/// A range of 50 deg, which is unknown after a reset.
const RANGE: [&str; 3] =
    ["limits.position_min_deg=-10", "limits.position_max_deg=40", "device.reference=\"command\""];

/// Effort of a jog, which is that of a homing unless a client asks for another, V: one and a half
/// times the 0.4 V that start the joint. Half a code of 4.88 mV is for rounding.
pub const EFFORT_V: f64 = 0.6 + 0.0025;

pub fn counts(deg: f64) -> i32 {
    (deg / COUNT_DEG).round() as i32
}

/// A joint between stops that has just come out of a reset, at zero and at rest.
pub fn joint(law: &str, stops_deg: [f64; 2], set: &[&str]) -> SimulatedDevice {
    let law = format!("loop.controller={law}");
    let set = [&[&*law, "reference.steps_deg=[5.0]"], &RANGE[..], set].concat();
    let plan = plans("step-response", &set).swap_remove(0);
    let parameters = parameters(&plan);
    let plan = RunPlan { substitute: Some(axis_with_stops(stops_deg)), ..plan };
    let mut device = SimulatedDevice::running(&plan, &parameters, Boot::default()).unwrap();
    device.ticks(50);
    device
}

pub fn begin(device: &mut SimulatedDevice, asked: HomeRequest) -> Result<(), Refusal> {
    let home = device.device.parameters().unwrap().home(&asked).unwrap();
    device.device.servo().home(home)
}

/// Runs until the output is off; returns the result and the largest effort.
pub fn until_off(device: &mut SimulatedDevice) -> (Option<HomeFindings>, f64) {
    let mut effort_v = 0.0f64;
    // Ten minutes of 20 ms.
    for _ in 0..30_000 {
        device.device.servo().heard();
        let output = device.tick();
        effort_v = effort_v.max(output.tick.v_applied.abs().into());
        if output.state != State::Armed {
            return (device.device.servo().homed(), effort_v);
        }
    }
    unreachable!("the homing did not end")
}

/// Runs ticks with a client that is alive.
pub fn pass(device: &mut SimulatedDevice, ticks: u32) {
    for _ in 0..ticks {
        device.device.servo().heard();
        device.tick();
    }
}

pub const UP: HomeRequest = HomeRequest {
    sense: Sense::Plus,
    at: 0,
    effort: None,
    travel: None,
    speed: None,
    time: None,
    to: HomeTarget::Stop,
};
pub const DOWN: HomeRequest = HomeRequest { sense: Sense::Minus, ..UP };

/// The stop is where the plant has it: what the servo counts as its position there is that of the
/// request, and the range holds from there.
#[test]
fn under_every_law_the_stop_is_found_both_ways_with_no_more_than_the_effort() {
    for law in controllers() {
        for (asked, stop_deg, at_deg) in [(UP, 12.0, 40.0), (DOWN, -7.0, -10.0), (UP, 0.001, 40.0)]
        {
            let stops_deg = if stop_deg > 0.0 { [-1e3, stop_deg] } else { [stop_deg, 1e3] };
            let mut device = joint(law, stops_deg, &[]);
            let name = format!("{law}, {stop_deg} deg");
            assert!(!device.device.servo().is_referenced(), "{name}");
            let asked = HomeRequest { at: counts(at_deg), ..asked };
            begin(&mut device, asked).unwrap();
            let (found, effort_v) = until_off(&mut device);
            let latched = device.device.servo().latched();
            let found = found.unwrap_or_else(|| panic!("{name}: {latched:?}"));
            assert_eq!(found.ended, HomeEnd::Stop, "{name}");
            assert!(effort_v <= EFFORT_V, "{name}: {effort_v} V");
            assert!((found.moved - counts(stop_deg)).abs() <= 2, "{name}: {found:?}");
            device.ticks(20);
            let off_deg = at_deg - stop_deg;
            let servo_deg = f64::from(device.device.servo().position()) * COUNT_DEG;
            let error_deg = servo_deg - (device.position_deg() + off_deg);
            assert!(error_deg.abs() <= 2.0 * COUNT_DEG, "{name}: {error_deg} deg");
            assert_eq!(found.touches, 2, "{name}");
            let servo = device.device.servo();
            assert!(servo.is_referenced(), "{name}");
            // The range is that of the reference: beyond the stop is out of it. The joint has gone
            // back by half of the 2 deg of a jog.
            servo.arm_for_link(None).unwrap();
            device.tick();
            let outward = stop_deg.signum();
            for (to_deg, is_in) in [(2.5 * outward, false), (0.5 * outward, true)] {
                let step = Step { to: Position::from_counts(counts(to_deg)), ..Step::default() };
                let went = device.device.servo().follow(Reference::Step(step));
                assert_eq!(went.is_ok(), is_in, "{name}, {to_deg} deg: {went:?}");
            }
            // The bound was the homing's: three degrees back ask every law for more.
            let back = Position::from_counts(counts(-3.0 * outward));
            let step = Step { to: back, ..Step::default() };
            device.device.servo().follow(Reference::Step(step)).unwrap();
            let most = (0..100).map(|_| {
                device.device.servo().heard();
                f64::from(device.tick().tick.v_applied.abs())
            });
            assert!(most.fold(0.0, f64::max) > 1.1 * EFFORT_V, "{name}");
        }
    }
}

/// The error may be half a degree. At 10 V/deg, 0.06 deg ask for the 0.6 V of a jog; at 1.5 V/deg,
/// 0.4 deg do, more than the three quarters at which the set point waits. It goes 4 deg/s.
#[test]
fn the_set_point_waits_at_the_stop_for_the_joint_of_a_stiff_loop() {
    for (law, kp) in [("pd", 10.0), ("srnf", 10.0), ("pd", 1.5)] {
        let stiff =
            [&*format!("controller.{law}.kp_v_per_deg={kp}"), "limits.following_error_deg=0.5"];
        let mut device = joint(law, [-1e3, 12.0], &stiff);
        begin(&mut device, HomeRequest { at: counts(40.0), ..UP }).unwrap();
        let (found, effort_v) = until_off(&mut device);
        let latched = device.device.servo().latched();
        assert_eq!(found.map(|found| found.ended), Some(HomeEnd::Stop), "{law}: {latched:?}");
        assert!(effort_v <= EFFORT_V, "{law}: {effort_v} V");
    }
}

/// The range is -10 to 40 deg, and the way back is a degree whatever a jog's travel is. From a stop
/// outside the range the joint goes back until it is a degree within. A stop at the wrong end of
/// the range leaves nowhere to go.
#[test]
fn a_homing_ends_within_the_range_or_is_refused() {
    for travel in ["jog.travel_deg=2", "jog.travel_deg=90"] {
        let ends = [(38.0, Some(1.0)), (40.0, Some(1.0)), (40.5, Some(1.5)), (45.0, Some(6.0))];
        let refused = [(-7.0, Some(1.0)), (-9.1, None), (200.0, None)];
        for (at_deg, back_deg) in ends.into_iter().chain(refused) {
            let mut device = joint("srnf", [-1e3, 3.0], &[travel]);
            let begun = begin(&mut device, HomeRequest { at: counts(at_deg), ..UP });
            let expected = back_deg.map_or(Err(Refusal::OutOfRange), |_| Ok(()));
            assert_eq!(begun, expected, "{travel}, {at_deg} deg");
            let Some(back_deg) = back_deg else { continue };
            let found = until_off(&mut device).0;
            assert_eq!(found.map(|found| found.ended), Some(HomeEnd::Stop), "{at_deg} deg");
            device.ticks(100);
            let beyond_deg = 3.0 - device.position_deg() - back_deg;
            assert!((-0.01..2.1).contains(&beyond_deg), "{travel}, {at_deg}: {beyond_deg} deg");
            // It can be armed from there.
            device.device.servo().arm_for_link(None).unwrap();
        }
    }
}

/// What ends a homing: its request, what happens on the way, and what it reports.
type Interruption = (&'static str, HomeRequest, fn(&mut SimulatedDevice), Option<HomeEnd>);

/// A request with a value for one of its bounds.
type Bounded = fn(f32) -> HomeRequest;

/// Each of these ends a homing before its stop; the joint was referenced before it.
#[test]
fn nothing_but_the_stop_leaves_a_reference() {
    let ends: [Interruption; 7] = [
        ("travel", HomeRequest { travel: Some(5.0), ..UP }, |_| {}, Some(HomeEnd::Travel)),
        ("time", HomeRequest { time: Some(2.0), ..UP }, |_| {}, Some(HomeEnd::Time)),
        ("stop", UP, |device| device.device.servo().stop(), None),
        ("brake", UP, |device| device.device.servo().come_to_rest(), None),
        ("fault", UP, |device| device.device.servo().fault(Fault::Watchdog), None),
        // It looks like a stop until the way back.
        ("dead encoder", UP, |device| device.wires = Wires::Cut, None),
        ("a dead line", UP, |device| device.wires = Wires::OneCut, None),
    ];
    for (name, asked, interrupt, expected) in ends {
        let mut device = joint("srnf", [-1e3, 30.0], &[]);
        device.device.servo().set_reference(0).unwrap();
        begin(&mut device, asked).unwrap();
        assert!(!device.device.servo().is_referenced(), "{name}");
        pass(&mut device, 80);
        interrupt(&mut device);
        let (found, _) = until_off(&mut device);
        assert_eq!(found.map(|found| found.ended), expected, "{name}");
        // It went there, and the travel is a bound: a tick of 4 deg/s and the way in which 0.36 V
        // of friction stop that speed come on top (kappa 27 deg/s^2 per V).
        let at_deg = device.position_deg();
        let most_deg = 5.0 + 0.08 + 4.0 * 4.0 / (2.0 * 27.0 * 0.36);
        assert!(at_deg > 1.0 && at_deg < 10.0, "{name}: {at_deg} deg");
        assert!(name != "travel" || at_deg < most_deg, "{at_deg} deg");
        device.ticks(50);
        let servo = device.device.servo();
        assert!(!servo.is_referenced(), "{name}");
        let _ = servo.clear();
        device.ticks(50);
        // The stall puts the encoder in doubt as well.
        let is_dead = device.wires != Wires::Sound;
        let refusal = if is_dead { Refusal::EncoderInDoubt } else { Refusal::NotReferenced };
        assert_eq!(device.device.servo().arm_for_link(None), Err(refusal), "{name}");
    }
}

#[test]
fn a_homing_is_refused_like_a_closed_loop_but_for_the_reference_which_it_keeps_then() {
    let mut device = joint("srnf", [-1e3, 30.0], &[]);
    // Out of the range: what finds the place must not be refused for it.
    device.device.servo().set_reference(counts(60.0)).unwrap();
    let far = HomeRequest { at: 1 << 30, ..UP };
    assert_eq!(begin(&mut device, far), Err(Refusal::TooFar));
    assert!(device.device.servo().is_referenced());
    assert_eq!(begin(&mut device, UP), Ok(()));
    device.tick();
    assert_eq!(begin(&mut device, UP), Err(Refusal::Armed));
    // A client that drives it otherwise would take the stop away.
    let servo = device.device.servo();
    assert_eq!(servo.follow(Reference::Step(Step::default())), Err(Refusal::Armed));
    assert_eq!(servo.hold(), Err(Refusal::Armed));
    assert_eq!(servo.arm_for_link(None), Err(Refusal::Armed));
    servo.stop();
    device.ticks(50);
    device.device.servo().fault(Fault::EncoderReversed);
    device.device.servo().clear().unwrap();
    device.ticks(50);
    assert_eq!(begin(&mut device, UP), Err(Refusal::EncoderInDoubt));
    let mut device = joint("srnf", [-1e3, 30.0], &["limits.breakaway_min_v=0"]);
    assert_eq!(begin(&mut device, UP), Err(Refusal::FrictionUnknown));
}

/// What interrupts a homing.
type End = fn(&mut SimulatedDevice);

/// Ends the homing of a joint at every ninth of its ticks, in four ways. Asserts that it leaves no
/// reference then, and no more effort than its own, unless it has found its place before. Returns
/// the number of homings that were ended.
pub fn end_at_any_moment(
    joint: impl Fn() -> SimulatedDevice,
    asked: HomeRequest,
    place: HomeEnd,
) -> usize {
    let ends: [(&str, End); 4] = [
        ("stop", |device| device.device.servo().stop()),
        ("brake", |device| device.device.servo().come_to_rest()),
        ("fault", |device| device.device.servo().fault(Fault::Watchdog)),
        ("silence", |_| {}),
    ];
    let mut ended = 0;
    for (name, interrupt) in ends {
        for at in (0..400).step_by(9) {
            let mut device = joint();
            begin(&mut device, asked).unwrap();
            pass(&mut device, at);
            if device.device.servo().state() != State::Armed {
                continue;
            }
            interrupt(&mut device);
            let mut effort_v = 0.0f64;
            // Two seconds are the silence that is a fault, half a second, and the longest braking.
            for _ in 0..100 {
                effort_v = effort_v.max(device.tick().tick.v_applied.abs().into());
            }
            let servo = device.device.servo();
            assert!(servo.state() != State::Armed, "{name} at {at}");
            // A silent link brakes only after half a second: the homing may have found its place.
            let has_found = servo.homed().is_some_and(|found| found.ended == place);
            assert_eq!(servo.is_referenced(), has_found, "{name} at {at}");
            assert!(!has_found || name == "silence", "{name} at {at}");
            assert!(effort_v <= EFFORT_V, "{name} at {at}: {effort_v} V");
            ended += 1;
        }
    }
    ended
}

/// Without an end it takes some 250 ticks.
#[test]
fn no_moment_at_which_it_ends_leaves_a_reference() {
    let asked = HomeRequest { at: counts(40.0), ..UP };
    let ended = end_at_any_moment(|| joint("srnf", [-1e3, 3.0], &[]), asked, HomeEnd::Stop);
    assert!(ended > 60, "{ended}");
}

/// An encoder that fails for a while, at any tick, may end a homing; what is referenced is right,
/// but for what was lost on the last way back: a travel of 2 deg at most.
#[test]
fn an_encoder_that_fails_for_a_while_sets_no_false_zero() {
    // When the joint leaves the stop for good if nothing fails.
    let leaves = {
        let mut device = joint("srnf", [-1e3, 3.0], &[]);
        begin(&mut device, HomeRequest { at: counts(40.0), ..UP }).unwrap();
        let at_stop = (0..3000).filter(|_| {
            device.device.servo().heard();
            device.tick().state == State::Armed && device.position_deg() > 3.0 - COUNT_DEG
        });
        at_stop.last().unwrap()
    };
    let mut referenced = 0;
    for wires in [Wires::Cut, Wires::OneCut] {
        for (from, during) in (0..400).step_by(9).flat_map(|at| [(at, 3), (at, 15), (at, 60)]) {
            let mut device = joint("srnf", [-1e3, 3.0], &[]);
            begin(&mut device, HomeRequest { at: counts(40.0), ..UP }).unwrap();
            for tick in 0..3000 {
                let fails = tick >= from && tick < from + during;
                device.wires = if fails { wires } else { Wires::Sound };
                device.device.servo().heard();
                if device.tick().state != State::Armed {
                    break;
                }
            }
            device.wires = Wires::Sound;
            device.ticks(20);
            let true_deg = device.position_deg() + 40.0 - 3.0;
            let servo = device.device.servo();
            assert!(servo.state() != State::Armed, "{wires:?} at {from}");
            if servo.is_referenced() {
                let error_deg = f64::from(servo.position()) * COUNT_DEG - true_deg;
                // The places agree within 0.125 deg, a sixteenth of the 2 deg of a jog.
                let most_deg = if from + during <= leaves { 0.13 } else { 2.0 };
                assert!(error_deg.abs() < most_deg, "{wires:?} {from}+{during}: {error_deg}");
                referenced += 1;
            }
        }
    }
    assert!(referenced > 20, "{referenced}");
}

/// The coarser the encoder, the longer the joint sets out without a count, which looks like a stop.
#[test]
fn a_coarse_encoder_sets_no_false_zero() {
    let mut referenced = 0;
    for count_deg in [0.01, 0.02, 0.045, 0.09, 0.18, 0.36] {
        for law in controllers() {
            let resolution = format!("encoder.resolution_deg={count_deg}");
            let mut device = joint(law, [-1e3, 30.0], &[&resolution]);
            // Half of 64 counts of 0.36 deg on the way back stay within the range.
            let at = (20.0 / count_deg) as i32;
            begin(&mut device, HomeRequest { at, ..UP }).unwrap();
            until_off(&mut device);
            device.ticks(20);
            let true_deg = device.position_deg() - 30.0;
            let servo = device.device.servo();
            if servo.is_referenced() {
                let shown_deg = f64::from(servo.position() - at) * count_deg;
                let error_deg = shown_deg - true_deg;
                assert!(error_deg.abs() <= 2.0 * count_deg, "{law}, {count_deg}: {error_deg}");
                referenced += 1;
            }
        }
    }
    assert!(referenced > 10, "{referenced}");
}

/// Bounds at their ends and beyond: 0.3 and 0.9 of the way from `breakaway_v` (0.4 V) to `stall_v`
/// (0.8 V), the speed of the profile, 64 counts, two turns, half an hour.
#[test]
fn a_bound_that_the_machine_does_not_allow_is_refused_by_its_name() {
    let device = joint("srnf", [-1e3, 1e3], &[]);
    let parameters: &Parameters = device.device.parameters().unwrap();
    let fastest = parameters.profile.velocity;
    let least = 64.0 * parameters.controller.encoder.resolution;
    let above = |bound: f32| bound * 1.001;
    let cases: [(&str, Bounded, f32, f32); 6] = [
        ("effort", |x| HomeRequest { effort: Some(x), ..UP }, 0.759, 0.761),
        ("little effort", |x| HomeRequest { effort: Some(x), ..UP }, 0.521, 0.519),
        ("speed", |x| HomeRequest { speed: Some(x), ..UP }, fastest, above(fastest)),
        ("least", |x| HomeRequest { travel: Some(x), ..UP }, least, least * 0.999),
        ("travel", |x| HomeRequest { travel: Some(x), ..UP }, 720.0, above(720.0)),
        ("time", |x| HomeRequest { time: Some(x), ..UP }, 1800.0, above(1800.0)),
    ];
    for (name, ask, within, beyond) in cases {
        assert!(parameters.home(&ask(within)).is_ok(), "{name}");
        for refused in [beyond, 0.0, -1.0, f32::NAN] {
            assert!(parameters.home(&ask(refused)).is_err(), "{name}: {refused}");
        }
    }
}
