//! Time stepping without located events (`nonsmooth`): backward Euler, with the friction of all
//! bodies at the end of the step found together with their velocities there.
//!
//! ```text
//! q+ = q + h v+
//! M(q+) (v+ - v) = h (f(t + h, q+, v+) - F+),    F+ in the friction law at v+
//! ```
//!
//! For set-valued friction ([`run`]) and given f that is a convex problem whose minimiser is at
//! rest in exactly v = 0; for friction with an internal state or a smoothed sign ([`run_implicit`])
//! an equation that is monotone in v+. f is brought to the end of the step by repetition; each pass
//! is one evaluation, and a few do.
//!
//! Guarantees: no step is too long for a friction's stiffness, and none is spent on events, however
//! many there are. Errors fall like h, also across events; those are reported at the end of the
//! step that they are in.
//!
//! Does badly: accuracy, against the exact solver; the mechanism's own springs, whose period must
//! be longer than about six steps; what is taken at the begin of the step. That is the speed in the
//! level of friction, so that h must be well below `m v_s / (F_s - F_d)`, and for set-valued
//! friction below `m / sigma2` as well.

mod convex;
mod implicit;
mod monotone;
mod set_valued;

use super::SolverFailure;
use super::state::{BodyEvent, BodySample, Finish, Observer};
use super::zeno_guard::ZenoGuard;
use crate::friction::Implicit;
use dynamics::friction::SetValued;
use dynamics::mechanism::Mechanism;
use dynamics::solver::EventKind;

/// Passes over a step before it counts as too long.
const MAX_PASSES: u32 = 60;

/// When a pass has changed nothing: velocities, relative to what the step does to them.
const SAME: f64 = 1e-12;

/// Runs a mechanism with set-valued friction from rest, in steps of at most `step_s` that end at
/// the corners of its drive.
///
/// Who is at rest breaks away above F_s; who moves has the friction of the speed at the begin of
/// the step, so that the problem stays convex, and comes to rest if it cannot pass zero against
/// F_s.
///
/// # Errors
/// If the mechanism's forces are too stiff for the step, or events do not end: with time and state.
pub fn run<const N: usize, M, F, O>(
    mechanism: &M,
    friction: &[F; N],
    step_s: f64,
    duration_s: f64,
    observer: &mut O,
) -> Result<Finish<N>, SolverFailure>
where
    M: Mechanism<N> + ?Sized,
    F: SetValued,
    O: Observer<N>,
{
    Run::new(mechanism, set_valued::SetValuedLaw::new(friction), duration_s, observer)
        .finished(step_s, duration_s)
}

/// The same for friction with an implicit step of its own.
///
/// # Errors
/// As [`run`].
pub fn run_implicit<const N: usize, const Z: usize, M, F, O>(
    mechanism: &M,
    friction: &[F; N],
    step_s: f64,
    duration_s: f64,
    observer: &mut O,
) -> Result<Finish<N>, SolverFailure>
where
    M: Mechanism<N> + ?Sized,
    F: Implicit<Z>,
    O: Observer<N>,
{
    Run::new(mechanism, implicit::ImplicitLaw::new(friction), duration_s, observer)
        .finished(step_s, duration_s)
}

/// A step with the mechanism's terms frozen.
#[derive(Clone, Copy, Debug)]
struct Step<const N: usize> {
    h: f64,
    mass: [[f64; N]; N],
    /// `M v + h f`: the momenta at the end if there were no friction.
    momentum: [f64; N],
    /// Velocities at the begin.
    v: [f64; N],
}

/// How friction enters a step.
trait ContactLaw<const N: usize> {
    /// A new step begins.
    fn begin(&mut self, v: &[f64; N]);

    /// Velocities at the end; `guess` is the last pass's. None if they are not found.
    fn velocities(&mut self, step: &Step<N>, guess: &[f64; N]) -> Option<[f64; N]>;

    /// The step is kept: frictions at its end.
    fn keep(&mut self, step: &Step<N>, v_end: &[f64; N]) -> [f64; N];

    /// The frictions from rest under given forces.
    fn at_rest(&self, force: &[f64; N]) -> [f64; N];

    /// 0 where a body sticks, else the sign of its slip.
    fn slip(&self) -> [i8; N];

    /// The first state of each friction; zero of one that has none.
    fn deflections(&self) -> [f64; N] {
        [0.0; N]
    }
}

struct Run<'a, const N: usize, M: ?Sized, L, O> {
    mechanism: &'a M,
    law: L,
    observer: &'a mut O,
    t: f64,
    q: [f64; N],
    v: [f64; N],
    slip: [i8; N],
    evaluations: u64,
    steps: u64,
    zeno_guard: ZenoGuard,
}

impl<'a, const N: usize, M: Mechanism<N> + ?Sized, L: ContactLaw<N>, O: Observer<N>>
    Run<'a, N, M, L, O>
{
    fn new(mechanism: &'a M, law: L, duration_s: f64, observer: &'a mut O) -> Self {
        let (q, slip) = (mechanism.start(), law.slip());
        let zeno_guard = ZenoGuard::new(duration_s);
        Self {
            mechanism,
            law,
            observer,
            t: 0.0,
            q,
            v: [0.0; N],
            slip,
            evaluations: 0,
            steps: 0,
            zeno_guard,
        }
    }

    fn finished(mut self, step_s: f64, duration_s: f64) -> Result<Finish<N>, SolverFailure> {
        self.sample_start();
        while self.t < duration_s {
            let begin_s = self.t;
            let corner_s = self.mechanism.next_corner(begin_s);
            let end_s = corner_s.min(duration_s);
            let last_s = if corner_s <= duration_s { end_s.next_down() } else { end_s };
            // A hair less than a whole number of steps is that number.
            let steps = ((end_s - begin_s) / step_s - 1e-9).ceil().max(1.0);
            let h = (end_s - begin_s) / steps;
            for i in 1..=steps as u64 {
                let t_end = if i == steps as u64 { end_s } else { begin_s + i as f64 * h };
                self.step(h, t_end, last_s)?;
                if !self.is_finite() {
                    return Ok(self.finish(Some(t_end)));
                }
            }
        }
        Ok(self.finish(None))
    }

    fn step(&mut self, h: f64, t_end: f64, last_s: f64) -> Result<(), SolverFailure> {
        self.law.begin(&self.v);
        let (v, mut v_end) = (self.v, self.v);
        for _ in 0..MAX_PASSES {
            let q_end: [f64; N] = std::array::from_fn(|i| self.q[i] + h * v_end[i]);
            let terms = self.mechanism.terms(t_end.min(last_s), &q_end, &v_end);
            self.evaluations += 1;
            let momentum = std::array::from_fn(|i| dot(&terms.mass[i], &v) + h * terms.force[i]);
            let step = Step { h, mass: terms.mass, momentum, v };
            if !momentum.iter().all(|p| p.is_finite()) {
                (self.t, self.v) = (t_end, [f64::NAN; N]);
                return Ok(());
            }
            let Some(found) = self.law.velocities(&step, &v_end) else {
                return Err(self.trouble("the velocities at the end of a step are not found", h));
            };
            let same = (0..N).all(|i| {
                let push = (h * terms.force[i] / terms.mass[i][i]).abs();
                (found[i] - v_end[i]).abs() <= SAME * (v[i].abs() + found[i].abs() + push)
            });
            v_end = found;
            if same {
                return self.keep(&step, t_end, v_end);
            }
        }
        Err(self
            .trouble("the step is too long for the springs (or other forces) of the mechanism", h))
    }

    fn keep(&mut self, step: &Step<N>, t_end: f64, v_end: [f64; N]) -> Result<(), SolverFailure> {
        let friction = self.law.keep(step, &v_end);
        let a = std::array::from_fn(|i| (v_end[i] - self.v[i]) / step.h);
        for (q, v) in self.q.iter_mut().zip(&v_end) {
            *q += step.h * v;
        }
        (self.t, self.v) = (t_end, v_end);
        self.steps += 1;
        let slip = self.law.slip();
        for (body, change) in self.slip.into_iter().zip(slip).enumerate() {
            let kind = match change {
                (before, after) if before == after => continue,
                (0, _) => EventKind::Break,
                (_, 0) => EventKind::Stick,
                _ => EventKind::Reverse,
            };
            self.observer.event(BodyEvent { time_s: t_end, body, kind });
            self.zeno_guard.count(t_end).map_err(|what| self.trouble(&what, step.h))?;
        }
        self.slip = slip;
        self.sample(a, friction);
        Ok(())
    }

    /// The instant at which the run begins; for the reader, not counted.
    fn sample_start(&mut self) {
        if O::SAMPLES {
            let terms = self.mechanism.terms(0.0, &self.q, &self.v);
            let friction = self.law.at_rest(&terms.force);
            let net = std::array::from_fn(|i| terms.force[i] - friction[i]);
            self.sample(dynamics::solver::linear::solve(&terms.mass, &net, &[false; N]), friction);
        }
    }

    fn sample(&mut self, a: [f64; N], friction: [f64; N]) {
        if O::SAMPLES {
            let Self { t: time_s, q, v, slip, .. } = *self;
            let z = self.law.deflections();
            self.observer.sample(&BodySample { time_s, q, v, a, friction, slip, z });
        }
    }

    fn is_finite(&self) -> bool {
        self.q.iter().chain(&self.v).all(|x| x.is_finite())
    }

    fn finish(&self, diverged_at_s: Option<f64>) -> Finish<N> {
        let Self { q, v, evaluations, steps, .. } = *self;
        Finish { q, v, evaluations, steps, diverged_at_s }
    }

    fn trouble(&self, what: &str, h: f64) -> SolverFailure {
        SolverFailure::new(format!("{what} (step {h:e} s)"), self.t, &self.q, &self.v)
    }
}

fn dot<const N: usize>(row: &[f64; N], x: &[f64; N]) -> f64 {
    row.iter().zip(x).map(|(a, b)| a * b).sum()
}
