//! A joint that rests against its load trips nothing: limits that are derived from its file know
//! the torque of the load, and a simulated joint lies on a flank of its gear before it is armed.

use std::sync::Mutex;
use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use simulator::experiment::{Document, Experiment, RunPlan};
use simulator::rules::RULES;
use stiction::Fault;
use stiction::link::{StateCode, Status};
use studies::ensemble::{Approach, CaseResult, DrawOptions, Ensemble, Family, run};

const GEARMOTOR: &str = include_str!("../joints_under_test/gear_with_backlash.toml");

/// The load hangs at -90 deg, so its torque at zero is the whole unbalance, downwards.
const UNBALANCE_NM: f64 = 0.25;
const STICK_NM: f64 = 0.35;
/// n eta K_t / R of the file.
const NM_PER_V: f64 = 50.0 * 0.75 * 0.016 / 2.1;

fn plan(text: &str, set: &[&str]) -> RunPlan {
    let mut document = Document::parse("gearmotor.toml", text).unwrap();
    let unbalance = format!("load.unbalance_nm={UNBALANCE_NM}");
    let set: Vec<String> =
        [&unbalance].into_iter().cloned().chain(set.iter().map(|s| (*s).into())).collect();
    document.set(&set).unwrap();
    Experiment::plan(&document, &[], &[]).unwrap().runs.remove(0)
}

/// The same joint with a rigid gear.
fn rigid() -> String {
    let of_the_spring = |line: &&str| {
        !["backlash_deg", "stiffness_nm_per_rad", "damping_nm_s_per_rad"]
            .iter()
            .any(|key| line.starts_with(key))
    };
    GEARMOTOR.lines().filter(of_the_spring).map(|line| format!("{line}\n")).collect()
}

fn client(plan: &RunPlan) -> Client<SimulatedWire> {
    Client::connect(SimulatedWire::new(SimulatedDevice::new(plan).unwrap())).unwrap()
}

/// Steps up by a degree, against the load, and holds it there for a minute of simulated time.
fn held_for_a_minute(plan: &RunPlan) -> Status {
    let mut client = client(plan);
    client.arm().unwrap();
    client.step_to(1.0).unwrap();
    client.pass_armed(Duration::from_secs(60)).unwrap()
}

#[test]
fn a_joint_that_rests_against_its_unbalance_trips_nothing_and_does_with_friction_alone_as_limit() {
    let text = rigid();
    // PD stops where its effort is that of slip friction and load, and stays there.
    let derived = held_for_a_minute(&plan(&text, &["loop.controller=pd"]));
    assert_eq!((derived.state, derived.fault.code), (StateCode::Armed, 0), "{derived:?}");
    assert!(derived.at_rest && !derived.wound_up, "{derived:?}");
    let friction = format!("limits.breakaway_v={}", STICK_NM / NM_PER_V);
    let friction = held_for_a_minute(&plan(&text, &["loop.controller=pd", &friction]));
    assert_eq!(friction.fault.code, Fault::Stall as u8, "{friction:?}");
}

#[test]
fn the_derived_limits_are_those_of_friction_and_load() {
    let limits =
        |set: &[&str]| simulator::experiment::parameters(&plan(GEARMOTOR, set)).unwrap().limits;
    let near = |found: f32, torque: f64| {
        let expected = torque / NM_PER_V;
        assert!((f64::from(found) - expected).abs() < 1e-5 * expected, "{found} V, {expected} V");
    };
    for (set, torque) in [
        (&[][..], STICK_NM + UNBALANCE_NM),
        (&["load.unbalance_nm=0"], STICK_NM),
        (&["load.constant_nm=-0.1"], STICK_NM + UNBALANCE_NM + 0.1),
        (&["load.constant_nm=0.1", "load.unbalance_nm=0"], STICK_NM + 0.1),
        // Both ways have their own friction.
        (&["friction.stick_reverse_nm=0.45", "friction.slip_reverse_nm=0.32"], 0.45 + UNBALANCE_NM),
    ] {
        let found = limits(set);
        near(found.breakaway_effort, torque);
        near(found.wind_up_effort, torque);
        near(found.stall_effort, 2.0 * torque);
        near(2.0 * found.stall_impulse, torque);
    }
    // What the file says is taken as it is.
    near(limits(&["limits.breakaway_v=1.5"]).breakaway_effort, 1.5 * NM_PER_V);
}

#[test]
fn a_joint_with_slack_and_unbalance_is_at_rest_before_it_is_armed_and_holds_under_each_law() {
    for law in ["robust", "srnf", "both", "pd"] {
        let plan = plan(GEARMOTOR, &[&format!("loop.controller={law}")]);
        let status = client(&plan).status().unwrap();
        assert!(status.at_rest && status.position == 0, "{law}: {status:?}");
        let held = held_for_a_minute(&plan);
        assert_eq!((held.state, held.fault.code), (StateCode::Armed, 0), "{law}: {held:?}");
    }
}

/// Runs 8 joints of each family under every law with derived limits, and returns family, joint, law
/// and faults of each run.
fn faults_of(approach: Approach, families: &[Family]) -> Vec<(String, u64, String, Vec<String>)> {
    let ensemble = Ensemble {
        seed: 2026,
        cases: 8,
        kind: DrawOptions { hard: false, rate_hz: 1000.0 },
        approach,
        moves: 0,
        families: families.to_vec(),
        rules: RULES.iter().collect(),
    };
    let rows = Mutex::new(Vec::new());
    let keep = |row| {
        rows.lock().unwrap().push(row);
        Ok(())
    };
    run(&ensemble, |_, _, _| true, keep).unwrap();
    let rows = rows.into_inner().unwrap();
    assert_eq!(rows.len(), 8 * families.len() * RULES.len());
    let of = |row: &CaseResult| {
        let faults = row.faults().map(str::to_owned).collect();
        (row.family.clone(), row.case, row.law.clone(), faults)
    };
    rows.iter().map(of).collect()
}

/// A move as users make it, against a load and against gravity.
#[test]
fn no_joint_of_the_families_with_load_and_gravity_trips_in_a_profiled_move() {
    for (family, case, law, faults) in
        faults_of(Approach::Profiled, &[Family::Gravity, Family::Loaded])
    {
        assert!(faults.is_empty(), "{family} {case} {law}: {faults:?}");
    }
}

/// A step that is far for a law without a profile trips the overspeed, whatever the load is. Load
/// and gravity trip nothing.
#[test]
fn no_joint_of_the_families_with_load_and_gravity_stalls_with_derived_limits() {
    let families = [Family::Gravity, Family::Loaded, Family::OverhaulingGravity];
    for (family, case, law, faults) in faults_of(Approach::Step, &families) {
        assert!(
            faults.iter().all(|fault| fault == "overspeed"),
            "{family} {case} {law}: {faults:?}"
        );
        assert!(faults.is_empty() || law != "robust", "{family} {case} {law}: {faults:?}");
    }
}
