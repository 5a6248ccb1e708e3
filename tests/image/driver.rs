//! The bridge's driver beside the image: it wakes up, and says so on the break input. And the pins
//! and bits that keep it off when the program does not run.

use std::time::Duration;

use emulator::board::FittedParts;
use emulator::board_under_test::{BoardUnderTest, StopCondition};
use emulator::fault_injection::Injection;
use emulator::lockstep::Lockstep;
use emulator::plant_interface::FreeDiscs;
use emulator::setup::BoardSetup;
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;
use stiction::Fault;
use stiction::link::StateCode;

use crate::common::{firmware, plans};
use crate::fault_injection::{MS, parameters};

const GPIOB_MODER: u64 = 0x4002_0400;
const GPIOB_ODR: u64 = 0x4002_0414;
const RCC_CFGR: u64 = 0x4002_3808;
const DBGMCU_APB1_FZ: u64 = 0xE004_2008;
const DBGMCU_APB2_FZ: u64 = 0xE004_200C;

const BREAK: StateCode = StateCode::Faulted(Fault::BreakInput as u8);
/// A driver that takes 2 ms to wake up, and 1 ms of it to let go of its fault output.
const SLOW: [&str; 3] =
    ["drive.pwm_hz=2000", "device.wake_up_s=0.002", "device.fault_blanking_s=0.002"];

fn board(set: &[&str]) -> Client<EmulatedWire> {
    let set = [&["reference.steps_deg=[5.0]"], set].concat();
    let plan = plans("step-response", &["pd"], &set).remove(0);
    Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap()
}

fn inject(client: &mut Client<EmulatedWire>, fault: Injection) {
    client.wire().board.act(move |halted| halted.inject(fault)).unwrap();
}

fn register(client: &mut Client<EmulatedWire>, address: u64) -> u32 {
    client.wire().board.act(move |halted| halted.register(address)).unwrap().unwrap()
}

/// Arms, lets time pass until the enable pin is high, and then 1 ms.
fn arm_and_wait(client: &mut Client<EmulatedWire>) {
    client.arm().unwrap();
    for _ in 0..400 {
        if register(client, GPIOB_ODR) & 1 != 0 {
            client.wire().board.pass(MS).unwrap();
            return;
        }
        client.wire().board.pass(MS / 10).unwrap();
    }
    panic!("the enable pin stayed low");
}

#[test]
fn a_driver_that_holds_its_fault_output_low_until_it_is_awake_is_armed() {
    let mut client = board(&SLOW);
    // It sleeps while it is not enabled, which is not reported as a fault.
    inject(&mut client, Injection::Break);
    let status = client.pass(Duration::from_millis(100)).unwrap();
    assert_eq!((status.state, status.faults), (StateCode::Stopped, 0));
    for _ in 0..2 {
        arm_and_wait(&mut client);
        inject(&mut client, Injection::BreakReleased);
        client.step_to(2.0).unwrap();
        let status = client.pass(Duration::from_millis(100)).unwrap();
        assert_eq!((status.state, status.faults), (StateCode::Armed, 0));
        let on = client.wire().board.act(|halted| halted.harness.spans.last.is_on()).unwrap();
        assert!(on);
        client.stop().unwrap();
        // It is off with the next tick, and the driver falls asleep.
        client.pass(Duration::from_millis(40)).unwrap();
        inject(&mut client, Injection::Break);
        client.pass(Duration::from_millis(100)).unwrap();
    }
    // From the first duty on, the input ends it in hardware as ever.
    arm_and_wait(&mut client);
    inject(&mut client, Injection::BreakReleased);
    client.pass(Duration::from_millis(100)).unwrap();
    inject(&mut client, Injection::Break);
    client.wire().board.pass(MS / 100).unwrap();
    assert_eq!(register(&mut client, GPIOB_ODR) & 1, 0);
    assert_eq!(client.pass(Duration::from_millis(40)).unwrap().state, BREAK);
    // Asleep again, it is no fault to clear, and the next wake-up is like the first.
    client.clear().unwrap();
    client.pass(Duration::from_millis(100)).unwrap();
    arm_and_wait(&mut client);
    inject(&mut client, Injection::BreakReleased);
    let status = client.pass(Duration::from_millis(100)).unwrap();
    assert_eq!((status.state, status.faults), (StateCode::Armed, 1));
}

#[test]
fn a_driver_that_does_not_wake_up_gets_no_duty() {
    let mut client = board(&SLOW);
    inject(&mut client, Injection::Break);
    arm_and_wait(&mut client);
    // One tick later the first duty is due, and the break input is on in the same write.
    assert_eq!(client.pass(Duration::from_millis(60)).unwrap().state, BREAK);
    let on = client.wire().board.act(|halted| halted.harness.spans.on_ns.clone()).unwrap();
    let longest = on.iter().map(|[from, until]| until - from).max().unwrap_or(0);
    assert!(longest < MS / 100, "{on:?}");
}

#[test]
fn without_a_blanking_a_fault_output_that_is_low_is_a_fault() {
    let mut client = board(&["drive.pwm_hz=2000", "device.wake_up_s=0.002"]);
    inject(&mut client, Injection::Break);
    assert_eq!(client.pass(Duration::from_millis(40)).unwrap().state, BREAK);
    assert!(client.arm().is_err());
}

#[test]
fn the_enable_pin_is_driven_low_before_the_clock_is_waited_for() {
    let mut setup = BoardSetup::new("enable pin", &firmware(), parameters());
    // Without a crystal, the part waits for one for 50 ms of its 16 MHz: 4.8 ms here.
    setup.fitted = FittedParts { crystal: false, ..FittedParts::default() };
    let mut board =
        BoardUnderTest::power_on(setup, Lockstep::new(FreeDiscs::default(), 20 * MS)).unwrap();
    board.until(StopCondition::Time(MS / 2)).unwrap();
    let [mode, output, clock] = board
        .act(|halted| [GPIOB_MODER, GPIOB_ODR, RCC_CFGR].map(|address| halted.register(address)))
        .unwrap();
    assert_eq!(clock.unwrap() & 0b1111, 0, "the clock is still that of the reset");
    assert_eq!((mode.map(|bits| bits & 3), output.map(|bits| bits & 1)), (Some(1), Some(0)));
}

#[test]
fn a_debugger_that_stops_the_watchdogs_with_the_core_is_overruled_and_the_outputs_stop() {
    let mut client = board(&["drive.pwm_hz=2000"]);
    // RM0090, DBGMCU: in the first register bit 11 is the window watchdog's, bit 12 the independent
    // one's; in the second, bit 0 is TIM1's and bit 1 TIM8's.
    let seen = [DBGMCU_APB1_FZ, DBGMCU_APB2_FZ].map(|address| register(&mut client, address));
    assert_eq!((seen[0] & 0x1800, seen[1] & 3), (0, 3));
    client.arm().unwrap();
    client
        .wire()
        .board
        .act(|halted| {
            // What OpenOCD sets by default, a timer's bit, and TIM1 and TIM8 left running.
            halted.set_register(DBGMCU_APB1_FZ, 0x1801);
            halted.set_register(DBGMCU_APB2_FZ, 1 << 16);
        })
        .unwrap();
    assert_eq!(register(&mut client, DBGMCU_APB1_FZ), 0x1801, "the test has set them");
    client.pass(Duration::from_millis(60)).unwrap();
    assert_eq!(register(&mut client, DBGMCU_APB1_FZ), 1, "what is no watchdog's is the debugger's");
    assert_eq!(register(&mut client, DBGMCU_APB2_FZ), 1 << 16 | 3);
}
