//! Random machines are identified within their error bars, and machines that break the model are
//! detected.

use rayon::prelude::*;

use super::machine::{LinearCongruence, RandomMachine};
use crate::log_identification::units::{LogUnits, PositionUnit};
use crate::log_identification::verdict::{self, FitQuality, Objections};
use crate::log_identification::{FitSettings, IdentifiedMachine, identify};

pub fn request() -> FitSettings {
    FitSettings {
        has_motor_current: false,
        scale: LogUnits::new(1.0, PositionUnit::Rad, 1.0, Some(1.0)),
        is_asymmetric: Some(true),
        has_stribeck: false,
        has_gravity: false,
        cut_off_hz: None,
        effort_delay_s: None,
    }
}

fn found(machine: &RandomMachine, seed: u64, request: &FitSettings) -> IdentifiedMachine {
    let log = machine.log(&mut LinearCongruence(seed));
    identify(log, request).unwrap_or_else(|why| panic!("{why}: {machine:?}"))
}

fn all_found(machines: &[RandomMachine]) -> Vec<IdentifiedMachine> {
    let seeded = machines.par_iter().enumerate();
    seeded.map(|(seed, machine)| found(machine, seed as u64, &request())).collect()
}

fn truth(machine: &RandomMachine, name: &str) -> f64 {
    let ([forward, backward], [b_forward, b_backward]) = (machine.coulomb, machine.viscous);
    match name {
        "inertia" => machine.inertia,
        "viscous_positive" => b_forward,
        "viscous_negative" => b_backward,
        "coulomb_positive" => forward,
        "coulomb_negative" => backward,
        "offset" => 0.5 * (forward - backward),
        other => panic!("{other}"),
    }
}

#[test]
fn random_machines_come_back_and_the_error_bars_hold_the_truth() {
    let mut random = LinearCongruence(14);
    let machines: Vec<RandomMachine> =
        (0..50).map(|_| RandomMachine::random(&mut random)).collect();
    let (mut held, mut reported) = (0, 0);
    let (mut false_flags, mut poor, mut proposed) = (0, 0, 0);
    let mut worst = [0.0f64; 3];
    for (machine, found) in machines.iter().zip(all_found(&machines)) {
        // Friction at the top speed, to which errors of friction are relative: a large relative
        // error of a small part matters little.
        let level = machine.coulomb[0] + machine.viscous[0] * machine.speed;
        for (name, parameter) in &found.parameters {
            let error = parameter.value - truth(machine, name);
            reported += 1;
            held += usize::from(error.abs() <= 2.0 * parameter.sd);
            let (place, part) = match *name {
                "inertia" => (0, error / machine.inertia),
                "viscous_positive" | "viscous_negative" => (1, error * machine.speed / level),
                _ => (2, error / level),
            };
            worst[place] = worst[place].max(part.abs());
        }
        false_flags += usize::from(!found.misfits.is_empty());
        poor += usize::from(found.verdict.quality == FitQuality::Poor);
        proposed += usize::from(!found.proposals.is_empty());
    }
    println!("{held} of {reported} held; worst {worst:?}; {false_flags} false flags, {poor} poor");
    // No term is missing in any of them.
    assert_eq!(proposed, 0);
    assert!(held * 10 >= reported * 9, "{held} of {reported} within two standard deviations");
    // Error bars that contain every value would be too wide.
    assert!(held < reported, "all {reported} within two standard deviations");
    // Inertia, friction by viscosity at the top speed, and the rest of friction.
    assert!(worst[0] < 0.02 && worst[1] < 0.05 && worst[2] < 0.03, "{worst:?}");
    assert!(false_flags <= 2 && poor == 0, "{false_flags} false flags, {poor} poor");
}

#[test]
fn machines_that_break_the_model_are_detected() {
    let mut random = LinearCongruence(41);
    let (mut uneven, mut backlash, mut heavy) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..15 {
        let machine = RandomMachine::random(&mut random);
        let machine = RandomMachine { noise: 0.2 * machine.noise, ..machine };
        let range = machine.speed;
        let periods = random.between(1.0, 40.0) / range;
        uneven.push(RandomMachine { ripple: [0.3, periods], ..machine });
        let behind = random.between(0.2, 0.6);
        backlash.push(RandomMachine {
            backlash: [behind, range * random.between(0.005, 0.03)],
            ..machine
        });
        let weight = machine.coulomb[0];
        // Over less than a radian, gravity hardly varies.
        heavy.push(RandomMachine {
            gravity: [weight, 0.0],
            speed: range.clamp(1.0, 2.0),
            ..machine
        });
    }
    let mut flexible = Vec::new();
    for _ in 0..15 {
        let machine = RandomMachine::random(&mut random);
        // As far above the loop's 25 rad/s as it can be seen.
        let contact = random.between(60.0, 90.0);
        flexible.push(RandomMachine { noise: 0.0, backlash: [0.5, 0.0], contact, ..machine });
    }
    let is_named = |found: &IdentifiedMachine, cause: &str| {
        found.misfits.iter().any(|misfit| misfit.cause == cause)
    };
    let is_proposed =
        |found: &IdentifiedMachine, term: &str| found.proposals.iter().any(|one| one.term == term);
    let uneven = all_found(&uneven);
    let named = uneven.iter().filter(|one| is_named(one, "position_dependent_friction")).count();
    assert!(named >= 14, "friction that varies with the position is named {named} times of 15");
    let heavy = all_found(&heavy);
    let named = heavy.iter().filter(|one| is_named(one, "position_dependent_load")).count();
    assert!(named >= 14, "gravity is named {named} times of 15");
    let named = heavy.iter().filter(|one| is_proposed(one, "gravity")).count();
    assert!(named >= 14, "gravity is proposed {named} times of 15");
    let flexible = all_found(&flexible);
    let named = flexible.iter().filter(|one| is_named(one, "flexibility")).count();
    assert!(named >= 12, "a spring between two bodies is named {named} times of 15");
    let good = flexible.iter().filter(|one| one.verdict.quality == FitQuality::Good).count();
    assert!(good <= 1, "{good} of 15 machines with a spring are called good");
    // The effect of a backlash depends on how it rattles: it is reported, but not always as such.
    let backlash = all_found(&backlash);
    let named = backlash.iter().filter(|one| !one.misfits.is_empty()).count();
    println!("of 15 machines with a backlash, a cause is named for {named}");
    let good = backlash.iter().filter(|one| one.verdict.quality == FitQuality::Good).count();
    assert!(good <= 1, "{good} of 15 machines with a backlash are called good");
}

#[test]
fn the_terms_for_gravity_and_stribeck_bring_back_what_they_stand_for() {
    let mut random = LinearCongruence(7);
    let machine = RandomMachine::random(&mut random);
    let machine = RandomMachine { speed: 2.0, count: 0.0, acceleration: 20.0, ..machine };
    let machine = RandomMachine { inertia: 0.2, noise: 0.01, sample_time_s: 5e-4, ..machine };
    let machine = RandomMachine { coulomb: [2.0, 2.0], viscous: [0.5, 0.5], ..machine };
    let heavy = RandomMachine { gravity: [3.0, -1.0], ..machine };
    let with = FitSettings { has_gravity: true, is_asymmetric: None, ..request() };
    let gravity = found(&heavy, 1, &with);
    assert_eq!(gravity.fitted.model.name(), "symmetric");
    for (name, value) in
        [("gravity_sine", 3.0), ("gravity_cosine", -1.0), ("inertia", 0.2), ("coulomb", 2.0)]
    {
        let found = gravity.fitted.get(name).map_or(f64::NAN, |found| found.value);
        assert!((found - value).abs() < 0.03 * value.abs(), "{name}: {found}, not {value}");
    }
    assert!(gravity.misfits.is_empty(), "{:?}", gravity.misfits);
    // Ramps from a half to 2.7 times the Stribeck velocity.
    let slow = RandomMachine { stribeck: [1.0, 0.3], speed: 0.8, acceleration: 8.0, ..machine };
    let with = FitSettings { has_stribeck: true, is_asymmetric: Some(false), ..request() };
    let stribeck = found(&slow, 1, &with);
    let velocity = stribeck.fitted.model.stribeck.unwrap_or(f64::NAN);
    assert!((velocity - 0.3).abs() < 0.03, "{velocity}");
    let term = stribeck.fitted.get("stribeck").map_or(f64::NAN, |found| found.value);
    assert!((term - 1.0).abs() < 0.1, "{term}");
    // Without the terms, each is proposed.
    let without = FitSettings { is_asymmetric: Some(false), ..request() };
    let uneven = RandomMachine { coulomb: [2.4, 1.6], viscous: [0.6, 0.4], ..machine };
    for (machine, term, option) in [
        (&heavy, "gravity", "--gravity"),
        (&slow, "stribeck", "--stribeck"),
        (&RandomMachine { viscous: [0.9, 0.1], ..uneven }, "asymmetric", "--model asymmetric"),
    ] {
        let found = found(machine, 1, &without);
        let first = found.proposals.first().map(|one| (one.term, one.option));
        assert_eq!(first, Some((term, option)), "{:?}", found.proposals);
        assert_eq!(found.verdict.quality.max(FitQuality::Fair), found.verdict.quality);
    }
}

/// The residual of a good fit is set to values beside the limits.
#[test]
fn a_residual_of_5_percent_is_good_and_one_above_15_is_poor() {
    let machine = RandomMachine::random(&mut LinearCongruence(14));
    let good = found(&machine, 0, &request());
    assert_eq!(good.verdict.quality, FitQuality::Good, "{:?}", good.verdict);
    for (percent, quality) in [
        (4.99, FitQuality::Good),
        (5.01, FitQuality::Fair),
        (14.99, FitQuality::Fair),
        (15.01, FitQuality::Poor),
    ] {
        let mut fitted = good.fitted.clone();
        fitted.fit.residual = fitted.fit.total * (0.01f64 * percent).powi(2);
        let against = Objections { implausible: &[], misfits: &[], proposals: &[] };
        let IdentifiedMachine { parameters, free_run, cut_off, read, .. } = &good;
        let judged = verdict::of(&fitted, parameters, free_run, against, cut_off, read);
        assert_eq!(judged.quality, quality, "{percent} %");
    }
}
