//! Drift: a slow trend of the output that the input does not explain.
//!
//! The part of the output not explained by the input is averaged over ten blocks of whole periods. Creep after a step
//! of the input grows with the logarithm of time: between the middle of the first block and the middle of the last one,
//! 1/5 of the creep occurs in the second half. Of a drift, 1/2 occurs there. The sum of creep and drift cannot be
//! separated.

use super::Detection;
use super::detector::{Consequence, Detector};
use super::explained::by_input;
use crate::record::Record;
use crate::waveform::dominant_frequency;
use piezoid_numerics::number::short;
use piezoid_numerics::series::{mean, range};

/// The smallest reported drift, relative to the range of the output.
const MIN_DRIFT_SHARE: f64 = 0.03;

/// A smaller trend that slows down may be creep, relative to the range of the output.
const MAX_CREEP_SHARE: f64 = 0.06;

/// A trend slows down if a smaller share of it is in the second half.
const MAX_SLOWING_SHARE: f64 = 0.35;

/// A trend must exceed the standard deviation of the blocks by this factor.
const MIN_DRIFT_DEVIATIONS: f64 = 6.0;

/// Lags and ridge of the regression on the input.
const INPUT_LAGS: std::ops::Range<isize> = 0..16;
const RIDGE: f64 = 1e-3;

/// Number of blocks, and the minimum number for a trend.
const BLOCK_COUNT: usize = 10;
const MIN_BLOCK_COUNT: usize = 4;

/// An input rests in a block in which it moves by less than this share of its range, and a record rests if this share
/// of its blocks do.
const REST_RANGE_SHARE: f64 = 0.05;
const RESTING_BLOCK_SHARE: f64 = 0.5;

/// A slow drift of the output.
pub static DRIFT: Detector = Detector {
    name: "drift",
    criterion: "the output has a trend of 3 % of its range that the input does not explain, 6 % if it slows down like creep",
    consequence: Consequence::Reported,
    loop_remedy: Some("remove the trend first, or choose a part of few cycles"),
    run: |context| drift(context.record()),
};

fn drift(record: &Record) -> Option<Detection> {
    let n = record.len();
    let period = match dominant_frequency(record.u(), record.ts()) {
        Some(hz) => 1.0 / (hz * record.ts()),
        // Within one cycle the hysteresis is a trend too. Where the input rests, only creep and drift are.
        None if rests(record.u()) => 1.0,
        None => return None,
    };
    // Whole periods per block; the period need not be a whole number of samples.
    let periods = (n as f64 / BLOCK_COUNT as f64 / period).max(1.0).floor();
    let blocks = (n as f64 / (periods * period)).floor() as usize;
    if blocks < MIN_BLOCK_COUNT {
        return None;
    }
    let end = |k: usize| ((k as f64 * periods * period).round() as usize).min(n);
    let explained = by_input(record.u(), record.y(), INPUT_LAGS, RIDGE);
    let residual: Vec<f64> = record.y().iter().zip(&explained).map(|(y, e)| y - e).collect();
    let means: Vec<f64> = (0..blocks).map(|k| mean(&residual[end(k)..end(k + 1)])).collect();
    let (first, middle, last) = (means[0], means[blocks / 2], means[blocks - 1]);
    let (total, second_half) = (last - first, last - 0.5 * (middle + means[(blocks - 1) / 2]));
    let bends: Vec<f64> = means.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2) / 6.0).collect();
    let scatter = mean(&bends).sqrt();
    let share = total.abs() / range(record.y());
    let slows = second_half / total < MAX_SLOWING_SHARE;
    if share < MIN_DRIFT_SHARE || total.abs() < MIN_DRIFT_DEVIATIONS * scatter || (slows && share < MAX_CREEP_SHARE) {
        return None;
    }
    let unit = &record.units().y;
    let seconds = (blocks - 1) as f64 * periods * period * record.ts();
    let kind =
        if slows { "it slows down like creep" } else { "it does not slow down like creep, so the sensor may drift" };
    let [total, seconds, percent] = [total, seconds, 100.0 * share].map(short);
    let drift = format!("the output drifts by {total} {unit} in {seconds} s ({percent} % of stroke)");
    Some(format!("{drift}, not explained by the input; {kind}").into())
}

/// True if the input rests for most of a record.
fn rests(u: &[f64]) -> bool {
    let (all, size) = (range(u), (u.len() / BLOCK_COUNT).max(1));
    let still = u.chunks(size).filter(|block| range(block) < REST_RANGE_SHARE * all).count();
    still as f64 >= RESTING_BLOCK_SHARE * u.chunks(size).count() as f64
}
