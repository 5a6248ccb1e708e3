//! A joint that brakes into a supply that takes nothing back: what its brake resistor does to the
//! supply, and what the limits of the resistor do to it.
//!
//! The simulated supply is an ideal diode with a capacitor, without the inductance of wires.

use experiments::braking::{RESISTOR, braking};
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use stiction::Fault;
use stiction::servo::State;

use crate::current_sensor::{heard, moves};

/// Back-EMF (V s/rad) and resistance (ohm) of the motor at the joint.
const BACK_EMF: f64 = 50.0 * 0.0909;
const WINDING_OHM: f64 = 2.51;

/// Values of the resistor in [`RESISTOR`], and the capacitor.
const OHM: f64 = 28.2;
const FROM_V: f64 = 53.0;
const SPAN_V: f64 = 6.0;
const FARAD: f64 = 2e-3;
const TICK_S: f64 = 1e-3;

/// A device that has cooled down since its reset.
fn device(set: &[&str]) -> SimulatedDevice {
    let mut device = SimulatedDevice::new(&braking(set)).unwrap();
    device.ticks(30_000);
    device
}

fn with(set: &[&'static str]) -> Vec<&'static str> {
    [&RESISTOR[..], set].concat()
}

fn volts(device: &SimulatedDevice) -> f64 {
    device.dc_link.as_ref().unwrap().volts()
}

/// Heat of a resistor beyond its rated power, J: from its true heat.
#[derive(Default)]
struct Heat {
    before_j: f64,
    beyond_j: f64,
    most_j: f64,
}

impl Heat {
    fn tick(&mut self, device: &SimulatedDevice, power_w: f64) {
        let now_j = device.dc_link.as_ref().unwrap().resistor_j();
        self.beyond_j = (self.beyond_j + now_j - self.before_j - power_w * TICK_S).max(0.0);
        self.before_j = now_j;
        self.most_j = self.most_j.max(self.beyond_j);
    }
}

/// The charge from 48 V to 62 V is 1.5 J. The joint has 6.3 kg m^2 (5.9 rad/s)^2 / 2 = 111 J.
#[test]
fn without_a_resistor_a_joint_that_brakes_trips_the_supply_and_one_that_gives_it_back_does_not() {
    for (set, fault) in
        [(&[][..], Some(Fault::SupplyHigh)), (&["supply.takes_current_back=true"], None)]
    {
        let mut device = device(set);
        moves(&mut device, 1200.0);
        let found = (0..7000).find_map(|_| match heard(&mut device).state {
            State::Faulted(fault) => Some(fault),
            _ => None,
        });
        assert_eq!(found, fault);
        assert_eq!((device.position_deg() - 1200.0).abs() < 0.1, fault.is_none());
    }
}

/// A motor returns (k_e w)^2 / (4 R) at most: 72 W at 340 deg/s. The resistor takes as much with a
/// duty of 72 W R / V^2, at 57.4 V or less. In two ticks the capacitor rises by 1.4 V.
#[test]
fn a_resistor_keeps_the_supply_below_a_bound_and_the_move_ends() {
    let speed = 340f64.to_radians();
    let most_w = (BACK_EMF * speed).powi(2) / (4.0 * WINDING_OHM);
    let settled_v = FROM_V + SPAN_V * most_w * OHM / (FROM_V * FROM_V);
    let most_v = settled_v + 2.0 * most_w * TICK_S / (FARAD * FROM_V);
    let mut device = device(&with(&[]));
    moves(&mut device, 1200.0);
    let mut highest_v: f64 = 0.0;
    for tick in 0..7000 {
        assert_eq!(heard(&mut device).state, State::Armed, "{tick}");
        highest_v = highest_v.max(volts(&device));
    }
    assert!((55.0..most_v).contains(&highest_v), "{highest_v} V, not below {most_v} V");
    assert!(most_v < 59.0);
    assert!((device.position_deg() - 1200.0).abs() < 0.1, "{}", device.position_deg());
}

/// The energy that the motor draws in a tick is u (u - k_e dq/dt) / R h, from the true positions.
#[test]
fn what_the_motor_returns_is_in_the_capacitor_and_in_the_resistor() {
    let mut device = device(&with(&[]));
    let lsb_v = f64::from(device.device.parameters().unwrap().controller.drive.lsb);
    moves(&mut device, 1200.0);
    let balance = |device: &SimulatedDevice| {
        let link = device.dc_link.as_ref().unwrap();
        link.stored_j() + link.resistor_j() - link.source_j()
    };
    let (before_j, mut returned_j, mut gross_j) = (balance(&device), 0.0, 0.0);
    for _ in 0..7000 {
        let from = device.position_deg().to_radians();
        let output = heard(&mut device);
        let effort_v = f64::from(output.tick.code) * lsb_v * device.supply_ratio;
        let speed = (device.position_deg().to_radians() - from) / TICK_S;
        let drawn_j = effort_v * (effort_v - BACK_EMF * speed) / WINDING_OHM * TICK_S;
        returned_j -= drawn_j;
        gross_j += drawn_j.abs();
    }
    let found_j = balance(&device) - before_j;
    assert!(device.dc_link.as_ref().unwrap().resistor_j() > 40.0);
    assert!((found_j - returned_j).abs() < 2e-3 * gross_j, "{found_j}, {returned_j}, {gross_j} J");
}

/// A move returns some 50 J in 6.4 s: 10 W are more than their mean, 4 W are less.
#[test]
fn moves_to_and_fro_never_heat_the_resistor_beyond_its_limits() {
    for (power, power_w, is_enough) in
        [("brake_resistor.power_w=10", 10.0, true), ("brake_resistor.power_w=4", 4.0, false)]
    {
        let mut device = device(&with(&[power, "brake_resistor.energy_j=100"]));
        let mut heat = Heat::default();
        let mut fault = None;
        'moves: for number in 0..10 {
            if number == 0 {
                moves(&mut device, 1200.0);
            } else {
                goes(&mut device, if number % 2 == 0 { 1200.0 } else { 0.0 });
            }
            for _ in 0..6600 {
                let state = heard(&mut device).state;
                heat.tick(&device, power_w);
                if let State::Faulted(found) = state {
                    fault = Some(found);
                    break 'moves;
                }
            }
        }
        // After the fault it takes no more than its rated power, either.
        device.dc_link.as_mut().unwrap().feed_w = power_w;
        for _ in 0..3000 {
            device.tick();
            heat.tick(&device, power_w);
        }
        assert_eq!(fault, if is_enough { None } else { Some(Fault::SupplyHigh) }, "{power}");
        // The law reads the supply up to two ticks late.
        let most_j = if is_enough { 100.0 } else { 1.02 * 100.0 };
        assert!(heat.most_j > 30.0 && heat.most_j < most_j, "{power}: {} J", heat.most_j);
    }
}

/// Goes on to another target.
fn goes(device: &mut SimulatedDevice, to_deg: f64) {
    let parameters = device.device.parameters().unwrap().clone();
    let counts = to_deg / f64::from(parameters.controller.encoder.resolution);
    let motion = stiction::Motion::Profiled(stiction::units::position::Position::from_counts(
        counts.round() as i32,
    ));
    let course = motion.course(&parameters.controller, &parameters.profile).unwrap();
    let stiction::Course::Profile(profile) = course else { unreachable!("it is a profiled move") };
    device.device.servo().go_to(profile).unwrap();
}

/// 30 W of another drive need a duty of 30 W R / V^2 = 6 V below the full one: at V = 54.67 V.
#[test]
fn the_resistor_works_with_the_output_off_and_after_a_fault() {
    let settled_v = (0..50).fold(FROM_V, |v, _| FROM_V + SPAN_V * 30.0 * OHM / (v * v));
    for has_fault in [false, true] {
        let mut device = device(&with(&[]));
        if has_fault {
            device.device.servo().fault(Fault::Overrun);
        }
        device.dc_link.as_mut().unwrap().feed_w = 30.0;
        let state = device.ticks(300).state;
        assert_eq!(state != State::Stopped, has_fault, "{state:?}");
        assert!((volts(&device) - settled_v).abs() < 0.05, "{}, {settled_v} V", volts(&device));
    }
    // Without it, or before it has cooled down, the supply rises.
    let mut open = device(&with(&[]));
    let link = open.dc_link.as_mut().unwrap();
    (link.feed_w, link.has_resistor) = (30.0, false);
    open.ticks(300);
    assert!(volts(&open) > 62.0, "{} V", volts(&open));
    let mut hot = SimulatedDevice::new(&braking(&with(&["brake_resistor.power_w=5"]))).unwrap();
    hot.dc_link.as_mut().unwrap().feed_w = 30.0;
    hot.ticks(300);
    assert!(volts(&hot) > 62.0, "{} V", volts(&hot));
}

/// 60 W of another drive are 20 W more than a hot resistor takes.
#[test]
fn new_parameters_keep_the_heat_of_the_resistor() {
    let mut device = device(&with(&[]));
    device.dc_link.as_mut().unwrap().feed_w = 60.0;
    device.ticks(200);
    let mut parameters = device.device.parameters().unwrap().clone();
    parameters.brake_resistor.from = 54.0;
    let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
    client.set_parameters(&parameters).unwrap();
    let device = &mut client.wire().simulated;
    device.ticks(300);
    let settled_v = (0..50).fold(54.0, |v, _| 54.0 + 5.0 * 60.0 * OHM / (v * v));
    assert!((volts(device) - settled_v).abs() < 0.05, "{}, {settled_v} V", volts(device));
}

/// a = h V^2 / (R C span V): 0.25 at 1.3 mF, 0.84 at 0.4 mF, and 1.3 at 0.25 mF.
#[test]
fn the_supply_swings_below_a_quarter_of_the_capacitance_that_the_law_states() {
    for (capacitance, most_v, least_v) in [
        ("supply.capacitance_f=1.4e-3", 0.05, 0.0),
        ("supply.capacitance_f=0.4e-3", 0.2, 0.0),
        ("supply.capacitance_f=0.25e-3", 12.0, 1.0),
    ] {
        let mut device = device(&with(&[capacitance]));
        device.dc_link.as_mut().unwrap().feed_w = 40.0;
        device.ticks(100);
        let mut range = [f64::INFINITY, 0.0f64];
        let begin: Vec<f64> = (0..200)
            .map(|_| {
                device.tick();
                volts(&device)
            })
            .collect();
        for found in &begin {
            range = [range[0].min(*found), range[1].max(*found)];
        }
        let swing_v = range[1] - range[0];
        assert!((least_v..most_v).contains(&swing_v), "{capacitance}: {swing_v} V");
    }
}
