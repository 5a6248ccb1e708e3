//! Laws in Python: a callable that makes the controller of a joint.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;

use files::error::Error;
use simulator::guest::{Controller, GuestLaw, JointFacts, Sample, find, register, release};
use simulator::rules::GainRule;

/// A joint as the built-in laws know it, in SI and the unit of its drive's effort.
#[pyclass(frozen, get_all)]
pub struct LawJoint {
    sample_time: f64,
    count: f64,
    largest_effort: f64,
    effort_step: f64,
    inertia: f64,
    viscous: f64,
    breakaway_low: f64,
    breakaway_high: f64,
    load: f64,
    hold_effort: f64,
    jitter: f64,
    encoder_at_load: bool,
}

impl LawJoint {
    fn of(joint: &JointFacts) -> Self {
        Self {
            sample_time: joint.sample_time,
            count: joint.count,
            largest_effort: joint.largest_effort,
            effort_step: joint.effort_step,
            inertia: joint.inertia,
            viscous: joint.viscous,
            breakaway_low: joint.breakaway_low,
            breakaway_high: joint.breakaway_high,
            load: joint.load,
            hold_effort: joint.hold_effort,
            jitter: joint.jitter,
            encoder_at_load: joint.encoder_at_load,
        }
    }
}

/// One tick of a law.
#[pyclass(frozen, get_all)]
pub struct LawSample {
    counts: i32,
    target_counts: f64,
    error: f64,
    velocity: f64,
    target_velocity: f64,
    target_acceleration: f64,
    applied: f64,
    saturated: bool,
}

/// Name, version and callable of a law.
pub type NamedLaw = (String, String, Py<PyAny>);

struct PythonLaw {
    name: String,
    version: String,
    law: Py<PyAny>,
    raised: Arc<Raised>,
}

struct PythonController {
    tick: Py<PyAny>,
    raised: Arc<Raised>,
}

/// First exception of a law.
#[derive(Default)]
pub struct Raised(Mutex<Option<PyErr>>);

impl Raised {
    /// Keeps the first exception, and returns its text.
    fn keep(&self, py: Python<'_>, raised: PyErr) -> String {
        let text = raised.value(py).to_string();
        let name = raised.get_type(py).name().map_or_else(|_| String::new(), |one| one.to_string());
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(raised);
        format!("{name}: {text}")
    }

    /// Returns an exception with the first one of the law as its cause.
    pub fn cause_of(&self, py: Python<'_>, error: PyErr) -> PyErr {
        let cause = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        if cause.is_some() {
            error.set_cause(py, cause);
        }
        error
    }
}

/// Laws that run until this is dropped.
pub struct Registered {
    /// Their rules.
    pub rules: Vec<&'static GainRule>,
    /// Their first exception.
    pub raised: Arc<Raised>,
}

impl Registered {
    /// Registers laws.
    ///
    /// # Errors
    /// Returns an error if a name is that of a built-in law, or is there twice.
    pub fn new(laws: Vec<NamedLaw>) -> Result<Self, Error> {
        let mut all = Self { rules: Vec::new(), raised: Arc::default() };
        for (name, version, law) in laws {
            if all.rules.iter().any(|rule| rule.law == name) {
                return Err(Error::Input(format!("--law: a second law is called `{name}`")));
            }
            let raised = Arc::clone(&all.raised);
            all.rules.push(register(Arc::new(PythonLaw { name, version, law, raised }))?);
        }
        Ok(all)
    }
}

impl Registered {
    /// Registers laws that a file finds by their names.
    ///
    /// # Errors
    /// As [`new`](Self::new); also if another thread runs a law of that name.
    pub fn by_name(laws: Vec<NamedLaw>) -> Result<Self, Error> {
        if let Some((name, ..)) = laws.iter().find(|(name, ..)| find(name).is_some()) {
            let why = "another thread runs a law of that name; give one of them another name";
            return Err(Error::Input(format!("law {name}: {why}")));
        }
        Self::new(laws)
    }

    /// Returns the names of the laws.
    pub fn names(&self) -> Vec<String> {
        self.rules.iter().map(|rule| rule.law.to_owned()).collect()
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        self.rules.iter().for_each(|rule| release(rule));
    }
}

impl GuestLaw for PythonLaw {
    fn name(&self) -> &str {
        &self.name
    }

    fn version(&self) -> &str {
        &self.version
    }

    fn following_error(&self, joint: &JointFacts) -> f64 {
        let of = |py: Python<'_>| {
            let law = self.law.bind(py);
            match law.getattr_opt("following_error")? {
                Some(function) => function.call1((LawJoint::of(joint),))?.extract(),
                None => Ok(0.0),
            }
        };
        Python::attach(|py| {
            of(py).unwrap_or_else(|raised| {
                self.raised.keep(py, raised);
                f64::NAN
            })
        })
    }

    fn start(&self, joint: &JointFacts) -> Result<Box<dyn Controller>, String> {
        Python::attach(|py| {
            let tick = self
                .law
                .call1(py, (LawJoint::of(joint),))
                .map_err(|raised| self.raised.keep(py, raised))?;
            Ok(Box::new(PythonController { tick, raised: Arc::clone(&self.raised) }) as _)
        })
    }

    /// Takes the interpreter's lock for the whole case: threads that hand it on in each tick would
    /// be slower than one.
    fn around_case(&self, case: &mut dyn FnMut()) {
        Python::attach(|_| case());
    }
}

impl Controller for PythonController {
    fn tick(&mut self, sample: &Sample) -> Result<f64, String> {
        let sample = LawSample {
            counts: sample.counts,
            target_counts: sample.target_counts,
            error: sample.error,
            velocity: sample.velocity,
            target_velocity: sample.target_velocity,
            target_acceleration: sample.target_acceleration,
            applied: sample.applied,
            saturated: sample.saturated,
        };
        Python::attach(|py| {
            let effort = self.tick.call1(py, (sample,)).and_then(|effort| effort.extract(py));
            effort.map_err(|raised| self.raised.keep(py, raised))
        })
    }
}
