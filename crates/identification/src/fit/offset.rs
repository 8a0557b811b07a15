//! The offset of the model: the median over all records, because sensors drift.

use super::dynamics::{creep_pole, slowest_observable};
use super::estimate::Responses;
use super::fitted::Fitted;
use super::free_run::free_run_residual;
use super::layout::ColumnLayout;
use super::runs::TrainingRecord;
use piezoid_numerics::number::short;
use piezoid_numerics::series::dot;

/// A lag is slow if the longest record is shorter than this number of its time constants.
const SLOW_LAG_TIME_CONSTANTS: f64 = 20.0;

/// Range of the offsets over the largest peak-to-peak of y from which there is a note.
const NOTED_OFFSET_RANGE: f64 = 0.02;

/// The offset of the model [output unit]. If the fit cannot separate the offset of a record from the state of a slow
/// lag, the free run determines it.
pub(crate) fn offset(fitted: &Fitted, runs: &[TrainingRecord], notes: &mut Vec<String>, unit: &str) -> f64 {
    let estimate = &fitted.estimate;
    let layout = ColumnLayout::of(estimate);
    let constant = layout.constant - layout.parameters();
    let slowest = SLOW_LAG_TIME_CONSTANTS * slowest_observable(runs.iter().map(|run| run.record));
    let is_slow = creep_pole(&estimate.linear, slowest).is_some();
    let free = estimate.model(0.0).ok().filter(|_| is_slow);
    let creep: f64 = 1.0 + estimate.lags.iter().map(|lag| lag.gain).sum::<f64>();
    let of = |(run, own): (&TrainingRecord, &Vec<f64>)| {
        let first = dot(&Responses::level(estimate, run), &estimate.weights);
        let fits = run.level + own[constant] - estimate.linear.dc_gain() * creep * first;
        let Some((mean, rms)) = free.as_ref().map(|model| free_run_residual(run, model)) else { return fits };
        if (mean - fits).abs() > rms { mean } else { fits }
    };
    let begins = runs.iter().zip(&fitted.own).filter(|(run, _)| !run.is_later_part);
    let (measured, others): (Vec<_>, Vec<_>) = begins.partition(|(run, _)| run.usable.contains(&true));
    // The level of a part without usable samples is no measurement, but better than nothing.
    let begins = if measured.is_empty() { others } else { measured };
    let mut offsets: Vec<f64> = begins.into_iter().map(of).collect();
    offsets.sort_by(f64::total_cmp);
    let (low, high) = (offsets[0], offsets[offsets.len() - 1]);
    let height = runs.iter().map(|run| run.scale.recip()).fold(0.0, f64::max);
    if high - low > NOTED_OFFSET_RANGE * height {
        notes.push(format!(
            "the offsets of the records differ by up to {} {unit}, {} % of the largest height: the sensor drifts, or \
             the initial conditions differ; the model uses the median offset",
            short(high - low),
            short(100.0 * (high - low) / height)
        ));
    }
    offsets[offsets.len() / 2]
}
