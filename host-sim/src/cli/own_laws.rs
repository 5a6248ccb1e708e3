//! Laws of the user's own, by `--law`.

use std::path::PathBuf;

use files::error::Error;
use simulator::rules::{GainRule, rules};

/// Returns the rules of the named laws (all if none is named), then those of the user's own.
///
/// # Errors
/// Returns an error with a name that no law has, or a library that is no law.
pub fn with_own_laws(
    names: &[String],
    libraries: &[PathBuf],
) -> Result<Vec<&'static GainRule>, Error> {
    let mut all = rules(names)?;
    for library in libraries {
        let own = opened(library)?;
        if all.iter().any(|rule| rule.law == own.law) {
            let (file, name) = (library.display(), own.law);
            return Err(Error::Input(format!("--law {file}: a second law is called `{name}`")));
        }
        all.push(own);
    }
    Ok(all)
}

#[cfg(feature = "shared-law")]
fn opened(library: &std::path::Path) -> Result<&'static GainRule, Error> {
    simulator::guest::register(shared_law::open(library)?)
}

#[cfg(not(feature = "shared-law"))]
fn opened(_: &std::path::Path) -> Result<&'static GainRule, Error> {
    Err(files::missing_part::not_built("--law", "laws of shared libraries are", "shared-law"))
}
