//! A loop that oscillates around a set point that rests: a warning, then a fault; and joints that
//! do not oscillate.
//!
//! The joint is the thesis's robot, with gains that make it swing.

use simulator::device::simulated::SimulatedDevice;
use stiction::Fault;
use stiction::servo::State;

use crate::dead_encoder::{armed_with, step};
use experiments::controllers;

/// Ticks of 20 ms in a minute.
const MINUTE: u32 = 3000;

/// The default `oscillation_s`, and the time of the warning, s.
const LIMIT_S: f64 = 30.0;
const WARNING_S: f64 = 3.0;

/// What became of a joint within a minute.
struct Run {
    state: State,
    /// Time until the fault, and until the warning, s.
    ends_s: f64,
    warned_s: Option<f64>,
    /// Way without its sign, deg.
    path: f64,
}

fn held(device: &mut SimulatedDevice, ticks: u32) -> Run {
    let (mut warned_s, mut path, mut tick) = (None, 0.0, 0);
    let mut before = device.position_deg();
    while tick < ticks && device.device.servo().state() == State::Armed {
        device.device.servo().heard();
        device.tick();
        tick += 1;
        let now = device.position_deg();
        path += (now - before).abs();
        before = now;
        if warned_s.is_none() && device.device.servo().is_oscillating() {
            warned_s = Some(f64::from(tick) * 0.02);
        }
    }
    let state = device.device.servo().state();
    Run { state, ends_s: f64::from(tick) * 0.02, warned_s, path }
}

/// Limits that let a loop swing up to the full scale.
const WIDE: [&str; 5] = [
    "limits.following_error_deg=off",
    "limits.overspeed_deg_per_s=off",
    "limits.encoder_jump_deg=off",
    "limits.stop_gain_deg_per_s2_per_v=off",
    "limits.continuous_v=off",
];

/// DNPF of eight times the thesis's gain swings by a few tenths of a degree, which no other monitor
/// detects: the joint went 1 028 deg to and fro in five minutes. `robust` has a guard of its own.
#[test]
fn a_loop_that_oscillates_is_reported_and_then_a_fault_under_every_law() {
    for law in controllers().filter(|law| *law != "robust") {
        let is_dnpf = law == "dnpf";
        let gain = format!("controller.{law}.kp_v_per_deg={}", if is_dnpf { 8 } else { 25 });
        let wide = if is_dnpf { &[][..] } else { &WIDE };
        let mut device = armed_with(law, 1.0, &[&[&*gain][..], wide].concat());
        step(&mut device, 0.5);
        let found = held(&mut device, MINUTE);
        let path_deg = format!("{:.0}", found.path);
        reliability!("oscillation", law, path_deg, after_s = format!("{:.1}", found.ends_s));
        assert_eq!(found.state, State::Faulted(Fault::Oscillation), "{law}");
        // A swing takes less than a second, and the series begins after the first ones.
        assert!((LIMIT_S..LIMIT_S + 3.0).contains(&found.ends_s), "{law}: {} s", found.ends_s);
        let warned_s = found.warned_s.unwrap();
        assert!((WARNING_S..WARNING_S + 3.0).contains(&warned_s), "{law}: {warned_s} s");
    }
}

/// Without the monitor it goes on.
#[test]
fn without_a_limit_of_its_time_an_oscillation_is_only_reported() {
    let set = ["controller.dnpf.kp_v_per_deg=8", "limits.oscillation_s=off"];
    let mut device = armed_with("dnpf", 1.0, &set);
    step(&mut device, 0.5);
    let found = held(&mut device, MINUTE);
    assert!(found.state == State::Armed && found.warned_s.is_some());
}

/// Something shakes the machine: the joint goes to and fro, and no effort of the loop does it.
#[test]
fn a_joint_that_is_shaken_does_not_oscillate() {
    let mut device = armed_with("pd", 1.0, &["controller.pd.kp_v_per_deg=0.1"]);
    for tick in 0..3 * MINUTE {
        device.device.servo().heard();
        let shaken = 0.2 * (f64::from(tick) * 0.02 * 2.0 * std::f64::consts::TAU).sin().abs();
        device.push(shaken, 0.0);
        assert_eq!(device.tick().state, State::Armed, "{tick}");
        assert!(!device.device.servo().is_oscillating(), "{tick}");
    }
}

/// A set point that goes to and fro takes the joint with it.
#[test]
fn a_joint_that_follows_its_set_point_to_and_fro_does_not_oscillate() {
    for law in controllers() {
        let mut device = armed_with(law, 1.0, &[]);
        for tick in 0..MINUTE {
            if tick % 40 == 0 {
                step(&mut device, if tick % 80 == 0 { 1.0 } else { 0.0 });
            }
            device.device.servo().heard();
            assert_eq!(device.tick().state, State::Armed, "{law}, {tick}");
            assert!(!device.device.servo().is_oscillating(), "{law}, {tick}");
        }
    }
}
