//! A gearmotor whose encoder cannot see 0.6 deg of backlash, in the studio: prediction, tuning and
//! self-test say the same of both sides of its gear as the commands do
//! (`tests/commissioned/walk.rs`), also where the device has another joint than the file.

use std::time::Duration;

use host_sim::device::simulated::SimulatedDevice;
use host_sim::device::wire::SimulatedWire;
use host_sim::experiment::{Document, Experiment, RunPlan};
use host_sim::studio::Server;
use serde_json::{Value, json};

use super::page::{Page, Visit, run, studio_of_file};
use super::what_if::{predicted, wish};

const GEARMOTOR: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/tests/joints_under_test/gear_with_backlash.toml");
const SLACK: &str = "cannot see 171 counts of backlash";

fn plan(set: &[&str]) -> RunPlan {
    let mut document = Document::open(GEARMOTOR).unwrap();
    document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>()).unwrap();
    Experiment::plan(&document, &["robust".into()], &[]).unwrap().into_first().unwrap()
}

/// A studio with the gearmotor's file, around a device whose joint has other keys.
fn studio_with_truth(set: &'static [&'static str]) -> Server {
    studio_of_file(GEARMOTOR, || {
        let plan = plan(&[]).with_truth(plan(set))?;
        Ok(SimulatedWire::new(SimulatedDevice::new(&plan)?))
    })
}

/// Makes the moves of a self-test, and returns its last event.
async fn tested(page: &mut Page) -> Value {
    page.done(json!({ "do": "predict-selftest", "moves": 4 })).await;
    let of_phase = |phase: &'static str| {
        move |event: &Value| event["event"] == "selftest" && event["phase"] == phase
    };
    let ready = page.until(of_phase("ready")).await;
    assert!(ready["unseen_slack"].as_str().unwrap().contains(SLACK), "{ready}");
    page.done(json!({ "do": "selftest", "number": ready["number"] })).await;
    page.until(of_phase("done")).await
}

#[test]
fn prediction_and_self_test_of_a_gearmotor_meet_the_goal_at_the_encoder_alone() {
    run(async {
        let server = studio_with_truth(&["friction.slip_nm=0.24"]);
        let mut page = Visit::proper(&server).connect().await.unwrap();
        let now = page.event("what-if").await;
        assert!(now["unseen_slack"].as_str().unwrap().contains(SLACK), "{now}");
        let move_by = json!({ "how": "move", "deg": 5.0 });
        let curves = predicted(&mut page, "laws", wish(&move_by, &["robust"], &json!({}), 0)).await;
        assert_eq!(curves[0]["success_at_encoder"], true);
        assert_eq!(curves[0]["success_at_load"], false);
        page.watch(Duration::from_millis(100)).await;
        let done = tested(&mut page).await;
        assert_eq!(done["result"]["verdict"], "pass", "{done}");
        assert!(done["unseen_slack"].as_str().unwrap().contains(SLACK), "{done}");
        for made in done["result"]["moves"].as_array().unwrap() {
            assert_eq!(made["success_at_encoder"], true, "{made}");
        }
    });
}

#[test]
fn the_self_test_of_a_joint_that_sticks_twice_as_much_as_its_file_says_fails() {
    run(async {
        let server = studio_with_truth(&["friction.stick_nm=0.7", "friction.slip_nm=0.55"]);
        let mut page = Page::open(&server).await;
        let done = tested(&mut page).await;
        assert_eq!(done["result"]["verdict"], "fail", "{done}");
    });
}
