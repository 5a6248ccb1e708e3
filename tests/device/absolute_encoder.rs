//! An absolute encoder on the load, beside the motor's: the reference at power-on, and what becomes
//! of a chip that does not answer.

use experiments::both_encoders::both_encoders;
use simulator::device::parameters;
use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::servo::{Boot, Refusal, State};

/// An AS5047P on the joint, which reads 16 000 at the joint's zero.
const CHIP: [&str; 2] = ["load_encoder.kind=as5047p", "load_encoder.zero_counts=16000"];
/// A range of half a turn.
const RANGE: [&str; 2] = ["limits.position_min_deg=-90", "limits.position_max_deg=90"];

/// Powers a device up with its joint at a position, deg.
fn powered_at(deg: f64, set: &[&str]) -> SimulatedDevice {
    let plan = &both_encoders(&["robust"], &[&CHIP, set].concat())[0];
    let parameters = parameters(plan).unwrap();
    let mut device = SimulatedDevice::running(plan, &parameters, Boot::default()).unwrap();
    device.push(deg, 0.0);
    device
}

/// Returns the position that the servo counts, deg.
fn counted_deg(device: &mut SimulatedDevice) -> f64 {
    f64::from(device.device.servo().position()) * 360.0 / 16384.0
}

#[test]
fn the_angle_gives_the_position_where_the_range_is_less_than_a_turn() {
    for direction in ["forward", "reverse"] {
        let direction = format!("load_encoder.direction={direction}");
        for deg in [-89.0, -10.0, 0.0, 30.0, 89.0] {
            let mut device = powered_at(deg, &[&RANGE[..], &[&direction]].concat());
            device.ticks(200);
            assert!(device.device.servo().is_referenced(), "{direction}, {deg} deg");
            // Half a count of rounding, and the twist that a push leaves in the gear: none.
            let off_deg = (counted_deg(&mut device) - deg).abs();
            assert!(off_deg <= 0.5 * 360.0 / 16384.0 + 1e-9, "{direction}, {deg}: {off_deg} deg");
            assert_eq!(device.device.servo().arm_for_link(None), Ok(()), "{deg} deg");
        }
    }
}

#[test]
fn the_number_of_turns_is_unknown_in_a_range_of_a_turn_and_outside_of_a_range() {
    let wide = ["limits.position_min_deg=-180", "limits.position_max_deg=181"];
    for (deg, set) in [(-179.5, wide), (100.0, RANGE)] {
        let mut device = powered_at(deg, &set);
        device.ticks(200);
        assert!(!device.device.servo().is_referenced(), "{deg} deg, {set:?}");
        let refused = device.device.servo().arm_for_link(None);
        assert_eq!(refused, Err(Refusal::NotReferenced), "{deg} deg, {set:?}");
    }
}

/// Five ticks of 1 ms. While the chip does not answer, nothing is armed; once it answers again, the
/// position is that of its angle, wherever the joint has been turned meanwhile.
#[test]
fn a_chip_that_does_not_answer_is_a_fault_and_the_angle_gives_the_position_again() {
    let mut device = powered_at(10.0, &RANGE);
    device.ticks(200);
    device.device.servo().arm_for_link(None).unwrap();
    device.ticks(10);
    assert_eq!(device.device.servo().state(), State::Armed);
    device.load_wires = Wires::Cut;
    device.ticks(4);
    assert_eq!(device.device.servo().state(), State::Armed);
    device.tick();
    let latched = device.device.servo().latched().unwrap();
    assert_eq!((latched.fault, latched.value), (Fault::EncoderSilent, 5.0));
    assert!(!device.device.servo().is_referenced());
    device.device.servo().clear().unwrap();
    device.ticks(200);
    assert_eq!(device.device.servo().arm_for_link(None), Err(Refusal::Moving));
    device.push(-50.0, 0.0);
    device.ticks(10);
    device.load_wires = Wires::Sound;
    device.ticks(200);
    assert!(device.device.servo().is_referenced());
    assert!((counted_deg(&mut device) + 50.0).abs() < 0.02, "{}", counted_deg(&mut device));
    assert_eq!(device.device.servo().arm_for_link(None), Ok(()));
}

/// A tenth of a second after power-on; four ticks without an answer later are none.
#[test]
fn a_chip_has_its_time_to_become_ready_and_may_miss_some_ticks() {
    let mut device = powered_at(10.0, &RANGE);
    device.load_wires = Wires::Cut;
    device.ticks(99);
    assert_eq!(device.device.servo().latched(), None);
    device.tick();
    assert_eq!(device.device.servo().latched().unwrap().fault, Fault::EncoderSilent);
    let mut device = powered_at(10.0, &RANGE);
    for _ in 0..50 {
        device.load_wires = Wires::Sound;
        device.ticks(3);
        device.load_wires = Wires::Cut;
        device.ticks(4);
    }
    assert_eq!(device.device.servo().latched(), None);
}
