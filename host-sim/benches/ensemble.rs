//! Nanoseconds of a tick of an ensemble, by family and law: servo, joint and measures.
//!
//! Each figure is of the first eight joints of a family: half of them with a delay, half with a
//! lag, half with the coarse encoder. The range is printed with it: laws that chatter keep the
//! joint in motion, and a joint at rest costs next to nothing.
#![allow(missing_docs, clippy::unwrap_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use simulator::rules::rules;
use studies::ensemble::{Case, DrawOptions, Family, Motions, run_and_show};

const JOINTS: u64 = 8;

fn ensemble(criterion: &mut Criterion) {
    let kind = DrawOptions::ORDINARY;
    for family in Family::USUAL {
        let joints: Vec<Case> =
            (0..JOINTS).map(|number| Case::draw(1, family, number, kind)).collect();
        let mut group = criterion.benchmark_group(family.name());
        group.sample_size(10);
        for rule in rules(&[]).unwrap() {
            let run = || {
                let mut ticks = 0;
                for joint in &joints {
                    let gains = joint.gains(rule);
                    run_and_show(joint, rule.law, &gains, Motions::default(), |_, _, _| ticks += 1)
                        .unwrap();
                }
                ticks
            };
            group.throughput(Throughput::Elements(run()));
            group.bench_function(rule.law, |bencher| bencher.iter(|| black_box(run())));
        }
        group.finish();
    }
}

criterion_group!(benches, ensemble);
criterion_main!(benches);
