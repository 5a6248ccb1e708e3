//! A device whose efforts are currents: what its current loop does to a step, a move, and a
//! winding, a supply or a wire that is not that of the file.

use experiments::current_sensor::current_sensor;
use simulator::device::simulated::{MotorWires, ShuntState, SimulatedDevice};
use simulator::experiment::Task;
use simulator::run::{RunDriver, run_driven};
use stiction::Fault;
use stiction::servo::State;

use crate::current_sensor::{STEP_A, heard, moves};
use crate::dead_encoder::step;

/// Laws of an image, of which the file of the joint has gains.
const LAWS: [&str; 3] = ["robust", "srnf", "pd"];

/// A current loop, and a winding with L/R = 0.5 ms.
const CURRENT: [&str; 3] =
    ["loop.effort=current", "drive.pwm_hz=21000", "motor.inductance_h=0.001255"];

/// The same joint without a loop.
const VOLTAGE: [&str; 1] = ["motor.inductance_h=0.001255"];

/// A device of the file, around a joint of the file with other values.
fn device(law: &str, file: &[&str], truth: &[&str]) -> SimulatedDevice {
    let plan = |set: &[&[&str]]| current_sensor(&[law], &set.concat()).remove(0);
    let mut of = plan(&[file]);
    of.truth = Some(Box::new(plan(&[file, truth])));
    let mut device = SimulatedDevice::new(&of).unwrap();
    device.ticks(200);
    device
}

/// Moves by 20 deg in 2 s. Returns the largest error on the way and the last one, deg.
fn tracks(device: &mut SimulatedDevice, sag: std::ops::Range<u32>) -> [f64; 2] {
    moves(device, 20.0);
    let (nominal, mut worst) = (device.supply_ratio, 0.0f64);
    for tick in 0..2000 {
        device.supply_ratio = nominal * if sag.contains(&tick) { 0.7 } else { 1.0 };
        let output = heard(device);
        assert_eq!(output.state, State::Armed, "{tick}: {:?}", output.tick);
        let error = f64::from(output.tick.error);
        worst = worst.max(error.abs());
    }
    [worst, (device.position_deg() - 20.0).abs()]
}

/// The back-EMF of 30 deg/s is 2.4 V of 48 V: each supply here suffices for the move.
#[test]
fn a_move_does_not_depend_on_winding_and_supply_as_it_does_without_a_current_loop() {
    for law in LAWS {
        let worst = |file: &[&str], ohm: f64, supply: f64, sag: std::ops::Range<u32>| {
            let mut device = device(law, file, &[&format!("motor.resistance_ohm={ohm}")]);
            device.supply_ratio = supply;
            let [worst, last] = tracks(&mut device, sag);
            assert!(law == "pd" || last < 0.01, "{law}, {ohm} ohm, {supply}: {last} deg");
            worst
        };
        let count_deg = {
            let device = device(law, &CURRENT, &[]);
            f64::from(device.device.parameters().unwrap().controller.encoder.resolution)
        };
        let nominal = worst(&CURRENT, 2.51, 1.0, 0..0);
        for (ohm, supply, sag) in [
            (0.7 * 2.51, 1.0, 0..0),
            (1.4 * 2.51, 1.0, 0..0),
            (2.51, 0.8, 0..0),
            (2.51, 1.2, 0..0),
            (2.51, 1.0, 500..600),
            (1.4 * 2.51, 0.8, 500..600),
        ] {
            let found = worst(&CURRENT, ohm, supply, sag.clone());
            // `srnf` switches its effort with the sign of the error's speed, and chatters.
            let most = if law == "srnf" { 2.5 * nominal } else { nominal + 2.0 * count_deg };
            assert!(found < most, "{law}, {ohm} ohm, {supply}, {sag:?}: {found}, {nominal} deg");
        }
        let (nominal, hot) =
            (worst(&VOLTAGE, 2.51, 1.0, 0..0), worst(&VOLTAGE, 1.4 * 2.51, 1.0, 0..0));
        assert!(hot > 1.2 * nominal, "{law}, without a loop: {hot}, {nominal} deg");
    }
}

/// The law asks for all of its 48 V, 19 A; the limit is 8 A. With the configured resistance a step
/// overshoots for two periods at most. With another one, the zero of the PI and the pole of the
/// winding do not cancel, and a rest of the current decays with L/R, 0.36 to 0.71 ms. From a tenth
/// of 8 A to the steps of the sensor that takes 3.3 of it, 50 periods.
#[test]
fn a_blocked_motor_exceeds_its_limit_by_a_tenth_at_most_for_two_periods_at_most() {
    for ohm in [0.7 * 2.51, 2.51, 1.4 * 2.51] {
        let mut device = device(
            "pd",
            &[&CURRENT[..], &["current_sensor.peak_a=8", "device.soft_start_s=0"]].concat(),
            &[&format!("motor.resistance_ohm={ohm}")],
        );
        device.brake_v = 1000.0;
        device.device.servo().arm_for_link(None).unwrap();
        heard(&mut device);
        step(&mut device, 90.0);
        let mut currents = Vec::new();
        for _ in 0..15 {
            assert_eq!(heard(&mut device).state, State::Armed, "{ohm} ohm");
            currents.extend_from_slice(device.currents_a());
        }
        let most = currents.iter().copied().fold(0.0, f64::max);
        let over = currents.iter().filter(|current| **current > 8.0 + STEP_A).count();
        let longest = if ohm == 2.51 { 2 } else { 50 };
        assert!(most < 1.1 * 8.0 && over <= longest, "{ohm} ohm: {most} A, {over} periods");
        let settled = &currents[currents.len() - 100..];
        let is_settled =
            settled.iter().all(|current| (8.0 - STEP_A..8.0 + STEP_A).contains(current));
        assert!(is_settled, "{ohm} ohm: {:?}", &settled[..5]);
    }
}

/// Returns the fault of a failure, the ticks until it was latched, and the largest travel from
/// there until the joint rests, deg.
fn fails(law: &str, fail: impl Fn(&mut SimulatedDevice)) -> (Fault, u32, f64) {
    let set = ["device.dead_time_s=1e-7", "current_sensor.full_scale_a=10"];
    let mut device = device(law, &[&CURRENT[..], &set].concat(), &[]);
    moves(&mut device, 40.0);
    while device.position_deg() < 5.0 {
        assert_eq!(heard(&mut device).state, State::Armed, "{law}");
    }
    fail(&mut device);
    let from_deg = device.position_deg();
    let found = (1..1000).find_map(|tick| match heard(&mut device).state {
        State::Faulted(fault) => Some((fault, tick)),
        _ => None,
    });
    let (fault, ticks) = found.unwrap();
    let travel = |device: &SimulatedDevice| (device.position_deg() - from_deg).abs();
    let farthest = (0..500).fold(travel(&device), |farthest, _| {
        device.tick();
        farthest.max(travel(&device))
    });
    (fault, ticks, farthest)
}

/// A current that is missing takes 6 ms ln 4 and 6 ms more, one that is too large a period of the
/// PWM. The farthest is below 2 deg: the loop drives with up to its largest voltage until the
/// fault, and the joint coasts. Without a current it loses speed; without a reading it gains some.
#[test]
fn each_failure_in_a_current_loop_is_its_own_fault() {
    for law in LAWS {
        let shorted = |device: &mut SimulatedDevice| device.motor_wires = MotorWires::Shorted;
        let open = |device: &mut SimulatedDevice| device.motor_wires = MotorWires::Open;
        let unpowered = |device: &mut SimulatedDevice| device.is_unpowered = true;
        let sensor = |state| {
            move |device: &mut SimulatedDevice| device.shunt.as_mut().unwrap().state = state
        };
        let over = [Fault::OverCurrent; 2];
        let none = [Fault::MotorOpen; 2];
        for (what, (fault, ticks, travel_deg), expected, most) in [
            ("shorted", fails(law, shorted), over, 3),
            ("open", fails(law, open), none, 16),
            ("unpowered", fails(law, unpowered), none, 16),
            ("sensor low", fails(law, sensor(ShuntState::Stuck(0))), over, 3),
            ("sensor high", fails(law, sensor(ShuntState::Stuck(3300))), over, 3),
            // The loop drives up to its largest voltage. Whether the joint moves on meanwhile
            // depends on the law.
            (
                "sensor at zero",
                fails(law, sensor(ShuntState::Stuck(1650))),
                [Fault::CurrentSensor, Fault::MotorOpen],
                16,
            ),
            // Its loop has the wrong sign.
            ("sensor reversed", fails(law, sensor(ShuntState::Reversed)), over, 3),
        ] {
            assert!(expected.contains(&fault), "{law}, {what}: {fault:?} after {ticks} ticks");
            assert!(ticks <= most && travel_deg < 2.0, "{law}, {what}: {ticks}, {travel_deg} deg");
        }
    }
}

/// With L/R = 5 ms, SRNF swings 14 counts about its target. The current of a loop lags by 0.2 ms.
#[test]
fn a_run_has_the_current_loop_of_a_device_with_and_without_its_servo() {
    const SLOW: &str = "motor.inductance_h=0.01255";
    let of = |set: &[&str], driven| {
        let runs = current_sensor(&["srnf"], set);
        let plan = runs.iter().find(|plan| matches!(plan.task, Task::Trajectory(_))).unwrap();
        run_driven(plan, driven).unwrap().metrics.rms_error_deg.unwrap()
    };
    for driven in [RunDriver::ByLoop, RunDriver::ByServo] {
        let with = of(&[&CURRENT[..2], &[SLOW]].concat(), driven);
        let without = of(&[SLOW], driven);
        let fast = of(&VOLTAGE, driven);
        assert!(with < 1.2 * fast && without > 2.0 * fast, "{driven:?}: {with} {without} {fast}");
    }
}
