//! The control task at a wrong time: kept from running by software, or called too early.

use std::sync::Arc;
use std::time::Duration;

use emulator::FirmwareImage;
use emulator::board::FittedParts;
use emulator::fault_injection::{Injection, observe};
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;
use stiction::link::StateCode;

use crate::common::{firmware, image, plans};
use crate::fault_injection::{AT, MS, UNTIL, assert_off_after, parameters};
use crate::stuck::{function, patched};

/// A branch to itself.
const FOR_EVER: [u8; 2] = [0xFE, 0xE7];

#[test]
fn a_task_that_hogs_the_processor_above_the_control_task_is_ended_by_the_watchdog() {
    // A copy of the image whose break task, which the control task cannot interrupt, never ends.
    let path = image();
    let hog =
        FirmwareImage::parse(&path, patched(|_| function("TIM1_BRK_TIM9"), &FOR_EVER)).unwrap();
    let records = [Some(&parameters()[..]), None];
    let injections = [(AT, Injection::Break), (AT + MS, Injection::BreakReleased)];
    let observed =
        observe(&Arc::new(hog), records, FittedParts::default(), &injections, UNTIL).unwrap();
    // The hardware has turned the outputs off by then; the enable pin waits for the reset.
    assert_off_after(&observed, AT, MS / 10);
    let [reset] = observed.resets[..] else { panic!("{:?}", observed.resets) };
    // 88 ms of a typical oscillator, from the last tick before.
    assert!((AT + 68 * MS..AT + 89 * MS).contains(&reset.at.0), "{reset:?}");
    assert!(observed.says("faulted: watchdog reset"), "{:?}", observed.log);
}

#[test]
fn a_tick_that_comes_too_early_is_no_overrun() {
    // Nothing looks for it: a tick is late or it is not (`src/safety/deadline.rs`), and a timer is
    // not early by itself.
    let plan = plans("step-response", &["srnf"], &["drive.pwm_hz=2000"]).remove(0);
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap();
    client.arm().unwrap();
    client.step_to(2.5).unwrap();
    let now =
        |client: &mut Client<EmulatedWire>| client.wire().board.act(|halted| halted.now()).unwrap();
    let (begin, before) = (now(&mut client), client.status().unwrap().clock);
    for _ in 0..10 {
        client.pass(Duration::from_millis(200)).unwrap();
        let board = &mut client.wire().board;
        // 5 ms after the tick, and 7 more: 8 ms before its time.
        board.samples(1).unwrap();
        board.pass(7 * MS).unwrap();
        board.act(|halted| halted.inject(Injection::TickEarly)).unwrap();
    }
    let status = client.pass(Duration::from_millis(200)).unwrap();
    assert_eq!((status.state, status.faults), (StateCode::Armed, 0));
    let position = f64::from(status.position) * f64::from(status.resolution);
    assert!((position - 2.5).abs() < 0.03, "{position}");
    // They did come: the board has counted more time than there was.
    let gained = f64::from(status.clock - before) * 20.0 - (now(&mut client) - begin) as f64 * 1e-6;
    assert!((80.0 - 20.0..=80.0 + 20.0).contains(&gained), "{gained} ms");
}
