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

/// The path of the image for two encoders, which is built beside the other one.
pub fn image_for_two() -> PathBuf {
    image().with_file_name("stiction-two-encoders.elf")
}

/// Runs of the image.
pub fn emulation() -> Emulation {
    Emulation::new(Some(&image())).unwrap()
}

/// Runs of the image for two encoders.
pub fn emulation_of_two() -> Emulation {
    Emulation::new(Some(&image_for_two())).unwrap()
}

/// The image for two encoders, read once.
pub fn firmware_for_two() -> Arc<FirmwareImage> {
    static IMAGE: LazyLock<Arc<FirmwareImage>> =
        LazyLock::new(|| Arc::new(FirmwareImage::open(&image_for_two()).unwrap()));
    IMAGE.clone()
}

/// Read once: its log's formats are half a second's work.
pub fn firmware() -> Arc<FirmwareImage> {
    static IMAGE: LazyLock<Arc<FirmwareImage>> =
        LazyLock::new(|| Arc::new(FirmwareImage::open(&image()).unwrap()));
    IMAGE.clone()
}
