//! The fault matrix: every fault under every law, at rest, moving and saturated.
//!
//! Each row says what is done to the joint or its board, and within how many ticks the device has
//! to see it. A case asserts the fault's code, the bound, that the bridge is off in the tick of the
//! detection, that nothing is driven afterwards whatever is asked, and that arming again takes a
//! cleared fault and a joint at rest. What cannot happen is listed with its reason.

use stiction::Fault;
use stiction::servo::{Servo, State};

use device_under_test::{DeviceUnderTest, harder};
use experiments::controllers;
use rows::{ELSEWHERE, FROM_THE_BOARD, rows, sound};

mod device_under_test;
mod reversed_encoder;
mod rows;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Situation {
    /// The joint is on target after a step, under the effort that it rests with.
    Rest,
    /// The joint follows a line of 5 deg/s.
    Moving,
    /// The output is at its full scale, on the way to a far target.
    Saturated,
}

use Situation::{Moving, Rest, Saturated};

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
            for law in controllers() {
                let name = format!("{} ({}), {law}, {situation:?}", row.fault.describe(), row.what);
                let set = [row.set, harder(law, situation)].concat();
                let mut device = DeviceUnderTest::new(law, &set);
                device.bring(situation);
                device.simulated().device.servo().heard();
                let mut detected = None;
                for tick in 0..most {
                    (row.inject)(device.simulated(), tick);
                    if row.fault != Fault::LinkTimeout {
                        device.simulated().device.servo().heard();
                    }
                    let output = device.simulated().tick();
                    if output.state != State::Armed {
                        // The bridge is off in the same tick.
                        assert_eq!(
                            (output.enable, output.duty()),
                            (false, device.neutral),
                            "{name}"
                        );
                        assert_eq!(output.state, State::Faulted(row.fault), "{name}, tick {tick}");
                        detected = Some(tick + 1);
                        break;
                    }
                }
                slowest = slowest.max(detected.unwrap_or(0));
                let ticks =
                    detected.unwrap_or_else(|| panic!("{name}: not seen within {most} ticks"));
                assert!(ticks >= least, "{name}: seen after {ticks} ticks already");
                device.check_latched(&name, row.fault, row.mend);
                cases += 1;
            }
            let (fault, situation) =
                (row.fault.describe(), format!("{situation:?}").to_lowercase());
            reliability!("latency", fault, what = row.what, situation, slowest, most);
        }
    }
    for fault in FROM_THE_BOARD {
        for situation in [Rest, Moving, Saturated] {
            for law in controllers() {
                let name = format!("{} from the board, {law}, {situation:?}", fault.describe());
                let mut device = DeviceUnderTest::new(law, harder(law, situation));
                device.bring(situation);
                Servo::fault(device.simulated().device.servo(), fault);
                let output = device.pass(1);
                assert_eq!((output.enable, output.duty()), (false, device.neutral), "{name}");
                assert_eq!(output.state, State::Faulted(fault), "{name}");
                device.check_latched(&name, fault, sound);
                cases += 1;
            }
        }
    }
    let faults = Fault::ALL.len() - ELSEWHERE.len();
    reliability!("matrix", cases, faults, laws = controllers().count(), impossible);
}

#[test]
fn no_fault_is_forgotten_by_the_matrix() {
    for &fault in Fault::ALL {
        let in_a_row =
            rows().iter().any(|row| row.fault == fault) || FROM_THE_BOARD.contains(&fault);
        let elsewhere = ELSEWHERE.iter().any(|(other, _)| *other == fault);
        assert!(in_a_row != elsewhere, "{fault:?}");
    }
}

#[test]
fn hidden_wind_up_at_standstill_is_a_warning_and_no_fault() {
    // An integral waits against friction just below the stall threshold: 0.4 V + 0.35 V. It grows
    // by 4 V/(deg s) of 0.05 deg: past the 0.4 V of the warning after 2 s, to the breakaway after
    // 3.5 s.
    let mut device = DeviceUnderTest::new("ri", &[]);
    device.client.arm().unwrap();
    device.simulated().brake_v = 0.35;
    device.client.step_to(0.05).unwrap();
    let seen = (1..300).find(|_| {
        device.pass(1);
        device.client.status().unwrap().wound_up
    });
    // The warning comes a second after the 2 s. The error is a count more or less, which is 5 %.
    let time_s = f64::from(seen.unwrap()) * 0.02;
    assert!((2.8..3.2).contains(&time_s), "{time_s}");
    assert_eq!(device.client.status().unwrap().state, stiction::link::StateCode::Armed);
}
