//! The bridge in its three modes: every bit of TIM1 and of its pins that says what a motor gets, as
//! RM0090 has them (chapter 17, TIM1; chapter 8, GPIO), in the emulated part's registers.
//!
//! Blind to the pins themselves: dead time and levels are measured in the first run
//! (docs/reference/wiring.md).

use std::time::Duration;

use emulator::board_under_test::HaltedBoard;
use emulator::fault_injection::Injection;
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;
use stiction::link::StateCode;

use crate::common::{firmware, plans};
use crate::fault_injection::MS;

const TIM1: u64 = 0x4001_0000;
const GPIOA: u64 = 0x4002_0000;
const GPIOB: u64 = 0x4002_0400;

/// CCER: the output and its complement. Polarity bits that are clear are active high.
const CC1E: u32 = 1;
const CC1NE: u32 = 1 << 2;
/// BDTR: outputs on; break input on, active low; driven while off, and in an off-state while on.
const MOE: u32 = 1 << 15;
const BKE: u32 = 1 << 12;
const OSSR: u32 = 1 << 11;
const OSSI: u32 = 1 << 10;

/// TIM1 and its pins at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Seen {
    ccer: u32,
    bdtr: u32,
    compare: u32,
    top: u32,
    /// Levels of PB0 and PB1 as they are written.
    enable: bool,
    reverse: bool,
}

/// What no mode changes: the names of the registers, their addresses, the bits that are looked at,
/// and what they are.
const FIXED: [(&str, u64, u32, u32); 11] = [
    ("CR2: both outputs are low when idle, OC4REF is TRGO", TIM1 + 0x04, 0xFFFF, 0x70),
    ("CCMR1: PWM mode 1, preloaded", TIM1 + 0x18, 0xFF, 0x68),
    // But for the direction in which it counts at present.
    ("CR1: centre-aligned, preloaded, counting", TIM1, 0x3FF & !0x10, 0xA1),
    ("PA8 is a timer's", GPIOA, 3 << 16, 2 << 16),
    ("PA8 is TIM1's", GPIOA + 0x24, 0xF, 1),
    ("PA8 has no pull, which would disturb a divider", GPIOA + 0x0C, 3 << 16, 0),
    ("PB0 and PB1 are outputs", GPIOB, 0xF, 0b0101),
    ("PB12 and PB13 are a timer's", GPIOB, 0xF << 24, 0b1010 << 24),
    ("PB12 and PB13 are TIM1's", GPIOB + 0x24, 0xFF << 16, 0x11 << 16),
    ("PB12 has its pull-up", GPIOB + 0x0C, 3 << 24, 1 << 24),
    ("PA6 has a pull-down, so that an open wire is a stop", GPIOA + 0x0C, 3 << 12, 2 << 12),
];

/// A board with a joint, a law and a mode, before it is armed.
fn board(set: &[&str]) -> Client<EmulatedWire> {
    let set = [&["drive.pwm_hz=2000", "reference.steps_deg=[5.0]"], set].concat();
    let plan = plans("step-response", &["pd"], &set).remove(0);
    Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap()
}

fn look(client: &mut Client<EmulatedWire>) -> Seen {
    let mut read = |address: u64| {
        let register = move |halted: &mut HaltedBoard<'_>| halted.register(address);
        client.wire().board.act(register).unwrap().unwrap()
    };
    for (what, address, bits, expected) in FIXED {
        assert_eq!(read(address) & bits, expected, "{what}");
    }
    let output = read(GPIOB + 0x14);
    Seen {
        ccer: read(TIM1 + 0x20),
        bdtr: read(TIM1 + 0x44),
        compare: read(TIM1 + 0x34),
        top: read(TIM1 + 0x2C),
        enable: output & 1 != 0,
        reverse: output & 2 != 0,
    }
}

/// What a mode is before arming, while it drives backwards, and after a stop.
fn off_driven_off(set: &[&str]) -> [Seen; 3] {
    let mut client = board(set);
    let before = look(&mut client);
    client.arm().unwrap();
    client.step_to(-2.0).unwrap();
    let status = client.pass(Duration::from_millis(200)).unwrap();
    assert_eq!(status.state, StateCode::Armed);
    let driven = look(&mut client);
    client.stop().unwrap();
    client.pass(Duration::from_millis(40)).unwrap();
    [before, driven, look(&mut client)]
}

/// 2 kHz of 168 MHz, there and back: a slow PWM, which the emulator is quicker with.
const TOP: u32 = 42_000;

#[test]
fn locked_antiphase_switches_both_half_bridges_with_the_dead_time() {
    // 1 us of 168 MHz is 168 clocks: (64 + 20) * 2. 0.5 us is 84, 6 us is (32 + 31) * 16.
    for (dead_time, code) in [("1e-6", 0x80 | 20), ("5e-7", 84), ("6e-6", 0xFF)] {
        let set = format!("device.dead_time_s={dead_time}");
        let [before, driven, after] = off_driven_off(&["drive.mode=locked-antiphase", &set]);
        let off = Seen {
            ccer: CC1E | CC1NE,
            bdtr: BKE | OSSR | OSSI | code,
            compare: TOP / 2,
            top: TOP,
            enable: false,
            reverse: false,
        };
        assert_eq!((before, after), (off, off));
        assert_eq!(
            driven,
            Seen { compare: driven.compare, bdtr: off.bdtr | MOE, enable: true, ..off }
        );
        assert!(driven.compare < TOP / 2, "{driven:?}");
    }
}

#[test]
fn sign_magnitude_has_a_direction_and_neither_complement_nor_dead_time() {
    let [before, driven, after] = off_driven_off(&["drive.mode=sign-magnitude"]);
    let bdtr = BKE | OSSR | OSSI;
    let off = Seen { ccer: CC1E, bdtr, compare: 0, top: TOP, enable: false, reverse: false };
    assert_eq!((before, after), (off, off));
    let Seen { compare, .. } = driven;
    assert_eq!(driven, Seen { compare, bdtr: bdtr | MOE, enable: true, reverse: true, ..off });
    assert!(compare > 0);
}

#[test]
fn analog_keeps_half_scale_while_it_is_off_and_the_inhibit_is_the_enable_pin() {
    let [before, driven, after] = off_driven_off(&["drive.mode=analog"]);
    let bdtr = MOE | BKE | OSSR;
    let compare = TOP / 2;
    let off = Seen { ccer: CC1E, bdtr, compare, top: TOP, enable: false, reverse: false };
    assert_eq!((before, after), (off, off));
    assert_eq!(driven, Seen { compare: driven.compare, enable: true, ..off });
    assert!(driven.compare < TOP / 2, "{driven:?}");
}

#[test]
fn a_break_lets_the_analog_output_go_and_half_scale_comes_back_with_the_inhibit_on() {
    let mut client = board(&["drive.mode=analog"]);
    client.arm().unwrap();
    client.step_to(-2.0).unwrap();
    client.pass(Duration::from_millis(200)).unwrap();
    client.wire().board.act(|halted| halted.inject(Injection::Break)).unwrap();
    client.wire().board.pass(MS / 10).unwrap();
    let at_once = look(&mut client);
    // Not driven (`OSSI` clear): the divider on the board is what the filter gets.
    assert_eq!((at_once.bdtr, at_once.enable), (BKE | OSSR, false));
    client.wire().board.act(|halted| halted.inject(Injection::BreakReleased)).unwrap();
    let status = client.pass(Duration::from_millis(40)).unwrap();
    assert!(matches!(status.state, StateCode::Faulted(_)), "{status:?}");
    let later = look(&mut client);
    assert_eq!((later.bdtr, later.compare, later.enable), (MOE | BKE | OSSR, TOP / 2, false));
}

#[test]
fn another_mode_over_the_link_takes_effect_at_once() {
    let mut client = board(&["drive.mode=analog"]);
    for (mode, ccer, bdtr) in [
        ("locked-antiphase", CC1E | CC1NE, BKE | OSSR | OSSI | 0x94),
        ("sign-magnitude", CC1E, BKE | OSSR | OSSI),
        ("analog", CC1E, MOE | BKE | OSSR),
        ("locked-antiphase", CC1E | CC1NE, BKE | OSSR | OSSI | 0x94),
    ] {
        let set = ["drive.pwm_hz=2000", "reference.steps_deg=[5.0]", &format!("drive.mode={mode}")];
        let plan = plans("step-response", &["pd"], &set).remove(0);
        client.set_parameters(&simulator::device::parameters(&plan).unwrap()).unwrap();
        let seen = look(&mut client);
        assert_eq!((seen.ccer, seen.bdtr, seen.enable), (ccer, bdtr, false), "{mode}");
    }
}
