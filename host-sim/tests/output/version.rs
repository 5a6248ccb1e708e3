use super::stiction;

/// A report of a fault begins with it.
#[test]
fn the_version_names_the_program_its_commit_and_its_features() {
    let first = format!("stiction {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(stiction(&["-V"]), first);
    let long = stiction(&["--version"]);
    let lines: Vec<&str> = long.lines().collect();
    assert!(long.starts_with(&first) && lines.len() == 3, "{long}");
    assert!(lines[1].starts_with("commit: "), "{long}");
    let features = lines[2].strip_prefix("features: ").unwrap();
    assert_eq!(features.contains("report"), cfg!(feature = "report"), "{long}");
    assert_eq!(features.contains("emulator"), cfg!(feature = "emulator"), "{long}");
}
