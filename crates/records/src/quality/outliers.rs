//! Outliers: single samples of the output far from their neighbours.
//!
//! ```text
//! i_t = r_t - (-r_{t-2} + 4 r_{t-1} + 4 r_{t+1} - r_{t+2}) / 6
//! ```
//! is the error of a cubic through four neighbours, for the part r of the output not explained by the input (i is
//! linear in the output, therefore i itself is regressed on the input). A spike of size s at t gives s (1/6, -2/3, 1,
//! -2/3, 1/6) around t. A spike is reported if it has this shape, exceeds the scatter of i around it (Hampel's rule, by
//! the median) and its neighbours, is not too small relative to the range, and is sharper than a response to a step of
//! the input. Spikes of several samples, and two spikes within eight samples, are not found.

use super::Detection;
use super::detector::{Consequence, Detector};
use super::explained::by_input;
use super::runs::{places, resolution};
use crate::record::Record;
use piezoid_numerics::number::short;
use piezoid_numerics::series::{largest, quantile, range};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The response i to a spike of size 1.
const SPIKE_SHAPE: [f64; 5] = [1.0 / 6.0, -2.0 / 3.0, 1.0, -2.0 / 3.0, 1.0 / 6.0];

/// The shape must explain this share of the power around a spike.
const MIN_SHAPE_POWER_SHARE: f64 = 0.9;

/// A spike must exceed this number of standard deviations of the scatter around it. Noise does so once in 1e15 samples.
const MIN_SCATTER_DEVIATIONS: f64 = 8.0;

/// The smallest spike, relative to the range of the output.
const MIN_SPIKE_SHARE: f64 = 1e-2;

/// A spike must exceed this share of the usual response to an equally sharp change of the input.
const MIN_RESPONSE_SHARE: f64 = 0.75;

/// Lags of the regression of i (which uses two future samples) on the input. At larger lags the output is smooth.
const INPUT_LAGS: std::ops::Range<isize> = -2..18;

/// Ridge of this regression.
const RIDGE: f64 = 1e-6;

/// The output responds to a sharp change of the input within this number of samples.
const RESPONSE_SAMPLES: usize = 6;

/// A spike (three samples wide) must exceed this number of samples on both sides by this factor; ringing does not.
const NEIGHBOUR_SAMPLES: usize = 8;
const MIN_NEIGHBOUR_RATIO: f64 = 1.5;

/// Maximum number of searches.
const MAX_SEARCHES: usize = 6;

/// Samples on each side of a spike for the scatter.
const SCATTER_SAMPLES: usize = 50;

pub(crate) static OUTLIERS: Detector = Detector {
    name: "outliers",
    criterion: "one sample of the output differs from its neighbours by more than usual (Hampel)",
    consequence: Consequence::Masked,
    loop_remedy: None,
    run: |context| outliers(context.record(), &context.usable),
};

/// The outliers among the usable samples.
fn outliers(record: &Record, usable: &[bool]) -> Option<Detection> {
    let n = record.len();
    if n < 2 * SCATTER_SAMPLES {
        return None;
    }
    let stroke = range(record.y());
    let smallest = (MIN_SPIKE_SHARE * stroke).max(3.0 * resolution(record.y()));
    let mut y = Cow::Borrowed(record.y());
    let mut found: BTreeMap<usize, f64> = BTreeMap::new();
    // Large spikes distort the regression: they are removed before smaller ones are searched.
    for _ in 0..MAX_SEARCHES {
        let spikes = spikes(record.u(), &y, smallest, usable);
        let most = largest(spikes.iter().map(|(_, size)| size));
        for (t, size) in spikes.into_iter().filter(|(_, size)| size.abs() > 0.5 * most) {
            *found.entry(t).or_default() += size;
            y.to_mut()[t] -= size;
        }
        if most == 0.0 {
            break;
        }
    }
    found.retain(|_, size| size.abs() > smallest);
    let most = largest(found.values());
    // Many spikes are a property of the output: ripple, or a sensor that misses every second step.
    if found.is_empty() || found.len() > 1 + n / 50 {
        return None;
    }
    let ranges: Vec<_> = found.keys().map(|t| *t..t + 1).collect();
    let (places, unit) = (places(&ranges, record.ts()), &record.units().y);
    let [most, percent] = [most, 100.0 * most / stroke].map(short);
    let text = format!(
        "the output has outliers: {places}, the largest {most} {unit} from its neighbours ({percent} % of stroke)"
    );
    Some(Detection { samples: ranges, text })
}

/// The spikes of `y` with their sizes.
fn spikes(u: &[f64], y: &[f64], smallest: f64, usable: &[bool]) -> Vec<(usize, f64)> {
    let n = y.len();
    let mut i: Vec<f64> = (0..n).map(|t| off_neighbours(y, t)).collect();
    let gain = sharp_gain(u, &i);
    let explained = by_input(u, &i, INPUT_LAGS, RIDGE);
    i.iter_mut().zip(&explained).for_each(|(i, explained)| *i -= explained);
    let power: f64 = SPIKE_SHAPE.iter().map(|p| p * p).sum();
    let size = |t: usize| {
        let around = &i[t - 2..=t + 2];
        let size = around.iter().zip(SPIKE_SHAPE).map(|(i, p)| i * p).sum::<f64>() / power;
        let alike = size * size * power >= MIN_SHAPE_POWER_SHARE * around.iter().map(|i| i * i).sum::<f64>();
        (alike && size.abs() > smallest).then_some(size)
    };
    // The lags of the first samples begin before the record.
    let past = INPUT_LAGS.end as usize;
    let clear = |t: &usize| !usable[t - past..=t + 4].contains(&false);
    let stands_out = |(t, size): (usize, f64)| {
        let usual: Vec<f64> =
            i[t.saturating_sub(SCATTER_SAMPLES)..(t + SCATTER_SAMPLES).min(n)].iter().map(|i| i.abs()).collect();
        // The median of absolute values of normal noise is 0.6745 standard deviations.
        let scatter = quantile(usual, 0.5) / 0.6745;
        let sharpest = (t - past - 2..=t + 2).map(|t| off_neighbours(u, t).abs()).fold(0.0, f64::max);
        let beside = largest(i[t - NEIGHBOUR_SAMPLES..t - 2].iter().chain(&i[t + 3..=t + NEIGHBOUR_SAMPLES]));
        (size.abs() > MIN_SCATTER_DEVIATIONS * scatter
            && size.abs() > MIN_RESPONSE_SHARE * gain * sharpest
            && size.abs() > MIN_NEIGHBOUR_RATIO * beside)
            .then_some((t, size))
    };
    (past + 3..n - NEIGHBOUR_SAMPLES).filter(clear).filter_map(|t| stands_out((t, size(t)?))).collect()
}

/// The error at t of a cubic through two neighbours on each side; 0 at the ends.
fn off_neighbours(x: &[f64], t: usize) -> f64 {
    match t.checked_sub(2).and_then(|from| x.get(from..=t + 2)) {
        Some([a, b, x, c, d]) => x - (4.0 * (b + c) - a - d) / 6.0,
        _ => 0.0,
    }
}

/// Median gain from sharp changes of the input to the response of the output; a few spikes do not affect it.
fn sharp_gain(u: &[f64], answers: &[f64]) -> f64 {
    let changes = || (0..u.len()).map(|t| off_neighbours(u, t).abs()).enumerate();
    let sharpest = changes().map(|(_, change)| change).fold(0.0, f64::max);
    let answer = |t: usize| largest(&answers[t..(t + RESPONSE_SAMPLES).min(answers.len())]);
    let sharp = changes().filter(|(_, change)| *change > 0.5 * sharpest);
    quantile(sharp.map(|(t, change)| answer(t) / change).collect(), 0.5)
}
