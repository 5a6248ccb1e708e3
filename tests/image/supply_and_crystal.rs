//! The part's own supply and crystal: what cannot be trusted drives nothing, and says why.

use std::time::Duration;

use emulator::board::FittedParts;
use emulator::board_under_test::{BoardUnderTest, HaltedBoard, StopCondition};
use emulator::fault_injection::Injection;
use emulator::lockstep::Lockstep;
use emulator::plant_interface::FreeDiscs;
use emulator::setup::BoardSetup;
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;
use stiction::Parameters;
use stiction::parameters::ROOM;

use crate::common::{firmware, plans};
use crate::fault_injection::{AT, MS, inject, parameters};

#[test]
fn a_crystal_of_another_frequency_is_measured_refused_and_reported() {
    for megahertz in [4, 6, 10, 20] {
        let fitted = FittedParts { crystal_hz: megahertz * 1_000_000, ..FittedParts::default() };
        let observed = inject(Some(&parameters()), fitted, &[]);
        assert!(observed.on_ns.is_empty(), "{megahertz} MHz: {observed:?}");
        assert!(observed.says("clock 168000000 Hz from internal oscillator"), "{:?}", observed.log);
        let measured = observed.log.iter().find_map(|line| {
            line.text.strip_prefix("the crystal has about ")?.split(' ').next()?.parse().ok()
        });
        // The emulated internal oscillator has no error: two counts of 3174 are left at 20 MHz.
        let measured: f64 = measured.unwrap_or_else(|| panic!("{:?}", observed.log));
        assert!(
            (measured / megahertz as f64 - 1.0).abs() < 1e-3,
            "{megahertz} MHz measured as {measured}"
        );
        assert!(observed.says("faulted: crystal of another frequency"), "{:?}", observed.log);
    }
}

#[test]
fn each_of_the_four_crystals_is_measured_and_gives_the_same_clock() {
    // 8.3 MHz is within what the internal oscillator can distinguish from 8 MHz.
    for (crystal_hz, mhz) in [
        (7_960_000, 8),
        (8_000_000, 8),
        (8_040_000, 8),
        (8_300_000, 8),
        (12_000_000, 12),
        (16_000_000, 16),
        (25_000_000, 25),
    ] {
        let observed =
            inject(Some(&parameters()), FittedParts { crystal_hz, ..FittedParts::default() }, &[]);
        assert!(observed.on_after(AT), "{crystal_hz} Hz: {:?}", observed.log);
        assert!(observed.says("clock 168000000 Hz from crystal"), "{:?}", observed.log);
        assert!(observed.says(&format!("the crystal has {mhz} MHz")), "{:?}", observed.log);
        assert!(!observed.says("not measured"), "{:?}", observed.log);
    }
}

/// The rate of USART1, and the processor's clock source.
const USART1_BRR: u64 = 0x4001_1008;
const USART1_CR1: u64 = 0x4001_100C;
const RCC_CFGR: u64 = 0x4002_3808;

#[test]
fn without_a_crystal_the_link_keeps_its_rate_but_for_the_internal_oscillators_error() {
    for fitted in [
        FittedParts { crystal: false, ..FittedParts::default() },
        FittedParts { crystal_hz: 10_000_000, ..FittedParts::default() },
    ] {
        let mut setup = BoardSetup::new("rate", &firmware(), parameters());
        setup.fitted = fitted;
        let mut board =
            BoardUnderTest::power_on(setup, Lockstep::new(FreeDiscs::default(), 20 * MS)).unwrap();
        board.until(StopCondition::Time(100 * MS)).unwrap();
        let registers = [USART1_BRR, USART1_CR1, RCC_CFGR];
        let [divider, control, clock] =
            board.act(move |halted| registers.map(|address| halted.register(address))).unwrap();
        // RM0090: the processor runs from the PLL; USART1 samples 16 times a bit (OVER8 is 0), and
        // then its divider counts clocks of 84 MHz to a bit.
        assert_eq!(clock.unwrap() >> 2 & 0b11, 0b10, "{fitted:?}");
        assert_eq!(control.unwrap() >> 15 & 1, 0, "{fitted:?}");
        let rate = 84e6 / f64::from(divider.unwrap());
        assert!((rate / 921_600.0 - 1.0).abs() < 0.002, "{fitted:?}: {rate} baud");
    }
}

/// The parameters with another word on dips.
fn after_dip(autostarts: bool) -> Vec<u8> {
    let (mut found, sequence) = Parameters::decode(&parameters()).unwrap();
    found.device.autostart_after_dip = autostarts;
    found.encode(sequence, &mut [0; ROOM]).unwrap().to_vec()
}

#[test]
fn without_a_brown_out_reset_nothing_autostarts_at_power_on_unless_the_parameters_say_so() {
    let factory = FittedParts::default();
    let set_up = FittedParts { brown_out: true, ..factory };
    for (fitted, autostarts, arms) in [
        (factory, false, false),
        (factory, true, true),
        (set_up, false, true),
        (set_up, true, true),
    ] {
        let observed = inject(Some(&after_dip(autostarts)), fitted, &[]);
        assert_eq!(observed.on_after(AT), arms, "{fitted:?}, {autostarts}: {:?}", observed.log);
        assert_eq!(observed.says("autostart: not after this reset"), !arms, "{:?}", observed.log);
        let off = observed.says("brown-out reset is off");
        assert_eq!(
            (off, observed.says("brown-out reset: level 3")),
            (!fitted.brown_out, fitted.brown_out)
        );
    }
}

#[test]
fn the_reset_button_is_no_dip() {
    // Power-on may be a dip, and arms nothing; the button after it does.
    let observed =
        inject(Some(&after_dip(false)), FittedParts::default(), &[(AT, Injection::Reset)]);
    assert!(observed.says("reset pin") && observed.on_after(AT), "{:?}", observed.log);
}

#[test]
fn nothing_is_erased_while_the_parts_own_supply_sags() {
    let plan = plans("step-response", &["pd"], &["drive.pwm_hz=2000"]).remove(0);
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap();
    assert!(!client.status().unwrap().has_brown_out, "a factory part");
    client.wire().board.act(|halted| halted.board().set_rail(2_700)).unwrap();
    let refusal = client.save().unwrap_err().to_string();
    assert!(refusal.contains("3.3 V supply is below 2.9 V"), "{refusal}");
    // With the supply back, a save of what is saved already has nothing to write, and is done.
    client.wire().board.act(|halted| halted.board().set_rail(3_300)).unwrap();
    client.save().unwrap();
}

/// FLASH_OPTCR of a part as the factory leaves it, and with the highest brown-out level: locked.
const FACTORY: u64 = 0x0FFF_AAED;
const SET: u64 = 0x0FFF_AAE1;

fn client() -> Client<EmulatedWire> {
    let plan = plans("step-response", &["pd"], &["drive.pwm_hz=2000"]).remove(0);
    Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap()
}

fn options(client: &mut Client<EmulatedWire>, set: Option<u64>) -> u64 {
    let act = move |halted: &mut HaltedBoard<'_>| {
        if let Some(word) = set {
            halted.board().set_option_bytes(word);
        }
        halted.board().option_bytes()
    };
    client.wire().board.act(act).unwrap()
}

#[test]
fn the_brown_out_reset_is_turned_on_by_a_command_and_no_other_option_byte_changes() {
    let mut client = client();
    assert_eq!(options(&mut client, None), FACTORY);
    client.set_brown_out().unwrap();
    assert_eq!(options(&mut client, None), SET);
    // The part goes by it after a reset, and says so then.
    assert!(!client.status().unwrap().has_brown_out);
    // Twice is once; and a part with a protection keeps it.
    client.set_brown_out().unwrap();
    let protected = 0x0FF0_55ED;
    options(&mut client, Some(protected));
    client.set_brown_out().unwrap();
    assert_eq!(options(&mut client, None), protected & !0b1100);
    // The board goes on as before: it is armed and stopped, and its ticks come.
    client.pass(Duration::from_millis(200)).unwrap();
    client.arm().unwrap();
    let refusal = client.set_brown_out().unwrap_err().to_string();
    assert!(refusal.contains("set-brown-out") && refusal.contains("motor is driven"), "{refusal}");
    client.stop().unwrap();
    assert_eq!(client.status().unwrap().faults, 0);
}

#[test]
fn option_bytes_that_may_not_be_touched_are_left_alone() {
    let mut client = client();
    // Protected for ever; and a bit that the part does not have.
    for word in [0x0FFF_CCED, FACTORY | 1 << 4] {
        options(&mut client, Some(word));
        let refusal = client.set_brown_out().unwrap_err().to_string();
        assert!(refusal.contains("option bytes cannot be changed"), "{refusal}");
        assert_eq!(options(&mut client, None), word);
    }
    options(&mut client, Some(FACTORY));
    client.wire().board.act(|halted| halted.board().set_rail(2_700)).unwrap();
    let refusal = client.set_brown_out().unwrap_err().to_string();
    assert!(refusal.contains("3.3 V supply is below 2.9 V"), "{refusal}");
    assert_eq!(options(&mut client, None), FACTORY);
}
