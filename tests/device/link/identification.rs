//! The identification of a joint, asked for over the link. The joint is the thesis's: 27 deg/s^2
//! per V, 0.02 V s/deg, 0.40 V to start it and 0.38 V to keep it moving.

use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::device::wire::SimulatedWire;
use simulator::hardware::STM32F405;
use stiction::identification::{Asked, Outcome, Search, Summary};
use stiction::link::{Kind, Machine, Refused, Reply, Request, Session, StateCode};
use stiction::parameters::Parameters;
use stiction::servo::{Boot, Servo};
use stiction::{Fault, Hardware};

use super::{client, frame, hello, replies};
use crate::fixture::{parameters, plans};

fn identified(client: &mut Client<SimulatedWire>, asked: Asked) -> Option<Summary> {
    client.identify_joint(asked).unwrap();
    while client.pass(Duration::from_secs(1)).unwrap().state == StateCode::Armed {}
    client.identified().unwrap().map(|(summary, _)| summary)
}

#[test]
fn a_joint_is_told_within_the_bounds_of_the_proof_and_the_output_is_off() {
    let mut client = client();
    assert_eq!(client.identified().unwrap(), None);
    let summary = identified(&mut client, Asked::default()).unwrap();
    let status = client.status().unwrap();
    assert_eq!((status.state, status.faults, status.at_rest), (StateCode::Stopped, 0, true));
    assert_eq!((summary.outcome, summary.doubts.is_none()), (Outcome::Done, true), "{summary:?}");
    let estimate = summary.estimate.unwrap();
    for (found, truth, share) in [
        (summary.breakaway[0].median, 0.40, 0.03),
        (summary.breakaway[1].median, 0.40, 0.03),
        (estimate.coulomb[0], 0.38, 0.03),
        (estimate.viscous[0], 0.02, 0.1),
        (estimate.inertia[0], 1.0 / 27.0, 0.05),
    ] {
        assert!((found / truth - 1.0).abs() < share, "{found} {truth} {summary:?}");
    }
    // It stays within its travel of 45 deg, and says so.
    assert!((30.0..90.0).contains(&summary.range), "{summary:?}");
    // Whatever arms next takes its place.
    client.arm().unwrap();
    assert_eq!(client.identified().unwrap(), None);
}

#[test]
fn it_begins_like_arming_refuses_more_than_the_device_allows_and_obeys_nothing_but_a_stop() {
    let said = |error: simulator::Error| error.to_string();
    let mut client = client();
    let ask = |asked| Asked { effort: Some(asked), ..Asked::default() };
    let message = said(client.identify_joint(ask(5.1)).unwrap_err());
    assert!(
        message.contains("`identification.effort_v` is 5.1; allowed is a number above 0, up to 5"),
        "{message}"
    );
    for asked in [
        ask(0.0),
        ask(f32::NAN),
        Asked { travel: Some(721.0), ..Asked::default() },
        Asked { travel: Some(0.1), ..Asked::default() },
        Asked { speed: Some(1e5), ..Asked::default() },
        Asked { time: Some(1801.0), ..Asked::default() },
    ] {
        assert!(client.identify_joint(asked).is_err(), "{asked:?}");
    }
    client.identify_joint(Asked::default()).unwrap();
    client.pass(Duration::from_secs(5)).unwrap();
    assert!(said(client.move_to(1.0).unwrap_err()).contains("stop"));
    assert!(client.arm().is_err());
    client.stop().unwrap();
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
    assert_eq!(client.identified().unwrap(), None);
}

#[test]
fn wires_that_are_wrong_end_it_at_the_first_step_in_words() {
    for (wires, outcome) in [(Wires::Swapped, Outcome::Reversed), (Wires::Cut, Outcome::Still)] {
        let mut device = SimulatedDevice::new(&plans("step-response", &[])[0]).unwrap();
        device.wires = wires;
        device.ticks(10);
        let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
        // As much effort as starts it, so that the stall's monitor does not come first.
        let asked = Asked { effort: Some(0.6), ..Asked::default() };
        let found = identified(&mut client, asked);
        let status = client.status().unwrap();
        match found {
            Some(summary) => {
                assert_eq!(summary.outcome, outcome, "{wires:?}: {summary:?}");
                assert!(summary.steps <= 2 && summary.range < 1.0, "{summary:?}");
            }
            // A dead encoder at more than the breakaway effort is a stall.
            None => assert_eq!((wires, status.fault.code), (Wires::Cut, Fault::Stall as u8)),
        }
        assert_ne!(status.state, StateCode::Armed);
    }
}

/// In the second of a pulse of 0.63 V it goes 27 (0.63 - 0.38) / 2 deg less what is viscous: 3 deg,
/// which are 50 counts.
#[test]
fn a_joint_of_few_counts_that_slides_is_not_taken_for_one_that_stands() {
    let coarse = "encoder.resolution_deg=0.06";
    let mut device = SimulatedDevice::new(&plans("step-response", &[coarse])[0]).unwrap();
    device.ticks(10);
    let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
    let asked = Asked { effort: Some(0.7), travel: Some(60.0), ..Asked::default() };
    let found = identified(&mut client, asked);
    let summary = found.unwrap_or_else(|| panic!("{:?}", client.status().unwrap()));
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
    let [inertia, deviation] = summary.estimate.unwrap().inertia;
    assert!((inertia - 1.0 / 27.0).abs() < 4.0 * deviation.max(0.0025), "{summary:?}");
}

/// A servo with nothing around it.
struct Bare(Servo);

impl Machine for Bare {
    fn servo<R>(&mut self, act: impl FnOnce(&mut Servo) -> R) -> R {
        act(&mut self.0)
    }

    fn hardware(&self) -> Hardware {
        STM32F405
    }

    fn save(&mut self, _: &Parameters) -> Result<(), Refused> {
        Ok(())
    }

    fn reconfigure(&mut self, _: &Parameters) -> Result<(), Refused> {
        Ok(())
    }
}

/// The fits take a board longer than its watchdog waits, so it makes them piece by piece.
#[test]
fn the_answer_with_the_fits_comes_once_at_its_end_and_not_after_another_request() {
    let parameters = parameters(&plans("step-response", &["loop.controller=srnf"])[0]);
    let mut bare = Bare(Servo::new(Ok(&parameters), Boot::default(), &STM32F405));
    let mut session: Session = Session::new(Kind::Simulated, Some(parameters));
    session.receive(&hello(1, 7), &mut bare);
    let said = |session: &mut Session| {
        let mut buffer = [0; 4096];
        let count = session.transmit(&mut buffer);
        replies(&buffer[..count])
    };
    said(&mut session);
    let read = |number| frame(number, Request::ReadIdentification);
    let nothing = |number| vec![(number, Reply::Identification(None))];
    session.receive(&read(2), &mut bare);
    // It comes twice before there is an answer.
    session.receive(&read(2), &mut bare);
    assert_eq!(said(&mut session), []);
    while session.work(&mut bare) {}
    assert_eq!(said(&mut session), nothing(2));
    // And once more after it.
    session.receive(&read(2), &mut bare);
    assert!(!session.work(&mut bare));
    assert_eq!(said(&mut session), nothing(2));
    for (number, other) in [(4, Request::Stop), (6, Request::Clear)] {
        session.receive(&read(number - 1), &mut bare);
        session.receive(&frame(number, other), &mut bare);
        assert!(!session.work(&mut bare));
        assert_eq!(said(&mut session), [(number, Reply::Done)]);
    }
}

#[test]
fn the_fits_take_more_than_a_piece() {
    let mut client = client();
    identified(&mut client, Asked::default()).unwrap();
    let found = *client.wire().simulated.device.servo().identified().unwrap();
    let (mut search, mut pieces) = (Search::default(), 1);
    while !search.go_on(&found.model, found.range) {
        pieces += 1;
    }
    // Thirty-two steps at most are looked at in a pass, seven at most in a piece.
    assert!((6..=13).contains(&pieces), "{pieces}");
    assert_eq!(found.summary_of(&search), found.summary());
}
