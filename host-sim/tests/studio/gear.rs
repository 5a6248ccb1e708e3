//! The gear of a device with two encoders, which the studio measures after an identification.

use std::process::Command;
use std::sync::atomic::Ordering;
use std::time::Duration;

use serde_json::{Value, json};
use simulator::device::clock::Clock;
use simulator::device::simulated::SimulatedDevice;
use simulator::experiment::{Document, Experiment};

use super::line::Line;
use super::page::{Page, Studio, run, studio_of, studio_on_a_slow_wire};

/// True stiffness, N m/rad, and true slack, deg.
const TRUTH: [f64; 2] = [4000.0, 0.15];

/// Counts of the motor's encoder in a turn of the joint.
const COUNTS: f64 = 100_000.0;

/// Link timeout of the device, s. A device in haste runs 5 s between two keep-alives.
const LINK_TIMEOUT: &str = "30.0";

/// The typical joint with a harmonic gear and two encoders, as a file with this gear.
fn file(directory: &tempfile::TempDir, name: &str, [stiffness, slack]: [f64; 2]) -> String {
    let path = directory.path().join(name).to_str().unwrap().to_owned();
    let (stiffness, slack) = (stiffness.to_string(), slack.to_string());
    let gear = ["--stiffness", &stiffness, "--backlash", &slack, "--counts-per-turn", "16384"];
    let new = ["new", &path, "--typical", "harmonic"];
    let made = Command::new(env!("CARGO_BIN_EXE_stiction")).args(new).args(gear).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    path
}

/// A line to a device in haste with the true gear, and a studio whose file has another gear.
fn studio(directory: &tempfile::TempDir, is_slow: bool, link_timeout_s: &str) -> (Line, Studio) {
    let truth = file(directory, "truth.toml", TRUTH);
    let believed = file(directory, "joint.toml", [9000.0, 0.05]);
    let mut document = Document::open(&truth).unwrap();
    document.set(&[format!("limits.link_timeout_s={link_timeout_s}")]).unwrap();
    let plan = Experiment::plan(&document, &["robust".into()], &[]).unwrap().into_first().unwrap();
    let line = Line::around(SimulatedDevice::new(&plan).unwrap());
    let line = Line { in_haste: true, ..line };
    let wire = line.clone();
    let open = move || Ok(wire.clone());
    let server = if is_slow {
        studio_on_a_slow_wire(&line.clock, &believed, open)
    } else {
        studio_of(&line.clock, &believed, true, open)
    };
    (line, server)
}

/// Identifies, and waits until this number of moves has started.
async fn moving(page: &mut Page, made: u64) {
    let said = page.done(json!({ "do": "identify" })).await;
    assert!(said.contains("moves with the loop closed follow"), "{said}");
    page.until(|event| event["gear"]["made"] == made).await;
}

#[test]
fn after_an_identification_the_gear_of_two_encoders_is_measured_and_is_in_the_file() {
    for is_slow in [false, true] {
        let directory = tempfile::tempdir().unwrap();
        let (line, server) = studio(&directory, is_slow, LINK_TIMEOUT);
        run(async {
            let mut page = Page::open(&server).await;
            page.done(json!({ "do": "identify" })).await;
            let (mut made, mut columns) = (vec![], vec![]);
            let found = loop {
                let event = page.next().await.unwrap();
                match event["event"].as_str().unwrap() {
                    "status" if event["gear"].is_object() => {
                        made.push(
                            [&event["gear"]["made"], &event["gear"]["moves"]].map(Value::clone),
                        );
                    }
                    "hello" => columns.push(event["signals"].as_array().unwrap().len()),
                    "identified" => break event,
                    _ => {}
                }
            };
            if is_slow {
                // The joint comes first: the device may not answer any more.
                let hello = page.event("hello").await;
                columns.push(hello["signals"].as_array().unwrap().len());
            }
            made.dedup();
            let started = (0..=3).map(|made| [json!(made), json!(3)]).collect::<Vec<_>>();
            assert_eq!(made, started);
            // A wire that cannot carry all signals at 1 kHz carries those of the moves meanwhile.
            let (first, all) = (columns.first(), columns.len());
            assert_eq!(
                (first, all),
                if is_slow { (Some(&4), 2) } else { (None, 0) },
                "{columns:?}"
            );
            assert!(columns.last().is_none_or(|last| *last > 10), "{columns:?}");
            let gear = &found["gear"];
            assert_eq!(found["gear_refused"], Value::Null, "{found}");
            for (value, truth) in [
                (&gear["si"]["stiffness"], TRUTH[0]),
                (&gear["slack_deg"], TRUTH[1]),
                (&gear["ratio"], COUNTS),
            ] {
                let [value, sd] = ["value", "sd"].map(|key| value[key].as_f64().unwrap());
                assert!((value - truth).abs() < 3.0 * sd && sd < 0.1 * truth, "{value} +- {sd}");
            }
            assert_eq!(gear["lost_samples"], 0, "{gear}");
            assert!(found["said"].as_str().unwrap().contains("\nslack "), "{found}");
            let file = Document::parse("found", found["toml"].as_str().unwrap()).unwrap();
            for (key, truth) in ["stiffness_nm_per_rad", "backlash_deg"].iter().zip(TRUTH) {
                let value = file.number(&format!("gear.{key}")).unwrap();
                assert!((value / truth - 1.0).abs() < 0.1, "{key}: {value}");
            }
            page.state("stopped").await;
            assert_eq!([starts(&line, "Arm"), starts(&line, "Move")], [1, 3]);
        });
    }
}

/// The joint that the sequence has identified, without a gear, and why.
async fn without_gear(page: &mut Page) -> String {
    let found = page.event("identified").await;
    assert_eq!((&found["ok"], &found["gear"]), (&json!(true), &Value::Null), "{found}");
    found["gear_refused"].as_str().unwrap().to_owned()
}

#[test]
fn a_stop_ends_the_moves_for_the_gear_at_once_and_the_joint_is_known() {
    let directory = tempfile::tempdir().unwrap();
    let (line, server) = studio(&directory, false, LINK_TIMEOUT);
    run(async {
        // Any page can stop, also while the device is not armed yet.
        for made in [0, 2] {
            let mut page = Page::open(&server).await;
            moving(&mut page, made).await;
            let why = page.refused(json!({ "do": "jog" })).await;
            assert!(why.contains("moves measure the gear"), "{why}");
            let before = line.names().len();
            page.done(json!({ "do": "stop" })).await;
            assert!(without_gear(&mut page).await.contains("ended by a stop"));
            page.state("stopped").await;
            page.watch(Duration::from_secs(1)).await;
            let after = line.names().split_off(before);
            let drives = |name: &String| name.starts_with("Arm") || name.starts_with("Move");
            assert!(!after.iter().any(drives), "{after:?}");
            drop(page);
            line.clock.pass(Duration::from_secs(2)).await;
        }
    });
}

fn starts(line: &Line, request: &str) -> usize {
    line.names().iter().filter(|name| name.starts_with(request)).count()
}

#[test]
fn the_link_timeout_ends_the_moves_for_the_gear_of_a_silent_page() {
    let directory = tempfile::tempdir().unwrap();
    let (line, server) = studio(&directory, false, LINK_TIMEOUT);
    run(async {
        let mut page = Page::open(&server).await;
        moving(&mut page, 1).await;
        // It reads, and sends nothing.
        page.lives = false;
        let why = without_gear(&mut page).await;
        assert!(why.contains("ended by fault 22"), "{why}");
        assert_eq!([starts(&line, "Arm"), starts(&line, "Move")], [1, 1], "{:?}", line.names());
    });
}

#[test]
fn the_moves_for_the_gear_do_not_start_for_a_page_that_is_silent_since_the_sequence() {
    let directory = tempfile::tempdir().unwrap();
    let (line, server) = studio(&directory, false, "600.0");
    run(async {
        let mut page = Page::open(&server).await;
        page.done(json!({ "do": "identify" })).await;
        page.state("armed").await;
        page.lives = false;
        let why = without_gear(&mut page).await;
        assert!(why.contains("were not started"), "{why}");
        page.lives = true;
        page.state("stopped").await;
        page.watch(Duration::from_secs(1)).await;
        assert_eq!(starts(&line, "Arm"), 0, "{:?}", line.names());
    });
}

#[test]
fn another_page_that_takes_the_command_does_not_go_on_with_the_moves_for_the_gear() {
    let directory = tempfile::tempdir().unwrap();
    let (line, server) = studio(&directory, false, LINK_TIMEOUT);
    run(async {
        let mut page = Page::open(&server).await;
        moving(&mut page, 1).await;
        drop(page);
        let mut other = Page::open(&server).await;
        let end = line.clock.now() + Duration::from_secs(20);
        let why = without_gear(&mut other).await;
        assert!(why.contains("ended by") && line.clock.now() < end, "{why}");
    });
}

#[test]
fn the_joint_is_known_if_the_device_is_lost_during_the_moves_for_the_gear() {
    let directory = tempfile::tempdir().unwrap();
    let (line, server) = studio(&directory, false, LINK_TIMEOUT);
    run(async {
        let mut page = Page::open(&server).await;
        moving(&mut page, 1).await;
        line.is_cut.store(true, Ordering::SeqCst);
        let why = without_gear(&mut page).await;
        assert!(why.contains("its moves were ended: "), "{why}");
        page.event("gone").await;
    });
}
