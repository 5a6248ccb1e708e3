//! Declarations of the core for the tables of a file.

use stiction::control::brake_resistor::BrakeResistor;
use stiction::control::current_sensor::CurrentSensor;
use stiction::control::drive::DriveConfig;
use stiction::control::encoder::Encoder;
use stiction::control::laws::{Gains, RobustDualGains};
use stiction::control::motor_encoder::MotorEncoder;
use stiction::control::motor_ntc::MotorNtc;
use stiction::control::pd::PdGains;
use stiction::motion::jog::JogBounds;
use stiction::parameters::DeviceConfig;
use stiction::units::value::{About, Absent, Table, Values};
use stiction::{Allowed, ControllerConfig, Limits, ProfileLimits};

use super::{FileScalar, scalar};

/// The declarations of a table of the file.
pub trait DeclaredTable {
    /// Returns the declarations of all values of the table.
    fn about() -> Vec<&'static About>;

    /// Returns whether a value is required.
    fn needs(about: &About) -> bool {
        about.absent == Absent::Needed
    }

    /// Returns the default of a value, if it does not depend on other values.
    fn otherwise(about: &About) -> Option<FileScalar>;

    /// Returns whether a missing value is written with its default, given the other values of the
    /// table.
    fn belongs(_: &About, _has: &dyn Fn(&str) -> bool) -> bool {
        true
    }

    /// Returns the allowed values, given the other values of the example.
    fn allowed(about: &About) -> Option<Allowed>;

    /// Returns the laws that need a value; laws of the host are marked.
    fn laws(_: &About) -> Vec<String> {
        vec![]
    }
}

macro_rules! declared {
    ($($table:ty),+) => {
        $(impl DeclaredTable for $table {
            fn about() -> Vec<&'static About> {
                <$table as Table>::ABOUT.iter().collect()
            }

            fn allowed(about: &About) -> Option<Allowed> {
                <$table as Table>::EXAMPLE.allowed(about.key)
            }

            fn otherwise(about: &About) -> Option<FileScalar> {
                let bits = <$table as Table>::EXAMPLE.get(about.key)?;
                (about.absent == Absent::Default).then(|| scalar(about.kind, bits))
            }
        })+
    };
}

declared!(
    ControllerConfig,
    Encoder,
    MotorEncoder,
    DriveConfig,
    DeviceConfig,
    Limits,
    ProfileLimits,
    JogBounds,
    CurrentSensor,
    BrakeResistor,
    MotorNtc
);

/// Returns the name of a law, with a mark if it runs on the host only.
pub(crate) fn shown(law: &Gains) -> String {
    let name = law.name();
    if law.on_the_device() { name.into() } else { format!("{name} (on the host only)") }
}

/// `[controller.NAME]`: the gains of PD and of every law. Those of PD are required; the listed laws
/// determine which others are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllGains;

/// Returns the laws that a file can name, with the declarations of their gains. The last one is the
/// law for two encoders, whose name in a file is `robust` as well.
pub fn laws() -> impl Iterator<Item = (Gains, &'static [About])> {
    let listed = Gains::EXAMPLES.iter().copied().zip(Gains::ABOUT.iter().copied());
    listed.chain([(Gains::RobustDual(RobustDualGains::EXAMPLE), RobustDualGains::ABOUT)])
}

impl DeclaredTable for AllGains {
    fn about() -> Vec<&'static About> {
        let mut all: Vec<&About> = PdGains::ABOUT.iter().collect();
        for about in laws().flat_map(|(_, law)| law) {
            // RI and RVI share a name, and therefore a key.
            if all.iter().all(|other| other.name != about.name) {
                all.push(about);
            }
        }
        all
    }

    fn needs(about: &About) -> bool {
        PdGains::ABOUT.contains(about)
    }

    fn allowed(about: &About) -> Option<Allowed> {
        let of_laws = || laws().find_map(|(law, _)| law.allowed(about.key));
        PdGains::EXAMPLE.allowed(about.key).or_else(of_laws)
    }

    fn otherwise(about: &About) -> Option<FileScalar> {
        let bits = laws().find_map(|(law, _)| law.get(about.key))?;
        (about.absent == Absent::Default).then(|| scalar(about.kind, bits))
    }

    /// A default belongs to a law whose required gains are present.
    fn belongs(about: &About, has: &dyn Fn(&str) -> bool) -> bool {
        // What `robust` needs is in every table of it; the keys for two encoders are not.
        Gains::ABOUT.iter().any(|law| {
            let mut needed = law.iter().filter(|gain| gain.absent == Absent::Needed);
            law.iter().any(|gain| gain.name == about.name) && needed.all(|gain| has(gain.name))
        })
    }

    fn laws(about: &About) -> Vec<String> {
        let takes = |law: &[About]| law.iter().any(|gain| gain.name == about.name);
        // A file names the law for two encoders `robust`, which needs the same gains.
        let named = laws().filter(|(law, _)| !matches!(law, Gains::RobustDual(_)));
        named.filter(|(_, law)| takes(law)).map(|(law, _)| shown(&law)).collect()
    }
}
