//! Homing from the page: the joint is referenced at its stop, and by nothing less.

use std::sync::Arc;
use std::time::Duration;

use serde_json::json;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use simulator::experiment::{Document, Experiment, RunPlan, parameters};
use stiction::servo::Boot;

use crate::axis_with_stops::axis_with_stops;
use crate::clock::TestClock;
use crate::page::{Page, Studio, run, studio_of};

/// Place of the stop from where the joint stands, deg.
const STOP_DEG: f64 = 3.0;

/// A studio around the thesis's axis before a stop, after a reset: its range needs a reference.
fn studio() -> Studio {
    let clock = Arc::<TestClock>::default();
    let of_wire = clock.clone();
    studio_of(&clock, "step-response", true, move || {
        let mut document = Document::open("step-response")?;
        let set = [
            "limits.position_min_deg=-10",
            "limits.position_max_deg=40",
            "device.reference=\"command\"",
        ];
        document.set(&set.map(str::to_owned))?;
        let plan = Experiment::plan(&document, &["srnf".into()], &[])?.into_first().unwrap();
        let parameters = parameters(&plan)?;
        let plan = RunPlan { substitute: Some(axis_with_stops([-1e3, STOP_DEG])), ..plan };
        let device = SimulatedDevice::running(&plan, &parameters, Boot::default())?;
        Ok(SimulatedWire::on_clock(device, of_wire.clone()))
    })
}

#[test]
fn the_joint_is_referenced_at_its_stop_and_by_nothing_less() {
    run(async {
        let server = studio();
        let mut page = Page::open(&server).await;
        // Without a reference no motion within the range can start.
        let said = page.refused(json!({ "do": "arm" })).await;
        assert!(said.contains("reference"), "{said}");

        // A stop on the way leaves the joint without one.
        let home = json!({ "do": "home", "home": { "towards": "plus", "at_deg": 40.0 } });
        let said = page.done(home.clone()).await;
        assert!(said.contains("not referenced until both places agree"), "{said}");
        page.state("armed").await;
        page.done(json!({ "do": "stop" })).await;
        assert_eq!(page.state("stopped").await["referenced"], false);

        // No stop within the travel.
        let mut short = home.clone();
        short["home"]["travel_deg"] = json!(1.0);
        page.done(short).await;
        let found = page.until(|event| event["event"] == "found").await;
        assert_eq!(found["grade"], "bad", "{found}");
        assert!(found["said"].as_str().unwrap().contains("no stop within the travel"), "{found}");
        // The page has no options of a command.
        assert!(!found["said"].as_str().unwrap().contains("--"), "{found}");

        // Until the joint has coasted to its rest.
        page.watch(Duration::from_millis(500)).await;
        page.done(home).await;
        let found = page.until(|event| event["event"] == "found").await;
        assert_eq!(found["grade"], "good", "{found}");
        assert!(found["said"].as_str().unwrap().contains("the joint is referenced"), "{found}");
        let status = page.until(|event| event["state"] == "stopped").await;
        assert_eq!(status["referenced"], true);
        page.watch(Duration::from_millis(500)).await;
        page.done(json!({ "do": "arm" })).await;
        page.done(json!({ "do": "stop" })).await;

        for wrong in [
            json!({ "do": "home" }),
            json!({ "do": "home", "home": { "towards": "up", "at_deg": 0.0 } }),
            json!({ "do": "home", "deg": 1.0, "home": { "towards": "plus", "at_deg": 0.0 } }),
        ] {
            // A request that is not understood has no number.
            page.send(&wrong).await;
            assert_eq!(page.event("answer").await["ok"], false, "{wrong}");
        }
        let far = json!({ "do": "home", "home": { "towards": "plus", "at_deg": 1e12 } });
        let said = page.refused(far).await;
        assert!(said.contains("2^30 counts"), "{said}");
    });
}
