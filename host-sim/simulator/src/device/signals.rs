//! The signals of a device, as it announces them: this program has no table of its own.

use stiction::control::signal::{Form, SIGNALS, name};
use stiction::link::{Announced, MAX_SIGNALS, Sample};

use crate::error::{Error, suggestion};
use crate::output::Cell;

/// The signals of a loop that every live view shows, beside those of its law.
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

/// The signals of a tick that a device can send.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    all: Vec<Announced>,
}

impl Signals {
    /// Takes the signals that a device has announced, in the order of their places.
    pub const fn new(all: Vec<Announced>) -> Self {
        Self { all }
    }

    /// The signals that every loop of this version of the core has.
    pub fn of_core() -> Self {
        Self { all: SIGNALS.iter().map(|signal| Announced::from(*signal)).collect() }
    }

    /// The names of all signals, in the order of their places.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.all.iter().map(|signal| signal.name.as_str())
    }

    /// The names of the signals that only the law in use has.
    pub fn of_law(&self) -> impl Iterator<Item = &str> {
        self.names().filter(|name| SIGNALS.iter().all(|signal| signal.name != *name))
    }

    /// The sum of 1 << place of the named signals. Names that the device does not have are left
    /// out.
    pub fn mask<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> u64 {
        let places = names.into_iter().filter_map(|name| self.place(name));
        places.filter(|place| *place < MAX_SIGNALS).fold(0, |mask, place| mask | 1 << place)
    }

    /// The value of a signal in a sample, as a number; zero if the sample does not have it.
    pub fn number(&self, sample: &Sample, name: &str) -> f64 {
        let Some(place) = self.place(name) else { return 0.0 };
        let Some(bits) = sample.value(place) else { return 0.0 };
        match self.all.get(place).map(|signal| signal.form) {
            Some(Form::Number) => f64::from(f32::from_bits(bits)),
            Some(Form::Whole) => f64::from(bits as i32),
            Some(Form::Bits) | None => f64::from(bits),
        }
    }

    /// Whether the output was on in the tick of a sample; a sample without the status says nothing
    /// of it, and counts as one.
    pub fn is_armed(&self, sample: &Sample) -> bool {
        let place = self.place("status").and_then(|place| sample.value(place));
        place.is_none_or(|status| status & 0xFF == 2)
    }

    /// The value of a signal in a sample, as a cell of a file. A number is in single precision, as
    /// the device has it.
    pub fn cell(&self, sample: &Sample, name: &str) -> Cell {
        let number = self.number(sample, name);
        match self.place(name).and_then(|place| self.all.get(place)).map(|signal| signal.form) {
            Some(Form::Number) => Cell::from(number as f32),
            _ => Cell::from(number as i64),
        }
    }

    /// Refuses a name that the device has not announced.
    ///
    /// # Errors
    /// Names the nearest signal that there is.
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
