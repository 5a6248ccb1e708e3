//! An encoder that breaks at any moment of an identification: how far the joint goes, and how the
//! sequence ends.
//!
//! The servo has the limits that are derived for the thesis's robot, and the sequence a travel of
//! 20 deg. Travel is true travel from the start, coasting included.

use dynamics::joint::{OpenLineDecoder, OpenLines};
use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::identification::{IdentificationRequest, Outcome};
use stiction::servo::State;

use crate::fixture::plans;
use crate::noisy_encoder::COUNT;

/// Bound of the sequence, deg.
const TRAVEL: f64 = 20.0;

/// Ticks of 20 ms in 300 s, the longest time of a sequence, and in the time for coming to rest.
const LONGEST: u32 = 15_000 + 500;

/// One sequence.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// Furthest distance from the start, deg.
    travel: f64,
    /// How it ended, unless a fault ended it.
    outcome: Option<Outcome>,
    fault: Option<Fault>,
    /// Steps that were done when the encoder broke.
    steps: u8,
    /// Ticks until it ended.
    ticks: u32,
}

/// Runs a sequence whose encoder breaks in tick `begin`.
fn run(open: OpenLines, begin: u32, seed: u64) -> Run {
    let set = ["loop.controller=srnf", "reference.steps_deg=[5.0]"];
    let mut device = SimulatedDevice::new(&plans("step-response", &set)[0]).unwrap();
    device.ticks(50);
    let asked = IdentificationRequest { travel: Some(TRAVEL as f32), ..Default::default() };
    let plan = device.device.parameters().unwrap().identify(&asked).unwrap();
    device.device.servo().identify(&plan).unwrap();
    let start = device.position_deg();
    let mut lines = OpenLineDecoder::new(open, seed);
    let mut broken_at = 0.0;
    let (mut travel, mut steps, mut ticks) = (0.0f64, 0, 0);
    for tick in 0..LONGEST {
        let at = device.position_deg();
        travel = travel.max((at - start).abs());
        if tick == begin {
            device.wires = Wires::Cut;
            broken_at = at;
            steps = device.device.servo().identification_steps().unwrap();
        }
        if tick >= begin {
            device.jump(lines.move_to(((at - broken_at) / COUNT).round() as i64) as i32);
        }
        device.device.servo().heard();
        if device.tick().state == State::Armed {
            ticks = tick;
        } else if device.velocity_deg_per_s() == 0.0 {
            break;
        }
    }
    let servo = device.device.servo();
    let outcome = servo.identified().map(|found| found.outcome);
    let fault = match servo.state() {
        State::Faulted(fault) => Some(fault),
        _ => None,
    };
    Run { travel, outcome, fault, steps, ticks }
}

/// Steps before the return, which is the last one.
const LAST: u8 = 47;

/// Moments at which the encoder breaks, evenly spread over the sequence.
const MOMENTS: u32 = 101;

#[test]
fn an_encoder_that_breaks_in_an_identification_ends_it_within_its_bound() {
    let sound = run(OpenLines::Both(0), u32::MAX, 1);
    assert_eq!(sound.outcome, Some(Outcome::Done), "{sound:?}");
    let both = [0, 1, 4, 16].map(OpenLines::Both);
    for open in [&[OpenLines::One], &both[..]].concat() {
        let (mut travel, mut ended) = (0.0f64, 0);
        for moment in 0..MOMENTS {
            let begin = moment * sound.ticks / MOMENTS;
            let found = run(open, begin, u64::from(moment) + 1);
            let name = format!("{open:?} from tick {begin}: {found:?}");
            assert!(found.travel < TRAVEL + 45.0, "{name}");
            // All readings were taken before the last step.
            let is_done = found.outcome == Some(Outcome::Done);
            assert!(!is_done || found.steps == LAST, "{name}");
            assert!(found.outcome.is_some() != found.fault.is_some(), "{name}");
            travel = travel.max(found.travel);
            ended += u32::from(found.fault.is_none());
        }
        let (lines, travel_deg) = (format!("{open:?}"), format!("{travel:.1}"));
        reliability!("noisy-identification", lines, travel_deg, without_fault = ended);
    }
}
