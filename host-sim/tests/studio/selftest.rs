//! The self-test from the page: the verdict of the command, and the guards of every motion.

use std::time::Duration;

use serde_json::{Value, json};
use simulator::device::client::Client;
use simulator::device::wire::SimulatedWire;
use studies::selftest::{JOINTS, SEED, SelfTestRequest, object, run as make_moves};

use super::page::{Page, Visit, arm, device, run, studio, studio_without_a_file};
use super::{LINK_TIMEOUT_S, SLACK_S, TICK_S, ticks_on_after};

fn predict(moves: usize) -> Value {
    json!({ "do": "predict-selftest", "moves": moves })
}

/// Makes the moves of a prediction.
fn begin(number: u64) -> Value {
    json!({ "do": "selftest", "number": number })
}

/// Waits for a prediction, and returns its number.
async fn ready(page: &mut Page) -> u64 {
    phase(page, "ready").await["number"].as_u64().unwrap()
}

async fn phase(page: &mut Page, phase: &str) -> Value {
    page.until(|event| event["event"] == "selftest" && event["phase"] == phase).await
}

/// A page whose device makes the first move of a self-test.
async fn moving(page: &mut Page) {
    page.done(predict(4)).await;
    let number = ready(page).await;
    page.done(begin(number)).await;
    page.until(|event| event["phase"] == "moving" && event["to_deg"].is_f64()).await;
    page.watch(Duration::from_millis(500)).await;
}

#[test]
fn the_verdict_is_that_of_the_command() {
    const MOVES: usize = 3;
    let by_command = {
        let mut client = Client::connect(SimulatedWire::new(device(&[]))).unwrap();
        let machine = "step-response".to_owned();
        let (range_deg, spreads) = (None, vec![]);
        let (moves, joints, seed) = (MOVES, JOINTS, SEED);
        let asked = SelfTestRequest { machine, range_deg, moves, joints, seed, spreads };
        let prepared = asked.prepare(&mut client).unwrap();
        let targets = prepared.request.targets.clone();
        let session = make_moves(&mut client, &targets, |_| {}).unwrap();
        object(&prepared.judged(session), client.warning())
    };
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        page.done(predict(MOVES)).await;
        let ready = phase(&mut page, "ready").await;
        assert_eq!(ready["range_deg"], by_command["range_deg"]);
        assert_eq!(page.event("status").await["state"], "stopped", "nothing moves yet");
        page.done(begin(ready["number"].as_u64().unwrap())).await;
        let mut made = vec![];
        let done = loop {
            let event = page.event("selftest").await;
            if event["phase"] == "done" {
                break event;
            }
            // The event of the arming may come before the answer.
            if event["to_deg"].is_f64() {
                made.push(event["made"].as_u64().unwrap());
            }
        };
        // At the begin of each move.
        assert_eq!(made, [0, 1, 2]);
        assert_eq!(page.state("stopped").await["driven"], false);
        let by_page = &done["result"];
        assert_eq!((&done["ok"], &by_page["verdict"]), (&json!(true), &by_command["verdict"]));
        assert!(done["said"].as_str().unwrap().starts_with("pass: the joint moves"), "{done}");
        for key in ["schema", "warning", "machine", "spread", "joints", "differences", "ended_by"] {
            assert_eq!(by_page[key], by_command[key], "{key}");
        }
        let close = |a: &Value, b: &Value, by: f64| match (a.as_f64(), b.as_f64()) {
            (Some(a), Some(b)) => (a - b).abs() <= by,
            _ => a == b,
        };
        let [ours, theirs] = [by_page, &by_command].map(|of| of["moves"].as_array().unwrap());
        assert_eq!((ours.len(), theirs.len()), (MOVES, MOVES));
        for (ours, theirs) in ours.iter().zip(theirs) {
            // The move starts in another tick of the encoder and the observer.
            for (key, by) in [("to_deg", 0.0), ("settled_s", 0.1), ("rest_counts", 1.0)] {
                assert!(close(&ours[key], &theirs[key], by), "{key}: {ours} {theirs}");
            }
            for key in ["held_v", "sliding_v", "accelerating_v"] {
                assert!(close(&ours[key], &theirs[key], 0.02), "{key}: {ours} {theirs}");
            }
            for key in ["predicted_settled_s", "predicted_rest_counts"] {
                assert_eq!(ours[key], theirs[key]);
            }
        }
        let [ours, theirs] = [by_page, &by_command].map(|of| of["checks"].as_array().unwrap());
        assert_eq!((ours.len(), theirs.len()), (8, 8));
        for (ours, theirs) in ours.iter().zip(theirs) {
            for key in ["name", "predicted", "least", "most", "pass"] {
                assert_eq!(ours[key], theirs[key], "{ours}");
            }
        }
        // What was predicted before is what it was judged by.
        let bounds = ready["checks"].as_array().unwrap();
        assert_eq!(bounds.len(), ours.len());
        for (bound, check) in bounds.iter().zip(ours) {
            assert_eq!((&bound["name"], &bound["most"]), (&check["name"], &check["most"]));
        }
    });
}

#[test]
fn a_self_test_is_refused_where_it_could_not_be_judged_or_is_not_expected() {
    run(async {
        let server = studio_without_a_file();
        let mut page = Page::open(&server).await;
        let said = page.refused(predict(4)).await;
        assert!(said.contains("without a machine's file"), "{said}");
        assert!(said.contains("in the step Identify"), "{said}");
        assert!(page.refused(begin(1)).await.contains("predict it first"));
    });
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let mut reader = Page::open(&server).await;
        for what in [predict(4), begin(1)] {
            assert!(reader.refused(what).await.contains("another page commands"));
        }
        drop(reader);
        assert!(page.refused(begin(1)).await.contains("predict it first"));
        // Of the range, as of the command.
        let wide = json!({ "do": "predict-selftest", "moves": 4, "deg": 1e6 });
        let said = page.refused(wide).await;
        assert!(said.contains("a range of 1000000 deg: ") && !said.contains("--"), "{said}");
        // Another machine: the file says what it is to be compared with.
        let other = json!({ "do": "set", "values": { "encoder.direction": "reverse" } });
        page.done(other).await;
        let said = page.refused(predict(4)).await;
        assert!(said.contains("another machine") && !said.contains("--"), "{said}");
        page.done(json!({ "do": "undo" })).await;
        page.done(arm()).await;
        assert!(page.refused(predict(4)).await.contains("stop first"));
        page.done(json!({ "do": "stop" })).await;
        page.done(predict(4)).await;
        let number = ready(&mut page).await;
        // The prediction is of what the device has run.
        let set = |value: &str| json!({ "do": "set", "values": { "limits.stall_s": value } });
        page.done(set("0.75")).await;
        assert!(page.refused(begin(number)).await.contains("predict anew"));
        assert_eq!(page.event("status").await["state"], "stopped");
        page.done(json!({ "do": "undo" })).await;
        page.done(begin(number)).await;
        // Nothing else is done while it moves.
        for what in [json!({ "do": "move", "deg": 1.0 }), json!({ "do": "hold" }), predict(4)] {
            assert!(page.refused(what).await.contains("a self-test moves the joint"));
        }
        // Every page may stop it, and that is no verdict.
        let mut other = Visit::proper(&server).connect().await.unwrap();
        other.send(&json!({ "do": "stop" })).await;
        let done = phase(&mut page, "done").await;
        assert_eq!((&done["ok"], &done["result"]["ended_by"]), (&json!(false), &json!("a stop")));
        assert_eq!(done["result"]["checks"], json!([]));
        page.state("stopped").await;
    });
}

#[test]
fn a_self_test_whose_page_is_closed_ends_by_the_link_timeout_also_if_another_page_commands() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let mut reader = Page::open(&server).await;
        reader.lives = false;
        moving(&mut page).await;
        let last = page.rows.last().unwrap().clock;
        drop(page);
        // The reader takes the command as soon as it is free, and gives words for all that comes.
        reader.lives = true;
        for _ in 0..4 {
            reader.send(&json!({ "do": "command" })).await;
            reader.send(&json!({ "do": "alive" })).await;
            reader.settle().await;
        }
        let on_s = ticks_on_after(&mut reader, last).await as f64 * TICK_S;
        assert!((LINK_TIMEOUT_S - 0.15..LINK_TIMEOUT_S + SLACK_S).contains(&on_s), "{on_s} s");
        assert_eq!(reader.state("faulted").await["fault"]["code"], 22);
        // It commands, and sees how it ended.
        reader.done(json!({ "do": "clear" })).await;
        let mut later = Visit::proper(&server).connect().await.unwrap();
        let done = phase(&mut later, "done").await;
        let by = done["result"]["ended_by"].as_str().unwrap();
        assert!(by.contains("fault 22"), "{by}");
    });
}

#[test]
fn a_prediction_reports_its_progress_and_ends_when_it_is_cancelled_or_the_motor_is_stopped() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let cancel = || json!({ "do": "cancel-selftest" });
        assert!(page.refused(cancel()).await.contains("none is being predicted"));
        // Its event may come before the answer.
        page.send(&predict(200)).await;
        let far = page.until(|event| event["over"].as_u64().is_some_and(|over| over > 0)).await;
        assert_eq!((&far["phase"], &far["joints"]), (&json!("predicting"), &json!(24)), "{far}");
        assert!(far["over"].as_u64().unwrap() < 24, "{far}");
        page.send(&cancel()).await;
        let none = phase(&mut page, "none").await;
        assert!(none["said"].as_str().unwrap().contains("is cancelled"), "{none}");
        assert!(page.refused(begin(1)).await.contains("predict it first"));
        page.done(predict(200)).await;
        // Every page may stop.
        let mut reader = Visit::proper(&server).connect().await.unwrap();
        reader.send(&json!({ "do": "stop" })).await;
        let none = phase(&mut page, "none").await;
        assert!(none["said"].as_str().unwrap().contains("cancelled by a stop"), "{none}");
        // Another one begins at once, and is not that one.
        page.done(predict(2)).await;
        assert_eq!(phase(&mut page, "ready").await["moves"], 2);
    });
}

#[test]
fn the_moves_of_another_prediction_than_the_last_are_refused() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        page.done(predict(2)).await;
        let first = phase(&mut page, "ready").await;
        // What was asked for: the range is derived.
        assert_eq!((&first["joint"], &first["deg"]), (&json!("file"), &Value::Null), "{first}");
        page.done(json!({ "do": "predict-selftest", "moves": 3, "deg": 2.5 })).await;
        let last = phase(&mut page, "ready").await;
        assert_eq!((&last["deg"], &last["moves"]), (&json!(2.5), &json!(3)), "{last}");
        let [first, last] = [first, last].map(|event| event["number"].as_u64().unwrap());
        for other in [first, last + 1] {
            let said = page.refused(begin(other)).await;
            assert!(said.contains("predicted again meanwhile"), "{said}");
        }
        assert_eq!(page.event("status").await["state"], "stopped");
        page.done(begin(last)).await;
        page.done(json!({ "do": "stop" })).await;
        // They may be repeated, as what they are.
        let done = phase(&mut page, "done").await;
        assert_eq!((&done["number"], &done["deg"]), (&json!(last), &json!(2.5)), "{done}");
    });
}

#[test]
fn without_a_link_timeout_the_studio_stops_a_self_test_whose_page_is_gone() {
    run(async {
        let server = studio(&["limits.link_timeout_s=\"off\""]);
        let mut page = Page::open(&server).await;
        let mut reader = Page::open(&server).await;
        moving(&mut page).await;
        drop(page);
        reader.send(&json!({ "do": "command" })).await;
        let status = reader.state("stopped").await;
        assert!(status["fault"].is_null(), "{status}");
        phase(&mut reader, "done").await;
    });
}
