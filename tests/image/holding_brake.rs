//! The holding brake's output, PB14, in the flash image: high only while the loop holds or moves
//! the joint.
//!
//! tests/device/holding_brake.rs has the times under every law. Ticks are 20 ms.

use std::time::Duration;

use emulator::fault_injection::Injection;
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;
use stiction::Fault;
use stiction::link::StateCode;

use crate::common::{firmware, plans};
use crate::fault_injection::MS;

const GPIOB_MODER: u64 = 0x4002_0400;
const GPIOB_ODR: u64 = 0x4002_0414;
const TIMES: [&str; 3] =
    ["device.soft_start_s=0.1", "device.brake_open_s=0.1", "device.brake_close_s=0.2"];
const TICK: Duration = Duration::from_millis(20);

fn board(set: &[&str]) -> Client<EmulatedWire> {
    let set = [&["drive.pwm_hz=2000", "reference.steps_deg=[5.0]"], set].concat();
    let plan = plans("step-response", &["pd"], &set).remove(0);
    Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap()
}

/// Levels of the enable pin and of the brake's output, as they are written.
fn pins(client: &mut Client<EmulatedWire>) -> [bool; 2] {
    let register = |halted: &mut emulator::board_under_test::HaltedBoard<'_>| {
        (halted.register(GPIOB_MODER), halted.register(GPIOB_ODR))
    };
    let (mode, levels) = client.wire().board.act(register).unwrap();
    assert_eq!(mode.unwrap() >> 28 & 3, 1, "PB14 is an output");
    [0, 14].map(|pin| levels.unwrap() >> pin & 1 != 0)
}

/// Lets ticks pass, and counts those with these pins.
fn count(client: &mut Client<EmulatedWire>, expected: [bool; 2], most: usize) -> usize {
    (0..most)
        .take_while(|_| {
            client.wire().board.samples(1).unwrap();
            pins(client) == expected
        })
        .count()
}

#[test]
fn the_output_is_high_from_the_end_of_the_soft_start_until_the_link_is_silent() {
    let mut client = board(&TIMES);
    assert_eq!(pins(&mut client), [false, false]);
    client.arm().unwrap();
    while !pins(&mut client)[0] {
        client.wire().board.samples(1).unwrap();
    }
    // The first of five ticks of the soft start has been seen.
    assert_eq!(count(&mut client, [true, false], 20), 4);
    client.step_to(1.0).unwrap();
    let status = client.pass_armed(50 * TICK).unwrap();
    assert_eq!((status.state, pins(&mut client)), (StateCode::Armed, [true, true]));
    while pins(&mut client)[1] {
        client.wire().board.samples(1).unwrap();
    }
    // The first of ten ticks in which the brake closes has been seen.
    assert_eq!(count(&mut client, [true, false], 20), 9);
    assert_eq!(pins(&mut client), [false, false]);
    let state = client.status().unwrap().state;
    assert_eq!(state, StateCode::Faulted(Fault::LinkTimeout as u8));
    client.clear().unwrap();
    client.pass(10 * TICK).unwrap();
    client.arm().unwrap();
    client.pass_armed(30 * TICK).unwrap();
    assert_eq!(pins(&mut client), [true, true]);
    client.stop().unwrap();
    client.pass(2 * TICK).unwrap();
    assert_eq!(pins(&mut client), [false, false]);
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
}

#[test]
fn a_break_input_closes_the_brake_at_once_and_so_does_a_reset() {
    for fault in [Injection::Break, Injection::Reset] {
        let mut client = board(&TIMES);
        client.arm().unwrap();
        client.pass_armed(30 * TICK).unwrap();
        assert_eq!(pins(&mut client), [true, true]);
        client.wire().board.act(move |halted| halted.inject(fault)).unwrap();
        // Within the instructions of the interrupt; a reset boots for longer.
        client
            .wire()
            .board
            .pass(if fault == Injection::Break { MS / 100 } else { 50 * MS })
            .unwrap();
        assert_eq!(pins(&mut client), [false, false], "{fault:?}");
    }
}

#[test]
fn a_fault_of_a_tick_closes_the_brake_in_that_tick() {
    let mut client = board(&[&TIMES[..], &["limits.link_timeout_s=0"]].concat());
    client.arm().unwrap();
    client.pass_armed(30 * TICK).unwrap();
    client.wire().board.act(|halted| halted.jump(3000)).unwrap();
    client.wire().board.samples(2).unwrap();
    assert_eq!(pins(&mut client), [false, false]);
    let state = client.status().unwrap().state;
    assert_eq!(state, StateCode::Faulted(Fault::EncoderJump as u8));
}

#[test]
fn without_the_times_the_output_stays_low() {
    let mut client = board(&[]);
    client.arm().unwrap();
    client.pass_armed(30 * TICK).unwrap();
    assert_eq!(pins(&mut client), [true, false]);
}
