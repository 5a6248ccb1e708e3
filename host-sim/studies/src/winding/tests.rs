//! The winding of a simulated device's motor, measured by pulses at standstill.

use super::*;
use files::document::Document;
use simulator::device::simulated::{MotorWires, ShuntState, SimulatedDevice};
use simulator::device::wire::SimulatedWire;
use simulator::draft::{Typical, text};
use simulator::experiment::{Experiment, RunPlan};

/// A sensor, and a PWM with a whole number of periods in a tick.
const SENSED: [&str; 2] = ["current_sensor.full_scale_a=30", "drive.pwm_hz=21000"];

/// The joint `harmonic` with these keys: 48 V, 2.51 ohm.
fn plan(set: &[&str]) -> RunPlan {
    let owned = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    let typical = Typical::find("harmonic").unwrap();
    let text = text("harmonic", &typical.answers().unwrap(), None).unwrap();
    let mut document = Document::parse("winding", &text).unwrap();
    document.set(&owned(set)).unwrap();
    Experiment::plan(&document, &owned(&["robust"]), &[]).unwrap().runs.remove(0)
}

fn client(file: &[&str], truth: &[&str], wires: MotorWires) -> Client<SimulatedWire> {
    let mut of = plan(&[&SENSED, file].concat());
    of.truth = Some(Box::new(plan(&[&SENSED, file, truth].concat())));
    let mut device = SimulatedDevice::new(&of).unwrap();
    device.motor_wires = wires;
    device.ticks(200);
    Client::connect(SimulatedWire::new(device)).unwrap()
}

fn measured(file: &[&str], truth: &[&str]) -> WindingResult {
    let mut client = client(file, truth, MotorWires::Sound);
    measure(&mut client, None).unwrap()
}

/// Whether the error bar covers the true value, and is at most this part of it.
fn is_within(estimate: Estimate, truth: f64, share: f64) -> bool {
    (estimate.value - truth).abs() <= estimate.error && estimate.error <= share * truth
}

#[test]
fn resistance_and_inductance_of_the_true_winding_are_found_whatever_the_file_says() {
    for (ohm, henry) in [(2.51, 1.255e-3), (1.8, 0.18e-3), (3.4, 17e-3), (2.51, 2.51e-4)] {
        let truth = [format!("motor.resistance_ohm={ohm}"), format!("motor.inductance_h={henry}")];
        let found = measured(&[], &truth.each_ref().map(String::as_str));
        let winding = found.winding;
        assert!(is_within(winding.resistance_ohm, ohm, 0.03), "{ohm} ohm: {found:?}");
        assert!(is_within(winding.inductance_h, henry, 0.05), "{henry} H: {found:?}");
    }
}

/// 0.2 us in both legs at 21 kHz are 0.4 V of 48 V.
#[test]
fn a_dead_time_is_lost_voltage_and_no_resistance_and_noise_is_averaged() {
    let set = ["motor.dead_time_s=0.2e-6", "motor.inductance_h=0.001255"];
    for noise_mv in [0, 10] {
        let mut client = client(&set, &[], MotorWires::Sound);
        if noise_mv > 0 {
            client.wire().simulated.shunt.as_mut().unwrap().state = ShuntState::Noisy(noise_mv);
        }
        let winding = measure(&mut client, None).unwrap().winding;
        assert!(is_within(winding.resistance_ohm, 2.51, 0.03), "{noise_mv} mV: {winding:?}");
        assert!(is_within(winding.inductance_h, 1.255e-3, 0.05), "{noise_mv} mV: {winding:?}");
        assert!(is_within(winding.lost_v, 0.4, 0.2), "{noise_mv} mV: {winding:?}");
    }
}

/// Without an inductance, the current has settled at the first reading.
#[test]
fn an_inductance_that_is_not_resolved_has_an_upper_bound() {
    let found = measured(&[], &[]);
    let Estimate { value, error } = found.winding.inductance_h;
    let quarter_s = 0.25 / 21e3;
    assert_eq!((value, found.configured[1]), (0.0, 0.0));
    assert!((error / (2.51 * quarter_s) - 1.0).abs() < 0.02, "{found:?}");
    assert!(is_within(found.winding.resistance_ohm, 2.51, 0.03), "{found:?}");
    assert!(found.words().contains("inductance below"), "{}", found.words());
}

#[test]
fn parameters_of_the_device_are_those_before_the_measurement() {
    for wires in [MotorWires::Sound, MotorWires::Open] {
        let mut client = client(&[], &[], wires);
        let before = client.parameters().unwrap();
        assert_eq!(before.controller.effort, EffortMode::Voltage);
        let found = measure(&mut client, None);
        assert_eq!(found.is_ok(), wires == MotorWires::Sound, "{found:?}");
        assert_eq!(client.parameters().unwrap(), before);
    }
}

#[test]
fn an_open_wire_an_effort_beyond_that_of_a_jog_and_a_pwm_out_of_step_are_named() {
    let why = |client: &mut Client<SimulatedWire>, effort| match measure(client, effort) {
        Err(Error::Device(why) | Error::Refused(why) | Error::Input(why)) => why,
        other => panic!("{other:?}"),
    };
    let open = why(&mut client(&[], &[], MotorWires::Open), None);
    assert!(open.contains("check supply and wires"), "{open}");
    let mut sound = client(&[], &[], MotorWires::Sound);
    for effort in [20.0, 4.5, 0.0, -1.0, f32::NAN] {
        let beyond = why(&mut sound, Some(effort));
        assert!(beyond.contains("jog.effort_v"), "{effort}: {beyond}");
    }
    let mut out_of_step = client(&["drive.pwm_hz=22000"], &[], MotorWires::Sound);
    let step = why(&mut out_of_step, None);
    assert!(step.contains("pwm_hz"), "{step}");
}
