//! While at least one body slips: a step, and the first switch in it.

use super::super::dense_output::DenseOutput;
use super::super::dormand_prince::{EVALUATIONS, TrialStep, growth, step};
use super::super::state::{BodySample, BodyState, Observer};
use super::{BEYOND, Run, SolverFailure};
use dynamics::friction::SetValued;
use dynamics::mechanism::Mechanism;
use dynamics::solver::modes::{BodyMode, accelerations};
use dynamics::solver::roots::{Quartic, first_falling_zero, slope, through};

/// A velocity is zero, a reaction at its limit, if off by no more than this part of its size.
const LOCATION_TOLERANCE: f64 = 1e-12;

/// Something that happens inside a step.
#[derive(Clone, Copy, Debug)]
struct Switch {
    /// Part of the step that is done by then, as far as the polynomial knows.
    part: f64,
    body: usize,
    /// The sign of the reaction of a body that breaks away; 0 for one that comes to a halt.
    breaks: i8,
    /// What falls through zero.
    left: Quartic,
}

impl<const N: usize, M, F, O> Run<'_, N, M, F, O>
where
    M: Mechanism<N> + ?Sized,
    F: SetValued,
    O: Observer<N>,
{
    /// One step, up to `end_s` at most or to the first switch in it.
    pub(super) fn slip(&mut self, end_s: f64) -> Result<(), SolverFailure> {
        let remaining = end_s - self.t;
        let mut h = self.step_s.min(remaining);
        loop {
            if h < 4.0 * (self.t.next_up() - self.t) && h < remaining {
                return Err(self.trouble("the step underflows"));
            }
            let attempt = self.attempt(h);
            if attempt.error.is_nan() || attempt.error > 1.0 {
                h *= growth(attempt.error).min(0.9);
                self.step_s = h;
                continue;
            }
            let end = attempt.end;
            let (a, forces) = self.instant(self.t + h, &end.q, &end.v);
            let between = DenseOutput::new(h, (&self.q, &self.v, &self.a), (&end.q, &end.v, &a));
            let Some(switch) = self.first_switch(&between, &forces) else {
                // A step that an end or a switch cut short says nothing about a longer one.
                let next = h * growth(attempt.error);
                self.step_s = if h < self.step_s { self.step_s.max(next) } else { next };
                let t = if h >= remaining { end_s } else { self.t + h };
                self.samples_between(&between, t);
                return self.arrive(t, &end, a, forces);
            };
            let Some((part, end, a, forces)) = self.locate(&switch, h) else {
                // The polynomial saw what is not there, or not quite: it sees better in a shorter
                // step.
                h *= 0.5;
                continue;
            };
            let between =
                DenseOutput::new(part * h, (&self.q, &self.v, &self.a), (&end.q, &end.v, &a));
            let t = self.t + part * h;
            self.samples_between(&between, t);
            self.arrive(t, &end, a, forces)?;
            let mut breaking: BodyMode<N> = [0; N];
            if switch.breaks == 0 {
                self.v[switch.body] = 0.0;
            }
            breaking[switch.body] = switch.breaks;
            // Others that halt at the same instant.
            for i in 0..N {
                let ahead = f64::from(self.mode[i]);
                if self.mode[i] != 0
                    && ahead * self.v[i] <= LOCATION_TOLERANCE * self.size_v[i]
                    && ahead * self.a[i] < 0.0
                {
                    self.v[i] = 0.0;
                }
            }
            return self.switch(breaking);
        }
    }

    fn arrive(
        &mut self,
        t: f64,
        end: &BodyState<N, 0>,
        a: [f64; N],
        forces: [f64; N],
    ) -> Result<(), SolverFailure> {
        (self.t, self.q, self.v, self.a, self.forces) = (t, end.q, end.v, a, forces);
        for i in 0..N {
            self.size_q[i] = self.size_q[i].max(self.q[i].abs());
            self.size_v[i] = self.size_v[i].max(self.v[i].abs());
        }
        self.sample();
        self.count_step()
    }

    #[inline]
    fn attempt(&mut self, h: f64) -> TrialStep<N, 0> {
        let mut scale = BodyState::ZERO;
        for i in 0..N {
            // The first step of a body has nothing to be relative to but itself.
            let (v, a) = (self.v[i].abs(), self.a[i].abs());
            scale.q[i] =
                self.tolerance * self.size_q[i].max(h * (v + h * a)).max(f64::MIN_POSITIVE);
            scale.v[i] = self.tolerance * self.size_v[i].max(h * a).max(f64::MIN_POSITIVE);
        }
        let from = BodyState { q: self.q, v: self.v, z: [[]; N] };
        let first = BodyState { q: self.v, v: self.a, z: [[]; N] };
        self.evaluations += EVALUATIONS;
        let (mechanism, friction, mode, last_s) =
            (self.mechanism, self.friction, self.mode, self.last_s);
        let rates = |t: f64, s: &BodyState<N, 0>| {
            let terms = mechanism.terms(t.min(last_s), &s.q, &s.v);
            let (a, _) = accelerations(&terms, friction, &s.v, &mode);
            BodyState { q: s.v, v: a, z: [[]; N] }
        };
        step(rates, self.t, &from, &first, h, &scale)
    }

    /// Accelerations and frictions.
    fn instant(&mut self, t: f64, q: &[f64; N], v: &[f64; N]) -> ([f64; N], [f64; N]) {
        let terms = self.terms(t, q, v);
        accelerations(&terms, self.friction, v, &self.mode)
    }

    /// The first switch in a step, as its polynomials see it.
    fn first_switch(
        &mut self,
        between: &DenseOutput<N>,
        forces_at_end: &[f64; N],
    ) -> Option<Switch> {
        let mut first: Option<Switch> = None;
        let mut consider = |body: usize, breaks: i8, left: Quartic| {
            if let Some(part) = first_falling_zero(&left)
                && first.is_none_or(|first| part < first.part)
            {
                first = Some(Switch { part, body, breaks, left });
            }
        };
        for i in 0..N {
            if self.mode[i] != 0 {
                consider(i, 0, between.v[i].map(|c| f64::from(self.mode[i]) * c));
            }
        }
        if self.mode.contains(&0) {
            let mut reactions = [self.forces; 5];
            for (node, part) in [0.25, 0.5, 0.75].into_iter().enumerate() {
                let (q, v) = between.at(part);
                reactions[node + 1] = self.instant(self.t + part * between.h, &q, &v).1;
            }
            reactions[4] = *forces_at_end;
            for i in 0..N {
                if self.mode[i] == 0 {
                    for sign in [1_i8, -1] {
                        let limit = self.friction[i].stick();
                        consider(
                            i,
                            sign,
                            through(&reactions.map(|r| limit - f64::from(sign) * r[i])),
                        );
                    }
                }
            }
        }
        first
    }

    /// Integrates up to a switch, and there: part of the step, state, accelerations, frictions.
    /// None if it is not found.
    #[allow(clippy::type_complexity)]
    fn locate(
        &mut self,
        switch: &Switch,
        h: f64,
    ) -> Option<(f64, BodyState<N, 0>, [f64; N], [f64; N])> {
        let i = switch.body;
        let mut part = switch.part;
        for _ in 0..8 {
            let end = if part > 0.0 {
                self.attempt(part * h).end
            } else {
                BodyState { q: self.q, v: self.v, z: [[]; N] }
            };
            let (a, forces) = self.instant(self.t + part * h, &end.q, &end.v);
            let (left, size) = if switch.breaks == 0 {
                (f64::from(self.mode[i]) * end.v[i], self.size_v[i].max(end.v[i].abs()))
            } else {
                let limit = BEYOND * self.friction[i].stick();
                (limit - f64::from(switch.breaks) * forces[i], limit)
            };
            // Near zero on its way up is no halt: a motion that begins in nothing, over whose
            // growth the polynomial swings.
            if switch.breaks == 0
                && left.abs() <= LOCATION_TOLERANCE * size
                && f64::from(self.mode[i]) * a[i] > 0.0
            {
                return None;
            }
            if left.abs() <= LOCATION_TOLERANCE * size {
                return Some((part, end, a, forces));
            }
            let steep = slope(&switch.left, part);
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

    fn samples_between(&mut self, between: &DenseOutput<N>, until_s: f64) {
        if !O::SAMPLES {
            return;
        }
        loop {
            let time_s = self.observer.next_sample_s();
            if time_s > until_s {
                return;
            }
            let (q, v) = between.at((time_s - self.t) / between.h);
            // For the reader, not for the solution: not counted.
            let terms = self.mechanism.terms(time_s.min(self.last_s), &q, &v);
            let (a, friction) = accelerations(&terms, self.friction, &v, &self.mode);
            self.observer.sample(&BodySample {
                time_s,
                q,
                v,
                a,
                friction,
                slip: self.mode,
                z: [0.0; N],
            });
        }
    }
}
