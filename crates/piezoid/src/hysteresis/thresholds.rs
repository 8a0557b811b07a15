//! Thresholds of plays and stops.

use super::basis::BasisDesign;
use crate::error::{Error, finite};

/// How many, unless told otherwise: every thirtieth of half the range.
pub(super) const ELEMENTS: usize = 29;

/// The most there may be.
const MOST: usize = 4096;

/// Evenly spaced thresholds up to half the range of the inputs, where a play stops moving. The largest stays short of
/// it, since a play that never moves has no weight to find.
pub(super) fn even(design: &BasisDesign, elements: usize) -> Vec<f64> {
    let n = design.elements.unwrap_or(elements).clamp(1, MOST);
    (1..=n).map(|k| design.half() * k as f64 / (n + 1) as f64).collect()
}

/// Refuses thresholds that do not rise from above zero.
pub(super) fn check(thresholds: &[f64]) -> Result<(), Error> {
    finite("thresholds", thresholds)?;
    let n = thresholds.len();
    if !(1..=MOST).contains(&n) {
        return Err(Error::parameter("thresholds", format!("{n} numbers"), format!("must be 1 to {MOST} numbers")));
    }
    let mut below = 0.0;
    for (k, &r) in thresholds.iter().enumerate() {
        if r <= below {
            let rule = format!("must be above {below}: thresholds rise from above zero");
            return Err(Error::parameter(format!("thresholds[{k}]"), r, rule));
        }
        below = r;
    }
    Ok(())
}
