//! Built-in experiments: those of the thesis, and one more.

use crate::error::{Error, suggestion};

/// An experiment that is part of the program.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// The name of the experiment on the command line.
    pub name: &'static str,
    /// The text of its file.
    pub toml: &'static str,
}

macro_rules! builtin {
    ($name:literal) => {
        Builtin {
            name: $name,
            toml: include_str!(concat!("../../../thesis/experiments/", $name, ".toml")),
        }
    };
}

/// Lists the built-in experiments in the thesis's order; the one that is not in it comes last.
pub const fn builtins() -> &'static [Builtin] {
    &[
        builtin!("spring-mass"),
        builtin!("spring-mass-2dof"),
        builtin!("manipulator-1dof"),
        builtin!("manipulator-2dof"),
        builtin!("square-wave"),
        builtin!("triangle-wave"),
        builtin!("spring-mass-revisited"),
        builtin!("step-response"),
        builtin!("trajectory"),
        builtin!("step-added-friction"),
        builtin!("srnf-robustness"),
        builtin!("srnf-added-friction"),
        builtin!("high-gain"),
        builtin!("friction-identification"),
        builtin!("spring-mass-independent"),
        builtin!("untuned-joints"),
    ]
}

/// Finds a built-in experiment by its name.
///
/// # Errors
/// Returns an error with the most similar name and the list of all.
pub fn find(name: &str) -> Result<Builtin, Error> {
    builtins().iter().copied().find(|builtin| builtin.name == name).ok_or_else(|| {
        let near = suggestion(name, builtins().iter().map(|builtin| builtin.name));
        Error::Input(format!("there is no experiment `{name}`{near}"))
    })
}
