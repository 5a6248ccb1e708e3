//! The text of `stiction --version`.

use std::sync::LazyLock;

/// Names of the features, and whether this program has each.
const FEATURES: [(&str, bool); 6] = [
    ("emulator", cfg!(feature = "emulator")),
    ("figures", cfg!(feature = "figures")),
    ("report", cfg!(feature = "report")),
    ("shared-law", cfg!(feature = "shared-law")),
    ("studio", cfg!(feature = "studio")),
    ("watch", cfg!(feature = "watch")),
];

/// Version, commit and features, a line each. `cargo xtask dist` sets the commit. If every build
/// read it, this crate would be compiled anew after each commit.
pub static LONG: LazyLock<String> = LazyLock::new(|| {
    let version = env!("CARGO_PKG_VERSION");
    let commit = option_env!("STICTION_COMMIT").unwrap_or("not recorded, built from sources");
    let features = FEATURES.iter().filter(|(_, is_there)| *is_there).map(|(name, _)| *name);
    let features = features.collect::<Vec<_>>().join(", ");
    let features = if features.is_empty() { "none" } else { &features };
    format!("{version}\ncommit: {commit}\nfeatures: {features}")
});
