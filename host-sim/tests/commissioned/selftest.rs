//! The self-test of a joint over the link: it passes for the joint of the file, and for one within
//! its error bars, and fails for another joint, on either side.

use files::Error;
use simulator::device;
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use simulator::experiment::{Document, RunPlan};
use stiction::Parameters;
use stiction::link::StateCode;
use stiction::servo::Boot;
use studies::selftest::{SelfTestCheck, SelfTestRequest, SelfTestResult, run};

use experiments::both_encoders::both_encoders;
use experiments::experiment;

const FILE: &str = "step-response";

fn plan(set: &[&str]) -> RunPlan {
    experiment(FILE, &[], set).runs.remove(0)
}

fn parameters(plan: &RunPlan) -> Parameters {
    device::parameters(plan).unwrap()
}

fn asked() -> SelfTestRequest {
    SelfTestRequest {
        machine: FILE.into(),
        range_deg: None,
        moves: 20,
        joints: 8,
        seed: 1,
        spreads: vec![],
    }
}

/// A device that runs what the file says, around a joint with keys set otherwise.
fn client(set: &[&str]) -> Client<SimulatedWire> {
    let law = "loop.controller=srnf";
    let (configured, joint) = (plan(&[law]), plan(&[&[law], set].concat()));
    let device =
        SimulatedDevice::running(&joint, &parameters(&configured), Boot::default()).unwrap();
    Client::connect(SimulatedWire::new(device)).unwrap()
}

fn tested(set: &[&str]) -> SelfTestResult {
    let mut client = client(set);
    let prepared = asked().prepare(&mut client).unwrap();
    assert_eq!(client.status().unwrap().state, StateCode::Stopped, "armed for a prediction");
    let session = run(&mut client, &prepared.request.targets, |_| {}).unwrap();
    client.stop().unwrap();
    prepared.judged(session)
}

fn failed(tested: &SelfTestResult) -> Vec<&'static str> {
    tested.checks.iter().filter(|check| !check.passes()).map(|check| check.name).collect()
}

#[test]
fn the_joint_of_the_file_passes_and_so_does_one_within_its_error_bars() {
    // The spread of a file that says nothing: slip of 0.285 to 0.39 V, stick from there to 0.5 V,
    // 20 % of the inertia.
    let within = ["joint.friction.stick_v=0.45", "joint.friction.slip_v=0.34"];
    for set in [&[][..], &within, &["joint.gain_deg_per_s2_per_v=24.0"]] {
        let tested = tested(set);
        assert!(tested.passes(), "{set:?}: {:?}", tested.checks);
        assert_eq!((tested.moves.len(), tested.ended_by.as_ref()), (20, None));
        assert!(tested.checks.len() == 8 && tested.differences.is_empty(), "{tested:?}");
        assert!(tested.moves.iter().all(|one| one.to_deg.abs() <= tested.range_deg));
    }
}

#[test]
fn another_joint_fails_by_the_figure_that_shows_it_on_either_side() {
    let sliding = |tested: &SelfTestResult| -> SelfTestCheck {
        *tested.checks.iter().find(|check| check.name == "sliding_v").unwrap()
    };
    let dry = ["joint.friction.stick_v=0.20", "joint.friction.slip_v=0.20"];
    let viscous = ["joint.viscous_v_per_deg_per_s=0.08"];
    for (set, is_more) in [(&dry[..], false), (&viscous, true)] {
        let tested = tested(set);
        let found = failed(&tested);
        assert!(found.contains(&"sliding_v"), "{set:?}: {:?} {:?}", tested.ended_by, tested.checks);
        let check = sliding(&tested);
        let measured = check.measured.unwrap();
        assert_eq!(measured > check.most, is_more, "{check:?}");
        assert_eq!(measured < check.least.unwrap(), !is_more, "{check:?}");
    }
    // So much friction that the monitor of a stall comes first.
    let stuck = tested(&["joint.friction.stick_v=0.56", "joint.friction.slip_v=0.56"]);
    assert!(!stuck.passes() && stuck.ended_by.is_some_and(|by| by.contains("stall")));
    // Half of the inertia, and twice as much: a loop that lags so far behind pushes while the set
    // point brakes, and shows it in the effort along the way.
    for (gain, shown) in [("54.0", "accelerating_v"), ("13.5", "sliding_v")] {
        let tested = tested(&[&format!("joint.gain_deg_per_s2_per_v={gain}")]);
        assert!(failed(&tested).contains(&shown), "{gain}: {:?}", tested.checks);
    }
}

#[test]
fn a_joint_that_is_held_ends_it_with_a_fault_and_the_output_off() {
    let mut client = client(&[]);
    let prepared = asked().prepare(&mut client).unwrap();
    client.wire().simulated.brake_v = 100.0;
    let session = run(&mut client, &prepared.request.targets, |_| {}).unwrap();
    assert!(session.is_ended && session.moves.len() < 20);
    assert!(matches!(client.status().unwrap().state, StateCode::Faulted(_)));
    let tested = prepared.judged(session);
    assert!(!tested.passes() && tested.checks.is_empty());
    let by = tested.ended_by.unwrap();
    assert!(by.contains("stall"), "{by}");
}

#[test]
fn nothing_is_moved_on_another_machine_or_out_of_its_range() {
    let said = |error: Error| error.to_string();
    let mut other = client(&[]);
    let other_count = plan(&["loop.controller=srnf", "encoder.resolution_deg=0.01"]);
    other.set_parameters(&parameters(&other_count)).unwrap();
    let why = said(asked().prepare(&mut other).unwrap_err());
    assert!(why.contains("another machine") && why.contains("encoder.resolution_deg"), "{why}");
    let mut bounded = client(&[]);
    let set = ["loop.controller=srnf", "limits.position_min_deg=-5", "limits.position_max_deg=5"];
    bounded.set_parameters(&parameters(&plan(&set))).unwrap();
    let far = SelfTestRequest { range_deg: Some(6.0), ..asked() };
    let why = said(far.prepare(&mut bounded).unwrap_err());
    assert!(why.contains("a range of 6") && why.contains("limits.position_min_deg"), "{why}");
    // Without a range it stays within the limits, and reports that they differ from the file's.
    let near = SelfTestRequest { joints: 3, ..asked() }.prepare(&mut bounded).unwrap();
    assert!(near.request.targets.iter().all(|to| to.abs() <= 4.5));
    let session = run(&mut bounded, &[1.0, 0.0], |_| {}).unwrap();
    bounded.stop().unwrap();
    let differences = near.judged(session).differences;
    assert!(
        differences.iter().any(|line| line.starts_with("limits.position_min_deg")),
        "{differences:?}"
    );
}

/// Returns the self-test of a joint with two encoders; a device that runs what the file says drives
/// it, and `other` are keys of the joint that the file does not have.
fn tested_with_two_encoders(set: &[&str], other: &[&str]) -> SelfTestResult {
    let plan = |set: &[&str]| both_encoders(&["robust"], set).remove(0);
    let (configured, joint) = (plan(set), plan(&[set, other].concat()));
    let device =
        SimulatedDevice::running(&joint, &parameters(&configured), Boot::default()).unwrap();
    let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
    client.pass(std::time::Duration::from_millis(300)).unwrap();
    let text = simulator::draft::both_encoders().unwrap();
    let mut document = Document::parse("both-encoders", &text).unwrap();
    document.set(&set.iter().map(|key| (*key).to_owned()).collect::<Vec<_>>()).unwrap();
    let prepared = asked().plan_of(&mut client, document).unwrap().predict().unwrap();
    let session = run(&mut client, &prepared.request.targets, |_| {}).unwrap();
    prepared.judged(session)
}

/// The counts of the device are those of the load, behind 0.3 deg of slack.
#[test]
fn a_joint_with_two_encoders_is_tested_at_its_load() {
    let chip = [
        "load_encoder.kind=as5047p",
        "load_encoder.zero_counts=16000",
        "limits.position_min_deg=-90",
        "limits.position_max_deg=90",
    ];
    for set in [&[][..], &chip] {
        let tested = tested_with_two_encoders(set, &[]);
        assert!(tested.passes(), "{set:?}: {:?} {:?}", tested.ended_by, tested.checks);
        assert!(tested.differences.is_empty() && tested.unseen_slack.is_none(), "{tested:?}");
        for one in &tested.moves {
            let load = one.at_load.unwrap();
            assert_eq!((one.settled_s, one.rest_counts), (load.settled_s, load.rest_counts));
        }
    }
    // Seven fourths of the friction that the file has.
    let stiff = ["friction.slip_nm=7.2", "friction.stick_nm=7.4"];
    let tested = tested_with_two_encoders(&[], &stiff);
    assert!(!tested.passes());
    assert!(tested.ended_by.is_some() || failed(&tested).contains(&"sliding_v"), "{tested:?}");
}

/// A device with another motor's encoder is another machine.
#[test]
fn nothing_is_moved_with_another_encoder_on_the_motor() {
    let plan = |set: &[&str]| both_encoders(&["robust"], set).remove(0);
    let configured = parameters(&plan(&["encoder.lines=512"]));
    let device = SimulatedDevice::running(&plan(&[]), &configured, Boot::default()).unwrap();
    let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
    let text = simulator::draft::both_encoders().unwrap();
    let document = Document::parse("both-encoders", &text).unwrap();
    let why = asked().plan_of(&mut client, document).unwrap_err().to_string();
    assert!(why.contains("another machine") && why.contains("motor_encoder."), "{why}");
}
