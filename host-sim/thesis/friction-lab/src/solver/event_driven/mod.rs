//! Event-driven integration with set-valued friction: every change of mode is located.
//!
//! While no body changes its mode the motion is smooth. A pair of order 8(5,3)
//! (`dormand_prince.rs`) follows it with an error control that is relative to the largest value
//! that each coordinate has had. After each step the event functions, which are the velocities of
//! slipping bodies and the reactions of stuck ones, are looked at *inside* the step, as
//! polynomials. The first that reaches its limit is located by integrating up to it, again and
//! again (Newton). There all bodies at rest are decided anew, and at once
//! ([`dynamics::solver::modes`]). A stuck body has velocity exactly zero. While all stick nothing
//! is integrated: only the reactions are followed in time.
//!
//! Guarantees: crossings in order, also several in one step; a time that is right to about the
//! tolerance; an end within bounded work, if need be with a [`SolverFailure`]. Does badly: two
//! crossings nearer to each other than a sixty-fourth of a step or so, which vanish together; stiff
//! mechanisms, whose steps are as short as stability wants.
// One index goes through several arrays of bodies at once.
#![allow(clippy::needless_range_loop)]

mod rest;
mod slip;

use super::SolverFailure;
use super::state::{BodyEvent, BodySample, Finish, Observer};
use super::zeno_guard::ZenoGuard;
use dynamics::friction::SetValued;
use dynamics::mechanism::{Mechanism, Terms};
use dynamics::solver::EventKind;
use dynamics::solver::linear::solve;
use dynamics::solver::modes::{BodyMode, accelerations, decide};

/// Steps and events before a run is given up: minutes of work.
const MAX_STEPS: u64 = 10_000_000;

/// A body breaks away this far beyond its limit, so that rounding cannot hold it where F_s = F_d.
const BEYOND: f64 = 1.0 + 4e-12;

/// Runs a mechanism with set-valued friction from rest.
///
/// `tolerance` bounds each step's error, relative to the largest value that a coordinate (or
/// velocity) has had.
///
/// # Errors
/// If no mode is consistent, steps underflow or events do not end: with time and state.
pub fn run<const N: usize, M, F, O>(
    mechanism: &M,
    friction: &[F; N],
    tolerance: f64,
    duration_s: f64,
    observer: &mut O,
) -> Result<Finish<N>, SolverFailure>
where
    M: Mechanism<N> + ?Sized,
    F: SetValued,
    O: Observer<N>,
{
    let start = mechanism.start();
    let mass = mechanism.terms(0.0, &start, &[0.0; N]).mass;
    // What F_s gives a body in a microsecond: a motion that begins without acceleration (F_s = F_d,
    // or Stribeck's curve) is measured by it, since by itself it is nothing.
    let kick: [f64; N] = std::array::from_fn(|i| 1e-6 * friction[i].stick() / mass[i][i]);
    let mut run = Run {
        mechanism,
        friction,
        tolerance,
        duration_s,
        observer,
        t: 0.0,
        q: start,
        v: [0.0; N],
        mode: [0; N],
        a: [0.0; N],
        forces: [0.0; N],
        size_q: std::array::from_fn(|i| start[i].abs().max(1e-6 * kick[i])),
        size_v: kick,
        step_s: duration_s / 100.0,
        last_s: duration_s,
        evaluations: 1,
        steps: 0,
        zeno_guard: ZenoGuard::new(duration_s),
    };
    run.follow()?;
    Ok(Finish {
        q: run.q,
        v: run.v,
        evaluations: run.evaluations,
        steps: run.steps,
        diverged_at_s: if run.is_finite() { None } else { Some(run.t) },
    })
}

struct Run<'a, const N: usize, M: ?Sized, F, O> {
    mechanism: &'a M,
    friction: &'a [F; N],
    tolerance: f64,
    duration_s: f64,
    observer: &'a mut O,
    t: f64,
    q: [f64; N],
    v: [f64; N],
    mode: BodyMode<N>,
    /// Accelerations and frictions at `t`.
    a: [f64; N],
    forces: [f64; N],
    /// Largest magnitudes so far.
    size_q: [f64; N],
    size_v: [f64; N],
    /// What the next step should be.
    step_s: f64,
    /// The last instant of the smooth stretch that `t` is in: forces are never asked for beyond it.
    last_s: f64,
    evaluations: u64,
    steps: u64,
    zeno_guard: ZenoGuard,
}

impl<const N: usize, M, F, O> Run<'_, N, M, F, O>
where
    M: Mechanism<N> + ?Sized,
    F: SetValued,
    O: Observer<N>,
{
    fn follow(&mut self) -> Result<(), SolverFailure> {
        while self.t < self.duration_s {
            let corner = self.mechanism.next_corner(self.t);
            let end_s = corner.min(self.duration_s);
            self.last_s = if corner <= self.duration_s { corner.next_down() } else { end_s };
            self.switch([0; N])?;
            while self.t < end_s {
                if self.mode == [0; N] {
                    self.rest(end_s)?;
                } else {
                    self.slip(end_s)?;
                }
                if !self.is_finite() {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    fn is_finite(&self) -> bool {
        self.q.iter().chain(&self.v).all(|x| x.is_finite())
    }

    fn terms(&mut self, t: f64, q: &[f64; N], v: &[f64; N]) -> Terms<N> {
        self.evaluations += 1;
        self.mechanism.terms(t.min(self.last_s), q, v)
    }

    /// Decides the mode at the present time, and reports changes.
    fn switch(&mut self, breaking: BodyMode<N>) -> Result<(), SolverFailure> {
        let (q, v) = (self.q, self.v);
        let terms = self.terms(self.t, &q, &v);
        let decided = decide(&terms, self.friction, &self.v, &breaking)
            // Only rounding can keep a body that reached its limit from being decided: then it may
            // stay.
            .or_else(|| decide(&terms, self.friction, &self.v, &[0; N]));
        let Some(mode) = decided else {
            return Err(self.trouble("no choice of sticking and slipping bodies is consistent"));
        };
        self.sample_limits(&terms, &mode);
        for i in 0..N {
            let kind = match (self.mode[i], mode[i]) {
                (before, after) if before == after => continue,
                (0, _) => EventKind::Break,
                (_, 0) => EventKind::Stick,
                _ => EventKind::Reverse,
            };
            self.observer.event(BodyEvent { time_s: self.t, body: i, kind });
            self.zeno_guard.count(self.t).map_err(|what| self.trouble(&what))?;
        }
        self.mode = mode;
        (self.a, self.forces) = accelerations(&terms, self.friction, &self.v, &self.mode);
        self.sample();
        Ok(())
    }

    fn count_step(&mut self) -> Result<(), SolverFailure> {
        self.steps += 1;
        if self.steps > MAX_STEPS {
            return Err(self.trouble(&format!("more than {MAX_STEPS} steps")));
        }
        Ok(())
    }

    fn trouble(&self, what: &str) -> SolverFailure {
        SolverFailure::new(what, self.t, &self.q, &self.v)
    }

    /// At the very instant at which a body breaks away or turns around its friction is F_s (thesis
    /// eq. 1, row 3).
    fn sample_limits(&mut self, terms: &Terms<N>, next: &BodyMode<N>) {
        if !O::SAMPLES || *next == self.mode {
            return;
        }
        let (_, mut friction) = accelerations(terms, self.friction, &self.v, next);
        let mut slip = *next;
        for i in 0..N {
            if next[i] != self.mode[i] && next[i] != 0 {
                friction[i] = f64::from(next[i]) * self.friction[i].stick();
                slip[i] = 0;
            }
        }
        let net = std::array::from_fn(|i| terms.force[i] - friction[i]);
        let a = solve(&terms.mass, &net, &next.map(|sign| sign == 0));
        for i in 0..N {
            if next[i] == 0 {
                let inertia: f64 = terms.mass[i].iter().zip(&a).map(|(m, a)| m * a).sum();
                friction[i] = terms.force[i] - inertia;
            }
        }
        self.observer.sample(&BodySample {
            time_s: self.t,
            q: self.q,
            v: self.v,
            a,
            friction,
            slip,
            z: [0.0; N],
        });
    }

    fn sample(&mut self) {
        if O::SAMPLES {
            self.observer.sample(&BodySample {
                time_s: self.t,
                q: self.q,
                v: self.v,
                a: self.a,
                friction: self.forces,
                slip: self.mode,
                z: [0.0; N],
            });
        }
    }
}
