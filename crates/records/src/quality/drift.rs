//! Drift: a slow trend of the output that the input does not explain.
//!
//! The part of the output not explained by the input is averaged over ten blocks of whole periods. Plays explain what
//! hysteresis does: the first stroke leaves a remanent displacement, and larger strokes leave more.
//!
//! Creep after a step of the input grows with the logarithm of time: between the middle of the first block and the
//! middle of the last one, 1/5 of the creep occurs in the second half. Of a drift, 1/2 occurs there. The sum of creep
//! and drift cannot be separated. Creep is proportional to the last large movement. Before a record about a bias, this
//! is the movement from 0 to the bias.

use super::Detection;
use super::detector::{Consequence, Detector};
use super::explained::by_input;
use super::plays;
use crate::record::Record;
use crate::waveform::dominant_frequency;
use piezoid_numerics::number::short;
use piezoid_numerics::series::{largest, mean, range};

/// The smallest reported drift, relative to the range of the output.
const MIN_DRIFT_SHARE: f64 = 0.03;

/// A smaller trend that slows down may be creep, relative to the output's movement with the input from 0.
const MAX_CREEP_SHARE: f64 = 0.06;

/// A trend slows down if a smaller share of it is in the second half.
const MAX_SLOWING_SHARE: f64 = 0.35;

/// A trend must exceed the standard deviation of the blocks by this factor.
const MIN_DRIFT_DEVIATIONS: f64 = 6.0;

/// Share of a trend that must be left when plays explain what they can.
const MIN_LEFT_SHARE: f64 = 0.6;

/// Lags and ridge of the regression on the input.
const INPUT_LAGS: std::ops::Range<isize> = 0..16;
const RIDGE: f64 = 1e-3;

/// Largest difference of the mean inputs of the first and the last block, over the range of the input: at other inputs,
/// hysteresis and curvature make another output.
const MAX_INPUT_SHIFT_SHARE: f64 = 0.2;

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
    criterion: "the output has a trend of 3 % of its range that input and hysteresis do not explain, 6 % of its movement from 0 V if it slows down like creep",
    consequence: Consequence::Reported,
    loop_remedy: Some("remove the trend first, or choose a part of few cycles"),
    run: |context| drift(context.record()),
};

fn drift(record: &Record) -> Option<Detection> {
    let (n, u, y) = (record.len(), record.u(), record.y());
    let period = match dominant_frequency(u, record.ts()) {
        Some(hz) => 1.0 / (hz * record.ts()),
        // Within one cycle the hysteresis is a trend too. Where the input rests, only creep and drift are.
        None if rests(u) => 1.0,
        None => return None,
    };
    // Whole periods per block; the period need not be a whole number of samples.
    let periods = (n as f64 / BLOCK_COUNT as f64 / period).max(1.0).floor();
    let blocks = (n as f64 / (periods * period)).floor() as usize;
    if blocks < MIN_BLOCK_COUNT {
        return None;
    }
    let end = |k: usize| ((k as f64 * periods * period).round() as usize).min(n);
    let means = |x: &[f64]| (0..blocks).map(|k| mean(&x[end(k)..end(k + 1)])).collect::<Vec<f64>>();
    let inputs = means(u);
    if (inputs[blocks - 1] - inputs[0]).abs() > MAX_INPUT_SHIFT_SHARE * range(u) {
        return None;
    }
    let left = |y: &[f64], explained: &[f64]| y.iter().zip(explained).map(|(y, e)| y - e).collect::<Vec<f64>>();
    let trend = |y: &[f64]| Trend::of(&means(&left(y, &by_input(u, y, INPUT_LAGS, RIDGE))));
    let (stroke, voltage) = (range(y), range(u));
    // From 0 to the farthest input, which may be a movement before the record.
    let reach = voltage.max(largest(u));
    let is_clear = |trend: &Trend| {
        let least = if trend.slows() { MAX_CREEP_SHARE * reach / voltage } else { MIN_DRIFT_SHARE };
        trend.total.abs() >= least * stroke && trend.total.abs() >= MIN_DRIFT_DEVIATIONS * trend.scatter
    };
    // The fit of hysteresis takes time, and is poor near a resonance: both trends count.
    let plain = Some(trend(y)).filter(is_clear)?;
    let found = trend(&left(y, &plays::explained(u, y)?));
    let is_scattered = found.total.abs() < MIN_DRIFT_DEVIATIONS * found.scatter;
    if is_scattered || found.total / plain.total < MIN_LEFT_SHARE || (found.slows() && !is_clear(&found)) {
        return None;
    }
    let unit = &record.units().y;
    let seconds = (blocks - 1) as f64 * periods * period * record.ts();
    let kind = if found.slows() {
        "it slows down like creep"
    } else {
        "it does not slow down like creep that begins with the record: the sensor may drift, or the actuator creeps \
         after a larger movement before"
    };
    let [total, seconds, percent] = [found.total, seconds, 100.0 * found.total.abs() / stroke].map(short);
    let drift = format!("the output drifts by {total} {unit} in {seconds} s ({percent} % of stroke)");
    Some(format!("{drift}, not explained by the input; {kind}").into())
}

/// The trend of what the input does not explain.
struct Trend {
    /// From the first block to the last, and in the second half of the blocks.
    total: f64,
    second_half: f64,
    /// Standard deviation of a block.
    scatter: f64,
}

impl Trend {
    /// Of the means of blocks.
    fn of(means: &[f64]) -> Self {
        let blocks = means.len();
        let (first, middle, last) = (means[0], means[blocks / 2], means[blocks - 1]);
        let bends: Vec<f64> = means.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2) / 6.0).collect();
        let second_half = last - 0.5 * (middle + means[(blocks - 1) / 2]);
        Trend { total: last - first, second_half, scatter: mean(&bends).sqrt() }
    }

    /// True if it slows down as creep does.
    fn slows(&self) -> bool {
        self.second_half / self.total < MAX_SLOWING_SHARE
    }
}

/// True if the input rests for most of a record.
fn rests(u: &[f64]) -> bool {
    let (all, size) = (range(u), (u.len() / BLOCK_COUNT).max(1));
    let still = u.chunks(size).filter(|block| range(block) < REST_RANGE_SHARE * all).count();
    still as f64 >= RESTING_BLOCK_SHARE * u.chunks(size).count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::Multisine;
    use piezoid_testing::noise;

    const TS: f64 = 2e-3;

    /// The drift of an actuator that was never moved, with so much drift of its sensor [um].
    fn found(u: &[f64], drift_um: f64) -> Option<Detection> {
        let (n, mut plays) = (u.len() as f64, [0.0f64; 6]);
        let mut y: Vec<f64> = noise(5, u.len()).iter().map(|e| 2e-3 * e).collect();
        for (t, (y, u)) in y.iter_mut().zip(u).enumerate() {
            plays.iter_mut().enumerate().for_each(|(k, s)| *s = s.clamp(u - 4.0 * k as f64, u + 4.0 * k as f64));
            *y += 0.05 * u + 0.02 * plays.iter().sum::<f64>() + drift_um * t as f64 / n;
        }
        drift(&Record::new(TS, u.to_vec(), y).unwrap())
    }

    /// A stroke to each of these voltages, with a rest at 0 V after it.
    fn strokes(peaks: &[f64]) -> Vec<f64> {
        let stroke = |peak: &f64| {
            let up = (0..500).map(|t| f64::from(t) / 500.0).collect::<Vec<f64>>();
            let all = up.iter().copied().chain(up.iter().rev().copied()).chain([0.0; 300]);
            all.map(|part| part * peak).collect::<Vec<f64>>()
        };
        peaks.iter().flat_map(stroke).collect()
    }

    #[test]
    fn the_displacement_that_the_first_or_a_larger_stroke_leaves_is_no_drift() {
        for peaks in [&[100.0; 5][..], &[30.0, 60.0, 90.0, 120.0], &[60.0, 60.0, 60.0, 120.0, 120.0, 120.0]] {
            assert_eq!(found(&strokes(peaks), 0.0), None, "{peaks:?}");
        }
        let drifting = found(&strokes(&[100.0; 5]), 2.0).expect("a drift of the sensor");
        assert!(drifting.text.contains("does not slow down"), "{}", drifting.text);
    }

    #[test]
    fn a_wave_on_a_slow_ramp_returns_to_no_state_and_has_no_drift() {
        let raster: Vec<f64> = (0..8000).map(|t| 0.005 * f64::from(t) + 0.2 * f64::from(t % 200)).collect();
        assert_eq!(found(&raster, 3.0), None);
    }

    /// An output that creeps from 0 V to the bias, to which the actuator moved before.
    #[test]
    fn creep_after_a_bias_is_as_large_as_that_of_the_movement_to_the_bias() {
        let wave = Multisine { amplitude: 1.0, frequency_low: 1.0, frequency_high: 90.0, ..Multisine::default() };
        let u: Vec<f64> = wave.samples(TS, 6000).unwrap().iter().map(|u| 70.0 + u).collect();
        let found = |trend: &dyn Fn(f64) -> f64| {
            let y = u.iter().enumerate().map(|(t, u)| 0.1 * u + trend(t as f64)).collect();
            drift(&Record::new(TS, u.clone(), y).unwrap())
        };
        assert_eq!(found(&|t| 0.015 * 7.0 * (1.0 + t).log10()), None);
        assert!(found(&|t| 1e-4 * t).is_some());
    }
}
