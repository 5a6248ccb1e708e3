//! Every fault under every law: at rest, moving, saturated.
//!
//! Each row says what is done to the joint or its board and within how many ticks it has to be seen. Asserted is the code,
//! the bound, that the bridge is off in the tick of the detection, that nothing is driven afterwards whatever is asked,
//! and that arming again takes a cleared fault and a joint at rest. What cannot happen is listed with its reason.

use host_sim::device::client::Client;
use host_sim::device::simulated::{SimulatedDevice, Wires};
use host_sim::device::wire::SimulatedWire;
use host_sim::hardware::STM32F405;
use stiction::drive::Drive;
use stiction::position::Position;
use stiction::reference::Corner;
use stiction::servo::{Output, Servo, State};
use stiction::{Fault, Motion};

use crate::fixture::{laws, plans};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Situation {
    /// On target after a step, the effort that it rests with applied.
    Rest,
    /// Along a line of 5 deg/s.
    Moving,
    /// At the full scale of the output, on the way to a far target.
    Saturated,
}

use Situation::{Moving, Rest, Saturated};

/// What is done in every tick from the injection on.
type Inject = fn(&mut SimulatedDevice, u32);

struct Row {
    fault: Fault,
    what: &'static str,
    /// Keys that take the row's fault out of the shadow of those that would be seen earlier.
    set: &'static [&'static str],
    inject: Inject,
    /// What makes it good again.
    mend: fn(&mut SimulatedDevice),
    /// Ticks from the injection to the detection, at least and at most, by situation; or why it cannot be.
    within: [Result<[u32; 2], &'static str>; 3],
}

const SUPPLY: &[&str] = &["device.supply_full_scale_v=24", "device.nominal_supply_v=12"];

fn sound(simulated: &mut SimulatedDevice) {
    simulated.wires = Wires::Sound;
    simulated.supply = 2048;
    simulated.brake_v = 0.0;
}

fn rows() -> Vec<Row> {
    let all = |within| [Ok(within), Ok(within), Ok(within)];
    vec![
        Row {
            fault: Fault::EncoderJump,
            what: "3000 counts at once",
            set: &[],
            inject: |simulated, tick| {
                if tick == 0 {
                    simulated.jump(3000);
                }
            },
            mend: sound,
            within: all([1, 1]),
        },
        Row {
            fault: Fault::Stall,
            what: "the joint is blocked",
            set: &[],
            inject: |simulated, _| simulated.brake_v = 100.0,
            mend: sound,
            within: [
                Err("a joint at rest is not asked to move: blocked or not is the same"),
                // From 0.5 V of cruising effort to 0.8 V at 5 deg/s is up to 0.3 s; then 0.2 s.
                Ok([10, 30]),
                Ok([10, 12]),
            ],
        },
        Row {
            fault: Fault::Stall,
            what: "both encoder wires cut",
            set: &[],
            inject: |simulated, _| simulated.wires = Wires::Cut,
            mend: sound,
            within: [Err("without motion there is no edge that could be missed"), Ok([10, 30]), Ok([10, 12])],
        },
        Row {
            fault: Fault::Stall,
            what: "one encoder wire cut",
            set: &[],
            inject: |simulated, _| simulated.wires = Wires::OneCut,
            mend: sound,
            within: [Err("without motion there is no edge that could be missed"), Ok([10, 30]), Ok([10, 12])],
        },
        Row {
            fault: Fault::FollowingError,
            what: "pushed away from its set point, 15 deg/s",
            set: &["limits.stall_v=0"],
            inject: |simulated, _| {
                let position = simulated.position_deg();
                simulated.push(position - 0.3, -15.0);
            },
            mend: sound,
            within: [
                // 5 deg at 0.3 deg a tick, less what the joint gives way by itself.
                Ok([8, 18]),
                Ok([6, 18]),
                // Also the way that it had gone since the jump.
                Ok([8, 40]),
            ],
        },
        Row {
            fault: Fault::Overspeed,
            what: "driven to 1.3 times the limit from outside",
            set: &["limits.overspeed_deg_per_s=40", "limits.encoder_jump_deg=3"],
            inject: |simulated, _| {
                let position = simulated.position_deg();
                simulated.push(position, 52.0);
            },
            mend: sound,
            within: [
                Err("a joint at rest has no speed; one that is thrown is not at rest: the next column"),
                // Within the window of the regression.
                Ok([2, 6]),
                Ok([2, 6]),
            ],
        },
        Row {
            fault: Fault::PositionLimit,
            what: "put beyond the range",
            set: &[
                "limits.position_min_deg=-100",
                "limits.position_max_deg=110",
                "encoder.counter_bits=32",
                "limits.encoder_jump_deg=0",
                "limits.overspeed_deg_per_s=0",
                "limits.following_error_deg=0",
            ],
            inject: |simulated, _| simulated.push(110.1, 0.0),
            mend: |simulated| simulated.push(50.0, 0.0),
            within: all([1, 1]),
        },
        Row {
            fault: Fault::SupplyLow,
            what: "6 V of 12 V",
            set: SUPPLY,
            inject: |simulated, _| simulated.supply = 1024,
            mend: sound,
            within: all([3, 3]),
        },
        Row {
            fault: Fault::SupplyHigh,
            what: "18 V of 12 V",
            set: SUPPLY,
            inject: |simulated, _| simulated.supply = 3072,
            mend: sound,
            within: all([3, 3]),
        },
        Row {
            fault: Fault::Overheat,
            what: "full effort against a block",
            set: &["limits.stall_v=0", "limits.thermal_s=1", "limits.continuous_v=2.5"],
            inject: |simulated, _| simulated.brake_v = 100.0,
            mend: |simulated| {
                sound(simulated);
                simulated.ticks(200);
            },
            within: [
                Err("the effort that a joint can rest with is less than any motor bears for ever"),
                Err("a blocked joint is saturated in the end: the next column"),
                // 1 s ln(1 / (1 - 1/4)) = 0.288 s from cold; some heat is there already.
                Ok([8, 16]),
            ],
        },
        Row {
            fault: Fault::LinkTimeout,
            what: "nobody says anything",
            set: &["limits.overspeed_deg_per_s=0", "limits.encoder_jump_deg=0"],
            inject: |_, _| {},
            mend: sound,
            // 0.5 s of 20 ms; the last word was said in the tick before.
            within: all([26, 26]),
        },
    ]
}

/// Those that the board reports; the core has to obey at once.
const FROM_THE_BOARD: [Fault; 5] =
    [Fault::Overrun, Fault::BreakInput, Fault::ClockLost, Fault::Panic, Fault::Watchdog];

/// Why the others are in no row.
const ELSEWHERE: [(Fault, &str); 8] = [
    (Fault::NonFinite, "no parameters that are accepted lead there (src/servo/tests.rs)"),
    (Fault::NoParameters, "only at boot: parameters cannot go while it is armed (tests/device/link.rs)"),
    (Fault::BadParameters, "the same"),
    (Fault::ClockAbsent, "only at boot; tests/image/hardware_faults.rs"),
    (Fault::BrownOut, "the part is reset: nothing runs that could detect it"),
    (Fault::ResetWhileArmed, "told after the reset; tests/image/hardware_faults.rs"),
    (Fault::HardFault, "the part is reset"),
    (Fault::EncoderReversed, "only in the first move: a test of its own, below"),
];

struct Bench {
    client: Client<SimulatedWire>,
    neutral: stiction::drive::Duty,
}

impl Bench {
    fn new(law: &str, set: &[&str]) -> Self {
        let law = format!("loop.controller={law}");
        let set = [&[&*law, "reference.steps_deg=[5.0]"], set].concat();
        let plan = &plans("step-response", &set)[0];
        let simulated = SimulatedDevice::new(plan).unwrap();
        let drive = &simulated.device.parameters().unwrap().controller.drive;
        let drive = Drive::new(drive, &STM32F405).unwrap();
        let client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        Self { client, neutral: drive.duty(0) }
    }

    fn simulated(&mut self) -> &mut SimulatedDevice {
        &mut self.client.wire().simulated
    }

    /// Ticks with a client that is there.
    fn pass(&mut self, ticks: u32) -> Output {
        let mut output = self.simulated().tick();
        for _ in 1..ticks {
            self.simulated().device.servo().heard();
            output = self.simulated().tick();
        }
        output
    }

    /// Brings the joint into a situation; it has moved before.
    fn bring(&mut self, situation: Situation) {
        self.client.arm().unwrap();
        self.client.step_to(3.0).unwrap();
        self.pass(400);
        let corner = |tick, counts| Corner { tick, position: Position::from_counts(counts) };
        match situation {
            Rest => {}
            Moving => {
                let corners = [corner(25, 1240), corner(1025, 1240 + 41_322)].into_iter().collect();
                self.client.move_along(Motion::Trajectory { corners, half_blend: 0.25 }).unwrap();
                let output = self.pass(100);
                assert!((output.tick.velocity - 5.0).abs() < 1.5, "{}", output.tick.velocity);
            }
            Saturated => {
                self.client.step_to(90.0).unwrap();
                let output = self.pass(4);
                assert_eq!(output.tick.code.abs(), 1024);
            }
        }
        let output = self.pass(1);
        assert_eq!((output.state, output.enable), (State::Armed, true), "{situation:?}");
    }

    /// Nothing is driven, whatever is asked, and it is armed again only as it should be.
    fn check_latched(&mut self, row: &str, fault: Fault, mend: fn(&mut SimulatedDevice)) {
        assert!(self.client.arm().is_err(), "{row}");
        assert!(self.client.step_to(1.0).is_err() && self.client.hold().is_err(), "{row}");
        for _ in 0..50 {
            let output = self.pass(1);
            assert_eq!((output.enable, output.duty()), (false, self.neutral), "{row}");
            assert_eq!(output.state, State::Faulted(fault), "{row}");
        }
        let told = self.client.status().unwrap().fault;
        assert_eq!(told.code, fault as u8, "{row}");
        assert!(told.tick > 0, "{row}");
        mend(self.simulated());
        if !fault.is_clearable() {
            assert!(self.client.clear().is_err(), "{row}");
            return;
        }
        self.client.clear().unwrap();
        // Cleared is not armed; and a joint that moves is not armed.
        assert_eq!(self.pass(1).state, State::Stopped, "{row}");
        let position = self.simulated().position_deg();
        self.simulated().push(position, 5.0);
        self.pass(2);
        assert!(self.client.arm().unwrap_err().to_string().contains("at rest"), "{row}");
        self.simulated().push(position, 0.0);
        self.pass(10);
        self.client.arm().unwrap();
        let output = self.pass(1);
        // The law has forgotten: on target, a fresh one has nothing to add.
        let tick = &output.tick;
        assert_eq!((output.enable, tick.error, tick.v_c, tick.code), (true, 0.0, 0.0, 0), "{row}");
    }
}

#[test]
fn every_fault_is_seen_in_time_and_turns_the_bridge_off_under_every_law() {
    let (mut cases, mut impossible) = (0, 0);
    for row in rows() {
        for (situation, within) in [Rest, Moving, Saturated].into_iter().zip(row.within) {
            let Ok([least, most]) = within else {
                impossible += 1;
                continue;
            };
            let mut slowest = 0;
            for law in laws() {
                let name = format!("{} ({}), {law}, {situation:?}", row.fault.describe(), row.what);
                let mut bench = Bench::new(law, row.set);
                bench.bring(situation);
                bench.simulated().device.servo().heard();
                let mut detected = None;
                for tick in 0..most {
                    (row.inject)(bench.simulated(), tick);
                    if row.fault != Fault::LinkTimeout {
                        bench.simulated().device.servo().heard();
                    }
                    let output = bench.simulated().tick();
                    if output.state != State::Armed {
                        // In the same tick.
                        assert_eq!((output.enable, output.duty()), (false, bench.neutral), "{name}");
                        assert_eq!(output.state, State::Faulted(row.fault), "{name}, tick {tick}");
                        detected = Some(tick + 1);
                        break;
                    }
                }
                slowest = slowest.max(detected.unwrap_or(0));
                let ticks = detected.unwrap_or_else(|| panic!("{name}: not seen within {most} ticks"));
                assert!(ticks >= least, "{name}: seen after {ticks} ticks already");
                bench.check_latched(&name, row.fault, row.mend);
                cases += 1;
            }
            let (fault, situation) = (row.fault.describe(), format!("{situation:?}").to_lowercase());
            reliability!("latency", fault, what = row.what, situation, slowest, most);
        }
    }
    for fault in FROM_THE_BOARD {
        for situation in [Rest, Moving, Saturated] {
            for law in laws() {
                let name = format!("{} from the board, {law}, {situation:?}", fault.describe());
                let mut bench = Bench::new(law, &[]);
                bench.bring(situation);
                Servo::fault(bench.simulated().device.servo(), fault);
                let output = bench.pass(1);
                assert_eq!((output.enable, output.duty()), (false, bench.neutral), "{name}");
                assert_eq!(output.state, State::Faulted(fault), "{name}");
                bench.check_latched(&name, fault, sound);
                cases += 1;
            }
        }
    }
    let faults = Fault::ALL.len() - ELSEWHERE.len();
    reliability!("matrix", cases, faults, laws = laws().count(), impossible);
}

#[test]
fn no_fault_is_forgotten_by_the_matrix() {
    for &fault in Fault::ALL {
        let in_a_row = rows().iter().any(|row| row.fault == fault) || FROM_THE_BOARD.contains(&fault);
        let elsewhere = ELSEWHERE.iter().any(|(other, _)| *other == fault);
        assert!(in_a_row != elsewhere, "{fault:?}");
    }
}

/// Swapped wires make the loop push away from the target: seen within the first hundredths of a degree.
#[test]
fn a_reversed_encoder_is_seen_in_the_first_move_under_every_law() {
    let mut furthest = 0.0f64;
    for law in laws() {
        let mut bench = Bench::new(law, &[]);
        bench.simulated().wires = Wires::Swapped;
        bench.client.arm().unwrap();
        bench.client.step_to(5.0).unwrap();
        let output = (0..60).map(|_| bench.pass(1)).find(|output| output.state != State::Armed).unwrap();
        assert_eq!(output.state, State::Faulted(Fault::EncoderReversed), "{law}");
        // Eight counts are 0.019 deg; a tick at the speed that it has by then is a little more.
        let travel = bench.simulated().position_deg();
        assert!(travel > 0.015 && travel < 0.2, "{law}: {travel} deg");
        furthest = furthest.max(travel);
        bench.check_latched(law, Fault::EncoderReversed, |_| {});
    }
    reliability!("reversed-at-first", travel_deg = format!("{furthest:.3}"));
}

/// Once the wiring has been proven, swapped wires are a loop that runs away.
#[test]
fn an_encoder_that_is_reversed_on_the_way_is_seen_before_it_has_gone_far() {
    for law in laws() {
        for situation in [Moving, Saturated] {
            let mut bench = Bench::new(law, &[]);
            bench.bring(situation);
            let from = bench.simulated().position_deg();
            bench.simulated().wires = Wires::Swapped;
            let output = (0..200).map(|_| bench.pass(1)).find(|output| output.state != State::Armed);
            let State::Faulted(fault) = output.unwrap().state else { panic!() };
            let runaway = [Fault::FollowingError, Fault::Overspeed, Fault::EncoderJump];
            assert!(runaway.contains(&fault), "{law} {situation:?}: {fault:?}");
            let travel = (bench.simulated().position_deg() - from).abs();
            let (fault, situation) = (fault.describe(), format!("{situation:?}").to_lowercase());
            reliability!("reversed", law, situation, fault, travel_deg = format!("{travel:.1}"));
            assert!(travel > 1.0 && travel < 60.0, "{law} {situation:?}: {travel}");
        }
    }
}

#[test]
fn hidden_wind_up_at_standstill_is_a_warning_and_no_fault() {
    // An integral that waits against friction just below the stall threshold: 0.4 V + 0.35 V. It grows by
    // 4 V/(deg s) of 0.05 deg: past the 0.4 V of the warning after 2 s, to the breakaway after 3.5 s.
    let mut bench = Bench::new("ri", &[]);
    bench.client.arm().unwrap();
    bench.simulated().brake_v = 0.35;
    bench.client.step_to(0.05).unwrap();
    let seen = (1..300).find(|_| {
        bench.pass(1);
        bench.client.status().unwrap().wound_up
    });
    // A second after the 2 s, and an error that is a count more or less: 5 %.
    let time_s = f64::from(seen.unwrap()) * 0.02;
    assert!((2.8..3.2).contains(&time_s), "{time_s}");
    assert_eq!(bench.client.status().unwrap().state, stiction::link::State::Armed);
}
