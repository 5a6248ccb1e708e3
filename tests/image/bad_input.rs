//! A bad image, and a file that cannot run on one, is refused in a sentence.

use std::fs;
use std::path::Path;
use std::sync::atomic::Ordering;

use emulator::Emulation;

use crate::common::{emulation, image, plans};

fn refusal(path: &Path) -> String {
    Emulation::new(Some(path)).map(|_| ()).unwrap_err().to_string()
}

/// A copy of the image with some bytes replaced.
fn patched(name: &str, from: &[u8], to: &[u8]) -> String {
    assert_eq!(from.len(), to.len());
    let mut bytes = fs::read(image()).unwrap();
    let places: Vec<usize> = bytes
        .windows(from.len())
        .enumerate()
        .filter(|(_, w)| *w == from)
        .map(|(at, _)| at)
        .collect();
    assert!(!places.is_empty(), "the image does not hold {from:?}");
    for at in places {
        bytes[at..at + to.len()].copy_from_slice(to);
    }
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    fs::write(&path, bytes).unwrap();
    refusal(&path)
}

#[test]
fn a_missing_file_a_text_and_a_program_of_this_machine() {
    let missing = refusal(Path::new("no/such/image"));
    assert!(
        missing.contains("no/such/image") && missing.contains("cargo xtask firmware"),
        "{missing}"
    );
    assert!(
        refusal(&Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"))
            .contains("not an ELF file")
    );
    let own = refusal(&std::env::current_exe().unwrap());
    assert!(own.contains("Cortex-M4") || own.contains("not an ELF file"), "{own}");
}

#[test]
fn another_chip_and_another_core() {
    let chip = patched("chip", b"\0STM32F405\0", b"\0STM32F411\0");
    assert!(chip.contains("STM32F411") && chip.contains("STM32F405"), "{chip}");
    let version = env!("CARGO_PKG_VERSION");
    let note = |version: &str| format!("stiction\0\0\0\0{version}\0").into_bytes();
    let core = patched("core", &note(version), &note(&"9".repeat(version.len())));
    assert!(core.contains("999") && core.contains(version), "{core}");
}

#[test]
fn an_image_that_does_not_keep_its_ticks() {
    let other = patched("ticks", b"\0STICTION_LAST_TICK\0", b"\0STICTION_LOST_TICK\0");
    assert!(
        other.contains("STICTION_LAST_TICK") && other.contains("cargo xtask firmware"),
        "{other}"
    );
}

#[test]
fn an_interrupted_run_says_so() {
    let plans = plans("step-response", &["pd"], &[]);
    let emulation = emulation();
    emulation.interrupt.store(true, Ordering::Relaxed);
    let error = emulation.run_all(&plans).unwrap_err().to_string();
    assert!(error.contains("interrupted"), "{error}");
}

#[test]
fn a_sample_time_that_the_device_does_not_take_is_named() {
    let plans = plans("step-response", &["pd"], &["loop.sample_time_s=0.05"]);
    let error = emulation().run_all(&plans).unwrap_err().to_string();
    assert!(error.contains("sample_time_s") && error.contains("0.05"), "{error}");
}
