//! What the core declares of the tables of a file.

use stiction::compensator::Gains;
use stiction::drive::DriveConfig;
use stiction::encoder::Encoder;
use stiction::jog::JogBounds;
use stiction::parameters::DeviceConfig;
use stiction::pd::PdGains;
use stiction::value::{About, Absent, Table, Values};
use stiction::{Allowed, ControllerConfig, Limits, ProfileLimits};

use super::{FileScalar, scalar};

/// The declarations of a table of the file.
pub trait Declared {
    /// Lists every value that the table may have.
    fn about() -> Vec<&'static About>;

    /// Tells whether a value has to be there.
    fn needs(about: &About) -> bool {
        about.absent == Absent::Needed
    }

    /// Tells what a value is that is left out, if that does not depend on others.
    fn otherwise(about: &About) -> Option<FileScalar>;

    /// Returns whether a value that is left out belongs into a table that has other ones.
    fn belongs(_: &About, _has: &dyn Fn(&str) -> bool) -> bool {
        true
    }

    /// Tells what a value may be beside the other values of the example.
    fn allowed(about: &About) -> Option<Allowed>;

    /// Names the laws that need a value, and says which of them live on the host.
    fn laws(_: &About) -> Vec<String> {
        vec![]
    }
}

macro_rules! declared {
    ($($table:ty),+) => {
        $(impl Declared for $table {
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

declared!(ControllerConfig, Encoder, DriveConfig, DeviceConfig, Limits, ProfileLimits, JogBounds);

/// The name of a law, and that it lives on the host if it does.
pub(crate) fn shown(law: &Gains) -> String {
    let name = law.name();
    if law.on_the_device() { name.into() } else { format!("{name} (on the host only)") }
}

/// `[controller.NAME]`: the gains of PD and of every law. Those of PD have to be there; what else
/// has to be depends on the laws that are listed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllGains;

impl Declared for AllGains {
    fn about() -> Vec<&'static About> {
        let mut all: Vec<&About> = PdGains::ABOUT.iter().collect();
        for about in Gains::ABOUT.iter().flat_map(|law| law.iter()) {
            // RI and RVI share a name, and so a key.
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
        let of_laws = || Gains::EXAMPLES.iter().find_map(|law| law.allowed(about.key));
        PdGains::EXAMPLE.allowed(about.key).or_else(of_laws)
    }

    fn otherwise(about: &About) -> Option<FileScalar> {
        let bits = Gains::EXAMPLES.iter().find_map(|law| law.get(about.key))?;
        (about.absent == Absent::Default).then(|| scalar(about.kind, bits))
    }

    /// A default belongs to a law whose needed gains are there.
    fn belongs(about: &About, has: &dyn Fn(&str) -> bool) -> bool {
        Gains::ABOUT.iter().any(|law| {
            let mut needed = law.iter().filter(|gain| gain.absent == Absent::Needed);
            law.iter().any(|gain| gain.name == about.name) && needed.all(|gain| has(gain.name))
        })
    }

    fn laws(about: &About) -> Vec<String> {
        let all = Gains::EXAMPLES.iter().zip(Gains::ABOUT);
        let takes = |law: &&[About]| law.iter().any(|gain| gain.name == about.name);
        all.filter(|(_, law)| takes(law)).map(|(law, _)| shown(law)).collect()
    }
}
