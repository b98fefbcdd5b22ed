//! Errors of results, in metres.

/// Returns the larger of two errors; infinity if one is not a number.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}
