//! Event-driven integration with single-valued friction, which is smooth piece by piece.
//!
//! It works as [`super::event_driven`] does, with the friction's own states among the unknowns: a
//! pair of order 8(5,3) with error control, polynomials of the functions that end a piece, Newton's
//! method on the integrated motion. A model without pieces is integrated through its kinks by error
//! control alone, and its breaks and sticks are reported at the ends of steps.
//!
//! Limits: stiff models. A bristle of `k` on a mass `m` needs a step about every `1/sqrt(k/m)`,
//! whatever the tolerance.
// One index goes through several arrays of bodies at once.
#![allow(clippy::needless_range_loop)]

use super::SolverFailure;
use super::dense_output::state_between;
use super::dormand_prince::{EVALUATIONS, growth, step};
use super::dynamics::{StateRates, direction, rates_in};
use super::state::{BodyEvent, BodySample, BodyState, Finish, Observer};
use super::zeno_guard::ZenoGuard;
use crate::friction::SingleValued;
use dynamics::mechanism::Mechanism;
use dynamics::solver::EventKind;
use dynamics::solver::roots::{Quartic, first_falling_zero, slope, through};

/// Largest number of steps of a run: half a minute of computation.
const MAX_STEPS: u64 = 2_000_000;

/// The event function of a piece counts as zero if it is off by no more than this part of its
/// largest value on the step.
const LOCATION_TOLERANCE: f64 = 1e-12;

/// What positions and velocities are measured by at rest where the friction has no deflection, in
/// SI.
const LEAST: f64 = 1e-9;

/// Runs a mechanism with single-valued friction from rest.
///
/// `tolerance` bounds each step's error, relative to the largest value that a coordinate, velocity
/// or state has had.
///
/// # Errors
/// If steps underflow or events do not end: with time and state.
pub fn run<const N: usize, const Z: usize, M, F, O>(
    mechanism: &M,
    friction: &[F; N],
    tolerance: f64,
    duration_s: f64,
    observer: &mut O,
) -> Result<Finish<N>, SolverFailure>
where
    M: Mechanism<N> + ?Sized,
    F: SingleValued<Z>,
    O: Observer<N>,
{
    let state = BodyState { q: mechanism.start(), ..BodyState::ZERO };
    let pieces = std::array::from_fn(|i| friction[i].piece(0.0, &state.z[i]));
    let z = std::array::from_fn(|i| friction[i].state_scale());
    // A body that has not moved yet is measured by its friction's deflection, and by that in a
    // second.
    let least = z.map(|scale: [f64; Z]| scale.iter().fold(LEAST, |least, z| least.max(*z)));
    let size =
        BodyState { q: std::array::from_fn(|i| least[i].max(state.q[i].abs())), v: least, z };
    let now = rates_in(mechanism, friction, &pieces, 0.0, &state);
    let mut run = Run {
        mechanism,
        friction,
        tolerance,
        observer,
        t: 0.0,
        state,
        pieces,
        slip: [0; N],
        now,
        size,
        step_s: duration_s / 1000.0,
        last_s: duration_s,
        evaluations: 1,
        steps: 0,
        zeno_guard: ZenoGuard::new(duration_s),
    };
    while run.t < duration_s && run.state.is_finite() {
        let corner_s = mechanism.next_corner(run.t);
        let end_s = corner_s.min(duration_s);
        run.last_s = if corner_s <= duration_s { corner_s.next_down() } else { end_s };
        run.refresh()?;
        while run.t < end_s && run.state.is_finite() {
            run.step(end_s)?;
        }
    }
    let diverged_at_s = if run.state.is_finite() { None } else { Some(run.t) };
    let (q, v) = (run.state.q, run.state.v);
    Ok(Finish { q, v, evaluations: run.evaluations, steps: run.steps, diverged_at_s })
}

struct Run<'a, const N: usize, const Z: usize, M: ?Sized, F, O> {
    mechanism: &'a M,
    friction: &'a [F; N],
    tolerance: f64,
    observer: &'a mut O,
    t: f64,
    state: BodyState<N, Z>,
    pieces: [u8; N],
    slip: [i8; N],
    /// Rates and frictions at `t`.
    now: StateRates<N, Z>,
    /// Largest magnitudes so far.
    size: BodyState<N, Z>,
    step_s: f64,
    /// The last instant of the smooth stretch that `t` is in.
    last_s: f64,
    evaluations: u64,
    steps: u64,
    zeno_guard: ZenoGuard,
}

/// The end of a piece inside a step.
#[derive(Clone, Copy)]
struct End {
    part: f64,
    body: usize,
    number: usize,
    left: Quartic,
    size: f64,
}

impl<const N: usize, const Z: usize, M, F, O> Run<'_, N, Z, M, F, O>
where
    M: Mechanism<N> + ?Sized,
    F: SingleValued<Z>,
    O: Observer<N>,
{
    /// Rates anew, after a jump of the forces or another piece, and what they make of sticking and
    /// slipping.
    fn refresh(&mut self) -> Result<(), SolverFailure> {
        self.now = self.rates(self.t, &self.state.clone());
        self.report_slips()?;
        self.sample(self.t, &self.state.clone(), &self.now.clone());
        Ok(())
    }

    fn rates(&mut self, t: f64, state: &BodyState<N, Z>) -> StateRates<N, Z> {
        self.evaluations += 1;
        rates_in(self.mechanism, self.friction, &self.pieces, t.min(self.last_s), state)
    }

    fn attempt(&mut self, h: f64) -> (BodyState<N, Z>, f64) {
        let reach = self.state.zip(&self.now.rates, |_, rate| (h * rate).abs());
        let scale =
            self.size.zip(&reach, |size, reach| self.tolerance * size.max(reach).max(1e-300));
        self.evaluations += EVALUATIONS;
        let (mechanism, friction, pieces, last_s) =
            (self.mechanism, self.friction, self.pieces, self.last_s);
        let rates = |t: f64, s: &BodyState<N, Z>| {
            rates_in(mechanism, friction, &pieces, t.min(last_s), s).rates
        };
        let attempt = step(rates, self.t, &self.state, &self.now.rates, h, &scale);
        (attempt.end, attempt.error)
    }

    /// One step, up to `end_s` at most or to the first end of a piece in it.
    fn step(&mut self, end_s: f64) -> Result<(), SolverFailure> {
        let remaining = end_s - self.t;
        let mut h = self.step_s.min(remaining);
        loop {
            if h < 4.0 * (self.t.next_up() - self.t) && h < remaining {
                return Err(self.trouble("the step underflows"));
            }
            let (end, error) = self.attempt(h);
            if error.is_nan() || error > 1.0 {
                h *= growth(error).min(0.9);
                self.step_s = h;
                continue;
            }
            let then = self.rates(self.t + h, &end);
            let Some(found) = self.first_end(h, &end, &then) else {
                let next = h * growth(error);
                self.step_s = if h < self.step_s { self.step_s.max(next) } else { next };
                let t = if h >= remaining { end_s } else { self.t + h };
                self.arrive(t, h, end, then)?;
                return self.report_slips();
            };
            let Some((part, end, then)) = self.locate(&found, h) else {
                h *= 0.5;
                continue;
            };
            self.arrive(self.t + part * h, part * h, end, then)?;
            let i = found.body;
            if self.state.v[i].abs() <= LOCATION_TOLERANCE * self.size.v[i] {
                self.state.v[i] = 0.0;
            }
            let v = self.state.v[i];
            self.pieces[i] =
                self.friction[i].next(self.pieces[i], found.number, v, &mut self.state.z[i]);
            return self.refresh();
        }
    }

    fn arrive(
        &mut self,
        t: f64,
        h: f64,
        end: BodyState<N, Z>,
        then: StateRates<N, Z>,
    ) -> Result<(), SolverFailure> {
        self.samples_between(t, h, &end, &then);
        (self.t, self.state, self.now) = (t, end, then);
        self.size = self.size.zip(&end, |size, x| size.max(x.abs()));
        self.sample(t, &end, &then);
        self.steps += 1;
        if self.steps > MAX_STEPS {
            return Err(self.trouble(&format!("more than {MAX_STEPS} steps")));
        }
        Ok(())
    }

    /// Reports bodies that started or stopped to slip.
    fn report_slips(&mut self) -> Result<(), SolverFailure> {
        for body in 0..N {
            let (v, z) = (self.state.v[body], &self.state.z[body]);
            let slips = self.friction[body].slips(self.pieces[body], v, z);
            // At the very instant at which a piece begins the velocity may be zero: it goes where
            // the piece does.
            let way = if v == 0.0 { direction(self.now.rates.v[body]) } else { direction(v) };
            let slip = if slips { way } else { 0 };
            let kind = match (self.slip[body], slip) {
                (before, after) if before == after => continue,
                (0, _) => EventKind::Break,
                (_, 0) => EventKind::Stick,
                _ => EventKind::Reverse,
            };
            self.slip[body] = slip;
            self.observer.event(BodyEvent { time_s: self.t, body, kind });
            self.zeno_guard.count(self.t).map_err(|what| self.trouble(&what))?;
        }
        Ok(())
    }

    /// The first end of a piece, as polynomials between the ends of the step see it.
    fn first_end(&self, h: f64, end: &BodyState<N, Z>, then: &StateRates<N, Z>) -> Option<End> {
        let mut first: Option<End> = None;
        let at = [0.25, 0.5, 0.75].map(|part| self.between(h, end, then, part));
        for body in 0..N {
            let ends = |s: &BodyState<N, Z>| {
                self.friction[body].ends(self.pieces[body], s.v[body], &s.z[body])
            };
            let nodes = [ends(&self.state), ends(&at[0]), ends(&at[1]), ends(&at[2]), ends(end)];
            for number in 0..2 {
                let values = nodes.map(|ends| ends[number]);
                if values.contains(&f64::INFINITY) {
                    continue;
                }
                let left = through(&values);
                if let Some(part) = first_falling_zero(&left)
                    && first.is_none_or(|first| part < first.part)
                {
                    let size = values.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
                    first = Some(End { part, body, number, left, size });
                }
            }
        }
        first
    }

    /// Integrates up to an end: part of the step, state, rates. None if it is not found.
    fn locate(&mut self, found: &End, h: f64) -> Option<(f64, BodyState<N, Z>, StateRates<N, Z>)> {
        let mut part = found.part;
        for _ in 0..8 {
            let end = if part > 0.0 { self.attempt(part * h).0 } else { self.state };
            let i = found.body;
            let left = self.friction[i].ends(self.pieces[i], end.v[i], &end.z[i])[found.number];
            let steep = slope(&found.left, part);
            if left.abs() <= LOCATION_TOLERANCE * found.size || (part == 0.0 && steep <= 0.0) {
                let then = self.rates(self.t + part * h, &end);
                return Some((part, end, then));
            }
            if steep >= 0.0 {
                return None;
            }
            part -= left / steep;
            if !(0.0..=1.0).contains(&part) {
                return None;
            }
        }
        None
    }

    /// The state after a part of a step.
    fn between(
        &self,
        h: f64,
        end: &BodyState<N, Z>,
        then: &StateRates<N, Z>,
        part: f64,
    ) -> BodyState<N, Z> {
        state_between(h, (&self.state, &self.now.rates), (end, &then.rates), part)
    }

    fn samples_between(
        &mut self,
        until_s: f64,
        h: f64,
        end: &BodyState<N, Z>,
        then: &StateRates<N, Z>,
    ) {
        while O::SAMPLES && self.observer.next_sample_s() <= until_s {
            let time_s = self.observer.next_sample_s();
            let state = self.between(h, end, then, (time_s - self.t) / h);
            // For the reader, not for the solution: not counted.
            let rates = rates_in(
                self.mechanism,
                self.friction,
                &self.pieces,
                time_s.min(self.last_s),
                &state,
            );
            self.sample(time_s, &state, &rates);
        }
    }

    fn sample(&mut self, time_s: f64, state: &BodyState<N, Z>, rates: &StateRates<N, Z>) {
        if O::SAMPLES {
            self.observer.sample(&BodySample {
                time_s,
                q: state.q,
                v: state.v,
                a: rates.rates.v,
                friction: rates.friction,
                slip: self.slip,
                z: state.deflections(),
            });
        }
    }

    fn trouble(&self, what: &str) -> SolverFailure {
        SolverFailure::new(what, self.t, &self.state.q, &self.state.v)
    }
}
