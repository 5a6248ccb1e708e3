//! An encoder that is not well drops, doubles or adds edges, or has its wires swapped, cut or
//! reversed. What can be seen stops the joint with its code, within a stated time and travel. A
//! slow loss of counts cannot be seen: without an index a lost count cannot be distinguished from a
//! joint that has moved less. The tests measure how far that leads instead.

use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;
use stiction::servo::State;

use crate::fixture::plans;

fn along(trajectory: &str) -> SimulatedDevice {
    let set = ["loop.controller=srnf", "reference.steps_deg=[]", trajectory];
    let plan = &plans("trajectory", &set)[0];
    let mut simulated = SimulatedDevice::new(plan).unwrap();
    simulated.ticks(10);
    simulated.device.servo().arm().unwrap();
    simulated
}

/// The random generator xorshift64 (Marsaglia 2003).
fn random(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// Runs the 26 s of the thesis's trajectory out to 50 deg and back. Each edge of one way is spoiled
/// with a probability. Returns the true position at the end (it should be zero), the edges that
/// were lost or gained, and the state.
fn spoiled(rate: f64, sign: i32, both_ways: bool) -> (f64, i64, State) {
    let mut simulated = along("run.duration_s=26");
    let (mut seed, mut spoiled) = (0x5713_C710_u64 | 1, 0);
    let mut before = simulated.position_deg();
    let mut state = State::Armed;
    for _ in 0..1300 {
        let position = simulated.position_deg();
        let edges = ((position - before) / 0.00242).round();
        before = position;
        // A dropped edge counts less the way the joint goes, a doubled one counts more.
        let hit = (0..edges.abs() as u32).filter(|_| random(&mut seed) < rate).count() as i32;
        if both_ways || edges > 0.0 {
            simulated.jump(-sign * hit * edges.signum() as i32);
            spoiled += i64::from(hit);
        }
        state = simulated.tick().state;
        if state != State::Armed {
            break;
        }
    }
    (simulated.position_deg(), spoiled, state)
}

/// The joint is off by the lost counts, undetected. A loss on the way out and one on the
/// way back cancel.
#[test]
fn slow_loss_of_counts_is_not_seen_and_shifts_the_joint_by_what_was_lost() {
    for rate in [1e-4, 1e-3, 1e-2] {
        let (position, lost, state) = spoiled(rate, 1, false);
        reliability!(
            "lost-edges",
            one_in = (1.0 / rate).round(),
            lost,
            error_deg = format!("{position:.3}")
        );
        assert_eq!(state, State::Armed);
        // Out 50 deg are 20 661 edges. Where counts were lost on the way out, the joint went too
        // far by them and came back to a place as far beyond zero; SRNF itself rests within ten
        // counts.
        assert!(
            (position - lost as f64 * 0.00242).abs() < 10.0 * 0.00242,
            "{rate}: {position} deg, {lost} lost"
        );
        let expected = 20_661.0 * rate;
        assert!(
            (lost as f64 - expected).abs() < 5.0 * expected.sqrt() + 1.0,
            "{lost} of {expected}"
        );
    }
    let (position, lost, state) = spoiled(1e-2, 1, true);
    reliability!("lost-both-ways", one_in = 100, lost, error_deg = format!("{position:.3}"));
    assert!(state == State::Armed && position.abs() < 60.0 * 0.00242, "{position}");
}

/// Every edge doubled or dropped is a wrong resolution: the set point is reached, as the encoder
/// has it.
#[test]
fn doubled_edges_scale_the_motion_and_are_not_seen() {
    let (_, doubled, state) = spoiled(0.5, -1, true);
    assert!(doubled > 10_000, "{doubled}");
    reliability!("doubled", edges = doubled);
    assert_eq!(state, State::Armed);
}

/// Noise counts up. As long as it is slow, the loop works against a motion that is none; a burst is
/// a jump.
#[test]
fn a_burst_of_noise_is_a_jump_in_its_tick() {
    let (unseen, seen) = (750, 1400);
    let mut simulated = along("run.duration_s=26");
    simulated.ticks(100);
    // The limit of SRNF is 2 * 50 deg/s * 20 ms + 4 counts = 830 counts, and the joint moves 41
    // counts a tick.
    simulated.jump(unseen);
    assert_eq!(simulated.tick().state, State::Armed);
    simulated.jump(seen);
    assert_eq!(simulated.tick().state, State::Faulted(Fault::EncoderJump));
    let plan = &plans("trajectory", &["loop.controller=srnf"])[0];
    let parameters = crate::fixture::parameters(plan);
    let limit = parameters.limits.encoder_jump / parameters.controller.encoder.resolution;
    reliability!("burst", unseen, seen, limit = format!("{limit:.0}"));
}

/// The joint is on its way at 5 deg/s. The test bounds the time and the true travel until the
/// bridge is off, and names the code.
#[test]
fn wires_that_are_cut_or_swapped_on_the_way_stop_the_joint_in_a_bounded_time_and_travel() {
    for (wires, faults, time_s, travel_deg) in [
        // Seen in the first tick without counts; the joint has a tick to coast in, from 5 deg/s, by
        // 13 deg/s^2 slower at the end.
        (Wires::Cut, &[Fault::Stall][..], [0.01, 0.03], [0.08, 0.12]),
        (Wires::OneCut, &[Fault::Stall], [0.01, 0.03], [0.08, 0.12]),
        // What is read goes back, so the error grows by 5 deg/s and the true speed, to 5 deg. That
        // speed grows by at least 65 deg/s^2 (the damping alone asks for 2.5 V) once the regression
        // has turned, which takes 0.1 s, and by at most 135 deg/s^2 (5 V). So it takes 0.2 to 0.37
        // s, in which the set point makes 1 to 1.9 deg of the 5. Until the bridge is off, it goes
        // on for two ticks, by less than 45 deg/s.
        (Wires::Swapped, &[Fault::FollowingError], [0.19, 0.38], [3.1, 5.8]),
    ] {
        let mut simulated = along("run.duration_s=26");
        simulated.ticks(200);
        let from = simulated.position_deg();
        simulated.wires = wires;
        let (ticks, state) = (1..200)
            .map(|k| (k, simulated.tick().state))
            .find(|(_, s)| *s != State::Armed)
            .unwrap();
        let (time, travel) = (f64::from(ticks) * 0.02, (simulated.position_deg() - from).abs());
        let State::Faulted(fault) = state else { panic!("{state:?}") };
        let what = match wires {
            Wires::Sound => "sound",
            Wires::Cut => "both cut",
            Wires::OneCut => "one cut",
            Wires::Swapped => "swapped",
        };
        let fault_is = fault.describe();
        reliability!(
            "wires",
            what,
            fault = fault_is,
            time_s = format!("{time:.2}"),
            travel_deg = format!("{travel:.1}")
        );
        assert!(faults.contains(&fault), "{wires:?}: {fault:?}");
        assert!((time_s[0]..time_s[1]).contains(&time), "{wires:?}: {time} s");
        assert!((travel_deg[0]..travel_deg[1]).contains(&travel), "{wires:?}: {travel} deg");
    }
}
