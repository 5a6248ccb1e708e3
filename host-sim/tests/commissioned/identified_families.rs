//! The identification of the ensemble's joints in the image, beside that on the host: the table of
//! docs/how-to/identify.md. A joint takes eight to thirty seconds, and there are a hundred, so
//! `cargo xtask test --all` runs it. By hand:
//!
//! ```text
//! STICTION_IMAGE=... STICTION_FAMILIES=rigid,lugre STICTION_JOINTS=10 STICTION_SEED=1 \
//!     cargo test -p host-sim --features emulator --ignore-rust-version --test commissioned \
//!     families_in_the_image -- --ignored --nocapture
//! ```

use std::time::Duration;

use dynamics::joint::{CoreUnits, Substitute};
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use simulator::experiment::RunPlan;
use stiction::identification::IdentificationRequest;
use stiction::link::{FaultReport, StateCode};
use studies::ensemble::{
    Case, Family, IdentifiedCase, Rates, TrueJoint, UNEVEN, drawn, rates_markdown,
};

use experiments::experiment;
use experiments::flash_image::firmware;

/// The loop of a case as a machine's file with the joint model that its law uses, and the case's
/// true joint.
fn plan(case: &Case) -> RunPlan {
    let (bounds, truth) = (&case.bounds, TrueJoint::of(case));
    // A joint of the thesis is in degrees and volts, as a machine's file is.
    let is_axis = case.family == Family::ThesisAxis;
    let [inertia, viscous, stick, slip] = if is_axis {
        [truth.inertia, truth.viscous, truth.stick, truth.slip]
    } else {
        [bounds.inertia, bounds.viscous, bounds.breakaway[1], bounds.breakaway[0]]
    };
    let delay = u8::from(case.delay == simulator::plant::Delay::OneSample);
    let set = [
        format!("joint.gain_deg_per_s2_per_v={:?}", 1.0 / inertia),
        format!("joint.viscous_v_per_deg_per_s={viscous:?}"),
        format!("joint.friction.stick_v={stick:?}"),
        format!("joint.friction.slip_v={slip:?}"),
        format!("encoder.resolution_deg={:?}", bounds.sampled.count),
        "encoder.counter_bits=32".to_owned(),
        format!("drive.full_scale_v={:?}", bounds.sampled.largest_effort),
        format!("drive.lsb_v={:?}", bounds.sampled.lsb),
        // A slower PWM costs the emulator less time.
        "drive.pwm_hz=2000".to_owned(),
        format!("loop.sample_time_s={:?}", bounds.sampled.sample_time),
        format!("run.delay_samples={delay}"),
    ];
    let mut plan =
        experiment("step-response", &["pd"], &set.each_ref().map(String::as_str)).runs.remove(0);
    let units = CoreUnits { effort_gain: case.scale.effort };
    let side = case.encoder.side;
    plan.substitute = (!is_axis).then_some(Substitute { joint: case.joint, units, side });
    plan
}

fn identified<W: Wire>(client: &mut Client<W>, case: &Case) -> IdentifiedCase {
    let clock = |client: &mut Client<W>| {
        let status = client.status().unwrap();
        f64::from(status.clock) * f64::from(status.sample_time)
    };
    let began = clock(client);
    // A joint that a load moves is refused.
    let is_armed = client.identify_joint(IdentificationRequest::default()).is_ok();
    while client.pass(Duration::from_secs(1)).unwrap().state == StateCode::Armed {}
    let found = client.identified().unwrap().filter(|_| is_armed);
    IdentifiedCase {
        number: case.number,
        truth: TrueJoint::of(case),
        summary: found.map(|(summary, _)| summary),
        map: found.map_or_else(Default::default, |(_, map)| map),
        fault: None,
        time_s: clock(client) - began,
        farthest: 0,
        lsb: case.bounds.sampled.lsb,
    }
}

/// Identifies the joint on the host and in the image, and returns what both have found, with the
/// fault of the image.
fn on_both(case: &Case) -> ([IdentifiedCase; 2], FaultReport) {
    let plan = plan(case);
    let mut simulated = SimulatedDevice::new(&plan).unwrap();
    simulated.ticks(200);
    let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
    let here = identified(&mut client, case);
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap();
    client.pass(Duration::from_millis(200)).unwrap();
    let there = identified(&mut client, case);
    let fault = client.status().unwrap().fault;
    ([here, there], fault)
}

/// Gravity takes two passes of the search for its fits, which is the longest that a board computes.
/// The watchdog waits for 15 ms in the image, and for no fit.
#[test]
fn a_joint_with_gravity_is_identified_in_the_image_as_on_the_host() {
    let ([here, there], fault) = on_both(&drawn("gravity", 1, 0).unwrap());
    let estimate = there.summary.unwrap().estimate.unwrap();
    assert!(estimate.gravity[0][1] > 0.0, "no gravity was found: {estimate:?}");
    assert_eq!((&there.summary, &there.map), (&here.summary, &here.map));
    assert_eq!(fault.code, 0, "{fault:?}");
}

fn number<T: std::str::FromStr>(name: &str, otherwise: T) -> T {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
#[ignore = "half a minute a joint: cargo xtask test --all"]
fn families_in_the_image_are_identified_as_on_the_host() {
    // An arm has two joints.
    let single = Family::USUAL.into_iter().filter(|family| !family.is_arm()).map(Family::name);
    let all = single.chain([UNEVEN]).collect::<Vec<_>>().join(",");
    let families = std::env::var("STICTION_FAMILIES").unwrap_or(all);
    let (joints, seed) = (number("STICTION_JOINTS", 10), number("STICTION_SEED", 1));
    let (mut tables, mut differ) = (Vec::new(), Vec::new());
    for family in families.split(',') {
        let [mut on_the_host, mut in_the_image] = ["host", "image"]
            .map(|place| Rates { family: format!("{family}, {place}"), ..Rates::default() });
        for joint in 0..joints {
            let case = drawn(family, seed, joint).unwrap();
            let ([here, there], fault) = on_both(&case);
            if (&there.summary, &there.map) != (&here.summary, &here.map) {
                differ.push(format!("{family} {joint}: {there:?}, on the host {here:?}"));
            }
            let outcome = there.summary.map(|summary| summary.outcome);
            println!("{family} {joint}: {:.0} s, {outcome:?}, {fault:?}", there.time_s);
            on_the_host.count(&here);
            in_the_image.count(&there);
        }
        tables.extend([on_the_host, in_the_image]);
        println!("{}", rates_markdown(&tables));
    }
    assert!(differ.is_empty(), "{} differ: {}", differ.len(), differ.join("\n"));
}
