//! Orders that have waited: too long, for a page that is gone, or behind a stop.

use std::time::Duration;

use serde_json::json;

use super::line::Line;
use super::page::{Page, arm, run};

#[test]
fn an_order_that_has_waited_for_more_than_a_second_is_not_obeyed() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        // The device is busy for so long, and the order is given meanwhile.
        line.until(&line.stalls("", Duration::from_millis(1500))).await;
        let said = page.refused(arm()).await;
        assert!(said.contains("the device was busy"), "{said}");
        assert!(!line.names().iter().any(|name| name == "Arm"), "{:?}", line.names());
        // One that is as old as half of that is.
        line.until(&line.stalls("", Duration::from_millis(500))).await;
        page.done(arm()).await;
        page.done(json!({ "do": "stop" })).await;
    });
}

#[test]
fn an_order_of_a_page_that_is_gone_is_not_obeyed() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let mut reader = Page::open(&server).await;
        reader.lives = false;
        line.until(&line.stalls("", Duration::from_millis(700))).await;
        page.send(&arm()).await;
        page.settle().await;
        drop(page);
        reader.watch(Duration::from_millis(1500)).await;
        assert!(!line.names().iter().any(|name| name == "Arm"), "{:?}", line.names());
        assert_eq!(reader.event("status").await["state"], "stopped");
    });
}

#[test]
fn a_stop_is_answered_however_many_orders_wait() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        line.until(&line.stalls("", Duration::from_millis(900))).await;
        for id in 100..140 {
            page.send(&json!({ "id": id, "do": "arm" })).await;
        }
        page.send(&json!({ "id": 99, "do": "stop" })).await;
        let (mut full, mut overtaken) = (0, 0);
        let stopped = loop {
            let event = page.event("answer").await;
            let said = event["said"].as_str().unwrap();
            full += u32::from(said.contains("too many requests wait"));
            overtaken += u32::from(said.contains("a stop came first"));
            if event["id"] == 99 {
                break event;
            }
        };
        assert_eq!((&stopped["ok"], full, overtaken), (&json!(true), 8, 32), "{stopped}");
        assert!(stopped["said"].as_str().unwrap().contains("the motor is off"), "{stopped}");
        assert!(!line.was_asked("Arm"), "{:?}", line.names());
    });
}

#[test]
fn what_waits_is_not_obeyed_after_a_stop() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let mut reader = Page::open(&server).await;
        reader.lives = false;
        line.until(&line.stalls("", Duration::from_millis(600))).await;
        page.send(&json!({ "id": 77, "do": "arm" })).await;
        page.settle().await;
        reader.done(json!({ "do": "stop" })).await;
        let answer = page.until(|event| event["id"] == 77).await;
        assert!(answer["said"].as_str().unwrap().contains("a stop came first"), "{answer}");
        assert!(!line.names().iter().any(|name| name == "Arm"), "{:?}", line.names());
    });
}
