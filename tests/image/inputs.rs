//! What the board reads, and when: the registers of its encoder, its supply and its timers, as
//! RM0090 has them (chapters 13, 18 and 5), in the emulated part.
//!
//! Blind to the pins themselves: the emulator's have no spikes that a filter could take.

use emulator::board_under_test::HaltedBoard;
use emulator::wire::EmulatedWire;
use simulator::device::client::Client;

use crate::common::{firmware, plans};

const GPIOA_PUPDR: u64 = 0x4002_000C;
const TIM1: u64 = 0x4001_0000;
const TIM2: u64 = 0x4000_0000;
const TIM3: u64 = 0x4000_0400;
const TIM5: u64 = 0x4000_0C00;
const ADC1: u64 = 0x4001_2000;
const ADC_CCR: u64 = 0x4001_2304;
const PWR_CR: u64 = 0x4000_7000;

/// Returns some registers of a board with these keys.
fn registers<const N: usize>(set: &[&str], addresses: [u64; N]) -> [u32; N] {
    let set = [&["drive.pwm_hz=2000", "reference.steps_deg=[5.0]"], set].concat();
    let plan = plans("step-response", &["pd"], &set).remove(0);
    let mut client = Client::connect(EmulatedWire::with(&firmware(), &plan).unwrap()).unwrap();
    let read =
        move |halted: &mut HaltedBoard<'_>| addresses.map(|address| halted.register(address));
    client.wire().board.act(read).unwrap().map(Option::unwrap)
}

#[test]
fn the_inputs_are_filtered_and_pulled_up_and_every_edge_counts() {
    let [pulls, selected, index, mode, polarity, top] = registers(
        &[],
        [GPIOA_PUPDR, TIM2 + 0x18, TIM2 + 0x1C, TIM2 + 0x08, TIM2 + 0x20, TIM2 + 0x2C],
    );
    // PA0, PA1 and the link's PA10: a wire that is cut does not float.
    assert_eq!(pulls & (0xF | 3 << 20), 0b0101 | 1 << 20);
    // The index and the switch, PA2 and PA7: a wire that is cut is no index, and an open contact.
    assert_eq!(pulls >> 4 & 3 | (pulls >> 14 & 3) << 2, 0b10 | 0b01 << 2);
    // Each input its own, IC1F, IC2F and IC3F 8 samples; encoder mode 3; not inverted; CC3E
    // captures; 32 bits.
    assert_eq!((selected, index, mode & 0xFFFF, polarity), (0x3131, 0x31, 3, 1 << 8));
    assert_eq!(top, u32::MAX);
}

#[test]
fn the_supply_is_sampled_long_enough_and_the_parts_own_is_watched_above_what_the_flash_takes() {
    let [first, times, common, power] = registers(&[], [ADC1 + 0x34, ADC1 + 0x0C, ADC_CCR, PWR_CR]);
    // PC0 is channel 10: 144 clocks of 84 MHz / 4.
    assert_eq!((first & 0x1F, times & 7, common >> 16 & 3), (10, 0b110, 0b01));
    // PVDE, and level 5 of PLS: the one that falls at 2.75 V at the least, above 2.7 V.
    assert_eq!(power & 0xF0, 5 << 5 | 1 << 4);
}

/// RM0090, chapters 13 and 17. The trigger is the reference of channel 4, one count below the top.
#[test]
fn the_current_is_converted_once_a_period_and_watched_alone() {
    let sensor = [
        "current_sensor.full_scale_a=30",
        "current_sensor.resistance_ohm=0.5",
        "limits.back_emf_v_per_deg_per_s=0.001",
    ];
    let [group, times, control, trigger, modes, master, compare, top] = registers(
        &sensor,
        [
            ADC1 + 0x38,
            ADC1 + 0x0C,
            ADC1 + 0x04,
            ADC1 + 0x08,
            TIM1 + 0x1C,
            TIM1 + 0x04,
            TIM1 + 0x40,
            TIM1 + 0x2C,
        ],
    );
    // PC1 is channel 11, the last of a group of one; 15 clocks.
    assert_eq!((group >> 20 & 3, group >> 15 & 0x1F, times >> 3 & 7), (0, 11, 0b001));
    // JAWDEN, AWDSGL and channel 11; AWDIE with the bridge on alone.
    assert_eq!(control & (1 << 22 | 1 << 9 | 0x1F | 1 << 6), 1 << 22 | 1 << 9 | 11);
    // JEXTSEL: TIM1_TRGO; JEXTEN: its rising edge, and without a sensor no edge.
    assert_eq!(trigger >> 16 & 0x3F, 0b01_0001);
    let [none] = registers(&[], [ADC1 + 0x08]);
    assert_eq!(none >> 20 & 3, 0);
    // OC4M: PWM mode 2; MMS: OC4REF.
    assert_eq!((modes >> 12 & 7, master >> 4 & 7), (0b111, 0b111));
    assert_eq!(compare, top - 1);
}

#[test]
fn ticks_come_at_the_rate_of_the_file_and_the_stopwatch_outlasts_them() {
    for (sample_time, clocks) in [("0.02", 1_680_000), ("0.001", 84_000)] {
        let set = format!("loop.sample_time_s={sample_time}");
        let [divider, reload, wraps] = registers(&[&set], [TIM3 + 0x28, TIM3 + 0x2C, TIM5 + 0x2C]);
        // 84 MHz, to the clock.
        assert_eq!((divider + 1) * (reload + 1), clocks, "{sample_time} s");
        assert_eq!(wraps, u32::MAX);
    }
}
