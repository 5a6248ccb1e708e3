//! The self-test of the flash image on the emulated board: it passes for the joint of the file, and
//! fails for another one.

use emulator::wire::EmulatedWire;
use simulator::device;
use simulator::device::client::Client;
use stiction::link::StateCode;
use studies::selftest::{SelfTestRequest, SelfTestResult, run};

use experiments::experiment;
use experiments::flash_image::firmware;

const FILE: &str = "step-response";

/// Four moves, since the emulator is slow; a slower PWM costs it less time, and moves the joint as
/// well.
fn tested(set: &[&str]) -> SelfTestResult {
    let pwm = "drive.pwm_hz=2000";
    let configured = device::parameters(&experiment(FILE, &["srnf"], &[pwm]).runs[0]).unwrap();
    let joint = experiment(FILE, &["srnf"], &[&[pwm], set].concat()).runs.remove(0);
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &joint).unwrap()).unwrap();
    client.set_parameters(&configured).unwrap();
    let asked = SelfTestRequest {
        machine: FILE.into(),
        range_deg: None,
        moves: 4,
        joints: 8,
        seed: 1,
        spreads: vec![],
    };
    let prepared = asked.prepare(&mut client).unwrap();
    let session = run(&mut client, &prepared.request.targets, |_| {}).unwrap();
    client.stop().unwrap();
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
    prepared.judged(session)
}

#[test]
fn it_passes_for_the_joint_of_the_file_and_fails_for_one_with_other_friction() {
    let right = tested(&[]);
    assert!(right.passes() && right.moves.len() == 4, "{:?}", right.checks);
    let wrong = tested(&["joint.viscous_v_per_deg_per_s=0.08"]);
    let failed: Vec<&str> =
        wrong.checks.iter().filter(|check| !check.passes()).map(|check| check.name).collect();
    assert!(failed.contains(&"sliding_v"), "{:?}", wrong.checks);
}
