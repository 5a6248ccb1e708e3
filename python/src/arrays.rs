//! Arrays of doubles as bytes, in the order of this machine.

use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Returns the bytes of an array.
pub fn bytes<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyBytes> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_ne_bytes()).collect();
    PyBytes::new(py, &bytes)
}

/// Reads the bytes of an array. The Python package passes whole numbers of eight bytes.
pub fn numbers(bytes: &[u8]) -> Vec<f64> {
    let (numbers, _) = bytes.as_chunks();
    numbers.iter().map(|number| f64::from_ne_bytes(*number)).collect()
}
