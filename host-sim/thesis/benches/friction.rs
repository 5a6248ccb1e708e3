//! The exact solver of the friction lab against `diffsol`'s `tsit45` with root finding, on the
//! thesis's one-dof spring-mass, one-dof and two-dof manipulators (Tables 1-2, 7-8, 10-11).
//!
//! Both follow the same modes, decided by the same function at events; what differs is integration
//! and root finding. `diffsol` keeps its problem from run to run and gets a new solver for each;
//! its absolute tolerance is the relative one times the largest value of each component, which is
//! what the exact solver's tolerance means. An error is the largest of those of the event times,
//! against closed forms or an independent simulation, over 5 s.
//!
//! `cargo bench --ignore-rust-version --package thesis --features diffsol,report --bench friction`
//! prints the error of both at tolerances from 1e-4 to 1e-12 beside the time of a run, and draws
//! them (work-precision) into `target/friction-bench`.
#![allow(missing_docs, clippy::unwrap_used)]

use std::cell::Cell;
use std::fs;
use std::hint::black_box;
use std::rc::Rc;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use diffsol::{NalgebraMat, OdeBuilder, OdeSolverMethod, OdeSolverStopReason};
use dynamics::friction::Coulomb;
use dynamics::mechanism::{Mechanism, TwoLinkArm};
use dynamics::solver::modes::{BodyMode, accelerations, decide};
use figure::{Figure, Panel, PlotCurve, Style};
use friction_lab::mechanism::{Pendulum, Pull, SpringMass};
use friction_lab::solver::event_driven;
use friction_lab::solver::state::BodyEvent;

const DURATION_S: f64 = 5.0;

/// A mechanism, its frictions, the times of its events, and the largest positions and velocities.
struct Case<const N: usize, M> {
    name: &'static str,
    mechanism: M,
    friction: [Coulomb; N],
    times_s: Vec<f64>,
    size: [[f64; N]; 2],
}

fn spring_mass() -> Case<1, SpringMass> {
    let times = (0..7).flat_map(|i| {
        let break_s = 1.25 + f64::from(i) * 0.607303620967653;
        [break_s, break_s + 0.107303620967653]
    });
    Case {
        name: "spring-mass",
        mechanism: SpringMass { mass: 0.1, stiffness: 100.0, pull: Pull::steady(0.002) },
        friction: [Coulomb { stick: 0.25, slip: 0.20 }],
        times_s: times.take(13).collect(),
        size: [[8.5e-3], [1.8e-2]],
    }
}

fn pendulum() -> Case<1, Pendulum> {
    Case {
        name: "manipulator-1dof",
        mechanism: Pendulum { mass: 1.0, length: 1.0, torque: 6.0, start: 0.0 },
        friction: [Coulomb { stick: 1.2, slip: 0.96 }],
        times_s: vec![0.0, 1.120988049917, 2.340084599805, 3.423533715457],
        size: [[1.15], [1.63]],
    }
}

fn arm() -> Case<2, TwoLinkArm> {
    Case {
        name: "manipulator-2dof",
        mechanism: TwoLinkArm {
            mass: [1.0; 2],
            length: [1.0; 2],
            torque: [0.4, 0.3],
            start: [0.0; 2],
        },
        friction: [Coulomb { stick: 0.10, slip: 0.08 }, Coulomb { stick: 0.075, slip: 0.06 }],
        times_s: vec![
            0.0,
            0.420702877109,
            0.726914373526,
            1.250820656225,
            1.892725888652,
            2.526265737564,
            2.564718794948,
            3.859631084155,
        ],
        size: [[0.011, 0.026], [0.031, 0.075]],
    }
}

fn exact<const N: usize, M: Mechanism<N>>(case: &Case<N, M>, tolerance: f64) -> Vec<f64> {
    let mut events: Vec<BodyEvent> = Vec::with_capacity(16);
    event_driven::run(&case.mechanism, &case.friction, tolerance, DURATION_S, &mut events).unwrap();
    events.iter().map(|event| event.time_s).collect()
}

/// Returns a function that runs the same problem once with `tsit45`.
fn tsit45<const N: usize, M: Mechanism<N> + Copy + 'static>(
    case: &Case<N, M>,
    tolerance: f64,
) -> impl Fn() -> Vec<f64> + use<N, M> {
    let (mechanism, friction) = (case.mechanism, case.friction);
    let mode: Rc<Cell<BodyMode<N>>> = Rc::new(Cell::new([0; N]));
    let split = |x: &[f64]| -> ([f64; N], [f64; N]) {
        (std::array::from_fn(|i| x[i]), std::array::from_fn(|i| x[N + i]))
    };
    let in_rates = mode.clone();
    let rates = move |x: &[f64], _: &[f64], t: f64, y: &mut [f64]| {
        let (q, v) = split(x);
        let (a, _) = accelerations(&mechanism.terms(t, &q, &v), &friction, &v, &in_rates.get());
        y[..N].copy_from_slice(&v);
        y[N..].copy_from_slice(&a);
    };
    let in_roots = mode.clone();
    let roots = move |x: &[f64], _: &[f64], t: f64, y: &mut [f64]| {
        let (q, v) = split(x);
        let mode = in_roots.get();
        // Reactions of stuck bodies cost an evaluation; velocities do not.
        let reactions = mode
            .contains(&0)
            .then(|| accelerations(&mechanism.terms(t, &q, &v), &friction, &v, &mode).1);
        for i in 0..N {
            let reaction = reactions.map_or(0.0, |r| r[i]);
            y[i] = match mode[i] {
                0 => friction[i].stick - reaction.abs(),
                // Just above zero for a body that has just started.
                sign => f64::from(sign) * v[i] + 1e-14,
            };
        }
    };
    let start = mechanism.start();
    let atol: Vec<f64> = case.size.iter().flatten().map(|size| tolerance * size).collect();
    let problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(tolerance)
        .atol(atol)
        .h0(1e-3)
        .rhs(rates)
        .init(
            move |_: &[f64], _: f64, y: &mut [f64]| {
                y[..N].copy_from_slice(&start);
                y[N..].fill(0.0);
            },
            2 * N,
        )
        .root(roots, N)
        .build()
        .unwrap();
    move || {
        let mut times_s = Vec::with_capacity(16);
        let first = decide(&mechanism.terms(0.0, &start, &[0.0; N]), &friction, &[0.0; N], &[0; N])
            .unwrap();
        times_s.extend(first.iter().filter(|sign| **sign != 0).map(|_| 0.0));
        mode.set(first);
        let mut solver = problem.tsit45().unwrap();
        solver.set_stop_time(DURATION_S).unwrap();
        loop {
            match solver.step().unwrap() {
                OdeSolverStopReason::InternalTimestep => {}
                OdeSolverStopReason::TstopReached => return times_s,
                OdeSolverStopReason::RootFound(t, body) => {
                    solver.state_mut_back(t).unwrap();
                    let state = solver.state_mut();
                    let x = state.y.batch_as_mut_slice(0);
                    let before = mode.get();
                    let mut breaking = [0; N];
                    let (q, mut v) = split(x);
                    if before[body] == 0 {
                        let terms = mechanism.terms(t, &q, &v);
                        let reaction = accelerations(&terms, &friction, &v, &before).1[body];
                        breaking[body] = if reaction > 0.0 { 1 } else { -1 };
                    } else {
                        v[body] = 0.0;
                    }
                    let terms = mechanism.terms(t, &q, &v);
                    let after = decide(&terms, &friction, &v, &breaking).unwrap();
                    times_s.extend((0..N).filter(|i| before[*i] != after[*i]).map(|_| t));
                    mode.set(after);
                    let (a, _) = accelerations(&terms, &friction, &v, &after);
                    x[N..].copy_from_slice(&v);
                    let dx = state.dy.batch_as_mut_slice(0);
                    dx[..N].copy_from_slice(&v);
                    dx[N..].copy_from_slice(&a);
                }
            }
        }
    }
}

fn worst(found: &[f64], expected: &[f64]) -> f64 {
    if found.len() != expected.len() {
        return f64::NAN;
    }
    found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn microseconds(run: impl Fn() -> Vec<f64>) -> f64 {
    let best = |n: u32| {
        let begin = Instant::now();
        (0..n).for_each(|_| drop(black_box(run())));
        begin.elapsed().as_secs_f64() * 1e6 / f64::from(n)
    };
    best(20);
    (0..5).map(|_| best(100)).fold(f64::INFINITY, f64::min)
}

fn compare<const N: usize, M: Mechanism<N> + Copy + 'static>(
    criterion: &mut Criterion,
    case: &Case<N, M>,
) {
    let mut curves: [Vec<(f64, f64)>; 2] = Default::default();
    println!("{}: tolerance, exact: us, error s; tsit45: us, error s", case.name);
    for exponent in 4..=12 {
        let tolerance = 10f64.powi(-exponent);
        let other = tsit45(case, tolerance);
        let errors =
            [worst(&exact(case, tolerance), &case.times_s), worst(&other(), &case.times_s)];
        let times = [microseconds(|| exact(case, tolerance)), microseconds(&other)];
        println!(
            "  1e-{exponent:02}  {:8.2} {:8.1e}   {:8.2} {:8.1e}",
            times[0], errors[0], times[1], errors[1]
        );
        for i in 0..2 {
            curves[i].push((times[i].log10(), errors[i].max(1e-13).log10()));
        }
    }
    let [ours, theirs] = curves;
    let lines = vec![
        PlotCurve::new("exact", Style::Primary, ours),
        PlotCurve::new("diffsol, tsit45 with roots", Style::Second, theirs),
    ];
    let figure = Figure {
        title: format!("{}: work and precision over 5 s", case.name),
        subtitle: "tolerances from 1e-4 to 1e-12".into(),
        x_label: "log10 of microseconds a run".into(),
        panels: vec![Panel::new("log10 of the worst event's error (s)", lines)],
    };
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/friction-bench");
    fs::create_dir_all(directory).unwrap();
    fs::write(format!("{directory}/{}.svg", case.name), figure.to_svg().unwrap()).unwrap();
    fs::write(format!("{directory}/{}.png", case.name), figure.to_png(2.0).unwrap()).unwrap();

    let mut group = criterion.benchmark_group(format!("{}, 5 s at 1e-8", case.name));
    group.bench_function("exact", |bencher| bencher.iter(|| exact(black_box(case), 1e-8)));
    let other = tsit45(case, 1e-8);
    group.bench_function("diffsol tsit45", |bencher| bencher.iter(&other));
    group.finish();
}

fn friction(criterion: &mut Criterion) {
    compare(criterion, &spring_mass());
    compare(criterion, &pendulum());
    compare(criterion, &arm());
}

criterion_group!(benches, friction);
criterion_main!(benches);
