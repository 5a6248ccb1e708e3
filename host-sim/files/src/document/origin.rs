//! Origin of a value: the file, a variant, the command line, or a draw.

use std::fmt;

use super::wording::brief;
use crate::data_sheet::SheetRefusal;

/// Origin of the values of a document, for messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Name of a built-in experiment, or path of a file.
    pub name: String,
    /// Variant, if any.
    pub(super) variant: Option<String>,
    /// Assignments of the command line, as typed.
    pub(super) set: Vec<String>,
    /// Values drawn within a spread, as `KEY=VALUE`.
    pub(super) drawn: Vec<String>,
}

impl Origin {
    /// Returns the message of a refused data sheet. If the allowed range follows from a key that is
    /// set by hand, the message names that key, and not the key of the file.
    pub fn refusal(&self, why: &SheetRefusal) -> String {
        let cause = why.cause.as_ref().filter(|_| !self.has_set(&why.key));
        let set = cause.and_then(|cause| {
            let key = cause.keys.iter().find(|key| self.has_set(key))?;
            Some(format!("{}: {}", self.of(key), cause.sentence))
        });
        set.unwrap_or_else(|| format!("{}: {why}", self.of(&why.key)))
    }

    /// Returns whether a key was set by hand or drawn.
    pub fn has_set(&self, key: &str) -> bool {
        let typed = |set: &String| set.split('=').next().unwrap_or_default().trim() == key;
        self.set.iter().chain(&self.drawn).any(typed)
    }

    /// Returns the source of a key's value: the draw, the assignment by hand, or else the file.
    pub fn of(&self, key: &str) -> String {
        let set = |assignment: &&String| {
            let typed = assignment.split('=').next().unwrap_or_default().trim();
            within(key, typed) || within(typed, key)
        };
        if let Some(drawn) = self.drawn.iter().rfind(set) {
            return format!("{self}: its spread gives {}", brief(drawn));
        }
        match self.set.iter().rfind(set) {
            Some(assignment) => brief(assignment),
            // A drawn value may contradict the key.
            None if !self.drawn.is_empty() => {
                let drawn: Vec<String> = self.drawn.iter().map(|drawn| brief(drawn)).collect();
                format!("{self}: its spread gives {}", drawn.join(", "))
            }
            None => {
                // An assignment may contradict a key of the file.
                let with = if self.set.is_empty() { "" } else { " with " };
                let set: Vec<String> = self.set.iter().map(|set| brief(set)).collect();
                format!("{self}{with}{}", set.join(", "))
            }
        }
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        match &self.variant {
            Some(variant) => write!(f, ", variant {variant}"),
            None => Ok(()),
        }
    }
}

/// Returns whether a key is the given table or list, or inside it.
pub fn within(key: &str, table: &str) -> bool {
    key.strip_prefix(table).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}
