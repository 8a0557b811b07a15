//! Wild values in the output: transmission errors, error codes, overflows.
//!
//! The core of a series is all samples between its 1 % and 99 % quantiles, extended by the other samples up to the
//! first gap that is wider than the core. Samples outside the core are wild, unless the input has such samples too. If
//! the core is constant, no sample is wild.

use super::runs::{quantile, runs};
use super::{Defect, Finding, bridged, places};
use crate::number::short;
use crate::record::Record;

/// Share of the samples on each side outside the initial core.
const BEYOND: f64 = 0.01;

/// The wild values of the output, and the record with interpolated values in their place.
pub(super) fn wild(record: &Record) -> (Option<Finding>, Option<Record>) {
    let y = record.y();
    let (Some((low, high)), true) = (core(y), calm(record.u())) else { return (None, None) };
    let inside: Vec<bool> = y.iter().map(|y| (low..=high).contains(y)).collect();
    let samples = runs(y.len(), 0, |t| !inside[t]);
    let tame = Record::new(record.ts(), record.u().to_vec(), bridged(y, &inside)).ok();
    let Some(tame) = tame.filter(|_| !samples.is_empty()) else { return (None, None) };
    let beyond = samples.iter().flat_map(|run| &y[run.clone()]);
    let wildest = beyond.fold(low, |m, &y| if (y - low).abs() > (m - low).abs() { y } else { m });
    let unit = &record.units().y;
    let text = format!(
        "the output has outliers: {}, up to {} {unit}, while all other samples are between {} and {} {unit}",
        places(&samples, record.ts()),
        short(wildest),
        short(low),
        short(high)
    );
    let finding = Finding { defect: Defect::Outliers, samples, text };
    (Some(finding), Some(tame.with_units(record.units().clone())))
}

/// True if a series has no wild values.
fn calm(x: &[f64]) -> bool {
    core(x).is_some_and(|(low, high)| x.iter().all(|x| (low..=high).contains(x)))
}

/// The range of the core; `None` if it is constant.
fn core(x: &[f64]) -> Option<(f64, f64)> {
    let (mut low, mut high) = (quantile(x.to_vec(), BEYOND), quantile(x.to_vec(), 1.0 - BEYOND));
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
