//! Laws of the user's own, by `--law`.

use std::path::PathBuf;

use files::error::Error;
use simulator::rules::{GainRule, rules};

/// Libraries with laws of the user's own.
#[derive(Clone, Debug, clap::Args)]
pub struct OwnLawArguments {
    /// A law of your own beside them: a shared library with the functions of stiction_law.h
    /// (docs/how-to/own-law.md); can be repeated
    #[arg(long, value_name = "FILE")]
    law: Vec<PathBuf>,
}

impl OwnLawArguments {
    /// Returns whether the user has given no law.
    pub fn is_empty(&self) -> bool {
        self.law.is_empty()
    }

    /// Returns the rules of the named built-in laws (all if none is named), then those of the
    /// user's laws.
    ///
    /// # Errors
    /// Returns an error that names an unknown law, or a library that is no law.
    pub fn after(&self, names: &[String]) -> Result<Vec<&'static GainRule>, Error> {
        Ok(rules(names)?.into_iter().chain(self.opened()?).collect())
    }

    /// Returns the names of the user's own laws, by which they are added to the controllers of a
    /// machine's file.
    ///
    /// # Errors
    /// Returns an error that names a library that is no law.
    pub fn names(&self) -> Result<Vec<String>, Error> {
        Ok(self.opened()?.into_iter().map(|rule| rule.law.to_owned()).collect())
    }

    fn opened(&self) -> Result<Vec<&'static GainRule>, Error> {
        let mut all: Vec<&'static GainRule> = Vec::new();
        for library in &self.law {
            let own = opened(library)?;
            if all.iter().any(|rule| rule.law == own.law) {
                let (file, name) = (library.display(), own.law);
                return Err(Error::Input(format!("--law {file}: a second law is called `{name}`")));
            }
            all.push(own);
        }
        Ok(all)
    }
}

#[cfg(feature = "shared-law")]
fn opened(library: &std::path::Path) -> Result<&'static GainRule, Error> {
    simulator::guest::register(shared_law::open(library)?)
}

#[cfg(not(feature = "shared-law"))]
fn opened(_: &std::path::Path) -> Result<&'static GainRule, Error> {
    Err(files::missing_part::not_built("--law", "laws of shared libraries are", "shared-law"))
}
