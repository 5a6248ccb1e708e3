//! The wake-up of the bridge's driver: the enable pin before the first duty, and low for long
//! enough before it.

use files::hardware::STM32F405;
use stiction::parameters::names::ValuePath;
use stiction::servo::{Boot, ControlLoop, Input, Output, State};
use stiction::{Fault, Parameters, Servo};

use crate::fixture::srnf;

/// A servo that has ticked for long enough to be at rest, in seven ticks of 20 ms.
fn at_rest(set: &[&str]) -> Servo {
    let parameters: Parameters = srnf(set);
    let mut servo = Servo::new(Ok(&parameters), Boot::default(), &STM32F405);
    for _ in 0..7 {
        tick(&mut servo, 0);
    }
    servo
}

fn tick(servo: &mut Servo, counter: u32) -> Output {
    servo.tick(Input { counter, supply: STM32F405.supply_top, lines: 0, ..Input::default() })
}

/// Pins of the bridge: wake-up and enable.
fn pins(output: &Output) -> (bool, bool) {
    (output.wakes, output.enable)
}

#[test]
fn the_driver_is_enabled_for_its_wake_up_and_the_loop_is_then_as_without_one() {
    for (wake_up, ticks) in [("0", 0), ("0.001", 1), ("0.02", 1), ("0.05", 3), ("1", 50)] {
        let mut plain = at_rest(&["device.soft_start_s=0"]);
        let mut waking =
            at_rest(&["device.soft_start_s=0", &format!("device.wake_up_s={wake_up}")]);
        plain.arm().unwrap();
        waking.arm().unwrap();
        for left in (0..ticks).rev() {
            let output = tick(&mut waking, 0);
            assert_eq!((pins(&output), output.state), ((true, false), State::Armed), "{left} left");
            // Nothing is computed, so nothing winds up.
            assert_eq!((output.tick.code, output.tick.tick, output.tick.v_c), (0, 0, 0.0));
        }
        // Before the stall of this joint, which does not move: 0.125 s at the full scale.
        for _ in 0..6 {
            let (expected, found) = (tick(&mut plain, 0), tick(&mut waking, 0));
            assert_eq!((found.tick, pins(&found)), (expected.tick, (false, true)), "{wake_up} s");
        }
    }
}

#[test]
fn a_joint_that_is_turned_during_the_wake_up_begins_where_it_is_then() {
    let mut servo = at_rest(&["device.wake_up_s=0.1", "device.soft_start_s=0"]);
    servo.arm().unwrap();
    // It is turned in all of the wake-up, which lasts until it has rested for 50 ms.
    (1..=5).for_each(|tick_of_it| assert!(tick(&mut servo, 40 * tick_of_it).wakes));
    let mut waits = 0;
    let first = loop {
        let output = tick(&mut servo, 200);
        if !output.wakes {
            break output;
        }
        waits += 1;
    };
    assert_eq!(waits, 3);
    // No count of it is in the error of the 5 deg, nor in the velocity.
    assert_eq!((first.tick.counts, first.tick.velocity, first.enable), (0, 0.0, true));
}

#[test]
fn a_link_that_falls_silent_in_the_wake_up_moves_nothing() {
    let mut servo = at_rest(&["device.wake_up_s=1", "limits.link_timeout_s=0.5"]);
    servo.arm_for_link(None).unwrap();
    let woken = (0..50).take_while(|_| tick(&mut servo, 0).wakes).count();
    // 0.5 s are 25 ticks.
    assert_eq!((woken, servo.state()), (25, State::Faulted(Fault::LinkTimeout)));
}

#[test]
fn a_stop_or_a_fault_ends_the_wake_up_and_the_next_one_is_whole() {
    let mut servo = at_rest(&["device.wake_up_s=0.1"]);
    for ends in [Servo::stop, |servo: &mut Servo| servo.fault(Fault::BreakInput)] {
        servo.arm().unwrap();
        assert!(tick(&mut servo, 0).wakes && tick(&mut servo, 0).wakes);
        ends(&mut servo);
        assert_eq!(pins(&tick(&mut servo, 0)), (false, false));
        servo.clear().unwrap();
        servo.arm().unwrap();
        let woken = (0..20).take_while(|_| tick(&mut servo, 0).wakes).count();
        assert_eq!(woken, 5);
        servo.stop();
    }
}

#[test]
fn the_enable_pin_is_low_for_the_reset_pulse_before_it_rises_again() {
    let mut servo = at_rest(&["device.wake_up_s=0.04", "device.reset_pulse_s=0.2"]);
    // It has been low for seven ticks since power-on: three more make 0.2 s.
    servo.arm().unwrap();
    let pulses = |servo: &mut Servo| (0..13).map(|_| pins(&tick(servo, 0))).collect::<Vec<_>>();
    let (off, wakes, on) = ((false, false), (true, false), (false, true));
    assert_eq!(pulses(&mut servo)[..6], [off, off, off, wakes, wakes, on]);
    // A fault that is cleared at once. The tick of the fault is the first with the pin low.
    servo.fault(Fault::BreakInput);
    assert_eq!(pins(&tick(&mut servo, 0)), off);
    servo.clear().unwrap();
    servo.arm().unwrap();
    let seen = pulses(&mut servo);
    assert_eq!(seen.iter().position(|&pins| pins == wakes), Some(9));
    assert_eq!(seen.iter().position(|&pins| pins == on), Some(11));
    // After a long rest there is nothing to wait for.
    servo.stop();
    for _ in 0..40 {
        tick(&mut servo, 0);
    }
    servo.arm().unwrap();
    assert_eq!(pulses(&mut servo)[..3], [wakes, wakes, on]);
}

#[test]
fn parameters_with_another_sample_time_do_not_shorten_the_reset_pulse() {
    let pulse = 0.2;
    let with = |sample_time: &str| {
        let times = [&format!("device.reset_pulse_s={pulse}"), "device.wake_up_s=0.01"];
        srnf(&[times[0], times[1], &format!("loop.sample_time_s={sample_time}")])
    };
    // Ticks of 1 ms, a hundred of which are half of the pulse, and ten times that of 10 ms.
    for (former, ticks, latter) in [("0.001", 100, "0.01"), ("0.01", 10, "0.001")] {
        let mut servo = Servo::new(Ok(&with(former)), Boot::default(), &STM32F405);
        for _ in 0..100 {
            tick(&mut servo, 0);
        }
        servo.arm().unwrap();
        while !tick(&mut servo, 0).enable {}
        servo.stop();
        for _ in 0..ticks {
            assert_eq!(pins(&tick(&mut servo, 0)), (false, false));
        }
        let mut after = None;
        ControlLoop::prepare(&mut after, &with(latter), &STM32F405).unwrap();
        servo.install(&mut after).unwrap();
        let tick_s: f64 = latter.parse().unwrap();
        // The joint has to rest anew: some ticks with the pin low.
        let mut low = 0;
        while servo.arm().is_err() {
            assert_eq!(pins(&tick(&mut servo, 0)), (false, false));
            low += 1;
        }
        while !tick(&mut servo, 0).wakes {
            low += 1;
        }
        // From the install on at least a whole pulse, and one tick more.
        let low_s = f64::from(low) * tick_s;
        assert!((pulse - 1e-9..pulse + 1.5 * tick_s).contains(&low_s), "{former}: {low_s} s");
    }
}

#[test]
fn no_duty_goes_without_the_break_input() {
    // The blanking may not outlast the wake-up, in which there is no duty.
    let mut parameters = srnf(&["device.wake_up_s=0.005", "device.fault_blanking_s=0.005"]);
    assert_eq!(parameters.check(), Ok(()));
    parameters.device.fault_blanking = 0.005_001;
    assert_eq!(
        ValuePath(parameters.check().unwrap_err().key).to_string(),
        "device.fault_blanking_s"
    );
    for (sample_time, s) in [(0.001, 0.001), (0.001, 0.003), (0.000_1, 0.05), (0.02, 0.05)] {
        parameters.controller.sample_time = sample_time;
        let ticks = parameters.ticks_at_least(s);
        let time = f64::from(ticks) * f64::from(sample_time);
        assert!(time >= f64::from(s) * (1.0 - 1e-6), "{ticks} of {sample_time} for {s}");
        assert!(time < f64::from(s) + 2.0 * f64::from(sample_time));
    }
}
