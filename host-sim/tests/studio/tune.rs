//! Tuning from the page: what `stiction tune` finds, without a device, and nothing moves by it.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::{Value, json};
use simulator::experiment::Document;
use simulator::rules::TUNING_SEEDS;
use studies::tuning::{CASES, GainSearch, TuningGoal, object, rewritten, spreads};

use super::clock::breath;
use super::page::{Page, run, studio, studio_around, studio_without_a_file};
use super::{LINK_TIMEOUT_S, SLACK_S, TICK_S, armed_with_a_reader, ticks_on_after};

fn tune(laws: &[&str], goal: &str) -> Value {
    json!({ "do": "tune", "laws": laws, "goal": goal })
}

#[test]
fn a_tuning_finds_what_the_command_finds_and_writes_no_file() {
    let directory = std::env::temp_dir().join(format!("stiction-tuned-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let file = directory.join("joint.toml");
    let text = std::fs::read_to_string("thesis/experiments/step-response.toml").unwrap();
    std::fs::write(&file, &text).unwrap();
    let machine: &'static str = file.to_str().unwrap().to_owned().leak();
    run(async {
        let server = studio_around(machine, "srnf", &[]);
        let mut page = Page::open(&server).await;
        // A page that only looks may ask as well: it moves nothing.
        let mut reader = Page::open(&server).await;
        let said = reader.done(tune(&["pd"], "settle")).await;
        assert_eq!(said, format!("tunes pd of {machine} for settle"));
        let is_on_its_way =
            |event: &Value| event["event"] == "tuning" && event["running"]["tried"].is_u64();
        let running = page.until(is_on_its_way).await["running"].clone();
        assert_eq!((&running["law"], &running["of"]), (&json!("pd"), &json!(1)), "{running}");
        let tuned = page.event("tuned").await;
        assert_eq!(tuned["ok"], true, "{tuned}");
        let document = Document::open(machine).unwrap();
        let request = GainSearch {
            file: machine.into(),
            goal: TuningGoal::Settle,
            limits: vec![],
            spreads: spreads(&document).unwrap(),
            cases: CASES,
            seed: *TUNING_SEEDS.start(),
            document,
        };
        let judges = request.judges();
        let same = [request.tune("pd", &|| ()).unwrap()];
        assert!(same[0].better, "nothing would be shown");
        assert_eq!(tuned["result"], object(machine, &same));
        assert_eq!(tuned["toml"], rewritten(&text, &same).unwrap());
        assert_eq!(tuned["file"], "joint.tuned.toml");
        assert_eq!((&tuned["machine"], &tuned["joint"]), (&json!(machine), &json!("file")));
        // The figures are of those.
        assert_eq!(tuned["joints"], judges);
        let figures = &tuned["result"]["controllers"]["pd"]["after"];
        assert_eq!(figures["cases"], 2 * judges, "with and without a delay: {figures}");
        let charts = tuned["charts"].as_array().unwrap();
        assert!(charts.iter().all(|one| one.as_str().unwrap().starts_with("<svg")));
        // Without a trajectory none of tracking; PD at rest has no chatter, so that its chart would
        // be zero all over.
        assert_eq!(charts.len(), usize::from(cfg!(feature = "figures")));
        // A page that connects later receives the result, and that nothing runs.
        let mut later = super::Visit::proper(&server).connect().await.unwrap();
        assert_eq!(later.event("tuned").await["toml"], tuned["toml"]);
        assert!(later.event("tuning").await["running"].is_null());
    });
    let files: Vec<_> = std::fs::read_dir(&directory).unwrap().flatten().collect();
    assert_eq!((files.len(), std::fs::read_to_string(&file).unwrap()), (1, text));
    std::fs::remove_dir_all(&directory).unwrap();
}

/// The encoder cannot see the gear's 171 counts of backlash: the page gets the refusal and both
/// sides, and no file to take.
#[test]
fn a_tuning_that_finds_nothing_is_refused_with_the_reason_and_without_a_file() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("gear.toml");
    let text = include_str!("../joints_under_test/gear_with_backlash.toml");
    // Enough for friction and unbalance together, whatever is derived.
    std::fs::write(&file, format!("{text}\n[limits]\nbreakaway_v = 2.5\n")).unwrap();
    let machine: &'static str = file.to_str().unwrap().to_owned().leak();
    run(async {
        let server = studio_around(machine, "robust", &[]);
        let mut page = Page::open(&server).await;
        let mut wanted = tune(&["robust"], "settle");
        wanted["cases"] = 1.into();
        page.done(wanted).await;
        let tuned = page.event("tuned").await;
        assert_eq!((&tuned["ok"], &tuned["result"]["outcome"]), (&json!(true), &json!("refused")));
        assert!(tuned["toml"].is_null(), "{tuned}");
        assert!(tuned["unseen_slack"].as_str().unwrap().contains("171 counts"), "{tuned}");
        let of = &tuned["result"]["controllers"]["robust"];
        let reason = of["reason"].as_str().unwrap();
        assert!(reason.contains("no gains can rest the load within 2 counts"), "{reason}");
        let said = tuned["said"].as_str().unwrap();
        assert!(said.starts_with("no gains were found") && said.contains(reason), "{said}");
        assert_eq!(
            (&of["before"]["success_at_load"], &of["before"]["success_at_encoder"]),
            (&json!(0.0), &json!(1.0))
        );
    });
}

#[test]
fn one_tuning_runs_at_a_time_and_a_cancelled_one_ends_at_once() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        assert!(page.refused(json!({ "do": "cancel-tuning" })).await.contains("no tuning runs"));
        assert!(page.refused(tune(&["pd", "unknown"], "track")).await.contains("`unknown`"));
        // What the command refuses, in words of a page that has no options.
        for (more, why) in [
            (json!({ "goal": "track" }), "reference.trajectories"),
            (json!({ "limits": ["rest_count=1"] }), "`rest_counts`"),
            (json!({ "limits": ["rest_counts=0"] }), "above 0"),
            (json!({ "cases": 0 }), "from 1 to 1000"),
            (json!({ "cases": 1001 }), "from 1 to 1000"),
            (json!({ "joint": "found" }), "identify it first"),
        ] {
            let mut wanted = tune(&[], "settle");
            more.as_object().unwrap().iter().for_each(|(key, value)| wanted[key] = value.clone());
            let said = page.refused(wanted).await;
            assert!(said.contains(why) && !said.contains("--"), "{said}");
        }
        page.done(tune(&[], "settle")).await;
        assert!(page.refused(tune(&["pd"], "settle")).await.contains("one runs at a time"));
        // Predictions come meanwhile.
        let way = json!({ "how": "move", "deg": 1.0 });
        let wish = json!({ "way": way, "laws": ["pd"] });
        page.send(&json!({ "do": "predict", "wish": wish })).await;
        let first =
            page.until(|event| event["event"] == "tuned" || event["event"] == "predicted").await;
        assert_eq!(first["event"], "predicted", "{first}");
        page.done(json!({ "do": "cancel-tuning" })).await;
        let tuned = page.event("tuned").await;
        assert_eq!((&tuned["ok"], tuned["result"].is_null()), (&json!(false), true), "{tuned}");
        assert!(tuned["said"].as_str().unwrap().starts_with("cancelled"), "{tuned}");
        // It is free for the next one, whose result is not that of the one before.
        page.until(|event| event["event"] == "tuning" && event["running"].is_null()).await;
        page.done(tune(&["pd"], "settle")).await;
        assert_eq!(page.event("tuned").await["ok"], true);
    });
}

#[test]
fn without_a_file_nothing_is_tuned_and_the_reason_is_reported() {
    run(async {
        let server = studio_without_a_file();
        let mut page = super::Visit::proper(&server).connect().await.unwrap();
        let event = page.event("tuning").await;
        assert!(event["why"].as_str().unwrap().contains("without a machine's file"), "{event}");
        assert_eq!(event["laws"], json!([]));
        let said = page.refused(tune(&[], "settle")).await;
        assert!(said.contains("without a machine's file"), "{said}");
    });
}

#[test]
fn a_tuning_keeps_nothing_alive() {
    run(async {
        let server = studio(&[]);
        let (mut page, mut reader) = armed_with_a_reader(&server).await;
        let last = page.rows.last().unwrap().clock;
        // The page that commands hangs, but for what it asks of the tuning.
        page.lives = false;
        let asks = async {
            page.send(&tune(&[], "balanced")).await;
            loop {
                page.send(&tune(&["pd"], "settle")).await;
                breath().await;
            }
        };
        let looks = async {
            reader.until(|event| event["running"]["law"] == "pd").await;
            ticks_on_after(&mut reader, last).await
        };
        tokio::select! {
            () = asks => {}
            on = looks => {
                let on_s = on as f64 * TICK_S;
                let allowed = LINK_TIMEOUT_S - 0.15..LINK_TIMEOUT_S + SLACK_S;
                assert!(allowed.contains(&on_s), "{on_s} s");
            }
        }
        assert_eq!(reader.state("faulted").await["fault"]["code"], 22);
        // It has run meanwhile, and does still.
        reader.done(json!({ "do": "cancel-tuning" })).await;
    });
}

fn request(cases: u64, limits: Vec<(String, f64)>) -> GainSearch {
    let document = Document::open("step-response").unwrap();
    GainSearch {
        file: "step-response".into(),
        goal: TuningGoal::Settle,
        limits,
        spreads: spreads(&document).unwrap(),
        cases,
        seed: *TUNING_SEEDS.start(),
        document,
    }
}

#[test]
fn limits_and_the_number_of_joints_are_those_of_the_command() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let limits = json!(["chatter_v_per_s=0.5", "held_v = 0.05"]);
        let wanted = json!({ "do": "tune", "laws": ["pd"], "goal": "settle", "limits": limits,
                             "cases": 3 });
        page.done(wanted).await;
        let tuned = page.event("tuned").await;
        let limits = vec![("chatter_v_per_s".into(), 0.5), ("held_v".into(), 0.05)];
        let bounded = [request(3, limits).tune("pd", &|| ()).unwrap()];
        assert_eq!(tuned["result"], object("step-response", &bounded));
        assert_eq!(tuned["joints"], 9);
        let free = [request(3, vec![]).tune("pd", &|| ()).unwrap()];
        assert_ne!(tuned["result"], object("step-response", &free), "the limits do nothing");
    });
}

#[test]
fn a_tuning_ends_wherever_it_is_cancelled() {
    let request = request(1, vec![]);
    // How often it asked, how often a set of gains was tried, and whether something was found.
    let until = |last: usize| {
        let (asked, tried) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let tried_one = || {
            tried.fetch_add(1, Ordering::Relaxed);
        };
        let goes_on = || asked.fetch_add(1, Ordering::Relaxed) < last;
        let tuned = request.tune_while("pd", &tried_one, &goes_on).unwrap();
        (asked.into_inner(), tried.into_inner(), tuned)
    };
    let (all, tried, whole) = until(usize::MAX);
    assert_eq!(whole.unwrap(), request.tune("pd", &|| ()).unwrap());
    // Four calls a set of gains: before it, before its joint without and with a delay, after it.
    // The judgement of a set has three joints, so eight calls.
    let (of_a_set, of_the_longest) = (4, 8);
    assert!(tried > 20 && all >= of_a_set * (tried + 2), "{all} of {tried}");
    for last in [0, 1, 2, 3, all / 4, all / 2, of_a_set * tried, all - 2, all - 1] {
        let (asked, tried_until, tuned) = until(last);
        assert!(tuned.is_none(), "after {last} of {all}");
        // Each joint of the set that was cancelled still asks, and none runs.
        assert!((last + 1..=last + of_the_longest).contains(&asked), "{asked} after {last}");
        let sets = last / of_a_set;
        assert!((sets.saturating_sub(1).min(tried)..=sets).contains(&tried_until), "{tried_until}");
    }
}

#[test]
fn what_was_found_before_a_cancelling_is_kept() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let mut wanted = tune(&[], "settle");
        wanted["cases"] = 12.into();
        page.done(wanted).await;
        page.until(|event| event["running"]["place"] == 2).await;
        page.done(json!({ "do": "cancel-tuning" })).await;
        let tuned = page.event("tuned").await;
        assert_eq!((&tuned["ok"], &tuned["cancelled"]), (&json!(true), &json!(true)), "{tuned}");
        let said = tuned["said"].as_str().unwrap();
        assert!(said.starts_with("cancelled after 1 of 7 laws: "), "{said}");
        let found = tuned["result"]["controllers"].as_object().unwrap();
        assert_eq!(found.keys().collect::<Vec<_>>(), ["pd"]);
    });
}
