//! The contact of the emergency stop: an open one ends the output, and nothing arms until it is
//! closed and the fault is cleared.
//!
//! A simulated device has no hardware beside its core: tests/image/emergency_stop.rs has that.

use experiments::controllers;
use experiments::matrix::{
    Bench as _, SITUATIONS, assert_armed_again_only_at_rest, assert_latched, bring, harder,
    start_over,
};
use files::hardware::STM32F405;
use stiction::servo::{Boot, ControlLoop, Input, Output, Refusal, State};
use stiction::{Fault, Servo};

use crate::fixture::srnf;
use crate::matrix::DeviceBench;

const CONTACT: &str = "device.emergency_stop=true";
const STOPPED: State = State::Faulted(Fault::EmergencyStop);
const REFUSED: Result<(), Refusal> = Err(Refusal::WouldTrip(Fault::EmergencyStop));

/// A servo whose joint has rested for ten ticks of 20 ms behind a closed contact.
fn at_rest(set: &[&str]) -> Servo {
    let mut servo = Servo::new(Ok(&srnf(set)), Boot::default(), &STM32F405);
    for _ in 0..10 {
        tick(&mut servo, true);
    }
    servo
}

fn tick(servo: &mut Servo, is_closed: bool) -> Output {
    let lines = if is_closed { Input::CONTACT } else { 0 };
    servo.tick(Input { supply: STM32F405.supply_top, lines, ..Input::default() })
}

#[test]
fn an_open_contact_is_off_in_its_tick_under_every_law_and_situation() {
    for (situation, law) in SITUATIONS.iter().flat_map(|&at| controllers().map(move |l| (at, l))) {
        let name = format!("{law}, {situation:?}");
        let mut bench = DeviceBench::new();
        start_over(&mut bench, law, &[harder(law, situation), &[CONTACT]].concat());
        bring(&mut bench, situation);
        bench.simulated().is_contact_open = true;
        assert!(!bench.ticks(1).is_on, "{name}");
        assert_latched(&mut bench, &name, law, (Fault::EmergencyStop, [0.0, 0.0]));
        let refused = bench.client().clear().unwrap_err().to_string();
        assert!(refused.contains("fault 32 (emergency stop) would turn"), "{name}: {refused}");
        bench.simulated().is_contact_open = false;
        bench.ticks(1);
        assert_eq!(bench.state(), STOPPED, "{name}: a closed contact clears nothing");
        start_over(&mut bench, law, &[CONTACT]);
        assert_armed_again_only_at_rest(&mut bench, &name);
    }
}

#[test]
fn a_device_without_the_key_has_no_contact() {
    let mut servo = at_rest(&[]);
    servo.arm().unwrap();
    assert!((0..5).all(|_| tick(&mut servo, false).enable));
}

#[test]
fn no_command_clears_or_arms_while_the_contact_is_open() {
    let mut servo = at_rest(&[CONTACT]);
    assert_eq!(tick(&mut servo, false).state, STOPPED);
    assert_eq!((servo.clear(), servo.state()), (REFUSED, STOPPED));
    tick(&mut servo, true);
    assert_eq!((servo.clear(), servo.arm()), (Ok(()), Ok(())));
    assert!(tick(&mut servo, true).enable);
    // Another fault is cleared before a tick has seen the contact.
    servo.fault(Fault::Overrun);
    assert_eq!((servo.clear(), tick(&mut servo, false).state), (Ok(()), STOPPED));
}

/// Valid parameters end the fault of bad ones, and not that of a contact that opened meanwhile.
#[test]
fn a_stop_behind_a_fault_that_parameters_end_is_the_fault_after_it() {
    let install = |servo: &mut Servo| {
        let mut after = None;
        ControlLoop::prepare(&mut after, &srnf(&[CONTACT]), &STM32F405).unwrap();
        servo.install(&mut after).unwrap();
    };
    let mut servo = at_rest(&[CONTACT]);
    servo.fault(Fault::BadParameters);
    assert_eq!(tick(&mut servo, false).state, State::Faulted(Fault::BadParameters));
    install(&mut servo);
    assert_eq!((servo.state(), servo.clear()), (STOPPED, REFUSED));
    assert_eq!(servo.arm(), Err(Refusal::Faulted(Fault::EmergencyStop)));
    // It needs one clearing, and no second one.
    tick(&mut servo, true);
    assert_eq!((servo.clear(), servo.state()), (Ok(()), State::Stopped));
    servo.fault(Fault::BadParameters);
    install(&mut servo);
    assert_eq!(servo.state(), State::Stopped);
}

/// The stop has a clearing of its own, though the contact is closed again.
#[test]
fn a_stop_behind_another_fault_is_the_fault_after_it() {
    for is_closed in [false, true] {
        let mut servo = at_rest(&[CONTACT]);
        servo.fault(Fault::Overrun);
        assert_eq!(tick(&mut servo, false).state, State::Faulted(Fault::Overrun));
        tick(&mut servo, is_closed);
        assert_eq!((servo.clear(), servo.state()), (Ok(()), STOPPED), "{is_closed}");
        let cleared = if is_closed { Ok(()) } else { REFUSED };
        tick(&mut servo, is_closed);
        assert_eq!(servo.clear(), cleared);
        let logged: Vec<Fault> = servo.log().iter().map(|latched| latched.fault).collect();
        assert_eq!(logged, [Fault::Overrun, Fault::EmergencyStop]);
    }
    // Without a contact that opened there is none.
    let mut servo = at_rest(&[CONTACT]);
    servo.fault(Fault::Overrun);
    tick(&mut servo, true);
    assert_eq!((servo.clear(), servo.state()), (Ok(()), State::Stopped));
}

#[test]
fn a_contact_that_is_open_at_power_on_arms_nothing_once_it_is_closed() {
    let keys = [CONTACT, "device.autostart=true", "device.autostart_delay_s=0"];
    let mut servo = Servo::new(Ok(&srnf(&keys)), Boot::default(), &STM32F405);
    assert_eq!(tick(&mut servo, false).state, STOPPED);
    assert!((0..50).all(|_| tick(&mut servo, true).state == STOPPED));
    servo.clear().unwrap();
    assert!((0..50).all(|_| tick(&mut servo, true).state == State::Stopped));
}

/// The contact pulls the break input at once; its own input is filtered, and it bounces.
#[test]
fn a_break_input_is_the_emergency_stop_if_its_contact_is_open_within_50_ms() {
    for closed in 0..6 {
        let mut servo = at_rest(&[CONTACT]);
        servo.arm().unwrap();
        tick(&mut servo, true);
        servo.break_input(Input::CONTACT);
        assert_eq!(servo.state(), State::Faulted(Fault::BreakInput));
        for _ in 0..closed {
            tick(&mut servo, true);
        }
        let found = tick(&mut servo, false).state;
        // 50 ms are two and a half ticks, rounded up.
        let expected = if closed < 3 { STOPPED } else { State::Faulted(Fault::BreakInput) };
        assert_eq!(found, expected, "closed for {closed} ticks");
        let logged: Vec<Fault> = servo.log().iter().map(|latched| latched.fault).collect();
        assert_eq!(logged[0], Fault::BreakInput);
    }
    let mut servo = at_rest(&[CONTACT]);
    servo.break_input(0);
    assert_eq!((servo.state(), servo.log().count()), (STOPPED, 1));
}
