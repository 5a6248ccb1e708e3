//! The motor's heat: no law heats a blocked motor beyond what it bears forever, and a reset does
//! not cool it.
//!
//! The joint is the thesis's robot, whose motor bears a tenth of the full effort of 5 V. It is held
//! fast, and vibration moves the encoder to and fro, so that no monitor of the encoder sees it.

use experiments::controllers;
use simulator::device::simulated::SimulatedDevice;
use stiction::Fault;
use stiction::servo::{Boot, Refusal, State};

use crate::dead_encoder::{armed_with, step};
use crate::fixture::{parameters, plans};

const CONTINUOUS_V: f32 = 0.5;
const CONTINUOUS: &str = "limits.continuous_v=0.5";

/// Ticks of 20 ms in ten minutes.
const TEN_MINUTES: u32 = 30_000;

/// Half a swing of the vibration, counts: the count of the effort's impulse begins anew.
const SHAKEN: i32 = 4;

/// Runs a blocked joint under a law with an error; returns the largest heat (V) while the motor was
/// driven, the effort's mean square (V^2), and the fault.
fn blocked(law: &str, error_deg: f64) -> (f32, f32, Option<Fault>) {
    let mut device = armed_with(law, 1.0, &[CONTINUOUS]);
    device.brake_v = 100.0;
    step(&mut device, error_deg);
    let (mut hottest, mut squares, mut ticks) = (0.0f32, 0.0, 0);
    for k in 0..TEN_MINUTES {
        device.device.servo().heard();
        if k % 5 == 0 {
            device.jump(if k % 10 == 0 { SHAKEN } else { -SHAKEN });
        }
        let output = device.tick();
        if let State::Faulted(fault) = output.state {
            return (hottest, squares / ticks.max(1) as f32, Some(fault));
        }
        squares += output.tick.v_applied * output.tick.v_applied;
        ticks += 1;
        hottest = hottest.max(device.device.servo().thermal_effort());
    }
    (hottest, squares / ticks as f32, None)
}

#[test]
fn a_blocked_joint_on_a_shaken_machine_never_heats_its_motor_beyond_what_it_bears() {
    let mut hot = 0;
    for law in controllers() {
        for error_deg in [0.05, 0.3, 0.5, 0.6, 0.7, 1.0, 5.0] {
            let (hottest, mean_square, fault) = blocked(law, error_deg);
            let name = format!("{law}, {error_deg} deg: {hottest} V, {mean_square} V^2, {fault:?}");
            assert!(hottest <= CONTINUOUS_V, "{name}");
            // What goes on for ten minutes is what the motor bears, beside what it begins with.
            let borne = CONTINUOUS_V * CONTINUOUS_V;
            assert!(fault.is_some() || mean_square <= 1.02 * borne, "{name}");
            hot += u32::from(fault == Some(Fault::Overheat));
            reliability!(
                "blocked-and-shaken",
                law,
                error_deg,
                hottest_v = format!("{hottest:.2}"),
                fault = fault.map_or("none", Fault::describe)
            );
        }
    }
    assert!(hot > 0, "some effort is found by its heat alone");
}

/// An effort V trips after tau ln(1 / (1 - (c / V)^2)). The encoder swings by 4 counts, so that PD
/// asks for 0.7 V less 2 counts of 0.00242 V in the mean: 10 s and 0.5 of 0.695 V make 7.3 s.
#[test]
fn an_effort_below_every_other_threshold_trips_when_its_heat_does() {
    // More on average than the breakaway and no net travel would be a stall after 5 s.
    let breakaway = "limits.breakaway_v=0.7";
    let mut device = armed_with("pd", 1.0, &[CONTINUOUS, "device.soft_start_s=0", breakaway]);
    device.brake_v = 100.0;
    step(&mut device, 0.7);
    let ticks = (0..TEN_MINUTES).find(|k| {
        device.device.servo().heard();
        device.jump(if k % 2 == 0 { SHAKEN } else { -SHAKEN });
        device.tick().state == State::Faulted(Fault::Overheat)
    });
    let expected = 10.0 / 0.02 * (1.0 / (1.0 - (0.5f64 / 0.695).powi(2))).ln();
    let found = f64::from(ticks.unwrap());
    assert!((found / expected - 1.0).abs() < 0.02, "{found} ticks, and not {expected}");
}

/// The motor cools with its time constant of 10 s: from 0.6 V to 0.5 V takes 10 s ln(1.44).
#[test]
fn a_motor_that_was_hot_before_a_reset_is_hot_after_it() {
    let set = ["loop.controller=pd", "reference.steps_deg=[5.0]", CONTINUOUS];
    let plan = &plans("step-response", &set)[0];
    let ticks_to_arm = |thermal_effort: f32| {
        let boot = Boot { thermal_effort, ..Boot::default() };
        let mut device = SimulatedDevice::running(plan, &parameters(plan), boot).unwrap();
        device.ticks(10);
        let arms = |device: &mut SimulatedDevice| match device.device.servo().arm_for_link(None) {
            Ok(()) => true,
            Err(why) => {
                assert_eq!(why, Refusal::WouldTrip(Fault::Overheat));
                device.tick();
                false
            }
        };
        10 + (0..TEN_MINUTES).find(|_| arms(&mut device)).unwrap()
    };
    assert_eq!(ticks_to_arm(0.0), 10);
    assert_eq!(ticks_to_arm(0.49), 10);
    let found = f64::from(ticks_to_arm(0.6));
    let expected = 10.0 / 0.02 * 1.44f64.ln();
    assert!((found - expected).abs() < 2.0, "{found} ticks, and not {expected}");
}
