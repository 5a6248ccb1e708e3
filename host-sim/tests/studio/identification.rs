//! The identification of a joint from the page, and what the joint that was found is good for.

use std::time::Duration;

use serde_json::{Value, json};
use simulator::device::clock::Clock;
use simulator::experiment::Document;
use simulator::rules::TUNING_SEEDS;
use studies::tuning::{GainSearch, TuningGoal, object, spreads};

use super::line::Line;
use super::page::{Page, Visit, run, studio, studio_around};
use super::what_if::{self, wish};

#[test]
fn the_joint_is_identified_by_the_device_s_own_sequence() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let said = page.done(json!({ "do": "identify" })).await;
        assert!(said.contains("ends automatically"), "{said}");
        page.state("armed").await;
        page.watch(Duration::from_secs(3)).await;
        let pushed = page.signal("v_applied_v").into_iter().map(f32::from_bits);
        assert!(pushed.fold(0.0, |most: f32, volt| most.max(volt.abs())) > 0.01, "it pushes");
        // It takes minutes; a stop ends it, and then there is no result and no event.
        page.done(json!({ "do": "stop" })).await;
        let mut found = false;
        let end = page.clock.now() + Duration::from_secs(1);
        while let Some(event) = page.next_before(end).await {
            found |= event["event"] == "found";
            if event["event"] == "status" {
                assert_eq!(event["state"], "stopped", "{event}");
            }
        }
        assert!(!found);
    });
}

#[test]
fn an_identification_begins_only_if_it_is_expected_once_it_was_checked_and_can_find_something() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let identify = json!({ "do": "identify" });
        line.stalls("ReadParameters", Duration::from_millis(1100));
        let said = page.refused(identify.clone()).await;
        assert!(said.contains("the device was busy"), "{said}");
        assert!(!line.was_asked("IdentifyJoint"), "{:?}", line.names());
        // As long as half of that, and it is expected still.
        line.stalls("ReadParameters", Duration::from_millis(400));
        page.done(identify).await;
        assert!(line.was_asked("IdentifyJoint"), "{:?}", line.names());
        page.done(json!({ "do": "stop" })).await;
    });
    run(async {
        // Too slow for the thesis's encoder, which shows the swings from 0.104 deg/s on.
        let line = Line::new(&["profile.velocity_deg_per_s=0.05"]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let said = page.refused(json!({ "do": "identify" })).await;
        assert!(said.contains("raise profile.velocity_deg_per_s"), "{said}");
        assert!(said.contains("Nothing has moved") && !said.contains("--"), "{said}");
        // That is a refusal, and the device is there.
        assert_eq!(page.event("status").await["state"], "stopped");
        assert!(!line.was_asked("IdentifyJoint"), "{:?}", line.names());
    });
}

#[test]
fn an_identification_is_reported_although_the_machine_s_file_is_gone() {
    let name = format!("stiction-studio-gone-{}.toml", std::process::id());
    let file = std::env::temp_dir().join(name);
    let text = std::fs::read_to_string("thesis/experiments/step-response.toml").unwrap();
    std::fs::write(&file, text).unwrap();
    run(async {
        // Its time passes as fast as it can be computed, so minutes take seconds.
        let line = Line { in_haste: true, ..Line::new(&["limits.link_timeout_s=\"off\""]) };
        let server = line.serve_as(file.to_str().unwrap(), true);
        let mut page = Page::open(&server).await;
        page.done(json!({ "do": "identify" })).await;
        std::fs::remove_file(&file).unwrap();
        let found = loop {
            let event = page.next().await.unwrap();
            assert_ne!(event["event"], "gone", "{event}");
            if event["event"] == "found" {
                break event["said"].as_str().unwrap().to_owned();
            }
        };
        assert!(found.contains("breakaway +") && found.contains("inertia"), "{found}");
        assert!(found.contains("not in SI units"), "{found}");
    });
}

/// The sliders of the joint that was found: the effort that starts it, V.
async fn found_stick(page: &mut Page, file: &Value) -> f64 {
    let event = page.until(|event| event["event"] == "what-if" && !event["found"].is_null()).await;
    assert_eq!((&event["found"]["machine"], &event["found"]["why"]), (file, &Value::Null));
    assert!(event["why"].as_str().unwrap().contains("without a machine's file"), "{event}");
    let knobs = event["found"]["knobs"].as_array().unwrap();
    knobs.iter().find(|knob| knob["name"] == "stick_v").unwrap()["value"].as_f64().unwrap()
}

#[test]
fn the_joint_that_was_found_is_a_file_and_is_predicted_tuned_and_tested_with() {
    const GAIN: &str = "joint.gain_deg_per_s2_per_v";
    run(async {
        let line = Line { in_haste: true, ..Line::new(&["limits.link_timeout_s=\"off\""]) };
        // Its joint is not known.
        let server = line.serve_as("step-response", false);
        let mut page = Page::open(&server).await;
        let test = json!({ "do": "predict-selftest", "moves": 2, "joint": "found" });
        let tune = json!({ "do": "tune", "laws": [], "goal": "settle", "joint": "found",
                           "cases": 2 });
        for early in [&test, &tune] {
            assert!(page.refused(early.clone()).await.contains("identify it first"));
        }
        let mut early = wish(&json!({ "how": "step", "deg": 1.0 }), &["srnf"], &json!({}), 0);
        early["wish"]["joint"] = "found".into();
        page.send(&early).await;
        let refused = page.until(|event| event["part"] == "refused").await;
        assert!(refused["content"].as_str().unwrap().contains("identify it first"), "{refused}");
        page.done(json!({ "do": "identify" })).await;
        let found = page.event("identified").await;
        assert_eq!((&found["ok"], &found["file"]), (&json!(true), &json!("joint.identified.toml")));
        assert_eq!(found["laws"], json!(["srnf"]));
        let text = found["toml"].as_str().unwrap();
        assert!(text.starts_with("# SIMULATED DEVICE") && text.contains("[spread]"), "{text}");
        // It is the joint of the device, and no other one.
        let of = |document: &Document| document.get(GAIN).unwrap().as_float().unwrap();
        let is = of(&Document::parse("found", text).unwrap());
        let was = of(&Document::open("step-response").unwrap());
        assert!((is / was - 1.0).abs() < 0.05, "{is} of {was}");
        // A page that connects later receives it, too.
        let mut later = Visit::proper(&server).connect().await.unwrap();
        later.lives = false;
        assert_eq!(later.event("identified").await["toml"], found["toml"]);
        // What if: the predictions are those of a studio that has that file.
        let stick = found_stick(&mut page, &found["file"]).await;
        let in_file = Document::parse("found", text).unwrap();
        let in_file = in_file.get("joint.friction.stick_v").unwrap().as_float().unwrap();
        assert!((stick / in_file - 1.0).abs() < 1e-6, "{stick} of {in_file}");
        let wanted = wish(&json!({ "how": "move", "deg": 5.0 }), &["srnf"], &json!({}), 3);
        let mut of_found = wanted.clone();
        of_found["wish"]["joint"] = "found".into();
        let file = std::env::temp_dir().join(format!("stiction-found-{}.toml", std::process::id()));
        std::fs::write(&file, text).unwrap();
        let other = studio_around(file.to_str().unwrap().to_owned().leak(), "srnf", &[]);
        let mut of_file = Page::open(&other).await;
        for part in ["laws", "cloud"] {
            let by_found = what_if::predicted(&mut page, part, of_found.clone()).await;
            let by_file = what_if::predicted(&mut of_file, part, wanted.clone()).await;
            assert_eq!(by_found, by_file, "{part}");
        }
        std::fs::remove_file(&file).unwrap();
        page.send(&wanted).await;
        let refused = page.until(|event| event["part"] == "refused").await;
        assert!(refused["content"].as_str().unwrap().contains("in the step Identify"), "{refused}");
        // The gains are those that the command finds with that file.
        let said = page.done(tune).await;
        assert!(said.contains("joint.identified.toml"), "{said}");
        let tuned = page.event("tuned").await;
        assert_eq!((&tuned["machine"], &tuned["joint"]), (&found["file"], &json!("found")));
        let document = Document::parse("joint.identified.toml", text).unwrap();
        let same = GainSearch {
            file: "joint.identified.toml".into(),
            goal: TuningGoal::Settle,
            limits: vec![],
            spreads: spreads(&document).unwrap(),
            cases: 2,
            seed: *TUNING_SEEDS.start(),
            document,
        };
        let same = [same.tune("srnf", &|| ()).unwrap()];
        assert_eq!(tuned["result"], object("joint.identified.toml", &same));
        // The moves are judged by the joint that was found.
        page.done(test).await;
        let ready = page.until(|event| event["phase"] == "ready").await;
        assert_eq!(ready["machine"], found["file"]);
        assert_eq!(ready["joint"], "found");
        let begin = json!({ "do": "selftest", "number": ready["number"] });
        page.done(begin.clone()).await;
        let done = page.until(|event| event["phase"] == "done").await;
        assert_eq!((&done["ok"], &done["result"]["machine"]), (&json!(true), &found["file"]));
        // What it was predicted with is not the joint that is found next.
        page.done(json!({ "do": "identify" })).await;
        let next = page.event("identified").await;
        assert_eq!(next["ok"], true);
        let none = page.until(|event| event["phase"] == "none").await;
        assert!(none["said"].as_str().unwrap().contains("another joint was identified"), "{none}");
        assert!(page.refused(begin).await.contains("predict it first"));
        // It leaves its place faster than this, so the joint that was found before stays.
        let slow = json!({ "profile.velocity_deg_per_s": "0.12" });
        page.done(json!({ "do": "set", "values": slow })).await;
        page.done(json!({ "do": "identify" })).await;
        let still = page.event("identified").await;
        let why = still["why"].as_str().unwrap();
        assert!(
            why.starts_with("the joint reached its speed limit") && !why.contains("--"),
            "{why}"
        );
        assert_eq!(still["ok"], false);
        for key in ["file", "toml", "laws"] {
            assert_eq!(still[key], next[key], "{key}");
        }
    });
}
