//! The identification in the image: it finds what a simulated device finds, bit for bit, and ends
//! by itself with the bridge off.

use std::time::Duration;

use emulator::board_under_test::HaltedBoard;
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

/// Key and reload registers of the independent watchdog, and the key that opens the second.
const IWDG_KR: u64 = 0x4000_3000;
const IWDG_RLR: u64 = 0x4000_3008;
const OPEN: u32 = 0x5555;

/// Sets the watchdog's oscillator to the fastest of the data sheet, and its timeout to a number of
/// counts of 4 / 47 kHz.
fn shorten_the_watchdog(client: &mut Client<EmulatedWire>, counts: u32) {
    let act = client.wire().board.act(move |halted| {
        halted.board().mcu.rcc.calibrate_lsi(47_000);
        halted.set_register(IWDG_KR, OPEN);
        halted.set_register(IWDG_RLR, counts);
    });
    act.unwrap();
    client.wire().board.pass(50_000_000).unwrap();
}

/// The link goes on with the fit piece by piece, and the watchdog waits for the link. Its shortest
/// timeout is 10 ms, 118 counts. A quarter of that leaves room for the wait states that the
/// emulated part does not have; it is a tick of 2 ms and half a millisecond.
#[test]
fn each_piece_of_a_fit_ends_within_a_quarter_of_the_shortest_watchdog() {
    let set = ["drive.pwm_hz=2000", "loop.sample_time_s=0.002"];
    let plan = plans("step-response", &["pd"], &set).remove(0);
    let asked = IdentificationRequest { time: Some(30.0), ..IdentificationRequest::default() };
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap();
    client.identify_joint(asked).unwrap();
    while client.pass(Duration::from_secs(1)).unwrap().state == StateCode::Armed {}
    shorten_the_watchdog(&mut client, 118 / 4);
    let (summary, _) = client.identified().unwrap().unwrap();
    assert!(summary.steps >= 6, "{summary:?}");
    let resets = |halted: &mut HaltedBoard| halted.resets().len();
    assert_eq!(client.wire().board.act(resets).unwrap(), 0);
    // The timeout holds: less than a tick resets the part.
    shorten_the_watchdog(&mut client, 118 / 8);
    assert!(client.wire().board.act(resets).unwrap() > 0);
}
