//! Gears of random machines are identified within their error bars.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::machine::{LinearCongruence, RandomMachine};
use super::machines::request;
use crate::log_identification::gear::IdentifiedGear;
use crate::log_identification::identify;
use crate::log_identification::reading::MotionLog;
use crate::log_identification::units::PositionUnit;

/// Counts of the motor in a radian of the joint.
const COUNTS: f64 = 40_000.0;

/// Returns a random machine whose load is behind a gear with slack.
fn geared(random: &mut LinearCongruence) -> RandomMachine {
    let machine = RandomMachine::random(random);
    let behind = random.between(0.3, 0.7);
    let contact = random.between(60.0, 150.0);
    let friction = machine.coulomb[0];
    // Wind-up of the gear by the load's friction.
    let wound = friction / (behind * machine.inertia * contact.powi(2));
    RandomMachine {
        backlash: [behind, wound * random.between(0.3, 3.0)],
        contact,
        damping: 0.05,
        load_coulomb: 0.5 * friction,
        count: 0.01 * wound,
        noise: 0.2 * machine.noise,
        ..machine
    }
}

/// Returns the log of a machine, with the load's position, and the motor's position in its own
/// counts.
fn log(machine: &RandomMachine, seed: u64) -> MotionLog {
    let samples = machine.samples(&mut LinearCongruence(seed));
    let column = |place: usize| samples.iter().map(|sample| sample[place]).collect();
    MotionLog {
        time: column(0),
        position: column(3),
        effort: column(2),
        motor: samples.iter().map(|sample| (sample[1] * COUNTS).round()).collect(),
        rows: samples.len() as u64,
        folded: 1,
        time_digit: 1e-9,
        smallest_change: machine.count,
        smallest_motor_change: 1.0,
        ..MotionLog::default()
    }
}

fn found(machine: &RandomMachine, seed: u64) -> Result<IdentifiedGear, String> {
    let mut request = request();
    request.scale = request.scale.with_motor(PositionUnit::Count).unwrap();
    identify(log(machine, seed), &request)?.gear.unwrap()
}

#[test]
fn gears_come_back_and_the_error_bars_hold_the_truth() {
    let mut random = LinearCongruence(14);
    let machines: Vec<RandomMachine> = (0..20).map(|_| geared(&mut random)).collect();
    let seeded = machines.par_iter().enumerate();
    let all: Vec<IdentifiedGear> =
        seeded.map(|(seed, machine)| found(machine, seed as u64).unwrap()).collect();
    let (mut held, mut reported) = ([0; 2], 0);
    let mut errors = [const { Vec::new() }; 5];
    for (machine, gear) in machines.iter().zip(all) {
        let [behind, width] = machine.backlash;
        let load = behind * machine.inertia;
        for (place, (found, truth)) in [
            (gear.ratio, TAU * COUNTS),
            (gear.stiffness, load * machine.contact.powi(2)),
            (gear.slack, width),
            (gear.motor_inertia, machine.inertia - load),
            (gear.motor_coulomb, 0.5 * (machine.coulomb[0] + machine.coulomb[1])),
        ]
        .into_iter()
        .enumerate()
        {
            let error = (found.value - truth).abs();
            reported += 1;
            held[0] += usize::from(error <= 2.0 * found.sd);
            held[1] += usize::from(error <= 4.0 * found.sd);
            errors[place].push(error / truth);
        }
        assert!(gear.relative_residual_percent < 5.0, "{gear:?}");
    }
    errors.iter_mut().for_each(|errors| errors.sort_by(f64::total_cmp));
    let [median, most] =
        [10, 19].map(|place| errors.each_ref().map(|errors: &Vec<f64>| errors[place]));
    println!("{held:?} of {reported} held; median {median:.4?}, most {most:.4?}");
    // The error bars are somewhat narrow: two standard deviations hold four fifths of the values.
    assert!(held[0] * 10 >= reported * 7 && held[0] < reported, "{held:?} of {reported}");
    assert!(held[1] * 20 >= reported * 19, "{held:?} of {reported}");
    // Ratio, stiffness, slack, inertia and friction of the motor's side.
    for ((found, most), bar) in median.iter().zip(most).zip([
        [1e-4, 1e-3],
        [0.01, 0.1],
        [0.03, 0.4],
        [0.02, 0.1],
        [0.03, 0.2],
    ]) {
        assert!(*found < bar[0] && most < bar[1], "{found} and {most}, not {bar:?}");
    }
}

/// With slack, the gear presses neither way for a while; without it, it always presses.
#[test]
fn a_gear_without_slack_has_none() {
    let mut random = LinearCongruence(15);
    for seed in 0..4 {
        let machine = geared(&mut random);
        let [behind, _] = machine.backlash;
        let tight = RandomMachine { backlash: [behind, 0.0], ..machine };
        let gear = found(&tight, seed).unwrap();
        let stiffness = behind * machine.inertia * machine.contact.powi(2);
        assert!(gear.slack.value < 0.05 * gear.twist && gear.is_slack_sure(), "{gear:?}");
        assert!((gear.stiffness.value / stiffness - 1.0).abs() < 0.1, "{gear:?}, {stiffness}");
    }
}
