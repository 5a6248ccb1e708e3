//! A device that does not answer for a while, and what was driven meanwhile or by another client.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use serde_json::json;
use simulator::device::wire::Wire;
use stiction::servo::State;
use tokio::time::timeout;

use super::line::Line;
use super::page::{Page, Visit, arm, run};
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
        assert_eq!(after[1], "Stop", "{after:?}");
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
        let mut kinds = vec![];
        while let Ok(event) = timeout(Duration::from_millis(300), second.next()).await {
            kinds.push(event.unwrap()["event"].as_str().unwrap().to_owned());
        }
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

#[test]
fn a_device_that_is_gone_is_tried_again_and_a_stop_is_answered_however_many_orders_come() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        line.is_cut.store(true, Ordering::SeqCst);
        page.event("gone").await;
        // Five times a second, and the time between two tries is one.
        for id in 200..215 {
            if id == 202 {
                page.send(&json!({ "id": 299, "do": "stop" })).await;
            }
            if id == 207 {
                line.is_cut.store(false, Ordering::SeqCst);
            }
            page.send(&json!({ "id": id, "do": "clear" })).await;
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
        let (mut stop, mut last) = (None, None);
        while stop.is_none() || last.is_none() {
            let answer = page.event("answer").await;
            match answer["id"].as_u64() {
                Some(299) => stop = Some(answer["said"].clone()),
                Some(214) => last = Some(answer["said"].clone()),
                _ => {}
            }
        }
        let (stop, last) = (stop.unwrap(), last.unwrap());
        assert!(stop.as_str().unwrap().contains("does not answer"), "{stop}");
        assert!(!last.as_str().unwrap().contains("does not answer"), "{last}");
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
        // It was asked once when a sample said so. (To watch would wait for an event.)
        tokio::time::sleep(Duration::from_millis(200)).await;
        let before = line.names().len();
        tokio::time::sleep(Duration::from_millis(1200)).await;
        let asked = line.names().split_off(before);
        assert!(asked.is_empty(), "{asked:?}");
        // It is asked again after 1 s and two link timeouts.
        tokio::time::sleep(Duration::from_millis(1100)).await;
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
            device.receive(Duration::from_millis(20)).unwrap();
            device.simulated.device.servo().state() == State::Armed
        };
        assert!(is_armed());
        let begin = Instant::now();
        while is_armed() && begin.elapsed() < Duration::from_secs(3) {}
        let took_s = begin.elapsed().as_secs_f64();
        assert!(took_s < LINK_TIMEOUT_S + SLACK_S, "{took_s} s");
        let latched = line.device.lock().unwrap().simulated.device.servo().latched().unwrap();
        assert_eq!(latched.fault as u8, 22);
    });
}
