//! State of a mechanism with friction, and the samples and events that solvers report.

use dynamics::solver::EventKind;

/// Coordinates, their velocities, and `Z` internal states of each friction; also the rates of all
/// these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState<const N: usize, const Z: usize> {
    /// Coordinates.
    pub q: [f64; N],
    /// Velocities.
    pub v: [f64; N],
    /// States of the frictions.
    pub z: [[f64; Z]; N],
}

impl<const N: usize, const Z: usize> BodyState<N, Z> {
    /// The state in which every component is zero.
    pub const ZERO: Self = Self { q: [0.0; N], v: [0.0; N], z: [[0.0; Z]; N] };

    /// Returns `self + factor * rate`.
    #[inline(always)]
    pub fn plus(mut self, factor: f64, rate: &Self) -> Self {
        for i in 0..N {
            self.q[i] += factor * rate.q[i];
            self.v[i] += factor * rate.v[i];
            for j in 0..Z {
                self.z[i][j] += factor * rate.z[i][j];
            }
        }
        self
    }

    /// Applies `f` to each component of this state and the same component of the other, and returns
    /// the state of the results.
    #[inline(always)]
    pub fn zip(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = Self::ZERO;
        for i in 0..N {
            out.q[i] = f(self.q[i], other.q[i]);
            out.v[i] = f(self.v[i], other.v[i]);
            for j in 0..Z {
                out.z[i][j] = f(self.z[i][j], other.z[i][j]);
            }
        }
        out
    }

    /// Returns all components: those of `q`, of `v`, and of `z`.
    pub fn components(&self) -> impl Iterator<Item = f64> {
        self.q.iter().chain(&self.v).chain(self.z.iter().flatten()).copied()
    }

    /// Returns the first state of each friction; zero for a friction without states.
    pub fn deflections(&self) -> [f64; N] {
        self.z.each_ref().map(|z| z.first().copied().unwrap_or(0.0))
    }

    /// Returns whether every component is finite.
    pub fn is_finite(&self) -> bool {
        self.components().all(f64::is_finite)
    }
}

/// A mechanism at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodySample<const N: usize> {
    /// Time, s.
    pub time_s: f64,
    /// Coordinates.
    pub q: [f64; N],
    /// Velocities.
    pub v: [f64; N],
    /// Accelerations.
    pub a: [f64; N],
    /// Frictions; at rest the one that holds the body.
    pub friction: [f64; N],
    /// 0 where a body sticks, else the sign of its slip.
    pub slip: [i8; N],
    /// The first state of each friction, its deflection; zero of one that has none.
    pub z: [f64; N],
}

/// Change of a body's motion: it breaks away, sticks, or reverses without rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyEvent {
    /// Time since the start of the run, s.
    pub time_s: f64,
    /// Number of the body, from 0.
    pub body: usize,
    /// Kind of the change.
    pub kind: EventKind,
}

/// Receiver of the samples and events of a solver.
pub trait Observer<const N: usize> {
    /// Whether [`Self::sample`] is to be called at all.
    const SAMPLES: bool = true;

    /// The next instant at which a sample is wanted, s; samples come at steps and on both sides of
    /// events as well.
    fn next_sample_s(&self) -> f64 {
        f64::INFINITY
    }

    /// The mechanism at an instant; times never decrease.
    fn sample(&mut self, sample: &BodySample<N>);

    /// A change of a body, in order of time.
    fn event(&mut self, event: BodyEvent);
}

/// Events and nothing else.
impl<const N: usize> Observer<N> for Vec<BodyEvent> {
    const SAMPLES: bool = false;

    fn sample(&mut self, _: &BodySample<N>) {}

    fn event(&mut self, event: BodyEvent) {
        self.push(event);
    }
}

/// End of a run, and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finish<const N: usize> {
    /// Coordinates at the end.
    pub q: [f64; N],
    /// Velocities at the end.
    pub v: [f64; N],
    /// How often the accelerations were computed.
    pub evaluations: u64,
    /// Steps that were kept.
    pub steps: u64,
    /// Time at which a state was no longer finite, s; the run ends there.
    pub diverged_at_s: Option<f64>,
}
