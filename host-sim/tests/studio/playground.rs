//! The studio without a server sends the same messages as the one with a server.

use std::time::Instant;

use host_sim::studio::{Playground, StudioMessage};
use serde_json::{Value, json};

use super::page::{PATIENCE, Page, run, studio};
use super::what_if::{predicted, wish};

/// Passes until an event comes for which `is_it` says so.
fn until(playground: &mut Playground, is_it: impl Fn(&Value) -> bool) -> Value {
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        playground.pass();
        for news in playground.by_ref() {
            let StudioMessage::Event(text) = news else { continue };
            let event: Value = serde_json::from_str(&text).unwrap();
            if is_it(&event) {
                return event;
            }
        }
    }
    panic!("the event did not come");
}

fn asked(playground: &mut Playground, id: u32, mut request: Value) -> Value {
    request["id"] = id.into();
    playground.ask(&request.to_string());
    until(playground, |event| event["event"] == "answer" && event["id"] == id)
}

#[test]
fn a_prediction_is_the_same_without_a_server() {
    let way = json!({ "how": "move", "deg": 5.0 });
    let values = json!({ "inertia": 1.5, "controller.pd.kp_v_per_deg": 0.7 });
    let asked = wish(&way, &["srnf", "pd"], &values, 6);
    let mut playground = Playground::open("step-response", Some("srnf")).unwrap();
    playground.ask(&asked.to_string());
    let mut of = |part: &str| until(&mut playground, |event| event["part"] == part);
    let (laws, cloud) = (of("laws"), of("cloud"));
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        assert_eq!(predicted(&mut page, "laws", asked.clone()).await, laws["content"]);
        assert_eq!(predicted(&mut page, "cloud", asked).await, cloud["content"]);
    });
}

#[test]
fn its_page_commands_and_is_refused_what_the_device_refuses() {
    let mut playground = Playground::open("step-response", Some("srnf")).unwrap();
    let role = until(&mut playground, |event| event["event"] == "role");
    assert_eq!(role["commands"], true);
    let refused = asked(&mut playground, 1, json!({ "do": "move", "deg": 5.0 }));
    assert_eq!(refused["ok"], false, "{refused}");
    // A page has no threads, on which these are computed.
    for what in [
        json!({ "do": "tune", "laws": ["pd"], "goal": "balanced" }),
        json!({ "do": "predict-selftest", "moves": 20 }),
    ] {
        let refused = asked(&mut playground, 4, what);
        assert_eq!(refused["ok"], false, "{refused}");
        assert!(refused["said"].as_str().unwrap().contains("no threads"), "{refused}");
    }
    let armed = asked(&mut playground, 2, json!({ "do": "arm" }));
    assert_eq!(armed["ok"], true, "{armed}");
    let stopped = asked(&mut playground, 3, json!({ "do": "stop" }));
    assert_eq!(stopped["ok"], true, "{stopped}");
    until(&mut playground, |event| event["event"] == "status" && event["state"] == "stopped");
    let nonsense = asked(&mut playground, 0, json!({ "do": "fly" }));
    assert_eq!(nonsense["ok"], false, "{nonsense}");
}

#[test]
fn a_page_that_gives_no_word_loses_the_drive() {
    let mut playground = Playground::open("step-response", Some("srnf")).unwrap();
    assert_eq!(asked(&mut playground, 1, json!({ "do": "arm" }))["ok"], true);
    let faulted = |event: &Value| event["event"] == "status" && event["state"] == "faulted";
    assert_eq!(until(&mut playground, faulted)["fault"]["code"], 22);
}
