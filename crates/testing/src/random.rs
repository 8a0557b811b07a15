//! What tests of random cases share.

use proptest::prelude::*;

/// A number of cases; none is kept in a file.
pub fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// The numbers bit by bit, for comparisons in which NaN equals itself and -0 is not 0.
pub fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// The largest magnitude.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

/// Voltages that rise, fall and stay constant for some samples.
pub fn drive(n: std::ops::Range<usize>) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec((-35.0..35.0f64, 1..4usize), n)
        .prop_map(|steps| steps.into_iter().flat_map(|(u, held)| std::iter::repeat_n(u, held)).collect())
}
