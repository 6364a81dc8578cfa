//! Arrays as bytes in the machine's order, which numpy takes as they are.

use pyo3::prelude::*;
use pyo3::types::PyByteArray;

/// Returns numbers as bytes.
pub(crate) fn numbers<'py>(
    py: Python<'py>,
    values: impl IntoIterator<Item = f64>,
) -> Bound<'py, PyByteArray> {
    let bytes: Vec<u8> = values.into_iter().flat_map(f64::to_ne_bytes).collect();
    PyByteArray::new(py, &bytes)
}

/// Returns counts or indices as bytes of 64-bit integers.
pub(crate) fn indices<'py>(
    py: Python<'py>,
    values: impl IntoIterator<Item = usize>,
) -> Bound<'py, PyByteArray> {
    let values = values
        .into_iter()
        .map(|value| i64::try_from(value).unwrap_or(i64::MAX));
    let bytes: Vec<u8> = values.flat_map(i64::to_ne_bytes).collect();
    PyByteArray::new(py, &bytes)
}

/// Returns the numbers in bytes.
pub(crate) fn from_bytes(bytes: &[u8]) -> impl Iterator<Item = f64> {
    let (numbers, _) = bytes.as_chunks::<8>();
    numbers.iter().copied().map(f64::from_ne_bytes)
}
