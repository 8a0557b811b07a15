//! Comparison of numbers with tolerances.

/// Asserts `|a - b| <= atol + rtol |b|` element by element, naming the worst one.
#[track_caller]
pub(crate) fn assert_close(what: &str, a: &[f64], b: &[f64], rtol: f64, atol: f64) {
    assert_eq!(a.len(), b.len(), "{what}: lengths differ");
    // NaN is not close to any number: it is the worst.
    let excess = |i: usize| match (a[i] - b[i]).abs() - atol - rtol * b[i].abs() {
        excess if excess.is_nan() => f64::INFINITY,
        excess => excess,
    };
    if let Some(i) = (0..a.len()).max_by(|&i, &j| excess(i).total_cmp(&excess(j))) {
        let (a, b) = (a[i], b[i]);
        let off = (a - b).abs();
        assert!(excess(i) <= 0.0, "{what}[{i}]: {a} is not {b} within rtol {rtol:e}, atol {atol:e} (off by {off:e})");
    }
}
