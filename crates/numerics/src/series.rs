//! Statistics of series of numbers.

use multiversion::multiversion;

/// The smallest and the largest number; (inf, -inf) for an empty series.
pub fn ends(x: impl IntoIterator<Item = f64>) -> (f64, f64) {
    x.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// The mean; NaN for an empty series.
pub fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// The sum of squares about the mean.
pub fn scatter(x: &[f64]) -> f64 {
    let mean = mean(x);
    x.iter().map(|x| (x - mean) * (x - mean)).sum()
}

/// The scalar product, summed in order.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The scalar product by `STRANDS` partial sums, added in the same order on every processor.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
pub fn dot_wide<const STRANDS: usize>(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<STRANDS>(), b.as_chunks::<STRANDS>());
    let (mut sums, mut rest) = ([0.0; STRANDS], 0.0);
    for t in 0..a.len().min(b.len()) {
        for k in 0..STRANDS {
            sums[k] += a[t][k] * b[t][k];
        }
    }
    for t in 0..a_rest.len().min(b_rest.len()) {
        rest += a_rest[t] * b_rest[t];
    }
    let mut sum = 0.0;
    for part in sums {
        sum += part;
    }
    sum + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_of_three_numbers_are_right() {
        let x = [3.0, -1.0, 4.0];
        assert_eq!((ends(x), mean(&x), scatter(&x)), ((-1.0, 4.0), 2.0, 14.0));
        assert_eq!((dot(&x, &x), dot_wide::<2>(&x, &x)), (26.0, 26.0));
    }
}
