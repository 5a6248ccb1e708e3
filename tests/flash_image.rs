//! The flash image under test.

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use emulator::{Emulation, FirmwareImage};

/// Set by `cargo xtask test`.
const IMAGE: &str = "STICTION_IMAGE";

/// The image's path. A test that cannot find it fails: one that is skipped looks like one that has
/// passed.
pub fn image() -> PathBuf {
    match std::env::var_os(IMAGE) {
        Some(path) => path.into(),
        None => panic!(
            "{IMAGE} does not name a flash image: run `cargo xtask test`, or `cargo xtask \
             firmware` and then this with {IMAGE}=<the file that it leaves>"
        ),
    }
}

/// Runs of the image.
pub fn emulation() -> Emulation {
    Emulation::new(Some(&image())).unwrap()
}

/// Read once: its log's formats are half a second's work.
pub fn firmware() -> Arc<FirmwareImage> {
    static IMAGE: LazyLock<Arc<FirmwareImage>> =
        LazyLock::new(|| Arc::new(FirmwareImage::open(&image()).unwrap()));
    IMAGE.clone()
}
