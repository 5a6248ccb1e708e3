//! The public items of the face for a firmware of your own, against the recorded list
//! `tests/face/items.txt`. A program that was written for one version must compile with the next.

use std::path::{Path, PathBuf};
use std::process::Command;

use public_api::Builder;

/// The face, and what its functions take and return from elsewhere.
const FACE: [&str; 5] = [
    "stiction::positioner",
    "stiction::units::position::",
    "stiction::control::laws::",
    "stiction::control::reference::Setpoint",
    "stiction::safety::fault::Fault",
];

#[test]
fn the_face_is_the_recorded_one() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let recorded = root.join("tests/face/items.txt");
    // The description of the library by this compiler's rustdoc is an unstable output, of which
    // each compiler has a version of its own.
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("face");
    let made = Command::new(env!("CARGO"))
        .args(["rustdoc", "--quiet", "--ignore-rust-version", "--lib", "--no-default-features"])
        .args(["--package", "stiction", "--target-dir"])
        .arg(&target)
        .args(["--", "-Zunstable-options", "--output-format=json", "--cap-lints=allow"])
        .env("RUSTC_BOOTSTRAP", "1")
        .current_dir(root)
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let api = Builder::from_rustdoc_json(target.join("doc/stiction.json"))
        .omit_blanket_impls(true)
        .omit_auto_trait_impls(true)
        .include_function_parameter_names(true)
        .build();
    let api = match api {
        Ok(api) => api,
        Err(why) => {
            eprintln!("NOT RUN: {why}. This test reads what rustdoc 1.95 writes.");
            return;
        }
    };
    let mut items: Vec<String> = api.items().map(ToString::to_string).collect();
    items.retain(|item| {
        let path = item.find("stiction::").and_then(|at| item.get(at..));
        path.is_some_and(|path| FACE.iter().any(|part| path.starts_with(part)))
    });
    items.sort();
    items.dedup();
    if std::env::var_os("STICTION_BLESS").is_some() {
        std::fs::write(&recorded, items.join("\n") + "\n").unwrap();
    }
    let before = std::fs::read_to_string(&recorded).unwrap_or_default();
    let before: Vec<&str> = before.lines().collect();
    let gone: Vec<_> = before.iter().filter(|old| !items.iter().any(|item| item == *old)).collect();
    let new: Vec<_> = items.iter().filter(|item| !before.contains(&item.as_str())).collect();
    assert!(
        gone.is_empty() && new.is_empty(),
        "the face has changed. An item that is gone or has another type breaks programs of others: \
         it needs another version and a line in CHANGELOG.md. Record the items with \
         STICTION_BLESS=1.\nGone: {gone:#?}\nNew: {new:#?}"
    );
    // Types of other crates would bind a user to their versions.
    let foreign = ["heapless", "libm", "serde", "cortex"];
    let face = items.iter().filter(|item| item.contains(FACE[0]));
    let bound: Vec<_> =
        face.filter(|item| foreign.iter().any(|name| item.contains(name))).collect();
    assert!(bound.is_empty(), "{bound:#?}");
    assert!(items.len() > 100, "{} items", items.len());
}
