//! Searches for the best parameters. How a search ended is data ([`Minimum::reason`]), not an error.

#[cfg(feature = "clarabel")]
mod least_absolute;
pub(crate) mod levenberg_marquardt;
mod non_negative;
pub mod swarm;

#[cfg(feature = "clarabel")]
pub(crate) use least_absolute::least_absolute;
pub(crate) use non_negative::non_negative;

use serde::{Deserialize, Serialize};

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The best point.
    pub x: Vec<f64>,
    /// Its cost.
    pub cost: f64,
    /// Best cost at the start and after each iteration; it never rises.
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
    /// All iterations were spent.
    Iterations,
    /// The cost fell to the threshold.
    Threshold,
    /// The cost has not fallen for as many iterations as the settings allow, or no step lowers it any more.
    Stall,
    /// The best step that is left would lower the cost by less than the settings ask for.
    Converged,
    /// The caller asked to stop.
    Cancelled,
}

/// The box a search starts in and stays in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Corners")]
pub struct Bounds {
    low: Vec<f64>,
    high: Vec<f64>,
}

/// How [`Bounds`] are read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Corners {
    low: Vec<f64>,
    high: Vec<f64>,
}

impl TryFrom<Corners> for Bounds {
    type Error = crate::Error;
    fn try_from(Corners { low, high }: Corners) -> Result<Self, crate::Error> {
        Bounds::new(low, high)
    }
}

impl Bounds {
    /// The box between the corners `low` and `high`, which have one number a dimension.
    ///
    /// # Errors
    /// Refused unless both are finite, equally long, not empty, and `low < high` in every dimension.
    pub fn new(low: Vec<f64>, high: Vec<f64>) -> Result<Self, crate::Error> {
        if low.len() != high.len() {
            return Err(crate::Error::Lengths {
                left: "the lower corner".into(),
                left_len: low.len(),
                right: "the upper corner".into(),
                right_len: high.len(),
            });
        }
        let narrow = low.iter().zip(&high).position(|(l, h)| !(l < h && (h - l).is_finite()));
        if let Some(d) = narrow {
            let value = format!("{} to {}", low[d], high[d]);
            return Err(crate::Error::parameter(format!("bounds[{d}]"), value, "must be finite and not empty"));
        }
        if low.is_empty() {
            return Err(crate::Error::parameter("bounds", "no dimension", "must have at least one"));
        }
        Ok(Bounds { low, high })
    }

    /// Number of dimensions.
    pub fn dimension(&self) -> usize {
        self.low.len()
    }

    /// Lower corner.
    pub fn low(&self) -> &[f64] {
        &self.low
    }

    /// Upper corner.
    pub fn high(&self) -> &[f64] {
        &self.high
    }
}
