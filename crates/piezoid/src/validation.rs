//! Proof on data the model has not seen: free run, never one step ahead.
//!
//! The free run starts settled at the record's first input, since an actuator has a past; the first `skip` seconds are
//! left out of the figures.

use crate::error::Error;
use crate::hammerstein::{Beginning, Model, dominant_frequency};
use crate::number::short;
use crate::record::{Record, same_sampling};
use crate::series::{ends, mean, scatter};
use crate::system::System;
use serde::Serialize;

/// Share of the identified range that an input must come back by to have turned, and stay off its ends to have turned
/// inside the loop.
const INSIDE: f64 = 0.05;

/// Share of a record that tells how it began.
const FIRST: f64 = 0.1;

/// How far a model is from a record, in the record's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Metrics {
    /// Samples compared.
    pub n: usize,
    /// Mean squared error [unit^2].
    pub mse: f64,
    /// Root mean squared error [unit].
    pub rmse: f64,
    /// 100 rms error / standard deviation of y.
    pub nrmse_percent: f64,
    /// 100 rms error / peak-to-peak of y.
    pub rms_pp_percent: f64,
    /// Largest absolute error [unit].
    pub max_abs: f64,
    /// 100 - nrmse_percent.
    pub fit_percent: f64,
    /// Standard deviation of y [unit].
    pub std: f64,
    /// Peak-to-peak of y [unit].
    pub peak_to_peak: f64,
}

impl Metrics {
    /// How far `simulated` is from `y`, which is as long and not empty.
    ///
    /// ```
    /// let m = piezoid::validation::Metrics::of(&[0.0, 2.0], &[0.0, 1.0]);
    /// assert_eq!((m.mse, m.rms_pp_percent, m.max_abs), (0.5, 50.0 * 0.5f64.sqrt(), 1.0));
    /// ```
    pub fn of(y: &[f64], simulated: &[f64]) -> Self {
        let n = y.len();
        let squares: f64 = y.iter().zip(simulated).map(|(y, s)| (y - s).powi(2)).sum();
        let variance = scatter(y) / n as f64;
        let (low, high) = ends(y.iter().copied());
        let max_abs = y.iter().zip(simulated).map(|(y, s)| (y - s).abs()).fold(0.0, larger);
        Metrics::from_parts(n, squares / n as f64, variance.sqrt(), high - low, max_abs)
    }

    /// All records as one: squared errors and variances (about each record's own mean, since offsets between records
    /// would flatter) are pooled; peak-to-peak and the largest error are the largest of any.
    pub fn total(records: &[Metrics]) -> Self {
        let n: usize = records.iter().map(|m| m.n).sum();
        let pooled = |f: &dyn Fn(&Metrics) -> f64| records.iter().map(|m| m.n as f64 * f(m)).sum::<f64>() / n as f64;
        let widest = |f: &dyn Fn(&Metrics) -> f64| records.iter().map(f).fold(0.0, larger);
        let (mse, variance) = (pooled(&|m| m.mse), pooled(&|m| m.std.powi(2)));
        Metrics::from_parts(n, mse, variance.sqrt(), widest(&|m| m.peak_to_peak), widest(&|m| m.max_abs))
    }

    fn from_parts(n: usize, mse: f64, std: f64, peak_to_peak: f64, max_abs: f64) -> Self {
        let rmse = mse.sqrt();
        let nrmse_percent = 100.0 * rmse / std;
        Metrics {
            n,
            mse,
            rmse,
            nrmse_percent,
            rms_pp_percent: 100.0 * rmse / peak_to_peak,
            max_abs,
            fit_percent: 100.0 - nrmse_percent,
            std,
            peak_to_peak,
        }
    }
}

/// The larger of two, or the one that is no number: an error that does not exist must not look small.
fn larger(m: f64, e: f64) -> f64 {
    if e > m || e.is_nan() { e } else { m }
}

/// How to compare.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// Seconds at the start that do not count.
    pub skip: f64,
    /// Take the mean error off first: sensors drift.
    pub free_offset: bool,
}

/// A free run beside its record.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// The figures.
    pub metrics: Metrics,
    /// The free run over the whole record, with the mean error added where the offset is free [record's unit].
    pub simulated: Vec<f64>,
    /// First sample that counts.
    pub start: usize,
    /// The mean error that was taken off, where the offset is free [record's unit].
    pub taken_off: Option<f64>,
    /// What the reader of the figures should know.
    pub remarks: Vec<String>,
}

/// Runs `model` free over `record` and compares.
///
/// # Errors
/// Refuses a record of another sampling period, of units that cannot be converted, or shorter than `skip`.
pub fn validate(model: &Model, record: &Record, settings: Settings) -> Result<Validation, Error> {
    same_sampling("the model", model.ts(), "the record", record.ts())?;
    if record.units().u != model.units().u {
        let (found, wanted) = (record.units().u.clone(), model.units().u.clone());
        return Err(Error::Units { what: "the input of the record".into(), found, wanted });
    }
    let known = crate::record::factor(&model.units().y, &record.units().y);
    let k = known.ok_or_else(|| Error::Units {
        what: "the output of the record".into(),
        found: record.units().y.clone(),
        wanted: model.units().y.clone(),
    })?;
    let start = crate::record::span(settings.skip, f64::INFINITY, record.ts(), record.len())?.start;
    let (mut simulated, _beginning) = begun(model, record, k, settings.free_offset);
    let mut taken_off = None;
    if settings.free_offset {
        let errors = record.y()[start..].iter().zip(&simulated[start..]).map(|(y, s)| y - s);
        let mean = errors.sum::<f64>() / (record.len() - start) as f64;
        simulated.iter_mut().for_each(|y| *y += mean);
        taken_off = Some(mean);
    }
    let metrics = Metrics::of(&record.y()[start..], &simulated[start..]);
    let remarks = remarks(model, record, start, &metrics);
    Ok(Validation { metrics, simulated, start, taken_off, remarks })
}

/// The free run from the beginning that leaves least of the first part of the record, in its unit: the input alone does not
/// tell what the actuator did before.
fn begun(model: &Model, record: &Record, k: f64, free_offset: bool) -> (Vec<f64>, Beginning) {
    let u = record.u();
    let part = (u.len() as f64 * FIRST).ceil() as usize;
    let left = |beginning: Beginning| {
        let simulated = model.resume(&mut model.before(u, beginning), &u[..part]);
        let e: Vec<f64> = record.y().iter().zip(&simulated).map(|(y, s)| y - k * s).collect();
        let offset = if free_offset { mean(&e) } else { 0.0 };
        e.iter().map(|e| (e - offset).powi(2)).sum::<f64>()
    };
    // Where two leave the same, the likelier.
    let all = Beginning::of(u).map(|beginning| (left(beginning), beginning));
    let (_, beginning) =
        all.into_iter().fold((f64::INFINITY, all[0].1), |best, one| if one.0 < best.0 { one } else { best });
    let simulated = model.resume(&mut model.before(u, beginning), u);
    (simulated.into_iter().map(|y| k * y).collect(), beginning)
}

/// What about this record is beyond what the model, or the figures, can do.
fn remarks(model: &Model, record: &Record, start: usize, metrics: &Metrics) -> Vec<String> {
    let mut remarks: Vec<String> = match (metrics.mse.is_finite(), metrics.nrmse_percent.is_finite()) {
        (false, _) => vec![
            "the error is beyond what numbers can hold: figures that do not exist are - in tables and null in JSON"
                .into(),
        ],
        (true, false) => vec![
            "the output does not change, so its error has no share of it: that is - in tables and null in JSON".into(),
        ],
        (true, true) => Vec::new(),
    };
    let unit = &model.units().u;
    let Some((low, high)) = model.hysteresis().range() else { return remarks };
    let u = &record.u()[start..];
    let (lowest, highest) = ends(u.iter().copied());
    if lowest < low - 0.01 * (high - low) || highest > high + 0.01 * (high - low) {
        remarks.push(format!(
            "the input runs from {} to {} {unit}, but the model was identified from {} to {} {unit}: beyond that it extrapolates",
            short(lowest),
            short(highest),
            short(low),
            short(high)
        ));
    }
    let frequency = dominant_frequency(u, record.ts());
    if let Some(((slowest, fastest), hz)) = model.hysteresis().frequencies().zip(frequency)
        && !(0.9 * slowest..=1.1 * fastest).contains(&hz)
    {
        remarks.push(format!(
            "the input goes to and fro at {} Hz, but the model was identified from {} to {} Hz: beyond that it extrapolates",
            short(hz),
            short(slowest),
            short(fastest)
        ));
    }
    let turns = inner_turns(u, low, high);
    let operator = model.hysteresis().operator();
    if turns > 0 && !operator.minor_loops {
        remarks.push(format!(
            "the input turns {turns} times inside the identified range, and the {} block has no minor loops: at each such turn it \
             jumps to the other branch of the full loop instead of following a smaller one",
            operator.name
        ));
    }
    remarks
}

/// Turns of `u` that lie inside the range from `low` to `high`, away from its ends.
fn inner_turns(u: &[f64], low: f64, high: f64) -> usize {
    let margin = INSIDE * (high - low);
    let (mut extreme, mut trend, mut turns) = (u[0], 0.0, 0);
    for &u in u {
        if (u - extreme) * trend > 0.0 {
            extreme = u;
        } else if (u - extreme).abs() > margin {
            turns += usize::from(trend != 0.0 && extreme > low + margin && extreme < high - margin);
            (trend, extreme) = ((u - extreme).signum(), u);
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_close;

    #[test]
    fn a_total_of_one_is_that_one_and_offsets_between_records_do_not_flatter() {
        let y: Vec<f64> = (0..100).map(|t| f64::from(t % 10)).collect();
        let shifted: Vec<f64> = y.iter().map(|y| y + 1000.0).collect();
        let off = |y: &[f64]| y.iter().map(|y| y + 0.5).collect::<Vec<_>>();
        let one = Metrics::of(&y, &off(&y));
        let total = Metrics::total(&[one, Metrics::of(&shifted, &off(&shifted))]);
        assert_close(&[total.nrmse_percent, total.rms_pp_percent], &[one.nrmse_percent, one.rms_pp_percent], 1e-9, 0.0);
        assert_eq!(total.n, 200);
    }

    #[test]
    fn turns_are_counted_inside_the_range_only() {
        let full: Vec<f64> = (0..400).map(|t| (f64::from(t) * 0.1).sin()).collect();
        assert_eq!(inner_turns(&full, -1.0, 1.0), 0);
        let half: Vec<f64> = full.iter().map(|u| 0.5 * u).collect();
        assert_eq!(inner_turns(&half, -1.0, 1.0), 12);
    }
}
