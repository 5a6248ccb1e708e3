//! A gearmotor whose encoder cannot see 0.6 deg of backlash, in the studio, around a device whose
//! joint is another one than the file's: prediction, identification, tuning and self-test say the
//! same of both sides of its gear as the commands do (`tests/commissioned/walk.rs`).

use std::cell::RefCell;
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use serde_json::{Value, json};
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use simulator::experiment::{Document, Experiment, RunPlan};

use super::clock::TestClock;
use super::gearmotor::{SLACK, new};
use super::line::Line;
use super::page::{Page, Visit, run, studio_of};
use super::what_if::{predicted, wish};

fn plan(file: &str, set: &[&str]) -> RunPlan {
    let mut document = Document::open(file).unwrap();
    document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>()).unwrap();
    Experiment::plan(&document, &["robust".into()], &[]).unwrap().into_first().unwrap()
}

/// The device of a file with the joint of another one.
fn device_with_truth(file: &str, truth: &str, set: &[&str]) -> SimulatedDevice {
    let plan = plan(file, set).with_truth(plan(truth, set)).unwrap();
    SimulatedDevice::new(&plan).unwrap()
}

/// Waits for an event that takes as long as its computation.
async fn awaited(page: &mut Page, wanted: impl Fn(&Value) -> bool) -> Value {
    loop {
        let event = page.next().await.expect("the connection has ended");
        if wanted(&event) {
            return event;
        }
    }
}

/// Makes four moves of a self-test with the joint of the file or the found one, and returns its
/// last event.
async fn tested(page: &mut Page, joint: &str) -> Value {
    page.done(json!({ "do": "predict-selftest", "moves": 4, "joint": joint })).await;
    let of_phase = |phase: &'static str| {
        move |event: &Value| event["event"] == "selftest" && event["phase"] == phase
    };
    let ready = awaited(page, of_phase("ready")).await;
    assert!(ready["unseen_slack"].as_str().unwrap().contains(SLACK), "{ready}");
    page.done(json!({ "do": "selftest", "number": ready["number"] })).await;
    awaited(page, of_phase("done")).await
}

/// Asserts that a move of 5 deg with the joint of the file or the found one meets the goal at the
/// encoder alone.
async fn predicted_at_the_encoder_alone(page: &mut Page, joint: &str) {
    let way = json!({ "how": "move", "deg": 5.0 });
    let mut wanted = wish(&way, &["robust"], &json!({}), 0);
    wanted["wish"]["joint"] = joint.into();
    let curves = predicted(page, "laws", wanted).await;
    assert_eq!(curves[0]["success_at_encoder"], true, "{joint}");
    assert_eq!(curves[0]["success_at_load"], false, "{joint}");
    assert!((80.0..130.0).contains(&curves[0]["rest_at_load_counts"].as_f64().unwrap()), "{joint}");
}

/// Returns the JSON of a command.
fn json_of(directory: &Path, arguments: &[&str]) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    let output = command.args(arguments).current_dir(directory).output().unwrap();
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{arguments:?}: {}", String::from_utf8_lossy(&output.stderr)))
}

#[test]
fn a_gearmotor_is_judged_from_its_first_file_to_its_self_test_as_by_the_commands() {
    let desk = tempfile::tempdir().unwrap();
    new(desk.path(), "gearmotor.toml", &["--stick-nm", "0.3..0.4", "--slip-nm", "0.22"]);
    new(desk.path(), "truth.toml", &["--stick-nm", "0.38", "--slip-nm", "0.25"]);
    let [file, truth] =
        ["gearmotor.toml", "truth.toml"].map(|name| desk.path().join(name).display().to_string());
    // Its time is not that on the wall, so that the identification takes seconds.
    let device = device_with_truth(&file, &truth, &["limits.link_timeout_s=\"off\""]);
    let device = Arc::new(Mutex::new(SimulatedWire::new(device)));
    let line = Line { device, in_haste: true, ..Line::new(&[]) };
    let of_studio = RefCell::new([Value::Null, Value::Null]);
    run(async {
        let server = line.serve_as(&file, true);
        let mut page = Visit::proper(&server).connect().await.unwrap();
        let now = page.event("what-if").await;
        assert!(now["unseen_slack"].as_str().unwrap().contains(SLACK), "{now}");
        predicted_at_the_encoder_alone(&mut page, "file").await;

        // The joint of the device is found, and what was not measured stays.
        page.done(json!({ "do": "identify" })).await;
        let found = awaited(&mut page, |event| event["event"] == "identified").await;
        assert_eq!(found["ok"], true, "{found}");
        let text = found["toml"].as_str().unwrap();
        let of = Document::parse("found.toml", text).unwrap();
        let number = |key: &str| of.get(key).unwrap().as_float().unwrap();
        assert_eq!(
            (number("gear.backlash_deg"), number("gear.stiffness_nm_per_rad")),
            (0.6, 200.0)
        );
        // 0.22 N m of the file, 0.25 N m of the truth.
        assert!((0.24..0.26).contains(&number("friction.slip_nm")), "{text}");
        predicted_at_the_encoder_alone(&mut page, "found").await;

        // No gains rest the load: the page gets the refusal of the command, and no file.
        let mut tune = json!({ "do": "tune", "laws": ["robust"], "goal": "balanced" });
        (tune["joint"], tune["cases"]) = ("found".into(), 1.into());
        page.done(tune).await;
        let tuned = awaited(&mut page, |event| event["event"] == "tuned").await;
        assert!(tuned["toml"].is_null(), "{tuned}");
        assert!(tuned["said"].as_str().unwrap().starts_with("no gains were found"), "{tuned}");
        std::fs::write(desk.path().join("found.toml"), text).unwrap();

        // The found joint is the device's.
        let done = tested(&mut page, "found").await;
        assert!(done["unseen_slack"].as_str().unwrap().contains(SLACK), "{done}");
        of_studio.replace([tuned["result"].clone(), done["result"].clone()]);
    });

    // The commands say the same. A page that waits for them would be cut off.
    let [tuned, tested] = of_studio.into_inner();
    let command = ["tune", "found.toml", "--controller", "robust", "--cases", "1", "--json"];
    let by_command = json_of(desk.path(), &command);
    assert_eq!(tuned["controllers"], by_command["controllers"]);
    let reason = by_command["reason"].as_str().unwrap();
    assert!(reason.contains(SLACK) && tuned["reason"] == reason, "{reason}");
    let mut command = vec!["device", "--simulated", "--machine", "found.toml", "--truth"];
    command.extend(["truth.toml", "selftest", "--moves", "4", "--json"]);
    let by_command = json_of(desk.path(), &command);
    for result in [&tested, &by_command] {
        assert_eq!(result["verdict"], "pass", "{result}");
        assert_eq!(result["success_at_encoder"], true, "{result}");
        assert_eq!(result["success_at_load"], false, "{result}");
        assert_eq!(result["missed_at_load"], 4, "{result}");
        assert_eq!(result["predicted_missed_at_load"], 4, "{result}");
    }
}

#[test]
fn the_self_test_of_a_joint_that_sticks_twice_as_much_as_its_file_says_fails() {
    let desk = tempfile::tempdir().unwrap();
    new(desk.path(), "gearmotor.toml", &["--stick-nm", "0.35", "--slip-nm", "0.22"]);
    new(desk.path(), "truth.toml", &["--stick-nm", "0.7", "--slip-nm", "0.55"]);
    let [file, truth] =
        ["gearmotor.toml", "truth.toml"].map(|name| desk.path().join(name).display().to_string());
    let clock = Arc::<TestClock>::default();
    let (of_wire, of_device) = (clock.clone(), file.clone());
    let open = move || {
        let device = device_with_truth(&of_device, &truth, &[]);
        Ok(SimulatedWire::on_clock(device, of_wire.clone()))
    };
    run(async {
        let server = studio_of(&clock, &file, true, open);
        let mut page = Page::open(&server).await;
        page.watch(Duration::from_millis(100)).await;
        let done = tested(&mut page, "file").await;
        assert_eq!(done["result"]["verdict"], "fail", "{done}");
    });
}
