//! Records of parameters: sent as a whole, refused as a whole, and kept across a reset by a save.

use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use stiction::Fault;
use stiction::link::StateCode;
use stiction::servo::{self, Boot};

use super::client;
use crate::fixture::{blank, plans, srnf, stored};

#[test]
fn parameters_come_over_the_link_as_a_whole_or_not_at_all() {
    let plan = &plans("step-response", &["loop.controller=srnf", "reference.steps_deg=[5.0]"])[0];
    let simulated = SimulatedDevice::with(plan, blank(), Boot::default()).unwrap();
    let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
    // Without parameters the fault is shown, and arming is refused.
    let message = client.arm().unwrap_err().to_string();
    assert!(message.contains("no parameters") && message.contains("`params push"), "{message}");
    assert!(client.clear().is_err());

    let good = srnf(&[]);
    client.set_parameters(&good).unwrap();
    let status = client.pass(Duration::from_millis(200)).unwrap();
    assert_eq!((status.state, status.unsaved), (StateCode::Stopped, true));
    assert_eq!(client.parameters().unwrap(), good);

    // One bad value is refused with its key, and everything is as it was.
    let mut bad = srnf(&["controller.srnf.kp_v_per_deg=2"]);
    bad.limits.thermal_time = -1.0;
    let message = client.set_parameters(&bad).unwrap_err().to_string();
    assert!(
        message.contains("`limits.thermal_s` is -1; must be a number from 0.1 to 100"),
        "{message}"
    );
    assert_eq!(client.parameters().unwrap(), good);

    // The timer of the device cannot make this frequency.
    let mut slow = srnf(&[]);
    slow.controller.drive.pwm_hz = 1000.0;
    let message = client.set_parameters(&slow).unwrap_err().to_string();
    assert!(
        message.contains("`drive.pwm_hz` is 1000; must be a number from 1300 to 5250000"),
        "{message}"
    );
    assert_eq!(client.parameters().unwrap(), good);

    // While the device is armed, nothing is taken or saved.
    client.arm().unwrap();
    assert!(client.set_parameters(&good).unwrap_err().to_string().contains("`stop` first"));
    assert!(client.save().unwrap_err().to_string().contains("`stop` first"));
    client.stop().unwrap();
    client.save().unwrap();
    assert!(!client.status().unwrap().unsaved);
}

/// Another board could run this record, so it is decoded; it is refused where the timer is known.
#[test]
fn a_device_whose_flash_asks_for_a_frequency_that_its_timer_cannot_make_is_faulted() {
    let plan = &plans("step-response", &["loop.controller=srnf"])[0];
    let mut slow = srnf(&[]);
    slow.controller.drive.pwm_hz = 1000.0;
    let mut simulated = SimulatedDevice::with(plan, stored(&slow), Boot::default()).unwrap();
    let output = simulated.ticks(50);
    assert_eq!(output.state, servo::State::Faulted(Fault::BadParameters));
    assert!(!output.enable && simulated.device.servo().arm().is_err());
}

#[test]
fn parameters_last_until_the_reset_unless_they_are_saved() {
    let plan = &plans("step-response", &["loop.controller=srnf", "reference.steps_deg=[5.0]"])[0];
    let (first, second) = (srnf(&[]), srnf(&["controller.srnf.v_ms_v=0.3"]));
    for save in [false, true] {
        let mut store = blank();
        store.save(&first).unwrap();
        let simulated = SimulatedDevice::with(plan, store, Boot::default()).unwrap();
        let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        client.set_parameters(&second).unwrap();
        if save {
            client.save().unwrap();
        }
        assert_eq!(client.parameters().unwrap(), second);
        let store = client.end().simulated.device.end();
        let simulated = SimulatedDevice::with(plan, store, Boot::default()).unwrap();
        let found = simulated.device.parameters().unwrap();
        assert_eq!(found, if save { &second } else { &first });
    }
}

/// Each save wears the flash. A client that changes and saves without end is refused in time.
#[test]
fn saves_are_counted_and_limited() {
    let mut client = client();
    let before = client.status().unwrap().saves;
    let sets = [0.2, 0.3].map(|v| srnf(&[&format!("controller.srnf.v_ms_v={v}")]));
    let mut save = |set: usize| {
        client.set_parameters(&sets[set % 2]).unwrap();
        (client.save(), client.status().unwrap())
    };
    for done in 1..=20 {
        let (saved, status) = save(done);
        saved.unwrap();
        assert_eq!(status.saves, before + done as u32);
    }
    let (refused, status) = save(21);
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("save again in 10 min"), "{refused}");
    assert!(status.unsaved && status.saves == before + 20, "{status:?}");
    // What is saved already is not saved again.
    let (saved, status) = save(20);
    assert!(saved.is_err() && status.saves == before + 20);
    client.pass(Duration::from_secs(600)).unwrap();
    client.save().unwrap();
    client.save().unwrap();
    assert_eq!(client.status().unwrap().saves, before + 20, "it is what was saved");
}
