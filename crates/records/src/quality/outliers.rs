//! Outliers: one to three samples of the output far from their neighbours.
//!
//! ```text
//! i_t = r_t - (-r_{t-2} + 4 r_{t-1} + 4 r_{t+1} - r_{t+2}) / 6
//! ```
//! is the error of a cubic through four neighbours, for the part r of the output not explained by the input (i is
//! linear in the output, therefore i itself is regressed on the input). A spike of size s at t gives s (1/6, -2/3, 1,
//! -2/3, 1/6) around t, one of several equal samples the sum of these for its samples. A step or a bend of the output
//! gives another shape. A spike is reported if it has its shape, exceeds the scatter of i around it (Hampel's rule, by
//! the median) and its neighbours, is not too small relative to the range, and is sharper than a response to a step of
//! the input. Wider spikes, and two spikes within eight samples, are not found.

use super::Detection;
use super::detector::{Consequence, Detector};
use super::explained::by_input;
use super::runs::{places, resolution, runs};
use crate::record::Record;
use libm::sqrt;
use piezoid_numerics::number::short;
use piezoid_numerics::series::{largest, quantile, range};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

/// The response i to a spike of one sample and size 1.
const SPIKE_SHAPE: [f64; 5] = [1.0 / 6.0, -2.0 / 3.0, 1.0, -2.0 / 3.0, 1.0 / 6.0];

/// Samples of the widest spike.
const MAX_WIDTH: usize = 3;

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

/// The peak of a spike in i must exceed this number of samples on both sides by this factor; ringing does not.
const NEIGHBOUR_SAMPLES: usize = 8;
const MIN_NEIGHBOUR_RATIO: f64 = 1.5;

/// Maximum number of searches.
const MAX_SEARCHES: usize = 6;

/// Samples on each side of a spike for the scatter.
const SCATTER_SAMPLES: usize = 50;

pub(crate) static OUTLIERS: Detector = Detector {
    name: "outliers",
    criterion: "one to three samples of the output differ from their neighbours by more than usual (Hampel)",
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
        let most = largest(spikes.iter().map(|spike| &spike.size));
        for Spike { samples, size, .. } in spikes.into_iter().filter(|spike| spike.size.abs() > 0.5 * most) {
            for t in samples {
                *found.entry(t).or_default() += size;
                y.to_mut()[t] -= size;
            }
        }
        if most == 0.0 {
            break;
        }
    }
    found.retain(|_, size| size.abs() > smallest);
    let most = largest(found.values());
    // Many spikes are a property of the output: ripple, or a sensor that misses every second step.
    let ranges = runs(n, 0, |t| found.contains_key(&t));
    if ranges.is_empty() || ranges.len() > 1 + n / 50 {
        return None;
    }
    let (places, unit) = (places(&ranges, record.ts()), &record.units().y);
    let [most, percent] = [most, 100.0 * most / stroke].map(short);
    let text = format!(
        "the output has outliers: {places}, the largest {most} {unit} from its neighbours ({percent} % of stroke)"
    );
    Some(Detection { samples: ranges, text })
}

/// Equal deviations of neighbouring samples.
struct Spike {
    samples: Range<usize>,
    size: f64,
    /// The power around it that it explains.
    power: f64,
}

/// The response i to a spike of size 1 and some width.
struct Shape {
    response: Vec<f64>,
    power: f64,
    peak: f64,
    /// Standard deviation of the size that noise alone has, relative to that of a spike of one sample.
    deviation: f64,
}

impl Shape {
    /// Of a spike of so many samples.
    fn of(width: usize) -> Self {
        let [response, single] = [width, 1].map(|width| summed(&SPIKE_SHAPE, &vec![1.0; width]));
        let deviation = |shape: &[f64]| sqrt(dot_self(&summed(&SPIKE_SHAPE, shape))) / dot_self(shape);
        let (power, peak) = (dot_self(&response), largest(&response));
        Shape { power, peak, deviation: deviation(&response) / deviation(&single), response }
    }
}

/// The convolution of two series.
fn summed(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; a.len() + b.len() - 1];
    a.iter().enumerate().for_each(|(i, a)| b.iter().enumerate().for_each(|(j, b)| sum[i + j] += a * b));
    sum
}

fn dot_self(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

/// The spikes of `y`; none of them overlap.
fn spikes(u: &[f64], y: &[f64], smallest: f64, usable: &[bool]) -> Vec<Spike> {
    let n = y.len();
    let whole: Vec<f64> = (0..n).map(|t| off_neighbours(y, t)).collect();
    let gain = sharp_gain(u, &whole);
    let explained = by_input(u, &whole, INPUT_LAGS, RIDGE);
    let i: Vec<f64> = whole.iter().zip(&explained).map(|(i, explained)| i - explained).collect();
    // The lags of the first samples begin before the record.
    let past = INPUT_LAGS.end as usize;
    let mut all: Vec<Spike> = Vec::new();
    for width in 1..=MAX_WIDTH {
        let shape = Shape::of(width);
        let like = |t: usize| {
            let around = &i[t - 2..t + width + 2];
            let size = around.iter().zip(&shape.response).map(|(i, p)| i * p).sum::<f64>() / shape.power;
            let power = size * size * shape.power;
            let is_like = power >= MIN_SHAPE_POWER_SHARE * dot_self(around);
            (is_like && size.abs() > smallest).then_some(Spike { samples: t..t + width, size, power })
        };
        let stands_out = |spike: &Spike| {
            let (t, end, size) = (spike.samples.start, spike.samples.end, spike.size.abs());
            let near = t.saturating_sub(SCATTER_SAMPLES)..(end - 1 + SCATTER_SAMPLES).min(n);
            // The median of absolute values of normal noise is 0.6745 standard deviations.
            let scatter = quantile(i[near].iter().map(|i| i.abs()).collect(), 0.5) / 0.6745;
            let sharpest = (t - past - 2..end + 2).map(|t| off_neighbours(u, t).abs()).fold(0.0, f64::max);
            let beside =
                |i: &[f64]| largest(i[t - NEIGHBOUR_SAMPLES..t - 2].iter().chain(&i[end + 2..end + NEIGHBOUR_SAMPLES]));
            // A ringing near half the sampling frequency resembles wide spikes where the lags of the regression end.
            let beside = if width == 1 { beside(&i) } else { beside(&i).max(beside(&whole)) };
            size > MIN_SCATTER_DEVIATIONS * shape.deviation * scatter
                && shape.peak * size > MIN_RESPONSE_SHARE * gain * sharpest
                && shape.peak * size > MIN_NEIGHBOUR_RATIO * beside
        };
        let clear = |t: &usize| !usable[t - past..t + width + 4].contains(&false);
        let starts = (past + 3..(n + 1).saturating_sub(NEIGHBOUR_SAMPLES + width)).filter(clear);
        all.extend(starts.filter_map(like).filter(stands_out));
    }
    // Of two that overlap, the one that explains more is the spike.
    all.sort_by(|a, b| b.power.total_cmp(&a.power));
    let mut taken = vec![false; n];
    all.retain(|spike| {
        let around = &mut taken[spike.samples.start - 2..spike.samples.end + 2];
        let is_apart = !around.contains(&true);
        if is_apart {
            around.fill(true);
        }
        is_apart
    });
    all
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::Chirp;
    use piezoid_testing::noise;
    use std::f64::consts::TAU;

    /// The samples that are found in the output of an actuator of 0.1 um/V, with noise.
    fn found(u: &[f64], y: impl Fn(usize, f64) -> f64) -> Vec<Range<usize>> {
        let noise = noise(4, u.len());
        let y = u.iter().enumerate().map(|(t, u)| y(t, 0.1 * u) + 2e-3 * noise[t]).collect();
        let record = Record::new(1e-3, u.to_vec(), y).unwrap();
        outliers(&record, &vec![true; u.len()]).map_or(Vec::new(), |found| found.samples)
    }

    fn sine() -> Vec<f64> {
        (0..4000).map(|t| 50.0 - 50.0 * (TAU * f64::from(t) / 500.0).cos()).collect()
    }

    #[test]
    fn spikes_of_one_to_three_samples_are_found_exactly() {
        for size in [0.15, -2.0] {
            let spikes = [600..601, 1100..1102, 2003..2006, 3100..3102];
            let spiked = |t: usize, y: f64| if spikes.iter().any(|spike| spike.contains(&t)) { y + size } else { y };
            assert_eq!(found(&sine(), spiked), spikes, "{size}");
        }
    }

    #[test]
    fn steps_bends_and_wide_pulses_of_the_output_are_no_spikes() {
        for wide in [0..1000, 0..8, 0..12] {
            let shifted = |t: usize, y: f64| if wide.contains(&t.wrapping_sub(1500)) { y + 2.0 } else { y };
            assert_eq!(found(&sine(), shifted), [], "{wide:?}");
        }
        assert_eq!(found(&sine(), |t, y| y + 0.2 * (t as f64 - 1500.0).max(0.0)), []);
    }

    #[test]
    fn pulses_of_the_input_and_fast_sweeps_are_no_spikes_of_the_output() {
        let pulses: Vec<f64> = (0..4000).map(|t| if t % 800 > 796 || t % 1000 == 300 { 40.0 } else { 10.0 }).collect();
        assert_eq!(found(&pulses, |_, y| y), []);
        let chirp = Chirp { amplitude: 30.0, frequency_start: 5.0, frequency_end: 400.0, ..Chirp::default() };
        assert_eq!(found(&chirp.samples(1e-3, 8000).unwrap(), |_, y| y), []);
    }

    /// A ringing at 0.48 of the sampling frequency grows and fades: the lags of the regression end within it.
    #[test]
    fn a_ringing_near_half_the_sampling_frequency_has_no_spikes() {
        let steps: Vec<f64> = (0..6000).map(|t| 12.0 * f64::from(t / 1000)).collect();
        for frequency in [0.26, 0.33, 0.4, 0.45, 0.48, 0.49] {
            let ringing = |t: usize, y: f64| {
                let since = (t % 1000) as f64;
                y + if t < 1000 { 0.0 } else { 0.8 * (-since / 25.0).exp() * (TAU * frequency * since).sin() }
            };
            assert_eq!(found(&steps, ringing), [], "{frequency}");
        }
    }
}
