//! Outliers: single samples of the output far off what their neighbours say.
//!
//! ```text
//! i_t = r_t - (-r_{t-2} + 4 r_{t-1} + 4 r_{t+1} - r_{t+2}) / 6
//! ```
//! is what a cubic through four neighbours misses, of the part r of the output that the input does not explain (i is linear
//! in the output, so it is i that the input is made to explain). A spike of
//! size s at t shows as s (1/6, -2/3, 1, -2/3, 1/6) around t. Taken for one is what has that shape, stands out of the
//! scatter of i around it (Hampel's rule, by the median) and out of its neighbours, is no crumb of the range, and is not as sharp as the answer to a
//! step of the input may be. Spikes of several samples, or two within eight samples, are not looked for.

use super::explained::by_input;
use super::runs::{quantile, resolution};
use super::{Defect, Finding, places};
use crate::number::short;
use crate::record::Record;
use crate::series::ends;
use std::collections::BTreeMap;

/// How a spike of size 1 shows.
const SHAPE: [f64; 5] = [1.0 / 6.0, -2.0 / 3.0, 1.0, -2.0 / 3.0, 1.0 / 6.0];

/// Share of the power around a spike that its shape must explain.
const ALIKE: f64 = 0.9;

/// Standard deviations of the scatter around it that a spike must exceed. Noise does that once in 1e15 samples.
const SCATTER: f64 = 8.0;

/// The smallest spike worth the name, over the range of the output.
const SMALLEST: f64 = 1e-2;

/// Share of the usual answer to as sharp a turn of the input that a spike must exceed.
const SHARP: f64 = 0.75;

/// Inputs that explain i, which reaches two samples ahead; beyond them even a beam answers smoothly.
const LAGS: std::ops::Range<isize> = -2..18;

/// Ridge of that explanation.
const RIDGE: f64 = 1e-6;

/// Samples within which the output answers to a sharp turn.
const ANSWERS: usize = 6;

/// Samples on either side that a spike, which is three samples wide, must exceed so many times: ringing does not.
const BESIDE: usize = 8;
const ALONE: f64 = 1.5;

/// How often what is left is looked at again.
const ROUNDS: usize = 6;

/// Half the samples around a spike that tell the usual scatter.
const AROUND: usize = 50;

/// The outliers of what is not yet known to be unusable.
pub(super) fn outliers(record: &Record, usable: &[bool]) -> Option<Finding> {
    let n = record.len();
    if n < 2 * AROUND {
        return None;
    }
    let (low, high) = ends(record.y().iter().copied());
    let smallest = (SMALLEST * (high - low)).max(3.0 * resolution(record.y()));
    let reversals = off_neighbours(record.u());
    let mut y = record.y().to_vec();
    let mut found: BTreeMap<usize, f64> = BTreeMap::new();
    // Large spikes bend the explanation of all the rest: they are taken out before smaller ones are believed.
    for _ in 0..ROUNDS {
        let spikes = spikes(record.u(), &reversals, &y, smallest, usable);
        let largest = spikes.iter().fold(0.0, |m: f64, (_, size)| m.max(size.abs()));
        for (t, size) in spikes.into_iter().filter(|(_, size)| size.abs() > 0.5 * largest) {
            *found.entry(t).or_default() += size;
            y[t] -= size;
        }
        if largest == 0.0 {
            break;
        }
    }
    found.retain(|_, size| size.abs() > smallest);
    let largest = found.values().fold(0.0, |m: f64, size| m.max(size.abs()));
    // Many would be the way the output is: ripple, or a sensor that misses every other step.
    if found.is_empty() || found.len() > 1 + n / 50 {
        return None;
    }
    let ranges: Vec<_> = found.keys().map(|t| *t..t + 1).collect();
    let text = format!(
        "the output has outliers: {}, the largest {} {} off its neighbours ({} % of peak-to-peak)",
        places(&ranges, record.ts()),
        short(largest),
        record.units().y,
        short(100.0 * largest / (high - low))
    );
    Some(Finding { defect: Defect::Outliers, samples: ranges, text })
}

/// The spikes of `y` with their sizes, as far as its present state tells.
fn spikes(u: &[f64], reversals: &[f64], y: &[f64], smallest: f64, usable: &[bool]) -> Vec<(usize, f64)> {
    let n = y.len();
    let mut i = off_neighbours(y);
    let gain = sharp_gain(reversals, &i);
    let explained = by_input(u, &i, LAGS, RIDGE);
    i.iter_mut().zip(&explained).for_each(|(i, explained)| *i -= explained);
    let power: f64 = SHAPE.iter().map(|p| p * p).sum();
    let size = |t: usize| {
        let around = &i[t - 2..=t + 2];
        let size = around.iter().zip(SHAPE).map(|(i, p)| i * p).sum::<f64>() / power;
        let alike = size * size * power >= ALIKE * around.iter().map(|i| i * i).sum::<f64>();
        (alike && size.abs() > smallest).then_some(size)
    };
    // Before the first, the lags reach into a past that is not known.
    let past = LAGS.end as usize;
    let clear = |t: &usize| !usable[t - past..=t + 4].contains(&false);
    let stands_out = |(t, size): (usize, f64)| {
        let usual: Vec<f64> = i[t.saturating_sub(AROUND)..(t + AROUND).min(n)].iter().map(|i| i.abs()).collect();
        // A median of absolute values is 0.6745 standard deviations of a normal scatter.
        let scatter = quantile(usual, 0.5) / 0.6745;
        let turn = reversals[t - past - 2..=t + 2].iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let beside = i[t - BESIDE..t - 2].iter().chain(&i[t + 3..=t + BESIDE]).fold(0.0, |m: f64, i| m.max(i.abs()));
        (size.abs() > SCATTER * scatter && size.abs() > SHARP * gain * turn && size.abs() > ALONE * beside)
            .then_some((t, size))
    };
    (past + 3..n - BESIDE).filter(clear).filter_map(|t| stands_out((t, size(t)?))).collect()
}

/// What a cubic through two neighbours on either side misses; 0 at the ends.
fn off_neighbours(x: &[f64]) -> Vec<f64> {
    let mut off = vec![0.0; x.len()];
    for (t, w) in x.windows(5).enumerate() {
        off[t + 2] = w[2] - (4.0 * (w[1] + w[3]) - w[0] - w[4]) / 6.0;
    }
    off
}

/// The sharpest answer of the output to the sharper turns of the input, over these: in the middle of all, so that a few
/// spikes do not tell.
fn sharp_gain(reversals: &[f64], answers: &[f64]) -> f64 {
    let sharpest = reversals.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let sharp = (0..reversals.len()).filter(|t| reversals[*t].abs() > 0.5 * sharpest);
    let answer = |t: usize| answers[t..(t + ANSWERS).min(answers.len())].iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    quantile(sharp.map(|t| answer(t) / reversals[t].abs()).collect(), 0.5)
}
