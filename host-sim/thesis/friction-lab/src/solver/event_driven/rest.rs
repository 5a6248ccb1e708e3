//! While all bodies stick: when does the first reaction reach its limit?
//!
//! Positions stay, velocities are zero, so each reaction is a function of time alone: the force on
//! its coordinate. It is taken as a polynomial through five values over a stretch that is halved
//! until two more values agree with it.

use super::super::state::{BodySample, Observer};
use super::{BEYOND, Run, SolverFailure};
use dynamics::friction::SetValued;
use dynamics::mechanism::Mechanism;
use dynamics::solver::modes::{BodyMode, accelerations};
use dynamics::solver::roots::{Quartic, first_falling_zero, slope, through, value};

/// How far polynomial and force may differ, as a part of the largest friction at rest, where the
/// limit is far: it only has to see that.
const AGREEMENT: f64 = 1e-4;

/// From this part of the limit on, the polynomial decides whether a body breaks away at all, and
/// has to be as good as the answer: a hundredth of the tolerance.
const NEAR: f64 = 0.99;

/// Points of a stretch at which a polynomial is looked at for [`NEAR`].
const LOOKS: u32 = 16;

impl<const N: usize, M, F, O> Run<'_, N, M, F, O>
where
    M: Mechanism<N> + ?Sized,
    F: SetValued,
    O: Observer<N>,
{
    /// Up to `end_s`, or to the first body that breaks away.
    pub(super) fn rest(&mut self, end_s: f64) -> Result<(), SolverFailure> {
        let mut stretch = end_s - self.t;
        while self.t < end_s {
            self.count_step()?;
            let to_end = stretch >= end_s - self.t;
            stretch = stretch.min(end_s - self.t);
            let Some(reactions) = self.reactions(stretch) else {
                stretch = self.shorter(
                    stretch,
                    "the force on bodies at rest jumps where no corner is \
                        named",
                )?;
                continue;
            };
            if let Some((part, body, sign)) = self.first_break(&reactions) {
                let Some(broken_s) = self.locate_break(&reactions[body], part, stretch, body, sign)
                else {
                    // The polynomial saw what is not there, or not quite: it sees better in a
                    // shorter stretch.
                    stretch = self.shorter(
                        stretch,
                        "the instant at which a body breaks away is not \
                            found",
                    )?;
                    continue;
                };
                self.wait(broken_s);
                let mut breaking: BodyMode<N> = [0; N];
                breaking[body] = sign;
                return self.switch(breaking);
            }
            let reached_s = if to_end { end_s } else { self.t + stretch };
            self.wait(reached_s);
            stretch *= 2.0;
        }
        Ok(())
    }

    /// Half of a stretch.
    fn shorter(&self, stretch: f64, what: &str) -> Result<f64, SolverFailure> {
        if 0.5 * stretch < 4.0 * (self.t.next_up() - self.t) {
            return Err(self.trouble(what));
        }
        Ok(0.5 * stretch)
    }

    fn force_at(&mut self, t: f64) -> [f64; N] {
        let q = self.q;
        self.terms(t, &q, &[0.0; N]).force
    }

    /// The reactions as polynomials over a stretch of time, if such polynomials they are.
    fn reactions(&mut self, stretch: f64) -> Option<[Quartic; N]> {
        let t = self.t;
        let nodes = [0.0, 0.25, 0.5, 0.75, 1.0].map(|part| self.force_at(t + part * stretch));
        let polynomials: [Quartic; N] =
            std::array::from_fn(|i| through(&nodes.map(|force| force[i])));
        let looks = (0..=LOOKS).map(|k| f64::from(k) / f64::from(LOOKS));
        let is_near = looks.into_iter().any(|part| {
            (0..N).any(|i| value(&polynomials[i], part).abs() > NEAR * self.friction[i].stick())
        });
        let agreement = if is_near { self.agreement() } else { AGREEMENT };
        let agrees = [0.1, 0.6].into_iter().all(|part| {
            let force = self.force_at(t + part * stretch);
            (0..N).all(|i| {
                (value(&polynomials[i], part) - force[i]).abs()
                    <= agreement * self.friction[i].stick()
            })
        });
        agrees.then_some(polynomials)
    }

    /// Part of the stretch, body and sign of the first break.
    fn first_break(&self, reactions: &[Quartic; N]) -> Option<(f64, usize, i8)> {
        let mut first: Option<(f64, usize, i8)> = None;
        for (body, reaction) in reactions.iter().enumerate() {
            for sign in [1_i8, -1] {
                let mut left = reaction.map(|c| -f64::from(sign) * c);
                left[0] += self.friction[body].stick();
                if let Some(part) = first_falling_zero(&left)
                    && first.is_none_or(|(earliest, ..)| part < earliest)
                {
                    first = Some((part, body, sign));
                }
            }
        }
        first
    }

    /// The instant at which the force itself reaches the limit: by Newton with the polynomial's
    /// slope, between instants at which it is known to be below and above. None if the force is not
    /// where the polynomial has it.
    fn locate_break(
        &mut self,
        reaction: &Quartic,
        part: f64,
        stretch: f64,
        body: usize,
        sign: i8,
    ) -> Option<f64> {
        let limit = BEYOND * self.friction[body].stick();
        let sign = f64::from(sign);
        let (mut part, mut below, mut above) = (part, 0.0, None);
        let mut nearest = (f64::NEG_INFINITY, part);
        for _ in 0..60 {
            let at_s = self.t + part * stretch;
            let over = sign * self.force_at(at_s)[body] - limit;
            let steep = sign * slope(reaction, part);
            // Closer than the rounding errors of force and time.
            let ulp = (at_s.next_up() - at_s) / stretch;
            if over.abs() <= 4.0 * f64::EPSILON * limit + steep.abs() * ulp {
                return Some(at_s);
            }
            if over < 0.0 {
                nearest = if over > nearest.0 { (over, part) } else { nearest };
                below = part.max(below);
            } else {
                above = Some(part);
            }
            let newton = part - over / steep;
            part = match above {
                _ if below < newton && newton < above.unwrap_or(1.0) => newton,
                Some(above) => 0.5 * (below + above),
                // A force that only just reaches its limit, or would a hair later.
                None => break,
            };
        }
        let missing = (self.agreement() + BEYOND - 1.0) * limit;
        (above.is_none() && nearest.0 >= -missing).then_some(self.t + nearest.1 * stretch)
    }

    /// How far the polynomial and the force may differ where the limit is near.
    fn agreement(&self) -> f64 {
        (1e-2 * self.tolerance).max(1e-12)
    }

    /// Lets time pass.
    fn wait(&mut self, until_s: f64) {
        while O::SAMPLES && self.observer.next_sample_s() < until_s {
            self.sample_at_rest(self.observer.next_sample_s());
        }
        self.sample_at_rest(until_s);
        self.t = until_s;
    }

    fn sample_at_rest(&mut self, time_s: f64) {
        if O::SAMPLES {
            // For the reader, not for the solution: not counted.
            let terms = self.mechanism.terms(time_s.min(self.last_s), &self.q, &[0.0; N]);
            let (a, friction) = accelerations(&terms, self.friction, &self.v, &self.mode);
            self.observer.sample(&BodySample {
                time_s,
                q: self.q,
                v: self.v,
                a,
                friction,
                slip: self.mode,
                z: [0.0; N],
            });
        }
    }
}
