//! The holding brake: open once the loop can hold the joint and before it moves, closed before the
//! output is off.
//!
//! Times are in ticks of 20 ms: 5 of soft start, 5 in which the brake opens, 10 in which it closes.

use simulator::device::client::Client;
use simulator::device::simulated::{HoldingBrake, SimulatedDevice};
use simulator::device::wire::SimulatedWire;
use stiction::control::reference::{Reference, Step};
use stiction::motion::jog::JogRequest;
use stiction::servo::{BrakeCommand, Output, Refusal, State};
use stiction::units::position::Position;
use stiction::{Fault, Tick};

use crate::fixture::plans;

const TIMES: [&str; 3] =
    ["device.soft_start_s=0.1", "device.brake_open_s=0.1", "device.brake_close_s=0.2"];
const OPEN_S: f64 = 0.1;
const CLOSE_S: f64 = 0.2;
/// Friction of the closed brake, V: four times the full effort.
const HOLDING_V: f64 = 20.0;
/// Counts of a degree.
const COUNTS: i32 = 413;

/// What a tick does with the bridge and the brake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Off,
    Wakes(BrakeCommand),
    On(BrakeCommand),
}
use BrakeCommand::{Closed, Open};
use Phase::{Off, On, Wakes};

fn phase(output: &Output) -> Phase {
    match (output.enable, output.wakes) {
        (true, _) => On(output.brake()),
        (_, true) => Wakes(output.brake()),
        _ => {
            assert_eq!(output.brake(), Closed);
            Off
        }
    }
}

/// The thesis's robot with a brake, at rest under a law.
fn at_rest(law: &str, set: &[&str]) -> SimulatedDevice {
    let controller = format!("loop.controller={law}");
    let own = [&*controller, "reference.steps_deg=[5.0]"];
    let plan = &plans("step-response", &[&own[..], &TIMES, set].concat())[0];
    let mut device = SimulatedDevice::new(plan).unwrap();
    device.holding_brake = Some(HoldingBrake::closed(HOLDING_V, [OPEN_S, CLOSE_S]));
    device.ticks(50);
    device
}

/// The same, armed, with its brake open.
fn armed(law: &str, set: &[&str]) -> SimulatedDevice {
    let mut device = at_rest(law, set);
    device.device.servo().arm_for_link(None).unwrap();
    device.ticks(11);
    device
}

fn step_to(device: &mut SimulatedDevice, deg: i32) {
    let to = Position::from_counts(deg * COUNTS);
    let step = Step { from: Position::default(), to, at_tick: 0 };
    device.device.servo().follow(Reference::Step(step)).unwrap();
}

fn phases(device: &mut SimulatedDevice, ticks: usize) -> Vec<Phase> {
    (0..ticks).map(|_| phase(&device.tick())).collect()
}

fn is_held(tick: &Tick) -> bool {
    (tick.reference_counts, tick.reference_velocity) == (0, 0.0)
}

#[test]
fn the_brake_opens_after_the_soft_start_and_the_motion_starts_once_it_is_open() {
    for law in experiments::controllers() {
        let mut device = at_rest(law, &["device.wake_up_s=0.04"]);
        device.device.servo().arm_for_link(None).unwrap();
        assert_eq!(phases(&mut device, 2), [Wakes(Closed); 2], "{law}");
        for tick in 0..10 {
            if tick == 3 {
                step_to(&mut device, 5);
            }
            let output = device.tick();
            let expected = if tick < 5 { On(Closed) } else { On(Open) };
            assert_eq!(phase(&output), expected, "{law}, {tick}");
            assert!(is_held(&output.tick), "{law}, {tick}: {:?}", output.tick);
        }
        // The command was 0.1 s ago, and the motion begins with its own first tick.
        assert!(!device.holding_brake.unwrap().is_open());
        let output = device.tick();
        assert!(device.holding_brake.unwrap().is_open());
        assert_eq!(phase(&output), On(Open), "{law}");
        let Tick { tick, reference_counts, .. } = output.tick;
        assert_eq!((tick, reference_counts), (0, 5 * COUNTS), "{law}");
    }
}

#[test]
fn the_latest_of_the_commands_before_the_brake_is_open_is_the_motion() {
    let mut device = at_rest("pd", &[]);
    device.device.servo().arm_for_link(None).unwrap();
    device.tick();
    for deg in [5, 3, 4] {
        step_to(&mut device, deg);
        device.tick();
    }
    device.ticks(6);
    assert_eq!(device.tick().tick.reference_counts, 4 * COUNTS);
    let mut device = at_rest("pd", &[]);
    device.device.servo().arm_for_link(None).unwrap();
    device.tick();
    step_to(&mut device, 5);
    device.device.servo().hold().unwrap();
    assert!((0..20).all(|_| is_held(&device.tick().tick)));
}

#[test]
fn a_client_waits_for_the_brake_that_opens_before_a_move() {
    let time_s = |set: &[&str]| {
        let mut client = Client::connect(SimulatedWire::new(at_rest("pd", set))).unwrap();
        client.longest_s(10.0).unwrap()
    };
    let opens_s = time_s(&[]) - time_s(&["device.brake_open_s=0"]);
    assert!((opens_s - OPEN_S).abs() < 1e-6, "{opens_s} s");
}

#[test]
fn the_brake_closes_before_the_output_of_a_joint_at_rest_is_off() {
    for law in experiments::controllers() {
        let mut device = armed(law, &[]);
        device.device.servo().come_to_rest();
        assert_eq!(device.device.servo().arm(), Err(Refusal::Stopping), "{law}");
        assert_eq!(phases(&mut device, 10), [On(Closed); 10], "{law}");
        assert_eq!(phase(&device.tick()), Off, "{law}");
        assert_eq!(device.device.servo().state(), State::Stopped, "{law}");
    }
}

#[test]
fn a_joint_that_moves_is_braked_before_the_brake_closes() {
    for law in experiments::controllers() {
        let mut device = armed(law, &[]);
        step_to(&mut device, 20);
        for _ in 0..30 {
            device.device.servo().heard();
            device.tick();
        }
        assert!(device.velocity_deg_per_s() > 5.0, "{law}");
        device.device.servo().come_to_rest();
        let seen = std::iter::repeat_with(|| {
            let (phase, at_rest) = (phase(&device.tick()), device.device.servo().is_at_rest());
            (phase, at_rest)
        });
        let seen: Vec<_> = seen.take_while(|(phase, _)| *phase != Off).collect();
        let braked = seen.iter().take_while(|(phase, _)| *phase == On(Open)).count();
        // The tick in which the joint is found at rest, or `stop_s` is over, is the first one.
        assert!(seen[braked].1 || braked == 49, "{law}: after {braked} ticks");
        assert!(seen[..braked].iter().all(|(_, at_rest)| !at_rest), "{law}");
        assert_eq!(seen.len() - braked, 10, "{law}");
        assert!(seen[braked..].iter().all(|(phase, _)| *phase == On(Closed)), "{law}");
        assert_eq!(device.device.servo().state(), State::Stopped, "{law}");
    }
}

#[test]
fn a_silent_link_closes_the_brake_first_and_any_other_fault_at_once() {
    let mut device = armed("pd", &[]);
    let seen: Vec<Phase> =
        std::iter::repeat_with(|| phase(&device.tick())).take_while(|seen| *seen != Off).collect();
    assert_eq!(seen.iter().filter(|seen| **seen == On(Closed)).count(), 10);
    assert_eq!(device.device.servo().state(), State::Faulted(Fault::LinkTimeout));
    for ends in [
        |device: &mut SimulatedDevice| device.device.servo().fault(Fault::Overrun),
        |device: &mut SimulatedDevice| {
            // The second stop.
            device.device.servo().come_to_rest();
            device.tick();
            device.device.servo().come_to_rest();
        },
    ] {
        let mut device = armed("pd", &[]);
        ends(&mut device);
        assert_eq!(phase(&device.tick()), Off);
    }
}

#[test]
fn a_stop_before_the_brake_has_begun_to_open_is_off_at_once() {
    for (ticks, closing) in [(0, 0), (5, 0), (6, 10), (9, 10)] {
        let mut device = at_rest("pd", &[]);
        device.device.servo().arm_for_link(None).unwrap();
        phases(&mut device, ticks);
        device.device.servo().come_to_rest();
        assert_eq!(phases(&mut device, closing), vec![On(Closed); closing], "{ticks}");
        assert_eq!(phase(&device.tick()), Off, "{ticks}");
    }
}

/// The motion of the parameters waits aside while the brake opens, and is not lost.
#[test]
fn a_fault_while_the_brake_opens_leaves_the_motion_of_the_parameters() {
    let mut device = at_rest("pd", &[]);
    device.device.servo().arm().unwrap();
    device.ticks(7);
    device.device.servo().fault(Fault::Overrun);
    device.tick();
    device.device.servo().clear().unwrap();
    device.ticks(10);
    device.device.servo().arm().unwrap();
    device.ticks(10);
    let Tick { tick, reference_counts, .. } = device.tick().tick;
    assert!(tick == 0 && (reference_counts - 5 * COUNTS).abs() < COUNTS, "{reference_counts}");
}

/// No loop holds a joint in a jog: the brake is open before the first effort.
#[test]
fn a_jog_waits_for_an_open_brake_without_a_duty() {
    let mut device = at_rest("pd", &[]);
    let jog = device.device.parameters().unwrap().jog(&JogRequest::default()).unwrap();
    device.device.servo().jog(jog).unwrap();
    assert_eq!(phases(&mut device, 5), [Wakes(Open); 5]);
    while phase(&device.tick()) == On(Open) {
        device.device.servo().heard();
    }
    assert!(device.device.servo().jogged().unwrap().agrees());
    // A load that moves the joint meets the bounds of the jog, and not those of the wake-up.
    let mut device = at_rest("pd", &[]);
    device.load_v = 2.0;
    device.device.servo().jog(jog).unwrap();
    device.holding_brake.as_mut().unwrap().open_s = 0.02;
    let waits = std::iter::repeat_with(|| phase(&device.tick()));
    let waits = waits.take_while(|seen| *seen == Wakes(Open)).count();
    assert!(waits < 5, "{waits}");
}

/// A load of 2 V falls by `k (2 V - T_d) t^2 / 2` in the time in which the brake closes, if the
/// loop does not hold it meanwhile. Damping takes less than a fifth of that.
#[test]
fn a_hanging_load_does_not_fall_while_the_brake_closes() {
    let fallen = |close: &str| {
        // The effort that holds the load would be a stall of a joint without one.
        let no_stall = ["limits.stall_v=0", "limits.breakaway_v=0", "limits.stall_impulse_vs=0"];
        let mut device = armed("pd", &[&no_stall[..], &[close]].concat());
        for tick in 0..500 {
            device.load_v = (0.01 * f64::from(tick)).min(2.0);
            device.device.servo().heard();
            assert_eq!(device.tick().state, State::Armed);
        }
        assert!(device.device.servo().is_at_rest());
        let from = device.position_deg();
        device.device.servo().come_to_rest();
        device.ticks(100);
        assert_eq!(device.velocity_deg_per_s(), 0.0);
        device.position_deg() - from
    };
    // 27 deg/s^2 for a volt, and 0.38 V of friction; the closed brake stops it within a tenth.
    let way = 0.5 * 27.0 * (2.0 - 0.38) * CLOSE_S * CLOSE_S;
    let (held, loose) = (fallen("device.brake_close_s=0.2"), fallen("device.brake_close_s=0"));
    assert!(held.abs() < 0.01, "{held} deg");
    assert!((0.8 * way..1.1 * way).contains(&loose), "{loose} deg, {way} deg");
}

#[test]
fn a_device_without_a_brake_is_as_before() {
    let mut device = at_rest("pd", &["device.brake_open_s=0", "device.brake_close_s=0"]);
    device.device.servo().arm_for_link(None).unwrap();
    step_to(&mut device, 5);
    let Output { tick, .. } = device.tick();
    assert_eq!((tick.tick, tick.reference_counts, tick.status & Tick::HELD), (0, 5 * COUNTS, 0));
    device.device.servo().hold().unwrap();
    device.device.servo().stop();
    assert_eq!(phase(&device.tick()), Off);
}

/// The play of the brake lets the joint move before the brake opens, and the loop has no effort
/// yet.
#[test]
fn a_stop_in_the_soft_start_leaves_the_brake_closed_though_the_joint_moves() {
    for law in experiments::controllers() {
        let mut device = at_rest(law, &[]);
        device.device.servo().arm_for_link(None).unwrap();
        device.ticks(2);
        device.push(0.05, 0.0);
        device.tick();
        assert!(!device.device.servo().is_at_rest(), "{law}");
        device.device.servo().come_to_rest();
        assert_eq!(phases(&mut device, 20), [Off; 20], "{law}");
    }
}

#[test]
fn a_ramp_whose_travel_nothing_bounds_is_refused_with_a_brake() {
    for set in [[0.1, 0.0], [0.0, 0.1]] {
        let mut parameters = at_rest("pd", &[]).device.parameters().unwrap().clone();
        [parameters.device.brake_open, parameters.device.brake_close] = set;
        assert!(parameters.ramp(0.5, 0.1).is_err(), "{set:?}");
        [parameters.device.brake_open, parameters.device.brake_close] = [0.0; 2];
        assert!(parameters.ramp(0.5, 0.1).is_ok());
    }
}
