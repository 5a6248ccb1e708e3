//! Shared parts of the thesis's two Runge-Kutta solvers: the classical step, and the reports to an
//! observer.
// One index goes through several arrays of bodies at once.
#![allow(clippy::needless_range_loop)]

use super::SolverFailure;
use super::dense_output::state_between;
use super::dynamics::{Dynamics, StateRates};
use super::state::{BodyEvent, BodySample, BodyState, Finish, Observer};
use super::zeno_guard::ZenoGuard;
use dynamics::solver::EventKind;

/// The classical Runge-Kutta step of order 4 from a state whose rates are known. `last_s` is the
/// last instant of the smooth stretch that the step is in. Three evaluations.
#[inline]
pub fn classical<const N: usize, const Z: usize, D: Dynamics<N, Z>>(
    dynamics: &D,
    t: f64,
    last_s: f64,
    from: &BodyState<N, Z>,
    first: &BodyState<N, Z>,
    h: f64,
) -> BodyState<N, Z> {
    let rates = |t: f64, state: &BodyState<N, Z>| dynamics.evaluate(t.min(last_s), state).rates;
    let second = rates(t + 0.5 * h, &from.plus(0.5 * h, first));
    let third = rates(t + 0.5 * h, &from.plus(0.5 * h, &second));
    let fourth = rates(t + h, &from.plus(h, &third));
    from.plus(h / 6.0, first).plus(h / 3.0, &second).plus(h / 3.0, &third).plus(h / 6.0, &fourth)
}

/// A run between its steps.
pub(super) struct Progress<const N: usize, const Z: usize> {
    pub t: f64,
    pub state: BodyState<N, Z>,
    /// Rates and frictions at `t`.
    pub rates: StateRates<N, Z>,
    pub evaluations: u64,
    pub steps: u64,
    slip: [i8; N],
    zeno_guard: ZenoGuard,
}

impl<const N: usize, const Z: usize> Progress<N, Z> {
    pub fn start<D: Dynamics<N, Z>, O: Observer<N>>(
        dynamics: &D,
        duration_s: f64,
        observer: &mut O,
    ) -> Self {
        let state = dynamics.start();
        let rates = dynamics.evaluate(0.0, &state);
        let slip = dynamics.slip(&state);
        let zeno_guard = ZenoGuard::new(duration_s);
        let progress = Self { t: 0.0, state, rates, evaluations: 1, steps: 0, slip, zeno_guard };
        progress.sample(observer);
        progress
    }

    /// Keeps a step up to `t`, in a smooth stretch whose last instant is `last_s`. Its events are
    /// at its end: nothing is located.
    ///
    /// # Errors
    /// If events do not end: with time and state.
    pub fn keep<D: Dynamics<N, Z>, O: Observer<N>>(
        &mut self,
        dynamics: &mut D,
        (t, last_s): (f64, f64),
        state: BodyState<N, Z>,
        observer: &mut O,
    ) -> Result<(), SolverFailure> {
        self.samples_between(dynamics, (t, last_s), &state, observer);
        (self.t, self.state) = (t, state);
        dynamics.accepted(&mut self.state, &self.rates);
        self.rates = dynamics.evaluate(t, &self.state);
        self.evaluations += 1;
        self.steps += 1;
        let slip = dynamics.slip(&self.state);
        for body in 0..N {
            let kind = match (self.slip[body], slip[body]) {
                (before, after) if before == after => continue,
                (0, _) => EventKind::Break,
                (_, 0) => EventKind::Stick,
                _ => EventKind::Reverse,
            };
            observer.event(BodyEvent { time_s: t, body, kind });
            self.zeno_guard.count(t).map_err(|what| self.trouble(what))?;
        }
        self.slip = slip;
        self.sample(observer);
        Ok(())
    }

    /// What a reader sees of a long step, and of its end where the forces jump there. Of a step in
    /// which a body changes between sticking and slipping, be it only on the way, nothing is known
    /// but its ends. Not counted: it is not for the solution.
    fn samples_between<D: Dynamics<N, Z>, O: Observer<N>>(
        &self,
        dynamics: &D,
        (t, last_s): (f64, f64),
        end: &BodyState<N, Z>,
        observer: &mut O,
    ) {
        let is_wanted = t > last_s || observer.next_sample_s() < t;
        if !O::SAMPLES || !is_wanted || !end.is_finite() {
            return;
        }
        let h = t - self.t;
        let (then, slip_then) = (dynamics.evaluate(t.min(last_s), end), dynamics.slip(end));
        while observer.next_sample_s() < t {
            let time_s = observer.next_sample_s();
            let part = (time_s - self.t) / h;
            let state =
                state_between(h, (&self.state, &self.rates.rates), (end, &then.rates), part);
            let slip = dynamics.slip(&state);
            if slip != self.slip || slip != slip_then {
                break;
            }
            let rates = dynamics.evaluate(time_s.min(last_s), &state);
            observer.sample(&sample(time_s, &state, &rates, slip));
        }
        if t > last_s {
            observer.sample(&sample(t, end, &then, slip_then));
        }
    }

    fn sample<O: Observer<N>>(&self, observer: &mut O) {
        if O::SAMPLES {
            observer.sample(&sample(self.t, &self.state, &self.rates, self.slip));
        }
    }

    pub fn finish(&self) -> Finish<N> {
        Finish {
            q: self.state.q,
            v: self.state.v,
            evaluations: self.evaluations,
            steps: self.steps,
            diverged_at_s: if self.state.is_finite() { None } else { Some(self.t) },
        }
    }

    pub fn trouble(&self, what: impl Into<String>) -> SolverFailure {
        SolverFailure::new(what, self.t, &self.state.q, &self.state.v)
    }
}

fn sample<const N: usize, const Z: usize>(
    time_s: f64,
    state: &BodyState<N, Z>,
    rates: &StateRates<N, Z>,
    slip: [i8; N],
) -> BodySample<N> {
    let StateRates { rates, friction } = *rates;
    BodySample {
        time_s,
        q: state.q,
        v: state.v,
        a: rates.v,
        friction,
        slip,
        z: state.deflections(),
    }
}
