//! A supply that is off, or sags, under the loop and the servo of a run.

use experiments::current_sensor::current_sensor;
use simulator::experiment::{RunPlan, Task};
use simulator::run::{RunDriver, RunTrace, run_driven};
use simulator::supply::SupplyCourse;
use simulator::target::{BareLoop, Target as _};

/// The run of a step of 20 deg under `pd`, with keys of the file, and a supply.
fn plan(set: &[&str], supply: Option<f64>, sag: &[f64]) -> RunPlan {
    let mut plan = current_sensor(&["pd"], set).remove(0);
    plan.task = Task::Step(20.0);
    match SupplyCourse::of_options(supply, sag).unwrap() {
        Some(supply) => plan.with_supply(supply).unwrap(),
        None => plan,
    }
}

/// Positions at each sample, deg.
fn positions(plan: &RunPlan, driver: RunDriver) -> Vec<f64> {
    let RunTrace::Loop(samples) = run_driven(plan, driver).unwrap().trace else { unreachable!() };
    samples.iter().map(|sample| sample.position_deg).collect()
}

/// Second method: the loop of the run, with each effort times the ratio of its tick.
#[test]
fn an_effort_of_a_run_is_that_of_the_supply_of_its_tick() {
    let of = plan(&[], Some(0.9), &[0.5, 0.05, 0.1]);
    let found = positions(&of, RunDriver::ByLoop);
    let closed_loop = of.closed_loop().unwrap();
    let mut plant = closed_loop.plant(of.joint().unwrap());
    let (counter, counts) = (plant.counter(), plant.counts());
    let mut target = BareLoop::new(&closed_loop.controller, &closed_loop.course, counter, counts);
    for (tick, found) in found.iter().enumerate() {
        assert_eq!(plant.position_deg(), *found, "{tick}");
        let code = target.tick(plant.counters()).unwrap().code;
        let ratio = if (50..150).contains(&tick) { 0.9 * 0.5 } else { 0.9 };
        let volts = ratio * plant.volts(code);
        plant.hold(volts, 1e-3, &mut |_| {});
    }
    assert_ne!(found, positions(&plan(&[], None, &[]), RunDriver::ByLoop));
}

/// A servo that measures its supply divides the duty by it, a tick later.
#[test]
fn a_servo_that_measures_its_supply_compensates_a_sag_and_another_does_not() {
    let off = |set: &[&str]| {
        let by_servo = |sag: &[f64]| positions(&plan(set, None, sag), RunDriver::ByServo);
        let (nominal, sagging) = (by_servo(&[]), by_servo(&[0.7, 0.3, 0.3]));
        let apart = nominal.iter().zip(&sagging).map(|(one, other)| (one - other).abs());
        apart.fold(0.0, f64::max)
    };
    let measured = off(&["device.nominal_supply_v=48", "device.supply_full_scale_v=66"]);
    let unmeasured = off(&[]);
    assert!(measured < 0.2 * unmeasured, "{measured}, {unmeasured} deg");
}
