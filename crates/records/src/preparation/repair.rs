//! The output with its outliers replaced, and without its mean or trend.

use super::Trend;
use crate::quality::{Consequence, OUTLIERS, bridged, inspect, places};
use crate::record::Record;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::series::mean;

/// The record with the outliers of its output replaced by the cubic through two samples on each side, or by the line
/// between the next samples if there is no such cubic. The inspection finds them: see [`crate::quality`].
pub(super) fn without_outliers(record: &Record) -> Result<Record, Error> {
    let findings = inspect(record).findings;
    if let Some(finding) = findings.iter().find(|finding| finding.detector.consequence == Consequence::Unusable) {
        return Err(Error::Content(format!("outliers cannot be found: {}", finding.text)));
    }
    let found = findings.into_iter().filter(|finding| finding.detector == &OUTLIERS);
    let mut ranges: Vec<_> = found.flat_map(|finding| finding.samples).collect();
    ranges.sort_by_key(|range| range.start);
    if ranges.is_empty() {
        return Ok(record.clone().with_step("no outliers were found in the output".into()));
    }
    let mut sound = vec![true; record.len()];
    ranges.iter().for_each(|range| sound[range.clone()].fill(false));
    let (before, mut y) = (record.y(), bridged(record.y(), &sound));
    for t in 2..y.len().saturating_sub(2) {
        let around = [t - 2, t - 1, t + 1, t + 2];
        if !sound[t] && around.iter().all(|k| sound[*k]) {
            y[t] = (4.0 * (before[t - 1] + before[t + 1]) - before[t - 2] - before[t + 2]) / 6.0;
        }
    }
    let step = format!("outliers of the output replaced by interpolation: {}", places(&ranges, record.ts()));
    Ok(record.with_samples(record.ts(), record.u().to_vec(), y)?.with_step(step))
}

/// The record without the mean of its output, or without the line that fits it best.
pub(super) fn detrended(record: &Record, trend: Trend) -> Result<Record, Error> {
    let (n, level, unit) = (record.len() as f64, mean(record.y()), &record.units().y);
    // Times about the middle, in samples.
    let time = |k: usize| k as f64 - 0.5 * (n - 1.0);
    let slope = match trend {
        Trend::Line if n > 1.0 => {
            let moment: f64 = record.y().iter().enumerate().map(|(k, y)| time(k) * (y - level)).sum();
            moment / (n * (n * n - 1.0) / 12.0)
        }
        _ => 0.0,
    };
    let y = record.y().iter().enumerate().map(|(k, y)| y - level - slope * time(k)).collect();
    let step = match trend {
        Trend::Mean => format!("mean of the output, {} {unit}, removed", short(level)),
        Trend::Line => {
            let per_second = short(slope / record.ts());
            format!("line removed from the output: {} {unit} in its middle, {per_second} {unit}/s", short(level))
        }
    };
    Ok(record.with_samples(record.ts(), record.u().to_vec(), y)?.with_step(step))
}
