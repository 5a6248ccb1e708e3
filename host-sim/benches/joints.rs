//! Time of a sample of 1 ms of each joint of the ensemble, on the host: in motion under an effort
//! that starts, reverses and stops it, and at rest under one that does not change.
//!
//! docs/explanation/simulator.md has the errors of the same joints. Divide by the samples of a run
//! to compare: the numbers are for 1000 samples.
#![allow(missing_docs, clippy::unwrap_used)]

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dynamics::joint::{
    AnyJoint, ArmDescription, Body, Bristle, Description, Dwell, Gravity, Joint, LoadTorque,
    Ripple, SetValuedFriction, ShaftDescription, StribeckCurve, Train,
};

const COUNT: f64 = TAU / 1e5;
const SAMPLES: u32 = 1000;

fn effort(sample: u32) -> f64 {
    let t = f64::from(sample) * 1e-3;
    9.0 * (17.0 * t).sin() + 5.0 * (61.0 * t).sin() + 3.0 * (7.0 * t).cos()
}

fn joints() -> Vec<(&'static str, Description)> {
    let part = |share: f64| StribeckCurve {
        coulomb: 4.0 * share,
        stick: 6.0 * share,
        stribeck_velocity: 0.03,
        viscous: 1.3 * share,
    };
    let body = |share: f64| Body { inertia: 0.34 * share, friction: part(share).into() };
    let of = |train| Description::of(train, COUNT);
    let rigid = of(Train::Rigid(body(1.0)));
    let varying = |ripple, dwell| {
        let friction = SetValuedFriction { ripple, dwell, ..part(1.0).into() };
        of(Train::Rigid(Body { inertia: 0.34, friction }))
    };
    let bristle = Bristle::breaking_at(6.0 * COUNT, 6.0, 0.34);
    let gravity = Some(Gravity { amplitude: 1.0, angle: 0.4 });
    let flexible = |backlash| {
        let shaft = ShaftDescription { stiffness: 900.0, damping: 0.4, backlash };
        of(Train::Flexible { motor: body(0.4), load: body(0.6), shaft })
    };
    let ripple = Some(Ripple { depth: 0.3, cycles: 100.0, phase: 0.7 });
    let dwell = Some(Dwell { growth: 0.3, time_s: 1.0 });
    vec![
        ("rigid", rigid),
        ("rigid, lag", Description { lag_s: 0.7e-3, ..rigid }),
        ("gravity", Description { load: LoadTorque { constant: 0.0, gravity }, ..rigid }),
        ("angle", varying(ripple, None)),
        ("dwell", varying(None, dwell)),
        ("lugre", of(Train::LuGre { inertia: 0.34, curve: part(1.0), bristle })),
        ("flexible", flexible(0.0)),
        ("flexible, backlash, lag", Description { lag_s: 0.7e-3, ..flexible(20.0 * COUNT) }),
    ]
}

fn run(mut joint: AnyJoint, effort: impl Fn(u32) -> f64) -> f64 {
    (0..SAMPLES).for_each(|sample| joint.hold(black_box(effort(sample)), 1e-3));
    joint.load().position
}

fn bench(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("joint");
    group.throughput(Throughput::Elements(u64::from(SAMPLES)));
    for (name, description) in joints() {
        let joint = description.build().unwrap();
        group.bench_function(format!("{name}, moving"), |bencher| {
            bencher.iter(|| run(black_box(joint.clone()), effort));
        });
        group.bench_function(format!("{name}, resting"), |bencher| {
            bencher.iter(|| run(black_box(joint.clone()), |_| 1.0));
        });
    }
    let curve = |coulomb, viscous| StribeckCurve {
        coulomb,
        stick: 1.5 * coulomb,
        stribeck_velocity: 0.05,
        viscous,
    };
    let arm = ArmDescription {
        mass: [0.09; 2],
        length: [1.0; 2],
        rotor: [0.959, 0.337],
        friction: [curve(5.61, 2.0), curve(4.1, 1.3)],
        start: [0.4, -0.7],
        count: COUNT,
    };
    let arm = arm.build().unwrap();
    group.bench_function("arm, moving", |bencher| {
        bencher.iter(|| {
            let mut arm = black_box(arm.clone());
            for sample in 0..SAMPLES {
                arm.hold([1.6 * effort(sample), 1.1 * effort(sample + 210)], 1e-3);
            }
            arm.turn(1).position
        });
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
