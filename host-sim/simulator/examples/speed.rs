//! Checks the speed of the closed loop by ratios inside one run (`cargo xtask speed`).
//!
//! The run is the thesis's 2.5 deg step, 2 s at 20 ms. The exact solver is compared with RK4 of
//! 10 us, which computes the same motion, and the servo with the bare loop that it has inside. Each
//! time is the shortest of many that alternate, so that other work on the machine adds nothing to
//! it. `tests/evidence/speed.md` explains the bounds.
#![allow(clippy::unwrap_used)]

use std::hint::black_box;
use std::ops::RangeInclusive;
use std::process::ExitCode;
use std::time::Instant;

use dynamics::solver::{ExactAxis, Rk4Axis};
use simulator::closed_loop::ClosedLoop;
use simulator::experiment::{Document, Experiment, RunPlan, parameters};
use simulator::target::WatchedServo;

/// 2 s of 20 ms.
const SAMPLES: u32 = 100;

/// Step of RK4 (s), and its static velocity range (deg/s), that of the thesis.
const RK4: [f64; 2] = [1e-5, 1e-4];

/// How often each time is measured.
const TIMES: u32 = 150;

/// A law, how many times as fast the exact solver is as RK4 under it, and how many times as long
/// the servo takes as the bare loop.
const BOUNDS: [(&str, RangeInclusive<f64>, RangeInclusive<f64>); 2] =
    [("pd", 1100.0..=3000.0, 1.0..=4.0), ("srnf", 750.0..=2000.0, 1.0..=4.0)];

fn plan(law: &str) -> RunPlan {
    let mut document = Document::open("step-response").unwrap();
    document.set(&["reference.steps_deg=[2.5]".into()]).unwrap();
    Experiment::plan(&document, &[law.into()], &[]).unwrap().into_first().unwrap()
}

/// The shortest time of a run so far, s.
struct Shortest(f64);

impl Shortest {
    /// Makes some runs, each of which returns its error at the end.
    fn of(&mut self, runs: u32, run: impl Fn() -> f64) {
        let begin = Instant::now();
        for _ in 0..runs {
            black_box(run());
        }
        self.0 = self.0.min(begin.elapsed().as_secs_f64() / f64::from(runs));
    }
}

fn bare(closed_loop: &ClosedLoop, mut solver: impl dynamics::solver::AxisSolver) -> f64 {
    let mut error = 0.0;
    closed_loop.run(&mut solver, SAMPLES, |moment| error = moment.error_deg(), |_| ());
    error
}

fn served(closed_loop: &ClosedLoop, servo: &WatchedServo, solver: ExactAxis) -> f64 {
    let (mut error, mut servo) = (0.0, servo.clone());
    let mut plant = closed_loop.plant(solver);
    let on_moment = |moment: &simulator::closed_loop::LoopSample| error = moment.error_deg();
    closed_loop.step(&mut servo, &mut plant, SAMPLES, on_moment, |_| ());
    error
}

fn main() -> ExitCode {
    let mut is_within = true;
    for (law, exact_bounds, servo_bounds) in BOUNDS {
        let plan = plan(law);
        let closed_loop = plan.closed_loop().unwrap();
        let axis = || ExactAxis::at_rest(&closed_loop.axis, closed_loop.sample_time_s);
        let rest = closed_loop.plant(axis());
        let servo =
            WatchedServo::new(parameters(&plan).unwrap(), rest.counters(), rest.counts()).unwrap();
        let [mut exact, mut rk4, mut watched] = [(); 3].map(|()| Shortest(f64::INFINITY));
        for _ in 0..TIMES {
            let [step_s, band] = RK4;
            exact.of(30, || bare(black_box(&closed_loop), axis()));
            rk4.of(1, || bare(&closed_loop, Rk4Axis::at_rest(&closed_loop.axis, band, step_s)));
            watched.of(30, || served(black_box(&closed_loop), &servo, axis()));
        }
        let [exact, rk4, watched] = [exact, rk4, watched].map(|shortest| shortest.0 * 1e6);
        println!(
            "{law}: a run takes {exact:.2} us; RK4 of 10 us takes {:.0} times as long, the servo \
             {:.2} times as long",
            rk4 / exact,
            watched / exact
        );
        for (what, ratio, bounds) in [
            ("RK4 of 10 us", rk4 / exact, exact_bounds),
            ("the servo", watched / exact, servo_bounds),
        ] {
            if !bounds.contains(&ratio) {
                is_within = false;
                let [least, most] = [bounds.start(), bounds.end()];
                eprintln!(
                    "{law}: {what} takes {ratio:.2} times as long as the exact closed loop, and it \
                     must be {least} to {most} times. One of the two has changed its speed: \
                     compare with the commit before on the same machine (tests/evidence/speed.md)."
                );
            }
        }
    }
    if is_within { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
