//! The identification in the image: it finds what a simulated device finds, bit for bit, and ends
//! by itself with the bridge off.

use std::time::Duration;

use emulator::wire::EmulatedWire;
use simulator::device::client::{Client, Map};
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use stiction::identification::{IdentificationRequest, Outcome, Summary};
use stiction::link::StateCode;

use crate::common::{firmware, plans};

fn identified<W: Wire>(
    client: &mut Client<W>,
    asked: IdentificationRequest,
) -> Option<(Summary, Map)> {
    client.identify_joint(asked).unwrap();
    while client.pass(Duration::from_secs(1)).unwrap().state == StateCode::Armed {}
    assert_eq!(client.status().unwrap().faults, 0);
    client.identified().unwrap()
}

/// Half a minute: both pushes, the pulses, and the first legs of the map, whose rows go into the
/// regression. A slower PWM costs the emulator less time.
#[test]
fn an_identification_finds_what_a_simulated_device_finds_and_ends_at_its_bound() {
    let plan = plans("step-response", &["pd"], &["drive.pwm_hz=2000"]).remove(0);
    let asked = IdentificationRequest { time: Some(30.0), ..IdentificationRequest::default() };
    let mut simulated = SimulatedDevice::new(&plan).unwrap();
    simulated.ticks(10);
    let here = identified(&mut Client::connect(SimulatedWire::new(simulated)).unwrap(), asked);
    let wire = EmulatedWire::with(&firmware(), &plan).unwrap();
    let mut client = Client::connect(wire).unwrap();
    client.pass(Duration::from_millis(200)).unwrap();
    let there = identified(&mut client, asked);
    let (summary, _) = here.unwrap();
    assert_eq!(summary.outcome, Outcome::Time);
    assert!(summary.steps >= 6 && summary.range > 1.0, "{summary:?}");
    assert_eq!(there, here);
}
