//! The short brake in the flash image: the bridge stays on at zero volts after a fault.
//!
//! tests/device/short_brake.rs has its faults, its end and the travel. Ticks are 1 ms.

use emulator::board_under_test::{BoardUnderTest, HaltedBoard};
use emulator::bridge::BridgeInputs;
use emulator::fault_injection::Injection;
use experiments::current_sensor::current_sensor;
use simulator::device::parameters;
use simulator::experiment::RunPlan;
use stiction::control::drive::Drive;
use stiction::{Fault, Parameters, Tick};

use crate::side_by_side;

/// A step that trips the overspeed monitor on its way, and 20 ticks of brake.
const SET: [&str; 10] = [
    "drive.pwm_hz=21000",
    "reference.steps_deg=[20.0]",
    "reference.trajectories=[]",
    "device.autostart=true",
    "device.autostart_after_dip=true",
    "device.autostart_delay_s=0.3",
    "device.soft_start_s=0.02",
    "device.short_brake_s=0.02",
    "limits.overspeed_deg_per_s=40",
    "profile.velocity_deg_per_s=30",
];
const BRAKE: u32 = 20;

/// ADC1's CR1. In it: interrupts of the current loop, and of the watchdog over the current.
const ADC1_CR1: u64 = 0x4001_2004;
const CONVERTED: u32 = 1 << 7;
const WATCHDOG: u32 = 1 << 6;

/// Bits 0 to 7, and bits 8 to 15 of a tick's status.
const ARMED: u32 = 2;
const FAULTED: u32 = 3;

fn plan(set: &[&str]) -> (RunPlan, Parameters) {
    let plan = current_sensor(&["pd"], &[&SET[..], set].concat()).remove(0);
    let parameters = parameters(&plan).unwrap();
    (plan, parameters)
}

/// What a board does after a sample: its tick, its bridge, and the interrupts of its converter.
struct Seen {
    tick: Tick,
    bridge: BridgeInputs,
    interrupts: u32,
}

fn next(board: &mut BoardUnderTest) -> Seen {
    board.samples(1).unwrap();
    let see = |halted: &mut HaltedBoard<'_>| Seen {
        tick: halted.last_tick().unwrap(),
        bridge: BridgeInputs::read(halted.board()),
        // Without its clock, before the boot has reached it, there is none.
        interrupts: halted.register(ADC1_CR1).unwrap_or(0),
    };
    board.act(see).unwrap()
}

const fn state(tick: &Tick) -> u32 {
    tick.status & 0xFF
}

/// With two modes of the bridge, a voltage and a current loop: position and current after the fault
/// depend on the duty of every period.
#[test]
fn an_image_brakes_short_as_a_simulated_device_does_bit_for_bit() {
    let current = ["loop.effort=current", "motor.inductance_h=0.001255"];
    for set in [
        &["drive.mode=sign-magnitude"][..],
        &["drive.mode=locked-antiphase"],
        &["drive.mode=sign-magnitude", current[0], current[1]],
    ] {
        let (plan, parameters) = plan(set);
        let drive = Drive::new(&parameters.controller.drive, &files::hardware::STM32F405).unwrap();
        let mut board = side_by_side::board(&plan, &parameters);
        let mut device = side_by_side::device(&plan, &parameters);
        let mut seen = next(&mut board);
        while state(&seen.tick) != ARMED {
            seen = next(&mut board);
        }
        let mut output = device.tick();
        while state(&output.tick) != ARMED {
            output = device.tick();
        }
        let (mut on, mut off) = (0, 0);
        // The joint rests at the end: position and current before that are those of another
        // instant.
        while off < 200 {
            assert_eq!(seen.tick, output.tick, "{set:?}");
            assert_eq!(seen.bridge.is_on(), output.enable, "{set:?}");
            if state(&seen.tick) == FAULTED && output.enable {
                assert_eq!(seen.tick.status >> 8 & 0xFF, Fault::Overspeed as u32);
                assert_eq!(seen.bridge.duty(drive.mode()), drive.duty(0), "{set:?}");
                // Nothing else writes a duty, and the watchdog over the current is on.
                assert_eq!(seen.interrupts & (CONVERTED | WATCHDOG), WATCHDOG, "{set:?}");
                on += 1;
            }
            off += u32::from(!output.enable);
            (seen, output) = (next(&mut board), device.tick());
        }
        assert_eq!(on, BRAKE, "{set:?}");
        assert_eq!(device.device.servo().latched().unwrap().fault, Fault::Overspeed);
        let there = board.act(|halted| halted.plant().position_deg()).unwrap();
        assert_eq!(there, device.position_deg(), "{set:?}");
    }
}

#[test]
fn the_hardware_ends_a_short_brake_for_good() {
    let (plan, parameters) = plan(&["drive.mode=sign-magnitude"]);
    let mut board = side_by_side::board(&plan, &parameters);
    while state(&next(&mut board).tick) != FAULTED {}
    assert!(next(&mut board).bridge.is_on());
    board.act(|halted| halted.inject(Injection::Break)).unwrap();
    for _ in 0..2 * BRAKE {
        assert!(!next(&mut board).bridge.is_on());
    }
}
