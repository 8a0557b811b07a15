//! Drift: a slow trend of the output that the input does not explain.
//!
//! The part that the input does not explain is averaged over blocks of whole periods. Creep after a change of the input
//! goes with the logarithm of time, so of what it does from the middle of the first of ten blocks to the middle of the
//! last it does a fifth in the second half; a drift does half. Both at once cannot be told apart.

use super::explained::by_input;
use super::{Defect, Finding};
use crate::number::short;
use crate::record::Record;
use crate::series::{ends, mean};
use crate::waveform::dominant_frequency;

/// The smallest drift worth a word, over the range of the output.
const SMALLEST: f64 = 0.03;

/// Up to here a trend that slows down may be creep, over the range of the output.
const CREEP: f64 = 0.06;

/// Share of the trend in the second half, below which it slows down.
const SLOWS: f64 = 0.35;

/// A trend must exceed the scatter of the blocks so many times.
const CLEAR: f64 = 6.0;

/// Inputs that explain the output, and the ridge of that explanation.
const LAGS: std::ops::Range<isize> = 0..16;
const RIDGE: f64 = 1e-3;

/// Blocks, and the fewest that show a trend.
const BLOCKS: (usize, usize) = (10, 4);

pub(super) fn drift(record: &Record) -> Option<Finding> {
    let n = record.len();
    let period = dominant_frequency(record.u(), record.ts()).map_or(1.0, |hz| 1.0 / (hz * record.ts()));
    // Whole periods a block, however the period falls between samples.
    let periods = (n as f64 / BLOCKS.0 as f64 / period).max(1.0).floor();
    let blocks = (n as f64 / (periods * period)).floor() as usize;
    if blocks < BLOCKS.1 {
        return None;
    }
    let end = |k: usize| ((k as f64 * periods * period).round() as usize).min(n);
    let explained = by_input(record.u(), record.y(), LAGS, RIDGE);
    let left: Vec<f64> = record.y().iter().zip(&explained).map(|(y, e)| y - e).collect();
    let means: Vec<f64> = (0..blocks).map(|k| mean(&left[end(k)..end(k + 1)])).collect();
    let (first, middle, last) = (means[0], means[blocks / 2], means[blocks - 1]);
    let (total, second_half) = (last - first, last - 0.5 * (middle + means[(blocks - 1) / 2]));
    let bends: Vec<f64> = means.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2) / 6.0).collect();
    let scatter = mean(&bends).sqrt();
    let (low, high) = ends(record.y().iter().copied());
    let share = total.abs() / (high - low);
    let slows = second_half / total < SLOWS;
    if share < SMALLEST || total.abs() < CLEAR * scatter || (slows && share < CREEP) {
        return None;
    }
    let unit = &record.units().y;
    let seconds = (blocks - 1) as f64 * periods * period * record.ts();
    let kind = if slows { "it slows down, as creep does" } else { "it does not slow down, as creep would" };
    let text = format!(
        "the output drifts by {} {unit} in {} s ({} % of peak-to-peak), which the input does not explain; {kind}",
        short(total),
        short(seconds),
        short(100.0 * share)
    );
    Some(Finding { defect: Defect::Drift, samples: Vec::new(), text })
}
