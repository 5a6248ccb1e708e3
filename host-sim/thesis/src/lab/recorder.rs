//! What is kept of a run: samples, events and what it is judged by.

use indicatif::ProgressBar;
use serde::Serialize;

use dynamics::mechanism::Mechanism;
use dynamics::solver::EventKind;
use friction_lab::solver::state::{BodyEvent, BodySample, Finish, Observer};

/// Samples of a run that lie evenly; those on both sides of events come on top. The Reset
/// Integrator's oscillation on the thesis's spring has a period of 13 ms in 5 s: 25 samples.
pub const EVEN_SAMPLES: u64 = 10_000;

/// Events of a run that are kept with their samples; a chattering run has more.
const MOST_ROWS: usize = 200_000;

/// The bodies at one instant, m or rad, N or N m.
#[derive(Clone, Debug)]
pub struct LabSample {
    /// Time, s.
    pub time_s: f64,
    /// Positions of the bodies.
    pub position: Vec<f64>,
    /// Velocities of the bodies.
    pub velocity: Vec<f64>,
    /// Accelerations of the bodies.
    pub acceleration: Vec<f64>,
    /// The force that friction and inertia balance, on each coordinate: the thesis's F_i.
    pub input: Vec<f64>,
    /// Friction on each coordinate.
    pub friction: Vec<f64>,
    /// The first state of each friction, such as p of the Reset Integrator; zero without one.
    pub deflection: Vec<f64>,
    /// Whether each friction sticks.
    pub stuck: Vec<bool>,
}

/// What a run is judged by; each an entry a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LabMetrics {
    /// Position of each body at the end.
    pub final_position: Vec<f64>,
    /// Velocity of each body at the end.
    pub final_velocity: Vec<f64>,
    /// Largest magnitude of the velocity of each body.
    pub max_speed: Vec<f64>,
    /// Largest magnitude of each friction.
    pub peak_friction: Vec<f64>,
    /// How often each body broke away.
    pub breaks: Vec<u64>,
}

/// Listens to a solver.
pub struct Recorder<'a, const N: usize> {
    mechanism: &'a dyn Mechanism<N>,
    /// Goes on by one at each even sample.
    bar: &'a ProgressBar,
    interval_s: f64,
    next: u64,
    last: Option<BodySample<N>>,
    last_is_kept: bool,
    pub rows: Vec<LabSample>,
    pub events: Vec<BodyEvent>,
    breaks: [u64; N],
    max_speed: [f64; N],
    peak_friction: [f64; N],
}

impl<'a, const N: usize> Recorder<'a, N> {
    pub fn new(mechanism: &'a dyn Mechanism<N>, duration_s: f64, bar: &'a ProgressBar) -> Self {
        Self {
            mechanism,
            bar,
            interval_s: duration_s / EVEN_SAMPLES as f64,
            next: 0,
            last: None,
            last_is_kept: false,
            rows: Vec::new(),
            events: Vec::new(),
            breaks: [0; N],
            max_speed: [0.0; N],
            peak_friction: [0.0; N],
        }
    }

    /// The metrics of a run that ended.
    pub fn metrics(&self, finish: &Finish<N>) -> LabMetrics {
        LabMetrics {
            final_position: self.mechanism.bodies(&finish.q).to_vec(),
            final_velocity: self.mechanism.bodies(&finish.v).to_vec(),
            max_speed: self.max_speed.to_vec(),
            peak_friction: self.peak_friction.to_vec(),
            breaks: self.breaks.to_vec(),
        }
    }

    fn keep(&mut self, sample: &BodySample<N>) {
        let mass = self.mechanism.terms(sample.time_s, &sample.q, &sample.v).mass;
        let input = (0..N).map(|i| {
            let inertia: f64 = mass[i].iter().zip(&sample.a).map(|(m, a)| m * a).sum();
            inertia + sample.friction[i]
        });
        self.rows.push(LabSample {
            time_s: sample.time_s,
            position: self.mechanism.bodies(&sample.q).to_vec(),
            velocity: self.mechanism.bodies(&sample.v).to_vec(),
            acceleration: self.mechanism.bodies(&sample.a).to_vec(),
            input: input.collect(),
            friction: sample.friction.to_vec(),
            deflection: sample.z.to_vec(),
            stuck: sample.slip.iter().map(|slip| *slip == 0).collect(),
        });
    }

    /// The largest speeds between two samples, velocities taken as cubic there.
    fn peaks_between(&mut self, from: &BodySample<N>, to: &BodySample<N>) {
        let h = to.time_s - from.time_s;
        let bodies = |x: &[f64; N]| self.mechanism.bodies(x);
        let (v0, a0, v1, a1) = (bodies(&from.v), bodies(&from.a), bodies(&to.v), bodies(&to.a));
        for i in 0..N {
            let (p0, p1) = (h * a0[i], h * a1[i]);
            self.max_speed[i] = self.max_speed[i].max(v1[i].abs());
            if h <= 0.0 || p0 * p1 >= 0.0 || from.slip != to.slip {
                continue;
            }
            let rise = v1[i] - v0[i];
            let (c2, c3) = (3.0 * rise - 2.0 * p0 - p1, p0 + p1 - 2.0 * rise);
            // The slope p0 + 2 c2 x + 3 c3 x^2 changes its sign once in between.
            let root = (c2 * c2 - 3.0 * c3 * p0).max(0.0).sqrt();
            let places = [-p0 / (c2 + root), -p0 / (c2 - root)];
            if let Some(x) = places.into_iter().find(|x| (0.0..=1.0).contains(x)) {
                let v = v0[i] + x * (p0 + x * (c2 + x * c3));
                self.max_speed[i] = self.max_speed[i].max(v.abs());
            }
        }
    }
}

impl<const N: usize> Observer<N> for Recorder<'_, N> {
    fn next_sample_s(&self) -> f64 {
        self.next as f64 * self.interval_s
    }

    fn sample(&mut self, sample: &BodySample<N>) {
        for i in 0..N {
            self.peak_friction[i] = self.peak_friction[i].max(sample.friction[i].abs());
        }
        let switched = match self.last {
            Some(last) => {
                self.peaks_between(&last, sample);
                let switched =
                    last.slip != sample.slip || last.time_s == sample.time_s && last != *sample;
                if switched && !self.last_is_kept && self.rows.len() < MOST_ROWS {
                    self.keep(&last);
                }
                switched
            }
            None => true,
        };
        let due = sample.time_s >= self.next_sample_s();
        self.last_is_kept = due || switched && self.rows.len() < MOST_ROWS;
        if self.last_is_kept {
            self.keep(sample);
        }
        // A step may be longer than the interval.
        while sample.time_s >= self.next_sample_s() {
            self.next += 1;
            self.bar.inc(1);
        }
        self.last = Some(*sample);
    }

    fn event(&mut self, event: BodyEvent) {
        if event.kind == EventKind::Break {
            self.breaks[event.body] += 1;
        }
        self.events.push(event);
    }
}
