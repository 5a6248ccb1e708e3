//! The ramp that finds the friction of a joint, asked for over the link.

use std::time::Duration;

use dynamics::solver::ExactAxis;
use simulator::device::client::Client;
use simulator::device::wire::SimulatedWire;
use simulator::experiment::Task;
use stiction::Fault;
use stiction::link::StateCode;
use stiction::servo::FrictionLevels;

use super::client;
use crate::fixture::plans;

/// Lets a ramp run to its end, and returns what it has found.
fn identified(client: &mut Client<SimulatedWire>) -> Option<FrictionLevels> {
    while client.pass(Duration::from_secs(1)).unwrap().state == StateCode::Armed {}
    client.levels().unwrap()
}

/// The simulator is the second method: it runs the same joint under the core's ramp, without a
/// servo, monitors or a link.
#[test]
fn a_ramp_over_the_link_finds_the_levels_of_the_experiment() {
    for plan in plans("friction-identification", &[]) {
        let Task::Ramp(rate) = plan.task else { panic!() };
        let (ramp, around) = (plan.ramp(rate).unwrap(), plan.closed_loop().unwrap());
        let mut solver = ExactAxis::at_rest(&around.axis, around.sample_time_s);
        let expected = ramp.run(&mut solver, &around, |_| {}, |_| {});

        let mut client = client();
        assert_eq!(client.levels().unwrap(), None);
        client.identify(ramp.rate as f32, ramp.hold_s as f32).unwrap();
        let found = identified(&mut client).unwrap();
        let status = client.status().unwrap();
        assert_eq!((status.state, status.faults, status.at_rest), (StateCode::Stopped, 0, true));
        // Levels are whole rungs. Both methods find the same ones, and their volts agree to single
        // precision.
        let rung_v = rate * around.sample_time_s;
        for (found, expected) in [(found.stick, expected.stick_v), (found.slip, expected.slip_v)] {
            let (found, expected) = (f64::from(found.unwrap()), expected.unwrap());
            assert_eq!(
                (found / rung_v).round(),
                (expected / rung_v).round(),
                "{rate}: {found} {expected}"
            );
            assert!((found - expected).abs() < 1e-6 * expected, "{rate}: {found} {expected}");
        }
        // Stick is late by what the effort rises until a count is seen, slip by the joint's lag of
        // 1.85 s; each is off by half an LSB besides.
        let (stick, slip) = (f64::from(found.stick.unwrap()), f64::from(found.slip.unwrap()));
        assert!(stick > 0.40 - 0.0025 && stick < 0.40 + 0.0025 + 0.6 * rate, "{rate}: {stick}");
        assert!(slip < 0.38 + 0.0025 && slip > 0.38 - 0.0025 - 2.5 * rate, "{rate}: {slip}");
    }
}

#[test]
fn a_ramp_begins_like_arming_and_obeys_nothing_but_a_stop() {
    let said = |error: files::Error| error.to_string();
    let mut client = client();
    // The rate is faster than the output's limit rises after arming: 5 V in 0.5 s.
    let message = said(client.identify(10.1, 1.0).unwrap_err());
    let allowed = "`identification.ramp_rates_v_per_s` is 10.1; must be a number from 0 to 10";
    assert!(message.contains(allowed), "{message}");
    let message = said(client.identify(0.02, -1.0).unwrap_err());
    assert!(message.contains("`identification.hold_s` is -1"), "{message}");

    // A ramp begins only when the device is stopped, at rest and without a fault.
    client.arm().unwrap();
    assert!(said(client.identify(0.02, 1.0).unwrap_err()).contains("`stop` first"));
    client.stop().unwrap();
    client.wire().simulated.push(0.0, 20.0);
    client.wire().simulated.ticks(5);
    assert!(said(client.identify(0.02, 1.0).unwrap_err()).contains("at rest"));
    client.pass(Duration::from_secs(10)).unwrap();
    client.wire().simulated.device.servo().fault(Fault::Overrun);
    assert!(said(client.identify(0.02, 1.0).unwrap_err()).contains("fault 5"));
    client.clear().unwrap();

    // During the ramp the device takes no move, and the ramp goes on.
    client.identify(0.1, 1.0).unwrap();
    client.pass(Duration::from_secs(1)).unwrap();
    assert!(said(client.step_to(1.0).unwrap_err()).contains("`stop` first"));
    assert!(said(client.hold().unwrap_err()).contains("`stop` first"));
    assert_eq!(
        (client.levels().unwrap(), client.status().unwrap().state),
        (None, StateCode::Armed)
    );
    let found = identified(&mut client).unwrap();
    assert!(found.stick.is_some() && found.slip.is_some(), "{found:?}");

    // A ramp that is stopped has found nothing, and what the one before it had found is gone.
    client.identify(0.1, 1.0).unwrap();
    client.pass(Duration::from_secs(1)).unwrap();
    client.stop().unwrap();
    assert!(!client.wire().simulated.tick().enable);
    assert_eq!(client.levels().unwrap(), None);

    // Without a client the output goes off after 0.5 s, as for any arming by a link.
    client.identify(0.1, 1.0).unwrap();
    client.wire().simulated.ticks(24);
    assert!(client.wire().simulated.tick().enable);
    assert!(!client.wire().simulated.ticks(2).enable);
    assert_eq!(client.status().unwrap().fault.code, Fault::LinkTimeout as u8);
}

/// The impulse without a count ends a ramp against a block, long before the full scale.
#[test]
fn a_ramp_against_a_block_stalls() {
    let mut client = client();
    client.wire().simulated.brake_v = 100.0;
    client.identify(0.1, 1.0).unwrap();
    assert_eq!(identified(&mut client), None);
    let fault = client.status().unwrap().fault;
    assert_eq!(fault.code, Fault::Stall as u8);
    // The ramp rises by 0.1 V/s. Beyond the breakaway effort of 0.4 V, 0.2 V s are let through:
    // they are 0.05 V for the first half of a second, and e^2/2r - 0.05^2/2r after it, so e is
    // 0.194 V. Codes of 4.88 mV make that uncertain by 2 %.
    assert!((0.590..0.598).contains(&fault.value), "{}", fault.value);
}
