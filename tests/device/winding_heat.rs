//! A winding that heats up by its current: what its resistance does to a voltage, and that a
//! current loop does not depend on it.

use experiments::current_sensor::current_sensor;
use simulator::device::simulated::SimulatedDevice;
use simulator::experiment::Task;
use simulator::run::{RunDriver, run_driven};
use stiction::servo::State;

use crate::current_sensor::{STEP_A, heard};
use crate::dead_encoder::step;

/// Of the file: resistance at 20 deg C, ohm.
const R: f64 = 2.51;
/// Temperature coefficient of copper, 1/K (IEC 60028).
const COPPER: f64 = 0.00393;
/// Both thermal resistances together, K/W.
const K_PER_W: f64 = 0.215 + 0.15;

/// A small motor, whose temperature is constant after 10 s.
const HEAT: [&str; 4] = [
    "motor.thermal_resistance_winding_k_per_w=0.215",
    "motor.thermal_resistance_case_k_per_w=0.15",
    "motor.thermal_time_winding_s=0.5",
    "motor.thermal_time_motor_s=1",
];

/// A device that holds a step against a block, without the monitors that would end it.
pub fn blocked(set: &[&str], to_deg: f64) -> SimulatedDevice {
    let unwatched = [
        "limits.stall_v=off",
        "limits.following_error_deg=off",
        "limits.progress_gain_deg_per_s2_per_v=off",
        "limits.breakaway_min_v=1000",
        "limits.breakaway_v=40",
        "limits.stall_impulse_vs=off",
        "limits.continuous_v=off",
        "device.soft_start_s=0",
    ];
    let set = [&unwatched, set].concat();
    let mut device = SimulatedDevice::new(&current_sensor(&["pd"], &set)[0]).unwrap();
    device.ticks(200);
    device.brake_v = 1000.0;
    device.device.servo().arm_for_link(None).unwrap();
    heard(&mut device);
    step(&mut device, to_deg);
    device
}

/// `T - 20 = K_PER_W i^2 R r` with `r = 1 + COPPER (T - 20)`: at a constant current, r is linear in
/// the loss of the cold winding.
#[test]
fn a_current_loop_holds_its_current_while_the_resistance_rises() {
    let set = ["loop.effort=current", "drive.pwm_hz=21000", "motor.inductance_h=0.001255"];
    let mut device = blocked(&[&set[..], &HEAT, &["current_sensor.peak_a=8"]].concat(), 90.0);
    for tick in 0..10_000 {
        assert_eq!(heard(&mut device).state, State::Armed, "{tick}");
        let held = (8.0 - STEP_A..8.0 + STEP_A).contains(&device.current_a());
        assert!(tick < 20 || held, "{tick}: {} A", device.current_a());
    }
    let expected = 1.0 / (1.0 - COPPER * K_PER_W * 64.0 * R);
    let found = device.temperatures().unwrap().resistance_ratio();
    // A step of the sensor is 0.4 % of the current.
    assert!((found - expected).abs() < 0.01 && expected > 1.25, "{found}, not {expected}");
}

/// At a constant voltage, `r (r - 1) = COPPER K_PER_W u^2 / R`.
#[test]
fn a_voltage_drives_less_current_through_a_hot_winding() {
    let mut device = blocked(&HEAT, 6.0);
    let lsb = device.device.parameters().unwrap().controller.drive.lsb;
    let mut output = heard(&mut device);
    for tick in 0..10_000 {
        output = heard(&mut device);
        assert_eq!(output.state, State::Armed, "{tick}");
    }
    let volts = f64::from(lsb) * f64::from(output.tick.code);
    let rise = COPPER * K_PER_W * volts * volts / R;
    let ratio = 0.5 + (0.25 + rise).sqrt();
    let (found, expected) = (device.current_a(), volts / (R * ratio));
    assert!((found - expected).abs() < 2e-3 * expected, "{found} A, not {expected} A");
    assert!(ratio > 1.05, "{volts} V, {ratio}");
}

/// A run and a servo in a run have the winding of the device: hot, it drives the joint less.
#[test]
fn a_run_simulates_the_heat_under_a_loop_and_a_servo() {
    let error = |set: &[&str], driver| {
        let mut plan = current_sensor(&["pd"], set).remove(0);
        plan.task = Task::Step(20.0);
        let result = run_driven(&plan, driver).unwrap();
        result.metrics
    };
    let hot = [&HEAT[..], &["motor.ambient_c=120"]].concat();
    for driver in [RunDriver::ByLoop, RunDriver::ByServo] {
        let [cold, warm] = [&HEAT[..], &hot].map(|set| format!("{:?}", error(set, driver)));
        assert_ne!(cold, warm, "{driver:?}");
    }
}
