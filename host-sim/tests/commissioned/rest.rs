//! A joint that rests against its load trips nothing: limits that are derived from its file know
//! the torque of the load, and a simulated joint lies on a flank of its gear before it is armed.

use std::sync::Mutex;
use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use simulator::experiment::{Document, Experiment, RunPlan};
use simulator::progress::Silent;
use simulator::rules::{GainRule, JointBounds, JointEstimate, RULES, SampledLoop};
use stiction::control::laws::Gains;
use stiction::control::reference::{Reference, Step};
use stiction::link::{StateCode, Status};
use stiction::servo::{Boot, State};
use stiction::units::position::Position;
use stiction::{Fault, Limits, Parameters};
use studies::ensemble::{Approach, CaseResult, DrawOptions, Ensemble, Family, run};

const GEARMOTOR: &str = include_str!("../joints_under_test/gear_with_backlash.toml");

/// The load hangs at -90 deg, so its torque at zero is the whole unbalance, downwards.
const UNBALANCE_NM: f64 = 0.25;
const STICK_NM: f64 = 0.35;
/// n eta K_t / R of the file.
const NM_PER_V: f64 = 50.0 * 0.75 * 0.016 / 2.1;

fn document(text: &str, set: &[&str]) -> Document {
    let mut document = Document::parse("gearmotor.toml", text).unwrap();
    let unbalance = format!("load.unbalance_nm={UNBALANCE_NM}");
    let set: Vec<String> =
        [&unbalance].into_iter().cloned().chain(set.iter().map(|s| (*s).into())).collect();
    document.set(&set).unwrap();
    document
}

fn plan(text: &str, set: &[&str]) -> RunPlan {
    Experiment::plan(&document(text, set), &[], &[]).unwrap().runs.remove(0)
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
        near(2.0 * found.breakaway_min, STICK_NM);
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

/// Parameters of a run with the rule book's gains of another law, and its derived limits.
fn with_gains(plan: &RunPlan, rule: &GainRule) -> Option<Parameters> {
    let mut parameters = simulator::experiment::parameters(plan).unwrap();
    let (sheet, mapping) = document(&rigid(), &[]).mapping().unwrap().unwrap();
    let controller = &mut parameters.controller;
    let estimate = JointEstimate::of_sheet(&sheet, &mapping);
    let gains = rule.gains(&JointBounds::of(&estimate, SampledLoop::of(controller)));
    (controller.pd, controller.velocity_window) = (gains.pd, gains.velocity_window);
    controller.compensator = gains.laws.iter().copied().collect();
    let Limits { breakaway_min, breakaway_effort, stop_gain, .. } = parameters.limits;
    let derived = Limits::derived(controller, &parameters.device, breakaway_effort);
    parameters.limits = Limits { breakaway_min, ..derived.of_gain(0.5 * stop_gain, controller) };
    gains.laws.iter().all(Gains::on_the_device).then_some(parameters)
}

/// Where a law stops short, the effort that holds the load is between the lowest and the highest
/// breakaway, so the encoder is probed: upwards, for the effort pulls upwards.
#[test]
fn a_load_is_held_for_five_minutes_under_each_law_while_the_encoder_is_probed() {
    let plan = plan(&rigid(), &["loop.controller=pd"]);
    let mut laws = 0;
    for rule in RULES {
        let Some(parameters) = with_gains(&plan, rule) else { continue };
        laws += 1;
        let mut device = SimulatedDevice::running(&plan, &parameters, Boot::default()).unwrap();
        device.ticks(100);
        let servo = device.device.servo();
        servo.arm_for_link(None).unwrap();
        device.tick();
        let to_deg = 0.2;
        let to = Position::from_counts((to_deg / device_count(&parameters)).round() as i32);
        let step = Step { from: Position::default(), to, at_tick: 0 };
        device.device.servo().follow(Reference::Step(step)).unwrap();
        for tick in 0..300_000 {
            device.device.servo().heard();
            let output = device.tick();
            let (name, at) = (rule.law, device.position_deg());
            assert_eq!(output.state, State::Armed, "{name}, tick {tick}, {at} deg");
            // 0.2 deg are 57 counts; the load would fall by 90 deg.
            assert!((-0.05..0.5).contains(&at), "{name}, tick {tick}, {at} deg");
        }
    }
    assert!(laws >= 9, "{laws}");
}

fn device_count(parameters: &Parameters) -> f64 {
    parameters.controller.encoder.resolution.into()
}

/// Runs 8 joints of each family under every law with derived limits, and returns family, joint, law
/// and faults of each run.
fn faults_of(approach: Approach, families: &[Family]) -> Vec<(String, u64, String, Vec<String>)> {
    let ensemble = Ensemble {
        seed: 2026,
        cases: 8,
        kind: DrawOptions::ORDINARY,
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
    run(&ensemble, &Silent, |_, _, _| true, keep).unwrap();
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
