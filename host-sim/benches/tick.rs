//! Time of the core's tick for each law, on the host, over the counts that its own 5 deg/s
//! trajectory produced.
//!
//! These are nanoseconds of this machine; tests/evidence/cost.md has the cost on the
//! microcontroller.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dynamics::solver::ExactAxis;
use simulator::experiment::{Document, Experiment};
use stiction::control::encoder::EncoderState;
use stiction::{CourseState, Reading};

fn tick(criterion: &mut Criterion) {
    let document = Document::open("trajectory").unwrap();
    let experiment = Experiment::plan(&document, &[], &[]).unwrap();
    let mut group = criterion.benchmark_group("tick");
    for plan in experiment.runs.iter().filter(|plan| plan.label.ends_with("trajectory-5.0")) {
        let closed_loop = plan.closed_loop().unwrap();
        let mut solver = ExactAxis::at_rest(&closed_loop.axis, closed_loop.sample_time_s);
        let mut counters = Vec::new();
        closed_loop.run(
            &mut solver,
            plan.samples().unwrap(),
            |moment| counters.push(moment.tick.counts as u32),
            |_| (),
        );
        group.throughput(Throughput::Elements(counters.len() as u64));
        group.bench_function(plan.controller.as_deref().unwrap(), |bencher| {
            bencher.iter(|| {
                let controller = &closed_loop.controller;
                let mut course = closed_loop.course.clone();
                let (mut encoder, mut state) =
                    (EncoderState::default(), CourseState::start(controller, 0));
                for counter in &counters {
                    controller.encoder().update(&mut encoder, *counter);
                    let reading = Reading::position(encoder.counts());
                    black_box(course.tick(controller, &mut state, reading));
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, tick);
criterion_main!(benches);
