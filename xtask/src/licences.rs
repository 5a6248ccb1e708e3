//! Packages of others in a release, and the texts of their licences.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::job::{cargo, root};
use crate::simulator::EVERYTHING;
use crate::toolchain;

/// Starts of the names of files that hold a licence or must go with one.
const NAMES: [&str; 5] = ["licen", "copying", "copyright", "notice", "unlicense"];

/// Packages of npm in the studio's page, with their licences: both dependencies of its
/// package.json, and what those depend on.
const PAGE: [(&str, &str); 5] = [
    ("uplot", "MIT"),
    ("@mcap/core", "MIT"),
    ("@foxglove/crc", "MIT"),
    ("heap-js", "BSD-3-Clause"),
    ("tslib", "0BSD"),
];

/// Texts of the system's libraries, where Debian and Rust keep them.
const OF_SYSTEM: [(&str, &str); 2] = [
    ("the GNU C library", "/usr/share/common-licenses/LGPL-2.1"),
    ("the standard library of Rust", "share/doc/rust/COPYRIGHT-library.html"),
];

/// What no package manager lists.
const SYSTEM: &str = "
In the programs besides: the standard library of Rust (MIT OR Apache-2.0). `stiction` is linked
with the GNU C library (LGPL-2.1-or-later); its sources and those of stiction are public, so it can
be linked anew with another one.
";

/// Returns the packages of the program, the wheel, the image and the page with their licences, and
/// then each text once.
///
/// `target` is that of the program and the wheel.
///
/// # Errors
/// Returns an error if cargo fails.
pub fn all(target: &str) -> Result<String, String> {
    let image = ["--package", "stiction", "--features", "board", "--target", toolchain::TARGET];
    let program = ["--package", "host-sim", "--features", EVERYTHING[1], "--target", target];
    let wheel = ["--package", "stiction-python", "--target", target];
    let mut text = String::from("Packages of others, and their licences. The texts follow.\n");
    // Texts, and the packages that have each.
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut without = Vec::new();
    for (part, arguments) in
        [("stiction", &program[..]), ("python/", &wheel), ("firmware/ and c/", &image)]
    {
        let _ = writeln!(text, "\n{part}\n");
        for (package, licence) in packages(arguments)? {
            let _ = writeln!(text, "  {package} {licence}");
            let found = files(&source(&package));
            if found.is_empty() && !without.contains(&package) {
                without.push(package.clone());
            }
            for one in found {
                let of = texts.entry(one).or_default();
                if !of.contains(&package) {
                    of.push(package.clone());
                }
            }
        }
    }
    text += "\nstiction, the page of the studio\n\n";
    for (name, licence) in PAGE {
        let _ = writeln!(text, "  {name} {licence}");
        let source = root().join("host-sim/studio-page/node_modules").join(name);
        let found = files(&[source]);
        if found.is_empty() {
            without.push(name.to_owned());
        }
        for one in found {
            texts.entry(one).or_default().push(name.to_owned());
        }
    }
    let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output();
    let sysroot = sysroot.map_or_else(
        |_| String::new(),
        |made| String::from_utf8_lossy(&made.stdout).trim().to_owned(),
    );
    for (name, file) in OF_SYSTEM {
        // An absolute path replaces the directory before it.
        match fs::read_to_string(PathBuf::from(&sysroot).join(file)) {
            Ok(one) => texts.entry(one).or_default().push(name.to_owned()),
            Err(_) => without.push(name.to_owned()),
        }
    }
    text += SYSTEM;
    if !without.is_empty() {
        let _ = writeln!(text, "\nWithout a text of their own: {}.", without.join(", "));
    }
    for (one, packages) in texts {
        let _ = write!(text, "\n{}\n{}:\n\n{one}\n", "=".repeat(80), packages.join(", "));
    }
    Ok(text)
}

/// Returns the packages of others in a part of the release, as `name version`, and their licences.
fn packages(arguments: &[&str]) -> Result<Vec<(String, String)>, String> {
    let mut tree = cargo(&["tree", "--edges", "normal", "--prefix", "none"]);
    let made = tree.args(["--format", "{p}|{l}"]).args(arguments).output();
    let made = made.map_err(|error| format!("cannot start cargo: {error}"))?;
    if !made.status.success() {
        return Err(String::from_utf8_lossy(&made.stderr).into_owned());
    }
    let all = String::from_utf8_lossy(&made.stdout).into_owned();
    let mut found: Vec<(String, String)> = Vec::new();
    // Our own packages have a path, and a package that is there twice a star.
    for line in all.lines().filter(|line| !line.contains(&*root().to_string_lossy())) {
        let Some((package, licence)) = line.split_once('|') else { continue };
        let package = package.trim_end_matches(" (proc-macro)").replacen(" v", " ", 1);
        found.push((package, licence.trim_end_matches(" (*)").to_owned()));
    }
    found.sort();
    found.dedup();
    Ok(found)
}

/// Returns the places in which cargo may keep a package's sources.
fn source(package: &str) -> Vec<PathBuf> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from).or_else(|| {
        let user = std::env::var_os("HOME")?;
        Some(PathBuf::from(user).join(".cargo"))
    });
    let sources = home.map(|home| home.join("registry/src"));
    let entries = sources.and_then(|sources| fs::read_dir(sources).ok());
    let name = package.replacen(' ', "-", 1);
    entries.into_iter().flatten().flatten().map(|entry| entry.path().join(&name)).collect()
}

/// Returns the texts of licences in directories.
fn files(directories: &[PathBuf]) -> Vec<String> {
    let mut texts = Vec::new();
    for directory in directories {
        for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().to_lowercase();
            if !NAMES.iter().any(|start| name.starts_with(start)) {
                continue;
            }
            // Some packages have a directory of texts.
            let path = entry.path();
            if path.is_dir() {
                texts.extend(files(&[path]));
            } else if let Ok(text) = fs::read_to_string(path) {
                let lines = text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
                texts.push(lines.trim().to_owned());
            }
        }
    }
    texts.sort();
    texts.dedup();
    texts
}

#[cfg(test)]
mod tests {
    /// The image's packages are few, and each is in the registry of this machine.
    #[test]
    fn each_package_of_the_image_has_its_licence_and_a_text() {
        let image =
            ["--package", "stiction", "--features", "board", "--target", super::toolchain::TARGET];
        let packages = super::packages(&image).unwrap();
        assert!(
            packages.iter().any(|(name, _)| name.starts_with("stm32f4xx-hal ")),
            "{packages:?}"
        );
        assert!(packages.iter().all(|(name, licence)| name.contains(' ') && !licence.is_empty()));
        let with_text = packages.iter().filter(|(name, _)| {
            super::files(&super::source(name)).iter().any(|text| text.len() > 300)
        });
        // A few crates leave their texts in the repository.
        let with_text = with_text.count();
        assert!(5 * with_text >= 4 * packages.len(), "{with_text} of {}", packages.len());
    }
}
