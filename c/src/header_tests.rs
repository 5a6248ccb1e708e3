//! The header against the declarations.

use std::fs;
use std::path::Path;

/// Set to any value, the header is written anew.
const BLESS: &str = "STICTION_BLESS";

#[test]
fn the_header_is_that_of_the_sources() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(package.join("cbindgen.toml")).unwrap();
    let sources = ["codes", "config", "joint", "monitors"];
    let mut builder = cbindgen::Builder::new().with_config(config);
    for source in sources {
        builder = builder.with_src(package.join("src").join(source).with_extension("rs"));
    }
    let mut written = Vec::new();
    builder.generate().unwrap().write(&mut written);
    // The heading is one of Rust; its sentence stays.
    let written = String::from_utf8(written).unwrap().replace("// # Safety\n", "");
    let header = package.join("include/stiction.h");
    if std::env::var_os(BLESS).is_some() {
        fs::write(&header, &written).unwrap();
    }
    let found = fs::read_to_string(&header).unwrap_or_default();
    assert!(
        found == written,
        "include/stiction.h is not that of the sources; write it by {BLESS}=1 cargo test -p \
         stiction-c"
    );
}
