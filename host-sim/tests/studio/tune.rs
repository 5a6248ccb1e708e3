//! Tuning from the page: what `stiction tune` finds, without a device, and nothing else moves by it.

use std::time::Duration;

use host_sim::ensemble::rules::TUNING_SEEDS;
use host_sim::experiment::Document;
use host_sim::tuning::{CASES, Goal, Request, object, rewritten, spreads};
use serde_json::{Value, json};

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
    let text = std::fs::read_to_string("experiments/step-response.toml").unwrap();
    std::fs::write(&file, &text).unwrap();
    let machine: &'static str = file.to_str().unwrap().to_owned().leak();
    run(async {
        let server = studio_around(machine, "srnf", &[]);
        let mut page = Page::open(&server).await;
        // A page that only looks may ask as well: it moves nothing.
        let mut reader = Page::open(&server).await;
        let said = reader.done(tune(&["pd"], "settle")).await;
        assert_eq!(said, "tunes pd for settle");
        let is_on_its_way =
            |event: &Value| event["event"] == "tuning" && event["running"]["tried"].is_u64();
        let running = page.until(is_on_its_way).await["running"].clone();
        assert_eq!((&running["law"], &running["of"]), (&json!("pd"), &json!(1)), "{running}");
        let tuned = page.event("tuned").await;
        assert_eq!(tuned["ok"], true, "{tuned}");
        let document = Document::open(machine).unwrap();
        let request = Request {
            file: machine.into(),
            goal: Goal::Settle,
            limits: vec![],
            spreads: spreads(&document).unwrap(),
            cases: CASES,
            seed: *TUNING_SEEDS.start(),
            document,
        };
        let same = [request.tune("pd", &|| ()).unwrap()];
        assert!(same[0].better, "nothing would be shown");
        assert_eq!(tuned["result"], object(machine, &same));
        assert_eq!(tuned["toml"], rewritten(&text, &same).unwrap());
        assert_eq!(tuned["file"], "joint.tuned.toml");
        let charts = tuned["charts"].as_array().unwrap();
        assert!(charts.iter().all(|one| one.as_str().unwrap().starts_with("<svg")));
        assert_eq!(charts.len(), if cfg!(feature = "figures") { 2 } else { 0 });
        // A page that comes later is told what was found, and that nothing runs.
        let mut later = super::Visit::proper(&server).connect().await.unwrap();
        assert_eq!(later.event("tuned").await["toml"], tuned["toml"]);
        assert!(later.event("tuning").await["running"].is_null());
    });
    let files: Vec<_> = std::fs::read_dir(&directory).unwrap().flatten().collect();
    assert_eq!((files.len(), std::fs::read_to_string(&file).unwrap()), (1, text));
    std::fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn one_tuning_runs_at_a_time_and_a_cancelled_one_ends_at_once() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        assert!(page.refused(json!({ "do": "cancel-tuning" })).await.contains("no tuning runs"));
        assert!(page.refused(tune(&["pd", "nobody"], "track")).await.contains("`nobody`"));
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
fn without_a_file_nothing_is_tuned_and_the_reason_is_told() {
    run(async {
        let server = studio_without_a_file();
        let mut page = super::Visit::proper(&server).connect().await.unwrap();
        let told = page.event("tuning").await;
        assert!(told["why"].as_str().unwrap().contains("without a machine's file"), "{told}");
        assert_eq!(told["laws"], json!([]));
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
                tokio::time::sleep(Duration::from_millis(40)).await;
            }
        };
        tokio::select! {
            () = asks => {}
            on = ticks_on_after(&mut reader, last) => {
                let on_s = on as f64 * TICK_S;
                assert!(on_s < LINK_TIMEOUT_S + SLACK_S, "{on_s} s");
            }
        }
        assert_eq!(reader.state("faulted").await["fault"]["code"], 22);
    });
}
