//! A self-test never moves a joint for an order that is old, stopped, or of a page that is gone.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::{Value, json};
use simulator::device::clock::Clock;

use super::clock::STEP;
use super::line::Line;
use super::page::{Page, Visit, run};

/// Predicts a self-test, and returns the order to make its moves.
async fn predicted(page: &mut Page, moves: usize) -> Value {
    page.done(json!({ "do": "predict-selftest", "moves": moves })).await;
    let ready = page.until(|event| event["phase"] == "ready").await;
    json!({ "do": "selftest", "number": ready["number"] })
}

#[test]
fn a_self_test_that_has_lost_its_device_reports_it_and_the_device_is_stopped_first() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let begin = predicted(&mut page, 2).await;
        page.done(begin.clone()).await;
        line.is_cut.store(true, Ordering::SeqCst);
        let event = page.until(|event| event["phase"] == "none").await;
        assert!(event["said"].as_str().unwrap().contains("did not answer"), "{event}");
        line.asked.lock().unwrap().clear();
        line.is_cut.store(false, Ordering::SeqCst);
        page.event("back").await;
        // After the hello and the request for the number of the session.
        assert_eq!(line.names().get(2).map(String::as_str), Some("Stop"), "{:?}", line.names());
        // It does not go on by itself.
        assert!(page.refused(begin).await.contains("predict it first"));
        // A page that comes later has not heard that it was gone.
        let mut later = Visit::proper(&server).connect().await.unwrap();
        later.lives = false;
        let mut kinds: Vec<String> = vec![];
        while kinds.last().is_none_or(|kind| kind != "status") {
            kinds.push(later.next().await.unwrap()["event"].as_str().unwrap().to_owned());
        }
        assert!(!kinds.iter().any(|kind| kind == "back" || kind == "gone"), "{kinds:?}");
    });
}

#[test]
fn a_self_test_that_is_not_expected_any_more_while_it_is_prepared_never_arms() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let mut begin = predicted(&mut page, 2).await;
        begin["id"] = 70.into();
        let answer = |event: &Value| event["event"] == "answer" && event["id"] == 70;
        // A stop comes while the parameters are read that the prediction has to fit.
        let stalled = line.stalls("ReadParameters", Duration::from_millis(400));
        page.send(&begin).await;
        line.until(&stalled).await;
        page.send(&json!({ "id": 71, "do": "stop" })).await;
        let said = page.until(answer).await;
        assert!(said["said"].as_str().unwrap().contains("a stop came first"), "{said}");
        page.until(|event| event["event"] == "answer" && event["id"] == 71).await;
        assert!(!line.was_asked("Arm"), "{:?}", line.names());
        // It takes longer than a request is valid.
        line.stalls("ReadParameters", Duration::from_millis(1100));
        page.send(&begin).await;
        let said = page.until(answer).await;
        assert!(said["said"].as_str().unwrap().contains("the device was busy"), "{said}");
        assert!(!line.was_asked("Arm"), "{:?}", line.names());
        // As long as the first one, but without a stop.
        line.stalls("ReadParameters", Duration::from_millis(400));
        page.send(&begin).await;
        assert_eq!(page.until(answer).await["ok"], true);
        assert!(line.was_asked("Arm"));
        page.done(json!({ "do": "stop" })).await;
        // The page that has given it is gone.
        line.asked.lock().unwrap().clear();
        let stalled = line.stalls("ReadParameters", Duration::from_millis(600));
        let mut reader = Page::open(&server).await;
        reader.lives = false;
        page.send(&begin).await;
        line.until(&stalled).await;
        drop(page);
        reader.watch(Duration::from_millis(1500)).await;
        assert!(line.was_asked("ReadParameters") && !line.was_asked("Arm"), "{:?}", line.names());
    });
}

/// A self-test whose device answers late when it is asked for the status with which the first move
/// is due. Returns when it is.
async fn due(line: &Line, page: &mut Page) {
    // The soft start, and 2 s.
    const WAITS_S: f64 = 2.2;
    let begin = predicted(page, 2).await;
    let (is_due, mut armed) = (Arc::new(AtomicBool::new(false)), None::<Duration>);
    let (due, clock) = (is_due.clone(), line.clock.clone());
    line.before(move |name, _| {
        if name == "Arm" {
            armed = Some(clock.now());
        }
        let is_late = armed.is_some_and(|at| (clock.now() - at).as_secs_f64() > WAITS_S - 0.1);
        if name == "Status" && is_late && !due.swap(true, Ordering::SeqCst) {
            // Less than what a simulated device catches up with, and more than a word is worth.
            clock.sleep(Duration::from_millis(190));
        }
    });
    page.done(begin).await;
    // It gives a word for all that comes, and none from then on.
    while !is_due.load(Ordering::SeqCst) {
        page.next_before(line.clock.now() + STEP).await;
    }
}

#[test]
fn no_move_of_a_self_test_begins_on_an_old_word_or_after_a_stop() {
    const SET: [&str; 2] = ["device.soft_start_s=0.2", "limits.link_timeout_s=5"];
    run(async {
        let line = Line::new(&SET);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        due(&line, &mut page).await;
        page.send(&json!({ "do": "stop" })).await;
        let done = page.until(|event| event["phase"] == "done").await;
        assert_eq!(done["result"]["ended_by"], "a stop", "{done}");
        assert!(!line.was_asked("Move"), "{:?}", line.names());
    });
    run(async {
        let line = Line::new(&SET);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        due(&line, &mut page).await;
        // The page hangs: it has given its last word before the status was asked for.
        page.hang(Duration::from_millis(600)).await;
        assert!(!line.was_asked("Move"), "{:?}", line.names());
        // With its next words the move begins.
        page.until(|event| event["phase"] == "moving" && event["to_deg"].is_f64()).await;
        assert!(line.was_asked("Move"));
        page.done(json!({ "do": "stop" })).await;
    });
}

#[test]
fn a_move_of_a_self_test_that_is_refused_ends_it_with_that_reason_and_keeps_the_moves() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let begin = predicted(&mut page, 3).await;
        let mut moves = 0;
        // Something else turns the output off just before the second move.
        line.before(move |name, wire| {
            moves += u32::from(name.starts_with("Move"));
            if moves == 2 {
                wire.simulated.device.servo().stop();
            }
        });
        page.done(begin).await;
        let done = page.until(|event| event["phase"] == "done").await;
        assert_eq!((&done["ok"], &done["result"]["checks"]), (&json!(false), &json!([])));
        let by = done["result"]["ended_by"].as_str().unwrap();
        assert!(by.contains("refuses"), "{by}");
        assert!(done["said"].as_str().unwrap().contains(by), "{done}");
        assert_eq!(done["result"]["moves"].as_array().unwrap().len(), 1, "{done}");
    });
}
