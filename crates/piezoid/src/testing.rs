//! What tests share: a comparison and noise.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// `n` standard normal numbers of a seed.
pub(crate) fn noise(seed: u64, n: usize) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| StandardNormal.sample(&mut random)).collect()
}

/// Asserts `|a - b| <= atol + rtol |b|` element by element, naming the worst one.
#[track_caller]
pub(crate) fn assert_close(a: &[f64], b: &[f64], rtol: f64, atol: f64) {
    assert_eq!(a.len(), b.len(), "lengths differ");
    let excess = |i: usize| (a[i] - b[i]).abs() - atol - rtol * b[i].abs();
    // NaN is not close to anything.
    if let Some(i) = (0..a.len()).find(|&i| excess(i) > 0.0 || excess(i).is_nan()) {
        panic!(
            "[{i}]: {} is not {} within rtol {rtol:e}, atol {atol:e} (off by {:e})",
            a[i],
            b[i],
            (a[i] - b[i]).abs()
        );
    }
}
