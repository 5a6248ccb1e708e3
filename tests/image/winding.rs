//! The measurement of the winding in the image: the converter's interrupt makes the pulses, and the
//! readings are those of a simulated device.

use emulator::wire::EmulatedWire;
use experiments::current_sensor::current_sensor;
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use stiction::link::StateCode;
use stiction::motion::winding::{WindingEnd, WindingFindings, WindingRequest};

use crate::common::firmware;

/// A current loop, whose file has a winding of 2.51 ohm and 0.5 ms.
const SET: [&str; 3] = ["loop.effort=current", "drive.pwm_hz=21000", "motor.inductance_h=0.001255"];

/// Two voltages and groups, one after the other.
const REQUESTS: [WindingRequest; 2] = [
    WindingRequest { effort: 2.4, periods: 1, cycles: 10 },
    WindingRequest { effort: 1.2, periods: 4, cycles: 3 },
];

fn found<W: Wire>(client: &mut Client<W>) -> [WindingFindings; 2] {
    REQUESTS.map(|asked| {
        client.wait_at_rest().unwrap();
        client.measure_winding(asked).unwrap();
        let status = client.pass_armed(std::time::Duration::from_secs(2)).unwrap();
        assert_eq!((status.state, status.faults), (StateCode::Stopped, 0));
        client.winding().unwrap().unwrap()
    })
}

#[test]
fn an_image_measures_the_currents_that_a_simulated_device_measures() {
    let plan = current_sensor(&["robust"], &SET).remove(0);
    let mut simulated = SimulatedDevice::new(&plan).unwrap();
    simulated.ticks(200);
    let here = found(&mut Client::connect(SimulatedWire::new(simulated)).unwrap());
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap();
    let there = found(&mut client);
    assert_eq!(there, here);
    for (found, asked) in there.iter().zip(REQUESTS) {
        assert_eq!(found.ended, WindingEnd::Done);
        // L / R is 0.5 ms: i(t) = U / R (1 - 2 exp(-t / tau) / (1 + exp(-H / tau))).
        let (period_s, periods) = (1.0 / 21e3, f64::from(asked.periods));
        let decay = |time_s: f64| (-time_s / 0.5e-3).exp();
        let last_a: Vec<f64> = (0..asked.periods)
            .map(|period| 32.0 * periods - f64::from(period) - 0.5)
            .map(|place| {
                1.0 - 2.0 * decay(place * period_s) / (1.0 + decay(32.0 * periods * period_s))
            })
            .collect();
        let expected_a = f64::from(asked.effort) / 2.51 * last_a.iter().sum::<f64>() / periods;
        let readings = 2.0 * f64::from(asked.cycles) * periods;
        let last_a = f64::from(found.sums[31]) * f64::from(found.unit) / readings;
        assert!((last_a - expected_a).abs() < f64::from(found.unit), "{last_a} A, {expected_a} A");
    }
    // The bridge is off again, and the current loop moves the joint.
    assert!(!client.wire().board.samples(2).unwrap().bridge.is_on());
    client.wait_at_rest().unwrap();
    client.arm().unwrap();
    client.step_to(1.0).unwrap();
    let status = client.pass(std::time::Duration::from_millis(400)).unwrap();
    let deg = f64::from(status.position) * f64::from(status.resolution);
    assert!(status.state == StateCode::Armed && (deg - 1.0).abs() < 0.2, "{deg} deg");
}
