//! Searches for the best parameters. The reason why a search ended is data ([`Minimum::reason`]), not an error.

mod cholesky;
#[cfg(feature = "clarabel")]
pub mod least_absolute;
pub mod levenberg_marquardt;
pub mod non_negative;
pub mod swarm;

#[cfg(feature = "clarabel")]
pub use least_absolute::least_absolute;
pub use non_negative::non_negative;

use crate::error::Error;
use serde::{Deserialize, Serialize};

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The best point.
    pub x: Vec<f64>,
    /// Its cost.
    pub cost: f64,
    /// Best cost at the start and after each iteration; it never increases.
    pub history: Vec<f64>,
    /// Best point at the start and after each iteration.
    pub courses: Vec<Vec<f64>>,
    /// Why the search ended.
    pub reason: Reason,
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// The maximum number of iterations is reached.
    Iterations,
    /// The cost is at or below the threshold.
    Threshold,
    /// The cost has not decreased for the number of iterations in the settings, or no step decreases it any more.
    Stall,
    /// The best step would decrease the cost by less than the tolerance.
    Converged,
    /// The caller cancelled the search.
    Cancelled,
}

/// The bounds of a search: it starts and stays in this box.
#[doc(hidden)]
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Bounds {
    /// The box between the corners `low` and `high`, with one number per dimension.
    ///
    /// # Errors
    /// Returns an error unless both are finite, of equal length, not empty, and `low < high` in every dimension.
    pub fn new(low: Vec<f64>, high: Vec<f64>) -> Result<Self, Error> {
        if low.len() != high.len() {
            let (left, right) = ("the lower corner".into(), "the upper corner".into());
            return Err(Error::Lengths { left, left_len: low.len(), right, right_len: high.len() });
        }
        let narrow = low.iter().zip(&high).position(|(l, h)| !(l < h && (h - l).is_finite()));
        if let Some(d) = narrow {
            let value = format!("{} to {}", low[d], high[d]);
            return Err(Error::parameter(format!("bounds[{d}]"), value, "must be finite and not empty"));
        }
        if low.is_empty() {
            return Err(Error::parameter("bounds", "no dimension", "must have at least one"));
        }
        Ok(Bounds { low, high })
    }

    /// Number of dimensions.
    pub fn dimension(&self) -> usize {
        self.low.len()
    }
}
