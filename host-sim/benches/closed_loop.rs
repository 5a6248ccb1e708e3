//! Closed-loop runs per second of the two solvers, and what each gets wrong.
//!
//! The run is the thesis's 2.5 deg step, 2 s at 20 ms. Errors are the largest distance of the joint from that of the
//! exact solver at any sample, for PD (which comes to rest) and for SRNF (which chatters at rest, so that small
//! differences grow).
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use host_sim::closed_loop::ClosedLoop;
use host_sim::experiment::{Document, Experiment};
use host_sim::solver::{AxisSolver, ExactAxis, Rk4Axis};

/// 2 s of 20 ms.
const SAMPLES: u32 = 100;

/// Table 21.
const BAND: f64 = 1e-4;

const STEPS_S: [f64; 4] = [1e-4, 2e-5, 1e-5, 2e-6];

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

/// The error at the end, and nothing else: what a sweep over many joints asks for.
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
        for step_s in STEPS_S {
            let rk4 = positions(&closed_loop, Rk4Axis::at_rest(&closed_loop.axis, BAND, step_s));
            let error = exact.iter().zip(&rk4).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!("{controller}: RK4 with {step_s:e} s differs from exact by up to {error:.1e} deg");
        }
        let mut group = criterion.benchmark_group(format!("2.5 deg step, 2 s, {controller}"));
        group.throughput(Throughput::Elements(1));
        group.bench_function("exact", |bencher| {
            bencher.iter(|| {
                rest_error(black_box(&closed_loop), ExactAxis::at_rest(&closed_loop.axis, sample_time_s))
            });
        });
        group.sample_size(10);
        for step_s in STEPS_S {
            group.bench_function(format!("rk4, {step_s:e} s"), |bencher| {
                bencher.iter(|| {
                    rest_error(black_box(&closed_loop), Rk4Axis::at_rest(&closed_loop.axis, BAND, step_s))
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, closed_loop);
criterion_main!(benches);
