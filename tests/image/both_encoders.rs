//! The image for two encoders: bit for bit what the host does with joints that have one on the
//! motor and one on the load; failed wires; a jog; and images that do not fit.

use std::time::Duration;

use emulator::as5047p::As5047p;
use emulator::wire::EmulatedWire;
use experiments::both_encoders::{STIFF, both_encoders};
use experiments::flash_image::{emulation_of_two, firmware_for_two};
use files::encoder::Wires;
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use simulator::experiment::RunPlan;
use stiction::Fault;
use stiction::control::signal::index;
use stiction::link::StateCode;
use stiction::motion::home::{HomeEnd, HomeFindings, HomeRequest, HomeTarget, Sense};
use stiction::motion::jog::Verdict;
use stiction::servo::Boot;

use crate::bit_for_bit::assert_same_in;
use crate::common::{emulation, firmware};
use crate::first_run::jogged;

/// A tenth of the usual frequency costs the emulator less time.
const SLOW_PWM: &str = "drive.pwm_hz=2000";

/// One step of 5 deg, a second long.
const STEP: [&str; 4] =
    ["reference.steps_deg=[5.0]", "reference.trajectories=[]", "run.duration_s=1.5", SLOW_PWM];

fn step(laws: &[&str], set: &[&str]) -> Vec<RunPlan> {
    both_encoders(laws, &[&STEP, set].concat())
}

/// One joint of each kind: with slack and soft, stiff, a load that drives it, with noise of a count
/// on both sides, with a load that starts wound up, and counters that run the other way.
#[test]
fn joints_with_both_encoders_move_as_on_the_host() {
    let emulation = emulation_of_two();
    for set in [
        &[][..],
        &STIFF,
        &["load.constant_nm=10.0"],
        &["encoder.noise_counts=1", "load_encoder.noise_counts=1"],
        &["encoder.direction=reverse", "load_encoder.direction=reverse"],
        &["load_encoder.counts_per_turn=1000000", "encoder.lines=25"],
        &["load_encoder.kind=as5047p", "load_encoder.zero_counts=16383"],
    ] {
        assert_same_in(&emulation, &step(&["robust"], set));
    }
    // The other laws close the loop at the load, with the velocity of the motor.
    assert_same_in(&emulation, &step(&["srnf", "pd"], &[]));
    // With one encoder, the same image reads the first one alone.
    assert_same_in(&emulation, &step(&["robust"], &["loop.position=motor"]));
}

/// A joint that goes on for longer than the 16 bits of the load's counter.
#[test]
fn counter_of_the_load_goes_on_beyond_its_sixteen_bits() {
    let far = ["load_encoder.counts_per_turn=4000000", "run.duration_s=3"];
    let plans =
        both_encoders(&["robust"], &[&STEP[..], &far, &["reference.steps_deg=[20.0]"]].concat());
    let host = &simulator::run::run_all(&plans).unwrap()[0];
    let simulator::run::RunTrace::Loop(samples) = &host.trace else { panic!("a ramp") };
    let counts = samples.iter().map(|sample| sample.tick.counts).max().unwrap();
    assert!(counts > 3 * 65536, "{counts}");
    assert_same_in(&emulation_of_two(), &plans);
}

#[test]
fn image_for_one_encoder_refuses_a_joint_with_two() {
    let plans = step(&["robust"], &[]);
    let why = emulation().run_all(&plans).unwrap_err().to_string();
    assert!(why.contains("reads one encoder") && why.contains("stiction-two-encoders"), "{why}");
    let why = EmulatedWire::with(&firmware(), &plans[0]).unwrap_err().to_string();
    assert!(why.contains("reads one encoder"), "{why}");
    // Over the link as well: the board there has the image for one encoder.
    let one = &step(&["robust"], &["loop.position=motor"])[0];
    let mut client = Client::connect(EmulatedWire::with(&firmware(), one).unwrap()).unwrap();
    let two = simulator::device::parameters(&plans[0]).unwrap();
    let why = client.set_parameters(&two).unwrap_err().to_string();
    assert!(why.contains("--two-encoders"), "{why}");
}

/// Runs a move of 20 deg with a failure from 5 deg on, a client alive. Returns the fault and its
/// value; none if no monitor sees it within three seconds.
fn outcome_of_a_move<W: Wire>(
    client: &mut Client<W>,
    mut ticks: impl FnMut(&mut Client<W>, bool) -> f64,
) -> Option<(u8, f32)> {
    client.arm().unwrap();
    client.move_to(20.0).unwrap();
    let mut is_failed = false;
    for _ in 0..300 {
        let deg = ticks(client, is_failed);
        is_failed |= deg > 5.0;
        let status = client.status().unwrap();
        if status.state != StateCode::Armed {
            return Some((status.fault.code, status.fault.value));
        }
    }
    None
}

/// Returns the same of a failure that is a fault.
fn fails_on_the_way<W: Wire>(
    client: &mut Client<W>,
    ticks: impl FnMut(&mut Client<W>, bool) -> f64,
) -> (u8, f32) {
    outcome_of_a_move(client, ticks).unwrap()
}

#[test]
fn failed_encoder_of_either_side_is_the_same_fault_as_on_a_simulated_device() {
    for wires in [[Wires::Cut, Wires::Sound], [Wires::Sound, Wires::Cut]] {
        for law in ["robust", "srnf"] {
            let plan = &step(&[law], &[])[0];
            let mut simulated = SimulatedDevice::new(plan).unwrap();
            simulated.ticks(200);
            let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
            let here = fails_on_the_way(&mut client, |client, is_failed| {
                let device = &mut client.wire().simulated;
                if is_failed {
                    [device.wires, device.load_wires] = wires;
                }
                device.ticks(10);
                device.position_deg()
            });
            let wire = EmulatedWire::with(&firmware_for_two(), plan).unwrap();
            let mut client = Client::connect(wire).unwrap();
            let there = fails_on_the_way(&mut client, |client, is_failed| {
                let board = &mut client.wire().board;
                if is_failed {
                    let act = board.act(move |halted| {
                        halted.rewire(wires[0]);
                        halted.rewire_load(wires[1]);
                    });
                    act.unwrap();
                }
                board.samples(10).unwrap();
                board.act(|halted| halted.plant().position_deg()).unwrap()
            });
            let name = |code: u8| Fault::from_code(code).map(Fault::describe);
            assert_eq!(name(there.0), name(here.0), "{law}, {wires:?}");
            // Both begin the failure up to a tick apart.
            let ratio = there.1 / here.1;
            assert!((0.8..1.25).contains(&ratio), "{law}, {wires:?}: {} {}", here.1, there.1);
        }
    }
}

/// Counts that the motor's encoder adds in a tick, given the number of the tick and the travel of
/// the joint in it, deg.
type FalseCounts = fn(u32, f64) -> i32;

/// Noise to and fro, and a disc that slips the other way by half of the joint's travel.
const FALSE_COUNTS: [(&str, FalseCounts); 2] = [
    ("noise", |tick, _| if tick % 2 == 0 { 200 } else { -200 }),
    ("slip", |_, deg| (-1.5 * deg / 0.0036).round() as i32),
];

#[test]
fn noisy_and_slipping_encoder_of_the_motor_is_the_same_fault_as_on_a_simulated_device() {
    let mut faults = 0;
    for (what, counts) in FALSE_COUNTS {
        for law in ["robust", "srnf"] {
            let plan = &step(&[law], &[])[0];
            let mut simulated = SimulatedDevice::new(plan).unwrap();
            simulated.ticks(200);
            let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
            let (mut tick, mut before) = (0, 0.0);
            let here = outcome_of_a_move(&mut client, |client, is_failed| {
                let device = &mut client.wire().simulated;
                for _ in 0..10 {
                    let deg = device.position_deg();
                    if is_failed {
                        device.jump(counts(tick, deg - before));
                    }
                    (tick, before) = (tick + 1, deg);
                    device.tick();
                }
                before
            });
            let wire = EmulatedWire::with(&firmware_for_two(), plan).unwrap();
            let mut client = Client::connect(wire).unwrap();
            let (mut tick, mut before) = (0, 0.0);
            let there = outcome_of_a_move(&mut client, |client, is_failed| {
                let board = &mut client.wire().board;
                for _ in 0..10 {
                    let act = board.act(move |halted| {
                        let deg = halted.plant().position_deg();
                        if is_failed {
                            halted.jump(counts(tick, deg - before));
                        }
                        deg
                    });
                    (tick, before) = (tick + 1, act.unwrap());
                    board.samples(1).unwrap();
                }
                before
            });
            let name = |of: Option<(u8, f32)>| {
                of.and_then(|(code, _)| Fault::from_code(code)).map(Fault::describe)
            };
            assert_eq!(name(there), name(here), "{what}, {law}");
            let (Some((_, here)), Some((_, there))) = (here, there) else { continue };
            // Both begin the failure up to a tick apart.
            assert!((0.8..1.25).contains(&(there / here)), "{what}, {law}: {here} {there}");
            faults += 1;
        }
    }
    assert!(faults > 1, "{faults} of 4 are a fault");
}

/// The motor turns, and the load stays behind slack that it never crosses. From the arming on, both
/// are the same in each tick, so the value is the same to the bit.
#[test]
fn open_coupling_is_the_same_fault_to_the_bit_as_on_a_simulated_device() {
    for law in ["robust", "srnf"] {
        let configured = simulator::device::parameters(&step(&[law], &[])[0]).unwrap();
        let joint = &step(&[law], &["gear.backlash_deg=170"])[0];
        let mut simulated = SimulatedDevice::running(joint, &configured, Boot::at_zero()).unwrap();
        simulated.ticks(200);
        let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        let here = fails_on_the_way(&mut client, |client, _| {
            client.wire().simulated.ticks(10);
            0.0
        });
        let wire = EmulatedWire::with(&firmware_for_two(), joint).unwrap();
        let mut client = Client::connect(wire).unwrap();
        client.set_parameters(&configured).unwrap();
        client.wire().board.samples(200).unwrap();
        let there = fails_on_the_way(&mut client, |client, _| {
            client.wire().board.samples(10).unwrap();
            0.0
        });
        assert_eq!((there.0, there.1.to_bits()), (here.0, here.1.to_bits()), "{law}");
    }
}

/// The chip on SPI3 answers frame by frame: its angle is in the tick in which it was sampled. One
/// that is cut off its bus, or whose magnet is too far, is a fault.
#[test]
fn absolute_encoder_gives_the_reference_and_its_silence_is_a_fault() {
    let set = [
        "load_encoder.kind=as5047p",
        "load_encoder.zero_counts=16000",
        "limits.position_min_deg=-90",
        "limits.position_max_deg=90",
    ];
    let plan = &step(&["robust"], &set)[0];
    for is_weak in [false, true] {
        let mut wire = EmulatedWire::with(&firmware_for_two(), plan).unwrap();
        let act = wire.board.act(|halted| {
            halted.push(30.0, 0.0);
        });
        act.unwrap();
        wire.board.samples(200).unwrap();
        let mut client = Client::connect(wire).unwrap();
        let status = client.status().unwrap();
        assert!(status.is_referenced);
        assert_eq!(status.position, (30.0 * 16384.0 / 360.0_f64).round() as i32);
        client.arm().unwrap();
        let board = &mut client.wire().board;
        board.samples(20).unwrap();
        assert!(board.samples(1).unwrap().bridge.is_on());
        // An error of the chip is cleared within two ticks.
        board.act(|halted| As5047p::refuse(&mut halted.board().mcu)).unwrap();
        board.samples(20).unwrap();
        assert!(board.samples(1).unwrap().bridge.is_on());
        let act = board.act(move |halted| {
            if is_weak {
                // Field too low: bit 11.
                As5047p::diagnose(&mut halted.board().mcu, 0x0980);
            } else {
                halted.rewire_load(Wires::Cut);
            }
        });
        act.unwrap();
        let ticks = (1..20).find(|_| !board.samples(1).unwrap().bridge.is_on()).unwrap();
        let fault = Fault::from_code(client.status().unwrap().fault.code);
        if is_weak {
            // Five ticks, and one more: a diagnosis is that of the tick before.
            assert_eq!((ticks, fault), (6, Some(Fault::EncoderSilent)));
        } else {
            // The bus breaks between the frames of a tick. The frame of the angle is zero then,
            // which is a valid one: a jump of 30 deg and the zero's angle.
            assert_eq!((ticks, fault), (1, Some(Fault::EncoderJump)));
        }
    }
}

#[test]
fn a_jog_finds_the_same_of_both_encoders_as_on_a_simulated_device() {
    for wires in [
        [Wires::Sound, Wires::Sound],
        [Wires::Swapped, Wires::Sound],
        [Wires::Sound, Wires::Swapped],
    ] {
        let plan = &step(&["robust"], &[])[0];
        let mut simulated = SimulatedDevice::new(plan).unwrap();
        simulated.ticks(200);
        [simulated.wires, simulated.load_wires] = wires;
        let here = jogged(&mut Client::connect(SimulatedWire::new(simulated)).unwrap()).unwrap();
        let mut wire = EmulatedWire::with(&firmware_for_two(), plan).unwrap();
        let act = wire.board.act(move |halted| {
            halted.rewire(wires[0]);
            halted.rewire_load(wires[1]);
        });
        act.unwrap();
        let there = jogged(&mut Client::connect(wire).unwrap()).unwrap();
        assert_eq!(there, here, "{wires:?}");
        assert_ne!(there.motor_verdict(), Some(Verdict::Still));
    }
}

/// The test at arming, with a load's encoder that is dead and with sound ones: the same fault, to
/// the bit of its value, or the same place after a second of the loop.
#[test]
fn a_test_at_arming_ends_as_on_a_simulated_device() {
    let wires = [([Wires::Sound, Wires::Cut], 26), ([Wires::Sound, Wires::Sound], 0)];
    for (wires, code) in wires {
        let plan = &step(&["robust"], &["device.arming_test_deg=3.0"])[0];
        let mut simulated = SimulatedDevice::new(plan).unwrap();
        simulated.ticks(200);
        [simulated.wires, simulated.load_wires] = wires;
        let here = tested(&mut Client::connect(SimulatedWire::new(simulated)).unwrap());
        let mut wire = EmulatedWire::with(&firmware_for_two(), plan).unwrap();
        let act = wire.board.act(move |halted| {
            halted.rewire(wires[0]);
            halted.rewire_load(wires[1]);
        });
        act.unwrap();
        let there = tested(&mut Client::connect(wire).unwrap());
        assert_eq!(there, here, "{wires:?}");
        assert_eq!(there.0, code, "{wires:?}");
    }
}

/// Arms a device, and returns the number of the fault of its test, the bits of its value, and the
/// position 3 s later, counts; 0 after a fault, since a line that is cut flickers.
fn tested<W: Wire>(client: &mut Client<W>) -> (u8, u32, i32) {
    if !client.status().unwrap().at_rest {
        client.pass(std::time::Duration::from_millis(100)).unwrap();
    }
    client.arm().unwrap();
    let status = client.pass(std::time::Duration::from_secs(3)).unwrap();
    assert_eq!(status.has_failed_test, status.fault.code != 0);
    assert!(!status.is_testing);
    let place = if status.fault.code == 0 { status.position } else { 0 };
    (status.fault.code, status.fault.value.to_bits(), place)
}

/// TIM2 captures the motor's counter, and the load is a chip or a second counter.
#[test]
fn a_homing_to_the_index_of_the_motor_finds_what_a_simulated_device_finds() {
    let home = HomeRequest { sense: Sense::Plus, to: HomeTarget::Index, ..HomeRequest::default() };
    for kind in [&[][..], &["load_encoder.kind=as5047p", "load_encoder.zero_counts=16000"]] {
        let plan = &step(&["robust"], &[&["device.index_counts=2000"], kind].concat())[0];
        let mut simulated = SimulatedDevice::new(plan).unwrap();
        simulated.ticks(200);
        let mut here = Client::connect(SimulatedWire::new(simulated)).unwrap();
        let wire = EmulatedWire::with(&firmware_for_two(), plan).unwrap();
        let mut there = Client::connect(wire).unwrap();
        there.pass(Duration::from_millis(300)).unwrap();
        let [expected, found] = [homed(&mut here, home), homed(&mut there, home)];
        assert_eq!(found, expected, "{kind:?}");
        // The index is 1.8 deg from the start, 82 counts of the load, which is behind the motor.
        let found = found.unwrap();
        assert_eq!(found.ended, HomeEnd::Index, "{kind:?}");
        assert!((50..75).contains(&found.moved), "{kind:?}: {found:?}");
        assert!(there.status().unwrap().is_referenced, "{kind:?}");
    }
}

fn homed<W: Wire>(client: &mut Client<W>, home: HomeRequest) -> Option<HomeFindings> {
    client.home(home).unwrap();
    client.pass_armed(Duration::from_secs(30)).unwrap();
    client.homed().unwrap()
}

/// Returns position of the load, effort and position of the motor in each tick of a move, from the
/// first effort on.
fn sampled<W: Wire>(client: &mut Client<W>) -> Vec<[u32; 3]> {
    if !client.status().unwrap().at_rest {
        client.pass(Duration::from_millis(100)).unwrap();
    }
    client.arm().unwrap();
    let signals = ["counts", "v_applied", "motor_counts"].map(index);
    client.subscribe(signals.iter().fold(0, |mask, place| mask | 1 << place), 1).unwrap();
    client.pass(Duration::from_millis(600)).unwrap();
    client.move_to(2.0).unwrap();
    client.pass(Duration::from_millis(700)).unwrap();
    let samples = std::iter::from_fn(|| client.kept());
    let values = samples.map(|sample| signals.map(|place| sample.value(place).unwrap()));
    let values = values.skip_while(|[_, effort, _]| f32::from_bits(*effort) == 0.0).take(600);
    let values: Vec<_> = values.collect();
    assert_eq!((client.lost(), values.len()), (0, 600));
    values
}

/// These are the samples from which `device identify` measures the gear.
#[test]
fn samples_of_both_encoders_are_those_of_a_simulated_device() {
    let plan = &step(&["robust"], &[])[0];
    let mut simulated = SimulatedDevice::new(plan).unwrap();
    simulated.ticks(200);
    let here = sampled(&mut Client::connect(SimulatedWire::new(simulated)).unwrap());
    let wire = EmulatedWire::with(&firmware_for_two(), plan).unwrap();
    let there = sampled(&mut Client::connect(wire).unwrap());
    assert_eq!(there, here);
    // The motor has gone ahead by slack and wind-up: 0.15 deg to either side of the middle, and no
    // more than the twist that the device tolerates.
    let twist_deg = |[load, _, motor]: &[u32; 3]| {
        f64::from(*motor as i32) * 0.0036 - f64::from(*load as i32) * 360.0 / 16384.0
    };
    let largest = there.iter().map(twist_deg).fold(0.0, f64::max);
    assert!((0.15..1.8).contains(&largest), "{largest} deg");
}
