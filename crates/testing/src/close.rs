//! Comparison of numbers with tolerances.

/// Asserts `|a - b| <= atol + rtol |b|` element by element, and names the worst one.
#[track_caller]
pub fn assert_close(a: &[f64], b: &[f64], rtol: f64, atol: f64) {
    assert_named_close("", a, b, rtol, atol);
}

/// [`assert_close`] with the name of what is compared in its message.
#[track_caller]
pub fn assert_named_close(name: &str, a: &[f64], b: &[f64], rtol: f64, atol: f64) {
    assert_eq!(a.len(), b.len(), "{name}: lengths differ");
    // NaN is not close to any number: it is the worst.
    let excess = |i: usize| match (a[i] - b[i]).abs() - atol - rtol * b[i].abs() {
        excess if excess.is_nan() => f64::INFINITY,
        excess => excess,
    };
    if let Some(i) = (0..a.len()).max_by(|&i, &j| excess(i).total_cmp(&excess(j))) {
        let (a, b) = (a[i], b[i]);
        let off = (a - b).abs();
        assert!(excess(i) <= 0.0, "{name}[{i}]: {a} is not {b} within rtol {rtol:e}, atol {atol:e} (off by {off:e})");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "gain[1]: 2.2 is not 2 within rtol 1e-2, atol 0e0")]
    fn the_worst_element_is_named() {
        assert_named_close("gain", &[1.05, 2.2, 3.0], &[1.0, 2.0, 3.0], 1e-2, 0.0);
    }

    #[test]
    #[should_panic(expected = "[0]: NaN is not 1")]
    fn nan_is_not_close() {
        assert_close(&[f64::NAN], &[1.0], 1.0, 1.0);
    }

    #[test]
    #[should_panic(expected = "lengths differ")]
    fn a_missing_element_is_not_close() {
        assert_close(&[1.0], &[1.0, 1.0], 1.0, 1.0);
    }

    #[test]
    fn both_tolerances_count() {
        assert_close(&[1.01, 1e-13], &[1.0, 0.0], 0.011, 1e-12);
    }
}
