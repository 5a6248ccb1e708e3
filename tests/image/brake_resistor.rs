//! The brake resistor's output, PC6, in the flash image: the pulse of each tick, and its end when
//! the program stands still.
//!
//! Blind to the switch, the resistor and the inductance of both. A probe that halts the core stops
//! TIM8 as well, which the emulated board does not model.

use emulator::board::GpioPort;
use emulator::board_under_test::BoardUnderTest;
use emulator::fault_injection::Injection;
use experiments::braking::{RESISTOR, braking};
use simulator::device::parameters;
use simulator::experiment::RunPlan;
use stiction::motion::Motion;
use stiction::servo::State;
use stiction::units::position::Position;
use stiction::{Fault, Parameters};

use crate::fault_injection::MS;
use crate::side_by_side::{self, is_armed};

/// A move of 5 deg, 0.3 s after power-on, with a resistor of 2 J that is cold by then.
const SET: [&str; 6] = [
    "device.autostart=true",
    "device.autostart_after_dip=true",
    "device.autostart_delay_s=0.3",
    "brake_resistor.power_w=10",
    "brake_resistor.energy_j=2",
    "brake_resistor.duty_max=0.5",
];

/// Power of another drive on the same supply, W.
const FEED_W: f64 = 40.0;

const TIM8_BDTR: u64 = 0x4001_0444;
const MOE: u32 = 1 << 15;

fn plan(set: &[&str]) -> (RunPlan, Parameters) {
    let plan = braking(&[&RESISTOR, &SET[..], set].concat());
    let mut parameters = parameters(&plan).unwrap();
    let counts = 5.0 / f64::from(parameters.controller.encoder.resolution);
    parameters.motion = Motion::Profiled(Position::from_counts(counts.round() as i32));
    (plan, parameters)
}

/// Feeds the supply of a board, and returns its voltage.
fn feeds(board: &mut BoardUnderTest, feed_w: f64) -> f64 {
    let link = move |halted: &mut emulator::board_under_test::HaltedBoard<'_>| {
        let link = halted.harness.coupling.plant.dc_link.as_mut().unwrap();
        link.feed_w = feed_w;
        link.volts()
    };
    board.act(link).unwrap()
}

/// Pulses and supply close a loop: one step of one pulse is seen in all that follow.
#[test]
fn an_image_with_a_brake_resistor_does_what_a_simulated_device_does_bit_for_bit() {
    let (plan, parameters) = plan(&[]);
    let mut board = side_by_side::board(&plan, &parameters);
    let mut device = side_by_side::device(&plan, &parameters);
    let mut next = |is_first: bool| loop {
        let sample = board.samples(1).unwrap();
        let tick = board.act(|halted| halted.last_tick()).unwrap().unwrap();
        if !is_first || is_armed(&tick) {
            let volts = feeds(&mut board, FEED_W);
            return (tick, sample.bridge.brake_steps, volts);
        }
    };
    let mut there = next(true);
    let mut here = device.tick();
    while !is_armed(&here.tick) {
        here = device.tick();
    }
    let (mut most, mut last, mut pulses) = (0, 0, 0);
    for tick in 0..700 {
        let link = device.dc_link.as_mut().unwrap();
        let expected = (here.tick, device.brake_steps, link.volts());
        link.feed_w = FEED_W;
        assert_eq!(there, expected, "tick {tick}");
        most = most.max(device.brake_steps);
        last = device.brake_steps;
        pulses += u32::from(last > 0);
        (there, here) = (next(false), device.tick());
    }
    // 2 J at 30 W last for 70 ms. From then on it is 10 W, and the supply trips its monitor. At the
    // 66 V that the converter reads at most, that is a duty of 10 W 28.2 ohm / 66^2 V^2.
    assert_eq!(here.state, State::Faulted(Fault::SupplyHigh));
    assert!(most > 300 && pulses > 600 && last.abs_diff(66) < 2, "{most}, {pulses}, {last} steps");
}

/// Pulses go on while the output is off. The last one is over 2 ms later.
#[test]
fn a_program_that_stands_still_commands_no_further_pulse() {
    let (plan, mut parameters) = plan(&[]);
    parameters.device.autostart = false;
    for stops in [Injection::TickStops, Injection::CoreStalls] {
        let mut board = side_by_side::board(&plan, &parameters);
        board.samples(150).unwrap();
        feeds(&mut board, 9.0);
        let steps = (0..150).map(|_| board.samples(1).unwrap().bridge.brake_steps).last().unwrap();
        assert!(steps > 50, "{steps} steps");
        board.act(move |halted| halted.inject(stops)).unwrap();
        board.pass(2 * MS).unwrap();
        for _ in 0..100 {
            board.pass(MS / 50).unwrap();
            let is_high = board.act(|halted| halted.board().is_high(GpioPort::C, 6)).unwrap();
            assert!(!is_high, "{stops:?}");
        }
    }
}

#[test]
fn pulses_go_on_after_a_break_input_and_there_are_none_without_a_resistor() {
    let (plan, parameters) = plan(&[]);
    let mut without = parameters.clone();
    without.brake_resistor.resistance = 0.0;
    for (parameters, is_on) in [(&without, false), (&parameters, true)] {
        let mut board = side_by_side::board(&plan, parameters);
        board.samples(350).unwrap();
        feeds(&mut board, 9.0);
        board.act(|halted| halted.inject(Injection::Break)).unwrap();
        let sample = board.samples(150).unwrap();
        let tick = board.act(|halted| halted.last_tick()).unwrap().unwrap();
        assert_eq!(tick.status & 0xFFFF, 3 | (Fault::BreakInput as u32) << 8);
        let enabled = board.act(|halted| halted.register(TIM8_BDTR)).unwrap().unwrap() & MOE != 0;
        assert_eq!((enabled, sample.bridge.brake_steps > 50), (is_on, is_on));
    }
}
