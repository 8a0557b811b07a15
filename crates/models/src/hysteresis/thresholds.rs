//! Thresholds of play and stop operators.

use super::basis::{BasisDesign, counted_within};
use piezoid_numerics::error::{Error, finite};

/// Default number: one per thirtieth of half the range.
const ELEMENTS: usize = 29;

const MAX_THRESHOLDS: usize = 4096;

/// Equidistant thresholds below half the range of the inputs. A play with a threshold of half the range would never
/// move, and its weight could not be identified.
pub(super) fn even(design: &BasisDesign) -> Vec<f64> {
    let n = design.elements.unwrap_or(ELEMENTS).clamp(1, MAX_THRESHOLDS);
    (1..=n).map(|k| design.half() * k as f64 / (n + 1) as f64).collect()
}

/// Thresholds of the examples: 3, 6, ..., 24.
pub(super) fn example() -> Vec<f64> {
    (1..=8).map(|k| 3.0 * f64::from(k)).collect()
}

/// Weights of the examples: `first` of the input, 0.06 of each threshold.
pub(super) fn example_weights(first: f64) -> Vec<f64> {
    [&[first][..], &[0.06; 8]].concat()
}

/// Returns an error unless the thresholds are positive and ascending.
pub(super) fn check(thresholds: &[f64]) -> Result<(), Error> {
    check_named("thresholds", thresholds)
}

/// The same for thresholds of another name.
pub(super) fn check_named(name: &str, thresholds: &[f64]) -> Result<(), Error> {
    finite(name, thresholds)?;
    counted_within(name, thresholds.len(), 1, MAX_THRESHOLDS)?;
    let mut below = 0.0;
    for (k, &r) in thresholds.iter().enumerate() {
        if r <= below {
            let rule = format!("must be above {below}: thresholds must be positive and ascending");
            return Err(Error::parameter(format!("{name}[{k}]"), r, rule));
        }
        below = r;
    }
    Ok(())
}
