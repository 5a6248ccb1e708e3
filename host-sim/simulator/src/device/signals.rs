//! Signals of a device, as it announces them. This program has no table of its own.

use stiction::control::signal::{Form, SIGNALS, name};
use stiction::link::{MAX_SIGNALS, Sample, SignalDescription};

use crate::output::Cell;
use files::error::{Error, suggestion};

/// Signals of a loop in every live view, in addition to those of its law.
pub const OF_THE_LOOP: [&str; 11] = [
    name("counts"),
    name("reference_counts"),
    name("reference_fraction"),
    name("error"),
    name("velocity"),
    name("v_pd"),
    name("v_c"),
    name("v"),
    name("v_applied"),
    name("code"),
    name("status"),
];

/// Signals that a device can send in each tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    all: Vec<SignalDescription>,
}

impl Signals {
    /// Creates the list from the announced signals, in the order of their places.
    pub const fn new(all: Vec<SignalDescription>) -> Self {
        Self { all }
    }

    /// Returns the signals that every loop of this version of the core has.
    pub fn of_core() -> Self {
        Self { all: SIGNALS.iter().map(|signal| SignalDescription::from(*signal)).collect() }
    }

    /// Returns the names of all signals, in the order of their places.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.all.iter().map(|signal| signal.name.as_str())
    }

    /// Returns the names of the signals of the law in use.
    pub fn of_law(&self) -> impl Iterator<Item = &str> {
        self.names().filter(|name| SIGNALS.iter().all(|signal| signal.name != *name))
    }

    /// Returns the mask of the named signals: the sum of 1 << place. Names that the device does not
    /// have are skipped.
    pub fn mask<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> u64 {
        let places = names.into_iter().filter_map(|name| self.place(name));
        places.filter(|place| *place < MAX_SIGNALS).fold(0, |mask, place| mask | 1 << place)
    }

    /// Returns the value of a signal in a sample; zero if the sample does not have it.
    pub fn number(&self, sample: &Sample, name: &str) -> f64 {
        let Some(place) = self.place(name) else { return 0.0 };
        let Some(bits) = sample.value(place) else { return 0.0 };
        match self.all.get(place).map(|signal| signal.form) {
            Some(Form::Number) => f64::from(f32::from_bits(bits)),
            Some(Form::Whole) => f64::from(bits as i32),
            Some(Form::Bits) | None => f64::from(bits),
        }
    }

    /// Returns whether the output was on in the tick of a sample; true for a sample without status.
    pub fn is_armed(&self, sample: &Sample) -> bool {
        let place = self.place("status").and_then(|place| sample.value(place));
        place.is_none_or(|status| status & 0xFF == 2)
    }

    /// Returns the value of a signal in a sample as a cell of a file. A number is in single
    /// precision, as in the device.
    pub fn cell(&self, sample: &Sample, name: &str) -> Cell {
        let number = self.number(sample, name);
        match self.place(name).and_then(|place| self.all.get(place)).map(|signal| signal.form) {
            Some(Form::Number) => Cell::from(number as f32),
            _ => Cell::from(number as i64),
        }
    }

    /// Checks that the device has announced a signal.
    ///
    /// # Errors
    /// Returns an error that names the most similar signal.
    pub fn check(&self, name: &str) -> Result<(), Error> {
        match self.place(name) {
            Some(_) => Ok(()),
            None => {
                let near = suggestion(name, self.names());
                Err(Error::Input(format!(
                    "--signals {name}: the device has no signal `{name}`{near}"
                )))
            }
        }
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.names().position(|known| known == name)
    }
}
