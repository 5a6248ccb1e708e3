//! Closed-loop runs per second of the two solvers, and the errors of RK4.
//!
//! The run is the thesis's 2.5 deg step, 2 s at 20 ms, under PD (which comes to rest) and under
//! SRNF (whose steep tanh amplifies small differences). An error is the largest distance from the
//! exact solver's joint at any sample; that one's own error is rounding (it is checked against
//! closed forms in `tests/plant/axis.rs`).
//!
//! RK4 runs with the thesis's velocity band at several steps, and with a band as narrow as each
//! step allows: with decelerations of up to 27 deg/s^2 in these runs a narrower one would be jumped
//! over. A coasting joint travels with the band's velocity, so the band, not the order of the
//! method, decides the error.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dynamics::solver::{AxisSolver, ExactAxis, Rk4Axis};
use simulator::closed_loop::ClosedLoop;
use simulator::experiment::{Document, Experiment};

/// 2 s of 20 ms.
const SAMPLES: u32 = 100;

/// Step (s) and static velocity range (deg/s) of RK4; the thesis's range is 1e-4 (Table 21).
const RK4: [(f64, f64); 6] =
    [(1e-4, 1e-4), (1e-5, 1e-4), (2e-6, 1e-4), (1e-4, 2.7e-3), (1e-5, 2.7e-4), (1e-6, 2.7e-5)];

fn step_response(controller: &str) -> ClosedLoop {
    let mut document = Document::open("step-response").unwrap();
    document.set(&["reference.steps_deg=[2.5]".into()]).unwrap();
    Experiment::plan(&document, &[controller.into()], &[]).unwrap().runs[0].closed_loop().unwrap()
}

/// The joint's position at every sample.
fn positions<S: AxisSolver>(closed_loop: &ClosedLoop, mut solver: S) -> Vec<f64> {
    let mut positions = Vec::new();
    closed_loop.run(&mut solver, SAMPLES, |moment| positions.push(moment.position_deg), |_| ());
    positions
}

/// Returns only the error at the end, as in a sweep over many joints.
fn rest_error<S: AxisSolver>(closed_loop: &ClosedLoop, mut solver: S) -> f64 {
    let mut error = 0.0;
    closed_loop.run(&mut solver, SAMPLES, |moment| error = moment.error_deg(), |_| ());
    error
}

fn closed_loop(criterion: &mut Criterion) {
    for controller in ["pd", "srnf"] {
        let closed_loop = step_response(controller);
        let sample_time_s = closed_loop.sample_time_s;
        let exact = positions(&closed_loop, ExactAxis::at_rest(&closed_loop.axis, sample_time_s));
        for (step_s, band) in RK4 {
            let rk4 = positions(&closed_loop, Rk4Axis::at_rest(&closed_loop.axis, band, step_s));
            let error = exact.iter().zip(&rk4).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!(
                "{controller}, RK4 of {step_s:e} s, band {band:e} deg/s: wrong by up to \
                 {error:.1e} deg"
            );
        }
        let mut group = criterion.benchmark_group(format!("2.5 deg step, 2 s, {controller}"));
        group.throughput(Throughput::Elements(1));
        group.bench_function("exact", |bencher| {
            bencher.iter(|| {
                rest_error(
                    black_box(&closed_loop),
                    ExactAxis::at_rest(&closed_loop.axis, sample_time_s),
                )
            });
        });
        group.sample_size(10);
        for (step_s, band) in RK4 {
            group.bench_function(format!("rk4 {step_s:e} s, {band:e} deg/s"), |bencher| {
                bencher.iter(|| {
                    rest_error(
                        black_box(&closed_loop),
                        Rk4Axis::at_rest(&closed_loop.axis, band, step_s),
                    )
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, closed_loop);
criterion_main!(benches);
