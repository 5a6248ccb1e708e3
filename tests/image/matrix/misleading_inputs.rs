//! Inputs that mislead the servo: noise on open lines, a file with too much friction, false counts,
//! play before an encoder on the load, a lost supply, a bumper.
//!
//! Bounds and reasons are those of the device's tests, which have every step, seed and speed:
//! noisy_encoder.rs, wrong_friction.rs, false_counts.rs, play.rs, no_supply.rs and bumper.rs in
//! tests/device. Here each law has one case. Travel is true travel beyond start and target,
//! coasting included.

use dynamics::joint::{OpenLineDecoder, OpenLines, Substitute};
use experiments::axis_with_play::axis_with_play;
use experiments::controllers;
use experiments::matrix::{Bench as _, Situation, pass, start_over};
use stiction::Fault;
use stiction::identification::{IdentificationRequest, Outcome};

use super::bench::{ImageBench, print_row};

/// Ticks of 20 ms in a second.
const SECOND: u32 = 50;

/// What an encoder shows in place of the disc's change in a tick, counts.
type Shown<'a> = &'a mut dyn FnMut(i64) -> i64;

/// True travel of a run, and the ticks until the bridge went off.
#[derive(Debug)]
struct Travel {
    beyond_deg: f64,
    tripped: Option<u32>,
}

/// Powers a board up and arms a law, and lets its soft start pass.
fn armed(law: &str, set: &[&str], joint: Option<Substitute>) -> ImageBench {
    let mut bench = ImageBench::around(joint);
    start_over(&mut bench, law, set);
    bench.client().arm().unwrap();
    pass(&mut bench, 30);
    bench
}

/// The disc's position, counts.
fn disc(bench: &mut ImageBench) -> i64 {
    bench.act(|halted| halted.plant().discs().first)
}

/// Steps, and runs until the bridge is off and the joint rests, or for a number of ticks.
fn step(bench: &mut ImageBench, to_deg: f64, ticks: u32, shown: Shown<'_>) -> Travel {
    let from_deg = bench.position_deg();
    if to_deg != 0.0 {
        bench.client().step_to(to_deg).unwrap();
    }
    let mut travel = Travel { beyond_deg: 0.0, tripped: None };
    let mut before = disc(bench);
    for tick in 1..=ticks {
        if travel.tripped.is_none() {
            bench.heard(tick);
        }
        let is_on = bench.ticks(1).is_on;
        // The board is halted where the plant has moved, and its edges are not shown yet.
        let now = disc(bench);
        let moved = now - std::mem::replace(&mut before, now);
        bench.jump((shown(moved) - moved) as i32);
        let at_deg = bench.position_deg() - from_deg;
        let (low, high) = (to_deg.min(0.0), to_deg.max(0.0));
        travel.beyond_deg = travel.beyond_deg.max((at_deg - high).max(low - at_deg));
        if !is_on {
            travel.tripped.get_or_insert(tick);
            if speed(bench) == 0.0 {
                break;
            }
        }
    }
    travel
}

fn speed(bench: &mut ImageBench) -> f64 {
    bench.act(|halted| halted.plant().velocity_deg_per_s())
}

/// The latched fault.
fn fault(bench: &mut ImageBench) -> Option<Fault> {
    let code = bench.client().status().unwrap().fault.code;
    Fault::ALL.iter().copied().find(|fault| *fault as u8 == code)
}

/// Judges a cause under every law: one of the faults comes, the first of them is the usual one, and
/// the travel stays below its bound.
fn assert_bounded(
    what: &str,
    set: &[&str],
    faults: &[Fault],
    bound_deg: f64,
    mut run: impl FnMut(&mut ImageBench) -> Travel,
) {
    let mut slowest = 0;
    for law in controllers() {
        let mut bench = armed(law, set, None);
        let travel = run(&mut bench);
        let name = format!("{what}, {law}: {travel:?}");
        assert!(travel.beyond_deg < bound_deg, "{name}");
        let found = fault(&mut bench);
        assert!(found.is_some_and(|fault| faults.contains(&fault)), "{name}: {found:?}");
        slowest = slowest.max(travel.tripped.unwrap());
    }
    let cases = controllers().count();
    print_row(faults[0], what, Situation::Rest, cases, &format!("{slowest} ticks"));
}

#[test]
fn noise_on_open_lines_leads_no_further_than_45_deg_under_any_law() {
    for open in [OpenLines::One, OpenLines::Both(4)] {
        let what = format!("open lines with noise ({open:?}), then a step of 5 deg");
        assert_bounded(&what, &[], &[Fault::Stall, Fault::EncoderReversed], 45.0, |bench| {
            let mut lines = OpenLineDecoder::new(open, 1);
            let mut disc = 0;
            step(bench, 5.0, 20 * SECOND, &mut |moved| {
                disc += moved;
                lines.move_to(disc)
            })
        });
    }
}

#[test]
fn a_silent_encoder_is_found_by_the_probe_where_the_file_has_too_much_friction() {
    let set = ["limits.breakaway_v=1.25", "limits.breakaway_min_v=0.4"];
    let what = "a dead encoder and three times the friction in the file, then a step of 1 deg";
    assert_bounded(what, &set, &[Fault::Stall], 45.0, |bench| {
        step(bench, 1.0, 20 * SECOND, &mut |_| 0)
    });
}

#[test]
fn false_counts_that_take_more_than_the_breakaway_are_a_stall() {
    let what = "32 false counts a tick while the joint is held";
    assert_bounded(what, &[], &[Fault::Stall, Fault::EncoderReversed], 60.0, |bench| {
        step(bench, 0.0, 60 * SECOND, &mut |moved| moved + 32)
    });
}

#[test]
fn play_that_the_file_states_is_no_stall_and_unstated_it_is() {
    let mut unstated = 0;
    for law in controllers() {
        for stated in ["limits.play_deg=1.0", "limits.play_deg=0"] {
            let mut bench = armed(law, &[stated], Some(axis_with_play(1.0)));
            let travel = step(&mut bench, 0.5, 20 * SECOND, &mut |moved| moved);
            let fault = fault(&mut bench);
            let is_stall = fault == Some(Fault::Stall);
            assert!(!is_stall || stated == "limits.play_deg=0", "{law}, {stated}: {travel:?}");
            unstated += u32::from(is_stall);
        }
    }
    assert!(unstated > 2, "{unstated}");
}

#[test]
fn a_supply_that_is_lost_in_motion_is_a_fault_within_a_second_of_effort_at_rest() {
    let what = "no supply of the motor, not measured, from 1 s of a move of 20 deg on";
    let mut slowest = 0;
    for law in controllers() {
        let mut bench = armed(law, &[], None);
        bench.client().move_to(20.0).unwrap();
        pass(&mut bench, SECOND);
        assert!(speed(&mut bench) > 1.0, "{law}");
        bench.act(|halted| halted.plant().is_unpowered = true);
        let mut pushed = 0;
        for tick in 0..10 * SECOND {
            bench.heard(tick);
            if !bench.ticks(1).is_on {
                break;
            }
            let effort_v = bench.last_tick().v_applied.abs();
            pushed += u32::from(speed(&mut bench) == 0.0 && effort_v > 1.25 * 0.4);
        }
        let found = fault(&mut bench);
        let name = format!("{what}, {law}: {pushed} ticks, {found:?}");
        // While the joint coasts, the set point goes on: its lead can be a following error first.
        assert!(matches!(found, Some(Fault::Stall | Fault::FollowingError)), "{name}");
        assert!(pushed <= SECOND, "{name}");
        slowest = slowest.max(pushed);
    }
    let cases = controllers().count();
    print_row(Fault::Stall, what, Situation::Moving, cases, &format!("{slowest} ticks"));
}

/// Runs a sequence of a travel (deg) until its bridge is off and the joint rests. Returns the
/// furthest distance from the start, deg.
fn identify(
    bench: &mut ImageBench,
    travel_deg: f64,
    meanwhile: &mut dyn FnMut(&mut ImageBench, u32),
) -> f64 {
    start_over(bench, "srnf", &[]);
    let request = IdentificationRequest {
        travel: Some(travel_deg as f32),
        speed: Some(10.0),
        ..Default::default()
    };
    bench.client().identify_joint(request).unwrap();
    let (mut furthest, mut has_begun) = (0.0f64, false);
    for tick in 0..120 * SECOND {
        meanwhile(bench, tick);
        bench.heard(tick);
        let is_on = bench.ticks(1).is_on;
        furthest = furthest.max(bench.position_deg().abs());
        if has_begun && !is_on && speed(bench) == 0.0 {
            return furthest;
        }
        has_begun |= is_on;
    }
    panic!("the sequence does not end");
}

/// Both lines break and pick up noise, 5 s after the begin and later.
#[test]
fn an_encoder_that_breaks_in_an_identification_keeps_its_travel_and_none_ends_as_whole() {
    for begin in [5 * SECOND, 20 * SECOND] {
        let mut bench = ImageBench::boot();
        let mut lines = OpenLineDecoder::new(OpenLines::Both(4), 1);
        let (mut before, mut travel) = (0, 0);
        let furthest = identify(&mut bench, 20.0, &mut |bench, tick| {
            let now = disc(bench);
            let moved = now - std::mem::replace(&mut before, now);
            if tick >= begin {
                travel += moved;
                bench.jump((lines.move_to(travel) - moved) as i32);
            }
        });
        let found = bench.client().identified().unwrap();
        let is_whole = found.is_some_and(|(summary, _)| summary.outcome == Outcome::Done);
        assert!(!is_whole && furthest < 20.0 + 45.0, "{begin}: {furthest} deg");
    }
}

#[test]
fn a_sequence_that_runs_into_a_bumper_keeps_its_travel_and_ends_as_a_stall() {
    let (begins_deg, v_per_deg, travel_deg) = (0.02, 10.0, 20.0);
    let mut bench = ImageBench::boot();
    let furthest = identify(&mut bench, travel_deg, &mut |bench, _| {
        let at_deg = bench.position_deg();
        let load_v = -v_per_deg * (at_deg - begins_deg).max(0.0);
        bench.act(move |halted| halted.plant().load_v = load_v);
    });
    // Energy, as in tests/device/bumper.rs: 1.6 V at most, and 10 deg/s at the arrival.
    let pressed = 1.6025 / v_per_deg;
    let held = begins_deg + pressed + (pressed * pressed + 100.0 / (27.0 * v_per_deg)).sqrt();
    assert!(furthest <= held.min(travel_deg), "{furthest} deg");
    assert_eq!(fault(&mut bench), Some(Fault::Stall));
}
