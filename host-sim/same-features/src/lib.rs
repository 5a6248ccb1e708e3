//! Empty: see its Cargo.toml.
