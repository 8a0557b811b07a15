//! Where an axis goes after a drive.

use piezoid::System;
use piezoid_numerics::options::OptionKind;
use serde::{Deserialize, Serialize};

/// Where the axis goes after the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Rest {
    /// To the voltage that it had before; in closed loop again if it was.
    #[default]
    Start,
    /// To 0 V.
    Zero,
    /// Nowhere: it stays at the last voltage of the drive.
    Stay,
}

impl Rest {
    /// A range of voltages, and the one of rest if it is known [V].
    pub(crate) fn with(self, (low, high): (f64, f64)) -> (f64, f64) {
        if self == Rest::Zero { (low.min(0.0), high.max(0.0)) } else { (low, high) }
    }
}

/// The voltage of a range that is nearest to 0 [V].
pub(crate) fn nearest_to_zero((low, high): (f64, f64)) -> f64 {
    low.max(0.0).min(high)
}

/// That voltage, and the state of a plant that has rested there.
pub(crate) fn at_rest(plant: &dyn System, range: (f64, f64)) -> (f64, Vec<f64>) {
    let start = nearest_to_zero(range);
    (start, if start == 0.0 { plant.initial() } else { plant.settled(start) })
}

pub(crate) const RESTS: OptionKind = OptionKind::Choice(&[
    ("start", "To the voltage that it had before; in closed loop again if it was, or to that position"),
    ("zero", "To 0 V, in open loop"),
    ("stay", "It stays at the last value of the drive, with the servo as it was for the drive"),
]);
