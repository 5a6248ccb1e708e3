//! Arming, steps and holds that a client asks for, and where the joint is afterwards.

use std::time::Duration;

use stiction::Motion;
use stiction::link::StateCode;
use stiction::units::position::Position;

use super::client;

#[test]
fn a_client_arms_moves_and_stops_a_joint() {
    let mut client = client();
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
    client.arm().unwrap();
    client.step_to(5.0).unwrap();
    let status = client.pass(Duration::from_secs(3)).unwrap();
    assert_eq!((status.state, status.at_rest, status.unsaved), (StateCode::Armed, true, false));
    let error = client.wire().simulated.position_deg() - 5.0;
    assert!(error.abs() < 0.01, "{error}");
    client.stop().unwrap();
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
    assert_eq!(client.faults().unwrap(), []);
}

#[test]
fn a_hold_stops_the_joint_where_it_is() {
    let mut client = client();
    client.arm().unwrap();
    client.step_to(10.0).unwrap();
    client.pass(Duration::from_millis(600)).unwrap();
    let at = client.wire().simulated.position_deg();
    client.hold().unwrap();
    client.pass(Duration::from_secs(3)).unwrap();
    let after = client.wire().simulated.position_deg();
    // The joint was on its way. When it is stopped from 20 deg/s, it overshoots by less than 0.46
    // (20 / 5.2) = 1.8 deg, and then it comes back.
    assert!(at > 2.0 && at < 9.0, "{at}");
    // It holds where it was at the last tick, up to 20 ms at 25 deg/s before.
    assert!((after - at).abs() < 0.5, "{at} {after}");
    assert_eq!(client.status().unwrap().state, StateCode::Armed);
}

#[test]
fn a_move_says_where_and_not_how_far() {
    let mut client = client();
    client.arm().unwrap();
    for _ in 0..3 {
        client.move_along(Motion::Step(Position::from_counts(1000))).unwrap();
        client.pass(Duration::from_secs(2)).unwrap();
    }
    let position = client.status().unwrap().position;
    assert!((position - 1000).abs() < 5, "{position}");
}

/// A move that holds is no move to zero.
#[test]
fn a_move_that_holds_stays_where_the_joint_is_however_often_it_is_said() {
    let mut client = client();
    client.arm().unwrap();
    client.step_to(5.0).unwrap();
    client.pass(Duration::from_secs(3)).unwrap();
    let at = client.wire().simulated.position_deg();
    assert!((at - 5.0).abs() < 0.03, "{at}");
    for _ in 0..3 {
        client.move_along(Motion::Hold).unwrap();
        let counts = client.status().unwrap().position;
        assert_eq!(client.wire().simulated.tick().tick.reference_counts, counts);
        client.pass(Duration::from_secs(2)).unwrap();
        let after = client.wire().simulated.position_deg();
        assert!((after - at).abs() < 0.03, "{at} {after}");
    }
}

/// A hold that the parameters have is where the joint is armed, also far from where it was at
/// power-on.
#[test]
fn a_motion_of_the_parameters_that_holds_stays_where_the_joint_is_armed() {
    let mut client = client();
    let parameters = stiction::Parameters { motion: Motion::Hold, ..client.parameters().unwrap() };
    client.set_parameters(&parameters).unwrap();
    client.wire().simulated.push(10.0, 0.0);
    client.pass(Duration::from_secs(1)).unwrap();
    let at = client.wire().simulated.position_deg();
    client.wire().simulated.device.servo().arm().unwrap();
    client.pass(Duration::from_secs(2)).unwrap();
    let after = client.wire().simulated.position_deg();
    assert!(at > 9.0 && (after - at).abs() < 1e-9, "{at} {after}");
    assert_eq!(client.status().unwrap().state, StateCode::Armed);
}
