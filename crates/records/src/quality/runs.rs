//! Runs of samples, their times in words, and statistics of samples.

use piezoid_numerics::number::round;
use piezoid_numerics::series::{mean, scatter};
use std::ops::Range;

/// The runs of samples from 0 up to `n` for which `so` holds; gaps of up to `gap` samples are closed.
pub(crate) fn runs(n: usize, gap: usize, so: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for t in (0..n).filter(|t| so(*t)) {
        match runs.last_mut() {
            Some(last) if t <= last.end + gap => last.end = t + 1,
            _ => runs.push(t..t + 1),
        }
    }
    runs
}

/// The smallest non-zero step between neighbours: the resolution of the sensor or less.
pub(super) fn resolution(x: &[f64]) -> f64 {
    let steps = x.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0);
    steps.fold(f64::INFINITY, f64::min)
}

/// A series about its mean, over its rms about it; `None` if it is constant.
pub(super) fn standardised(x: &[f64]) -> Option<Vec<f64>> {
    let (mean, rms) = (mean(x), (scatter(x) / x.len() as f64).sqrt());
    (rms > 0.0).then(|| x.iter().map(|x| (x - mean) / rms).collect())
}

/// Number and times of the samples in sorted ranges, for example "12 samples (from 0.15 s to 0.1555 s)".
pub(crate) fn places(ranges: &[Range<usize>], ts: f64) -> String {
    let count: usize = ranges.iter().map(|r| r.len()).sum();
    let at = |k: usize| round(k as f64 * ts);
    let noun = if count == 1 { "sample" } else { "samples" };
    let (Some(first), Some(last)) = (ranges.first(), ranges.last()) else { return format!("{count} {noun}") };
    match (ranges.len(), count) {
        (1, 1) => format!("{count} {noun} (at {} s)", at(first.start)),
        (1, _) => format!("{count} {noun} (from {} s to {} s)", at(first.start), at(first.end - 1)),
        (many, _) => {
            let (first, last) = (at(first.start), at(last.start));
            format!("{count} {noun} in {many} places (the first at {first} s, the last at {last} s)")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_close_small_gaps_and_keep_large_ones() {
        let so = [true, false, true, false, false, false, true];
        assert_eq!(runs(7, 1, |t| so[t]), [0..3, 6..7]);
        assert_eq!(runs(7, 0, |t| so[t]).len(), 3);
    }
}
