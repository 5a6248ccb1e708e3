use super::stiction;

/// A report of a fault begins with it.
#[test]
fn the_version_names_the_program_and_its_version() {
    assert_eq!(stiction(&["--version"]), format!("stiction {}\n", env!("CARGO_PKG_VERSION")));
}
