//! The motor's NTC in the image: the board converts PC2, and does with it what a simulated device
//! does.
//!
//! Blind to the heat of the NTC itself and to the time that its divider takes to settle.

use std::time::Duration;

use emulator::bridge::BridgeInputs;
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use simulator::motor_ntc::NtcState;
use stiction::Fault;
use stiction::link::{StateCode, Status};

use crate::common::{firmware, plans};

const SET: [&str; 7] = [
    "limits.link_timeout_s=off",
    "drive.pwm_hz=2000",
    "reference.steps_deg=[5.0]",
    "limits.continuous_v=5",
    "motor_ntc.resistance_25_ohm=10000",
    "motor_ntc.limit_c=120",
    "motor_ntc.ambient_c=20",
];

/// What the sensor shows, for half a second each, and what the servo makes of it.
const STATES: [(NtcState, StateCode); 5] = [
    (NtcState::Sound, StateCode::Armed),
    (NtcState::At(95.0), StateCode::Armed),
    (NtcState::At(121.0), StateCode::Faulted(Fault::MotorHot as u8)),
    (NtcState::At(60.0), StateCode::Stopped),
    (NtcState::Open, StateCode::Faulted(Fault::MotorSensor as u8)),
];

fn shown<W: Wire>(
    client: &mut Client<W>,
    mut set: impl FnMut(&mut Client<W>, NtcState),
) -> Vec<Status> {
    client.wait_at_rest().unwrap();
    client.arm().unwrap();
    let mut each = |(state, expected)| {
        set(client, state);
        if expected == StateCode::Stopped {
            // The mean of what the sensor showed before.
            client.pass(Duration::from_millis(200)).unwrap();
            client.clear().unwrap();
        }
        let status = client.pass(Duration::from_millis(500)).unwrap();
        assert_eq!(status.state, expected, "{state:?}");
        status
    };
    STATES.into_iter().map(&mut each).collect()
}

#[test]
fn an_image_measures_the_motor_as_a_simulated_device_does() {
    let plan = plans("step-response", &["pd"], &SET).remove(0);
    let simulated = SimulatedDevice::new(&plan).unwrap();
    let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
    let here = shown(&mut client, |client, state| {
        client.wire().simulated.ntc.as_mut().unwrap().state = state;
    });
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap();
    let there = shown(&mut client, |client, state| {
        let set = move |halted: &mut emulator::board_under_test::HaltedBoard<'_>| {
            halted.harness.coupling.plant.ntc.as_mut().unwrap().state = state;
        };
        client.wire().board.act(set).unwrap();
    });
    let of = |status: &Status| (status.motor_temperature.map(f32::to_bits), status.fault.value);
    assert_eq!(there.iter().map(of).collect::<Vec<_>>(), here.iter().map(of).collect::<Vec<_>>());
    // 75 % of the way, and so of the heat of 5 V. It cools between two means, up to a hundredth.
    for warm in [&there[1], &here[1]] {
        let part = warm.thermal_effort.powi(2) / 25.0;
        assert!((0.74..0.7501).contains(&part), "{part}");
    }
    assert!(!client.wire().board.act(|halted| BridgeInputs::read(halted.board()).is_on()).unwrap());
}
