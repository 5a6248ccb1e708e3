//! The wires of the encoder are swapped, before the first move or on the way.

use simulator::device::simulated::Wires;
use stiction::Fault;
use stiction::servo::State;

use super::Situation::{Moving, Saturated};
use super::device_under_test::{DeviceUnderTest, harder};
use experiments::controllers;

/// Swapped wires make the loop push away from the target. The monitor sees that within the first
/// hundredths of a degree.
#[test]
fn a_reversed_encoder_is_seen_in_the_first_move_under_every_law() {
    let mut furthest = 0.0f64;
    for law in controllers() {
        let mut device = DeviceUnderTest::new(law, &[]);
        device.simulated().wires = Wires::Swapped;
        device.client.arm().unwrap();
        device.client.step_to(5.0).unwrap();
        let output =
            (0..60).map(|_| device.pass(1)).find(|output| output.state != State::Armed).unwrap();
        assert_eq!(output.state, State::Faulted(Fault::EncoderReversed), "{law}");
        // Eight counts are 0.019 deg; at the speed that the joint has by then, a tick is a little
        // more.
        let travel = device.simulated().position_deg();
        assert!(travel > 0.015 && travel < 0.2, "{law}: {travel} deg");
        furthest = furthest.max(travel);
        device.check_latched(law, Fault::EncoderReversed, |_| {});
    }
    reliability!("reversed-at-first", travel_deg = format!("{furthest:.3}"));
}

/// Once a move has proven the wiring, swapped wires make the loop run away.
#[test]
fn an_encoder_that_is_reversed_on_the_way_is_seen_before_it_has_gone_far() {
    for law in controllers() {
        for situation in [Moving, Saturated] {
            let mut device = DeviceUnderTest::new(law, harder(law, situation));
            device.bring(situation);
            let from = device.simulated().position_deg();
            device.simulated().wires = Wires::Swapped;
            let output =
                (0..200).map(|_| device.pass(1)).find(|output| output.state != State::Armed);
            let State::Faulted(fault) = output.unwrap().state else { panic!() };
            assert_eq!(fault, Fault::FollowingError, "{law} {situation:?}");
            let travel = (device.simulated().position_deg() - from).abs();
            let (fault, situation) = (fault.describe(), format!("{situation:?}").to_lowercase());
            reliability!("reversed", law, situation, fault, travel_deg = format!("{travel:.1}"));
            // What is read goes back by the limit at the full scale: from 17 deg/s at the most,
            // since 5 V (135 deg/s^2) have driven it for 6 ticks, and it goes on for two ticks at
            // the speed that it has at the end. The limit is 5 deg, and the speed 41 deg/s; under
            // `robust` it is 5 V / (J w_n^2) = 2.76 deg, and 32 deg/s. On a line the set point
            // makes some of the limit, with 5 deg/s: for half a second at most, since even PD asks
            // for 1.5 V (30 deg/s^2) by its damping alone; under `robust` for 0.3 s, since its
            // damping asks for 0.45 V s/deg, which are 2.2 V (60 deg/s^2).
            let (limit, line_s) = if law == "robust" { (2.755, 0.3) } else { (5.0, 0.5) };
            let least = if situation == "saturated" { limit } else { limit - 5.0 * line_s };
            let speed = (17.0f64.powi(2) + 2.0 * 135.0 * limit).sqrt();
            let expected = least..limit + 2.0 * 0.02 * speed + 0.1;
            assert!(expected.contains(&travel), "{law} {situation:?}: {travel}");
        }
    }
}
