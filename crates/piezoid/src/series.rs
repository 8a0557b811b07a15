//! Statistics of series of numbers.

/// The smallest and the largest number; (inf, -inf) for an empty series.
pub fn ends(x: impl IntoIterator<Item = f64>) -> (f64, f64) {
    x.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// The mean; NaN for an empty series.
pub(crate) fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// The sum of squares about the mean.
pub(crate) fn scatter(x: &[f64]) -> f64 {
    let mean = mean(x);
    x.iter().map(|x| (x - mean) * (x - mean)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_of_three_numbers_are_right() {
        let x = [3.0, -1.0, 4.0];
        assert_eq!((ends(x), mean(&x), scatter(&x)), ((-1.0, 4.0), 2.0, 14.0));
    }
}
