//! A device that does not answer for a while, and what was driven meanwhile or by another client.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use simulator::device::clock::Clock;
use simulator::device::wire::Wire;
use stiction::servo::State;

use super::clock::breath;
use super::line::Line;
use super::page::{PATIENCE, Page, Visit, arm, run};
use super::{LINK_TIMEOUT_S, SLACK_S};

#[test]
fn a_device_that_was_out_of_reach_while_armed_from_here_is_stopped_first() {
    run(async {
        let line = Line::new(&["limits.link_timeout_s=30"]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        page.done(arm()).await;
        page.watch(Duration::from_millis(300)).await;
        line.is_cut.store(true, Ordering::SeqCst);
        let gone = page.event("gone").await;
        assert!(gone["said"].as_str().unwrap().contains("THE MOTOR MAY STILL BE DRIVEN"), "{gone}");
        let said = page.refused(json!({ "do": "move", "deg": 1.0 })).await;
        assert!(said.contains("does not answer"), "{said}");
        let before = line.names().len();
        line.is_cut.store(false, Ordering::SeqCst);
        page.event("back").await;
        let after = line.names().split_off(before);
        assert!(after[0].starts_with("Hello"), "a session begins with it: {after:?}");
        assert!(after[1].starts_with("Open"), "{after:?}");
        // The session before has the motor driven; a stop needs none.
        assert_eq!(after[2], "Stop", "{after:?}");
        let status = page.state("stopped").await;
        assert!(status["fault"].is_null(), "{status}");
    });
}

#[test]
fn a_page_that_opens_while_the_device_is_gone_receives_no_status_until_it_is_back() {
    run(async {
        let line = Line::new(&["limits.link_timeout_s=30"]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        page.done(arm()).await;
        page.state("armed").await;
        line.is_cut.store(true, Ordering::SeqCst);
        page.event("gone").await;
        let mut second = Visit::proper(&server).connect().await.unwrap();
        // The device is silent, so nothing comes behind what stood.
        let kinds: Vec<String> =
            second.come().await.iter().map(|e| e["event"].as_str().unwrap().to_owned()).collect();
        assert!(kinds.contains(&"hello".to_owned()), "{kinds:?}");
        assert!(kinds.contains(&"gone".to_owned()), "{kinds:?}");
        assert!(!kinds.contains(&"status".to_owned()), "a stale status: {kinds:?}");
        line.is_cut.store(false, Ordering::SeqCst);
        // It was stopped first, and a status comes again.
        second.state("stopped").await;
    });
}

#[test]
fn a_device_that_was_not_armed_from_here_is_left_alone_when_it_is_back() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        line.is_cut.store(true, Ordering::SeqCst);
        page.event("gone").await;
        let before = line.names().len();
        line.is_cut.store(false, Ordering::SeqCst);
        page.event("back").await;
        let after = line.names().split_off(before);
        assert!(!after.contains(&"Stop".to_owned()), "{after:?}");
    });
}

#[test]
fn a_stop_that_did_not_reach_the_device_is_said_once_it_is_back() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        line.is_cut.store(true, Ordering::SeqCst);
        let said = page.refused(json!({ "do": "stop" })).await;
        assert!(said.contains("not answer"), "{said}");
        let before = line.names().len();
        line.is_cut.store(false, Ordering::SeqCst);
        page.event("back").await;
        page.watch(Duration::from_millis(300)).await;
        let after = line.names().split_off(before);
        assert!(after.contains(&"Stop".to_owned()), "{after:?}");
    });
}

/// Sends requests far more often than the device is tried again, until an event comes.
async fn flooded(page: &mut Page, wanted: impl Fn(&Value) -> bool) -> Value {
    let begin = Instant::now();
    loop {
        page.send(&json!({ "do": "clear", "id": 200 })).await;
        if let Some(event) = page.come().await.into_iter().find(&wanted) {
            return event;
        }
        assert!(begin.elapsed() < PATIENCE, "it does not come");
        page.clock.step();
        breath().await;
    }
}

#[test]
fn a_device_that_is_gone_is_tried_again_and_a_stop_is_answered_however_many_orders_come() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        line.is_cut.store(true, Ordering::SeqCst);
        page.event("gone").await;
        page.send(&json!({ "id": 199, "do": "stop" })).await;
        let stop = flooded(&mut page, |event| event["id"] == 199).await;
        assert!(stop["said"].as_str().unwrap().contains("does not answer"), "{stop}");
        line.is_cut.store(false, Ordering::SeqCst);
        flooded(&mut page, |event| event["event"] == "back").await;
        let last = page.ask(json!({ "do": "clear" })).await;
        assert!(!last["said"].as_str().unwrap().contains("does not answer"), "{last}");
    });
}

#[test]
fn what_something_else_has_turned_on_is_not_kept_alive_by_the_studio() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        page.lives = false;
        page.watch(Duration::from_millis(400)).await;
        line.device.lock().unwrap().simulated.device.servo().arm().unwrap();
        page.state("armed").await;
        // It was asked once when a sample said so.
        page.hang(Duration::from_millis(200)).await;
        let before = line.names().len();
        page.hang(Duration::from_millis(1200)).await;
        let asked = line.names().split_off(before);
        assert!(asked.is_empty(), "{asked:?}");
        // It is asked again after 1 s and two link timeouts.
        page.hang(Duration::from_millis(1100)).await;
        let asked = line.names().split_off(before);
        assert_eq!(asked, ["Status"]);
        page.done(json!({ "do": "stop" })).await;
    });
}

#[test]
fn a_studio_that_ends_leaves_the_motor_to_the_link_timeout() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        page.done(arm()).await;
        page.watch(Duration::from_millis(500)).await;
        drop(server);
        let is_armed = || {
            let mut device = line.device.lock().unwrap();
            // The device goes on.
            line.clock.jump(Duration::from_millis(20));
            device.receive(Duration::ZERO).unwrap();
            device.simulated.device.servo().state() == State::Armed
        };
        assert!(is_armed());
        let begin = line.clock.now();
        let took_s = || (line.clock.now() - begin).as_secs_f64();
        while is_armed() && took_s() < 3.0 {}
        let allowed = LINK_TIMEOUT_S - 0.15..LINK_TIMEOUT_S + SLACK_S;
        assert!(allowed.contains(&took_s()), "{} s", took_s());
        let latched = line.device.lock().unwrap().simulated.device.servo().latched().unwrap();
        assert_eq!(latched.fault as u8, 22);
    });
}
