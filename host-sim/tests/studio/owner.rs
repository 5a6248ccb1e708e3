//! A device that another client drives, and one that another client takes over from the studio.

use std::time::Duration;

use serde_json::json;
use simulator::device::client::Client;
use simulator::device::wire::SimulatedWire;
use stiction::link::{NO_SESSION, PROTOCOL, Request, encode_request};
use stiction::servo::State;

use super::line::Line;
use super::page::{Page, arm, device, run};

/// The owner of the tests stays silent for longer than they take.
const PATIENT: [&str; 1] = ["limits.link_timeout_s=30"];

/// A line to a device that another client has armed.
fn owned() -> Line {
    let mut owner = Client::connect(SimulatedWire::new(device(&PATIENT))).unwrap();
    owner.pass(Duration::from_millis(200)).unwrap();
    owner.arm().unwrap();
    Line::around(owner.end().simulated)
}

fn state(line: &Line) -> State {
    line.device.lock().unwrap().simulated.device.servo().state()
}

#[test]
fn a_studio_shows_a_motor_that_another_client_drives_and_takes_over_if_a_page_says_so() {
    run(async {
        let line = owned();
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let status = page.state("armed").await;
        assert_eq!(status["guest"], true, "{status}");
        let said = page.refused(json!({ "do": "move", "deg": 1.0 })).await;
        assert!(said.contains("another client has the motor driven"), "{said}");
        assert_eq!(state(&line), State::Armed);
        page.done(json!({ "do": "take-over" })).await;
        assert_eq!(state(&line), State::Stopped);
        let status = page.state("stopped").await;
        assert_eq!(status["guest"], false, "{status}");
        page.watch(Duration::from_millis(200)).await;
        page.done(arm()).await;
        let rows = page.rows.len();
        page.watch(Duration::from_millis(300)).await;
        assert!(page.rows.len() > rows, "the owner receives samples");
        page.done(json!({ "do": "stop" })).await;
    });
}

#[test]
fn a_page_of_a_studio_that_is_a_guest_stops_the_motor() {
    run(async {
        let line = owned();
        let server = line.serve();
        let mut page = Page::open(&server).await;
        page.state("armed").await;
        page.done(json!({ "do": "stop" })).await;
        assert_eq!(state(&line), State::Stopped);
        // Nothing is driven, so the studio has the device.
        page.until(|event| event["event"] == "status" && event["guest"] == false).await;
    });
}

#[test]
fn a_studio_whose_device_was_taken_over_is_a_guest_and_does_not_stop_the_new_owner() {
    run(async {
        let line = Line::new(&PATIENT);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        page.done(arm()).await;
        page.state("armed").await;
        {
            let mut wire = line.device.lock().unwrap();
            let mut say = |session, number, request| {
                let bytes = encode_request(session, number, request).unwrap();
                wire.simulated.device.receive(&bytes);
                wire.simulated.ticks(100);
                wire.simulated.device.session()
            };
            say(NO_SESSION, 1, Request::TakeOver);
            say(NO_SESSION, 2, Request::Hello { protocol: PROTOCOL, session: 9 });
            let session = say(NO_SESSION, 3, Request::Open { hello: 9 });
            say(session, 4, Request::Arm);
        }
        assert_eq!(state(&line), State::Armed);
        let before = line.names().len();
        let gone = page.event("gone").await;
        assert!(gone["said"].as_str().unwrap().contains("another client"), "{gone}");
        page.event("back").await;
        let status = page.state("armed").await;
        assert_eq!(status["guest"], true, "{status}");
        let after = line.names().split_off(before);
        assert!(!after.contains(&"Stop".to_owned()), "{after:?}");
        assert_eq!(state(&line), State::Armed);
    });
}
