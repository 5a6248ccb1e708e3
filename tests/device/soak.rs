//! A client moves the joint for a simulated hour, and asks for this and that meanwhile.

use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use stiction::control::signal::index;
use stiction::link::StateCode;

use crate::fixture::plans;

#[test]
fn an_hour_of_moves_neither_drifts_nor_loses_a_sample_unreported() {
    let plan = &plans("step-response", &["loop.controller=srnf", "reference.steps_deg=[5.0]"])[0];
    let mut client =
        Client::connect(SimulatedWire::new(SimulatedDevice::new(plan).unwrap())).unwrap();
    let signals = 1 << index("counts") | 1 << index("status");
    client.arm().unwrap();
    client.subscribe(signals, 10).unwrap();
    let (mut samples, mut moves, mut last, mut drift) = (0u64, 0u32, None, 0.0f64);
    let begin = client.status().unwrap().clock;
    while client.status().unwrap().clock - begin < 180_000 {
        let target = f64::from((moves * 7919) % 11) - 5.0;
        client.step_to(target).unwrap();
        client.pass(Duration::from_secs(4)).unwrap();
        moves += 1;
        if moves.is_multiple_of(17) {
            client.hold().unwrap();
            client.signals().unwrap();
            client.faults().unwrap();
        }
        drift = drift.max((client.wire().simulated.position_deg() - target).abs());
        while let Some(sample) = client.sample(Duration::ZERO).unwrap() {
            samples += 1;
            // Each sample that is missing is reported as lost.
            let expected: u32 = last.map_or(sample.number, |last: u32| last + 1);
            assert_eq!(sample.number, expected);
            last = Some(sample.number);
        }
    }
    let status = client.status().unwrap();
    assert_eq!(
        (status.state, status.faults, status.bad_frames, status.dropped),
        (StateCode::Armed, 0, 0, 0)
    );
    assert_eq!((client.lost(), u64::from(last.unwrap()) + 1), (0, samples));
    // A sample comes every ten ticks of 50 Hz: 18 000 in the hour, and those of the last moves.
    assert!((17_990..18_100).contains(&samples), "{samples}");
    // The joint is as near after an hour as after a move: SRNF rests within ten counts.
    assert!(drift < 10.0 * 0.00242 && moves > 800, "{drift} deg, {moves} moves");
    reliability!("soak", moves, samples, lost = client.lost(), worst_deg = format!("{drift:.4}"));
}
