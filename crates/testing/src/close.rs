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

/// Asserts that two texts have the same words in the same order, and numbers that differ by at most `rtol` of
/// themselves and `atol`.
#[track_caller]
pub fn assert_alike(found: &str, expected: &str, rtol: f64, atol: f64) {
    let parts = |text: &str| -> Vec<String> {
        let marks = |c: char| c.is_whitespace() || "()[]{},:;\"".contains(c);
        text.split(marks).filter(|part| !part.is_empty()).map(String::from).collect()
    };
    let (found, expected) = (parts(found), parts(expected));
    for (k, (a, b)) in found.iter().zip(&expected).enumerate() {
        let close = match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= atol + rtol * b.abs(),
            _ => false,
        };
        assert!(a == b || close, "{a} is not {b} after {}", expected[k.saturating_sub(12)..k].join(" "));
    }
    assert_eq!(found.len(), expected.len());
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

    #[test]
    fn texts_are_alike_if_their_words_are_the_same_and_their_numbers_close() {
        assert_alike("fit {a: 1.0000001, b: [inf, 0]}", "fit {a: 1, b: [inf, 1e-9]}", 1e-6, 1e-8);
    }

    #[test]
    #[should_panic(expected = "1.1 is not 1 after fit a")]
    fn a_number_that_is_not_close_is_named_with_what_stands_before_it() {
        assert_alike("fit a 1.1", "fit a 1", 1e-6, 0.0);
    }

    #[test]
    #[should_panic(expected = "order is not mode after second")]
    fn another_word_is_not_alike() {
        assert_alike("second order", "second mode", 1.0, 1.0);
    }

    #[test]
    #[should_panic(expected = "left == right")]
    fn a_text_that_goes_on_is_not_alike() {
        assert_alike("second order", "second", 1.0, 1.0);
    }
}
