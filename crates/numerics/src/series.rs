//! Statistics of series of numbers.

use multiversion::multiversion;

/// The smallest and the largest number; (inf, -inf) for an empty series.
pub fn ends(x: impl IntoIterator<Item = f64>) -> (f64, f64) {
    x.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// The largest number less the smallest; -inf for an empty series.
pub fn range(x: &[f64]) -> f64 {
    let (low, high) = ends(x.iter().copied());
    high - low
}

/// The largest magnitude; 0 for an empty series.
pub fn largest<'a>(x: impl IntoIterator<Item = &'a f64>) -> f64 {
    x.into_iter().fold(0.0, |largest: f64, x| largest.max(x.abs()))
}

/// Shifts `newest` into the past values of a series, newest first; the oldest leaves.
pub fn shift_in(past: &mut [f64], newest: f64) {
    if let Some(oldest) = past.len().checked_sub(1) {
        past.copy_within(..oldest, 1);
        past[0] = newest;
    }
}

/// The mean; NaN for an empty series.
pub fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// So many samples for each one of `x`, beginning with it: on the straight line to the next one, or all equal to it.
/// The last one is held.
pub fn upsampled(x: &[f64], every: usize, is_joined: bool) -> Vec<f64> {
    let of = |k: usize| {
        let from = x[k];
        let to = x.get(k + 1).filter(|_| is_joined).copied().unwrap_or(from);
        (0..every).map(move |j| from + j as f64 / every as f64 * (to - from))
    };
    (0..x.len()).flat_map(of).collect()
}

/// The series without its mean.
pub fn centred(x: &[f64]) -> Vec<f64> {
    let mean = mean(x);
    x.iter().map(|x| x - mean).collect()
}

/// The sum of squares about the mean.
pub fn scatter(x: &[f64]) -> f64 {
    let mean = mean(x);
    x.iter().map(|x| (x - mean) * (x - mean)).sum()
}

/// The share of the scatter of `y` that a line over `x` explains; NaN if one of them is constant.
pub fn explained(x: &[f64], y: &[f64]) -> f64 {
    let (mx, my) = (mean(x), mean(y));
    let crossed: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    crossed * crossed / (scatter(x) * scatter(y))
}

/// The line of least squares of `y` over `x`: its slope, and its value at 0; `None` if `x` is constant.
pub fn line(x: &[f64], y: &[f64]) -> Option<(f64, f64)> {
    let (mx, my, along) = (mean(x), mean(y), scatter(x));
    let crossed: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    (along > 0.0).then(|| (crossed / along, my - crossed / along * mx))
}

/// The quantile of `x` at `share`; 0 if `x` is empty.
pub fn quantile(mut x: Vec<f64>, share: f64) -> f64 {
    let k = (share * x.len() as f64) as usize;
    match x.len() {
        0 => 0.0,
        n => *x.select_nth_unstable_by(k.min(n - 1), f64::total_cmp).1,
    }
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
        assert_eq!((range(&x), largest(&x), centred(&x)), (5.0, 4.0, vec![1.0, -3.0, 2.0]));
        assert_eq!((dot(&x, &x), dot_wide::<2>(&x, &x)), (26.0, 26.0));
    }

    #[test]
    fn samples_between_others_are_on_a_line_or_held() {
        assert_eq!(upsampled(&[1.0, 3.0], 4, true), [1.0, 1.5, 2.0, 2.5, 3.0, 3.0, 3.0, 3.0]);
        assert_eq!(upsampled(&[1.0, 3.0], 2, false), [1.0, 1.0, 3.0, 3.0]);
        assert!(upsampled(&[], 3, true).is_empty());
    }

    #[test]
    fn a_line_explains_a_line_and_nothing_of_a_peak() {
        assert_eq!(explained(&[1.0, 2.0, 3.0], &[5.0, 3.0, 1.0]), 1.0);
        assert_eq!(explained(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0]), 0.0);
        assert_eq!(explained(&[-1.0, 0.0, 1.0], &[0.0, 0.0, 3.0]), 0.75);
        assert!(explained(&[2.0, 2.0], &[0.0, 1.0]).is_nan());
    }

    #[test]
    fn quantiles_are_counted_from_the_smallest() {
        let x = vec![4.0, 1.0, 3.0, 2.0];
        assert_eq!((quantile(x.clone(), 0.0), quantile(x.clone(), 0.5), quantile(x, 1.0)), (1.0, 3.0, 4.0));
        assert_eq!(quantile(Vec::new(), 0.5), 0.0);
    }
}
