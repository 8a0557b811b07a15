//! Wild values in the output: transmission errors, error codes, overflows. They are outliers so large that the other
//! detectors see the record without them.
//!
//! The core of a series is all samples between its 1 % and 99 % quantiles, extended by the other samples up to the
//! first gap that is wider than the core. Samples outside the core are wild, unless the input has such samples too. If
//! the core is constant, no sample is wild.

use super::detector::{Consequence, Detector};
use super::runs::{places, runs};
use super::{Detection, bridged};
use crate::record::Record;
use piezoid_numerics::number::short;
use piezoid_numerics::series::quantile;

/// Share of the samples on each side outside the initial core.
const TAIL_SHARE: f64 = 0.01;

pub(super) static WILD_VALUES: Detector = Detector {
    name: "outliers",
    criterion: "the output is far outside the range of all other samples, the input is not: error codes, overflows",
    consequence: Consequence::Masked,
    loop_remedy: None,
    run: |context| context.wild().map(|wild| wild.found.clone()),
};

/// The wild values of an output.
pub(super) struct Wild {
    pub(super) found: Detection,
    /// The record, interpolated over them.
    pub(super) interpolated: Record,
}

pub(super) fn wild(record: &Record) -> Option<Wild> {
    let y = record.y();
    let (low, high) = core(y).filter(|_| calm(record.u()))?;
    let inside: Vec<bool> = y.iter().map(|y| (low..=high).contains(y)).collect();
    let samples = runs(y.len(), 0, |t| !inside[t]);
    if samples.is_empty() {
        return None;
    }
    let interpolated = Record::new(record.ts(), record.u().to_vec(), bridged(y, &inside)).ok()?;
    let beyond = samples.iter().flat_map(|run| &y[run.clone()]);
    let wildest = beyond.fold(low, |m, &y| if (y - low).abs() > (m - low).abs() { y } else { m });
    let unit = &record.units().y;
    let (places, [wildest, low, high]) = (places(&samples, record.ts()), [wildest, low, high].map(short));
    let text = format!(
        "the output has outliers: {places}, up to {wildest} {unit}, while all other samples are between {low} and \
         {high} {unit}"
    );
    let interpolated = interpolated.with_units(record.units().clone());
    Some(Wild { found: Detection { samples, text }, interpolated })
}

/// True if a series has no wild values.
fn calm(x: &[f64]) -> bool {
    core(x).is_some_and(|(low, high)| x.iter().all(|x| (low..=high).contains(x)))
}

/// The range of the core; `None` if it is constant.
fn core(x: &[f64]) -> Option<(f64, f64)> {
    let (mut low, mut high) = (quantile(x.to_vec(), TAIL_SHARE), quantile(x.to_vec(), 1.0 - TAIL_SHARE));
    let mut beyond: Vec<f64> = x.iter().copied().filter(|x| !(low..=high).contains(x)).collect();
    // The nearest samples first.
    beyond.sort_by(|a, b| (a - a.clamp(low, high)).abs().total_cmp(&(b - b.clamp(low, high)).abs()));
    for x in beyond {
        if x - high > high - low || low - x > high - low {
            break;
        }
        (low, high) = (low.min(x), high.max(x));
    }
    (low < high).then_some((low, high))
}
