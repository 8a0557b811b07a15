//! Closed loop: the input answers the noise of the output.
//!
//! The innovations of input and output, which the last samples of both signals do not predict, are independent in open
//! loop. A controller answers a rise of the output by lowering the input, at once or a few samples later: the
//! correlation is negative there, and not at larger lags. An input that was measured with noise gives a positive one.
//! Only samples without sharp changes count.

use super::Detection;
use super::detector::{Consequence, Detector};
use super::lags::Lags;
use super::runs::standardised;
use crate::record::Record;
use nalgebra::{DMatrix, DVector};
use piezoid_numerics::number::short;
use piezoid_numerics::series::{dot, mean, quantile};

/// Samples that predict the next one.
const PREDICTION_LAGS: usize = 6;

/// The controller answers within this number of samples; at the last of these lags and beyond nothing is expected.
const RESPONSE_LAGS: usize = 4;

/// The correlation must be this number of standard deviations below zero, and below that at the last lag.
const MIN_DEVIATIONS: f64 = 8.0;

/// A weaker correlation is not worth a word.
const MIN_CORRELATION: f64 = 0.1;

/// Innovations of the input above this multiple of those of the output are a drive signal, not an answer.
const MAX_INNOVATION_RATIO: f64 = 0.2;

/// Innovations of the input with a larger correlation from sample to sample are a drive signal as well.
const MAX_SAMPLE_CORRELATION: f64 = 0.5;

/// Smaller ones, over the rms, are rounding of the numbers in a file.
const MIN_INNOVATION: f64 = 1e-6;

/// Least number of samples that count.
const MIN_COUNTED: usize = 100;

/// Larger innovations, over their usual size, are changes of the drive.
const MAX_CALM_INNOVATION: f64 = 4.0;

pub(super) static CLOSED_LOOP: Detector = Detector {
    name: "closed-loop",
    criterion: "the input falls when noise raises the output",
    consequence: Consequence::Reported,
    loop_remedy: None,
    run: |context| context.closed_loop().cloned(),
};

/// `None` if a sample is not usable: a limit is no noise.
pub(super) fn closed_loop(record: &Record, usable: &[bool]) -> Option<Detection> {
    if usable.contains(&false) {
        return None;
    }
    let (a, e) = {
        let (u, mut y) = (standardised(record.u())?, standardised(record.y())?);
        if dot(&u, &y) < 0.0 {
            y.iter_mut().for_each(|y| *y = -*y);
        }
        (innovations(&u, &[&u])?, innovations(&y, &[&u, &y])?)
    };
    // The median of absolute values of normal noise is 0.6745 standard deviations.
    let usual = |x: &[f64]| quantile(x.iter().map(|x| x.abs()).collect(), 0.5) / 0.6745;
    let (input, output) = (usual(&a), usual(&e));
    if !(MIN_INNOVATION..=MAX_INNOVATION_RATIO * output).contains(&input) {
        return None;
    }
    let calm = |t: usize| a[t].abs() < MAX_CALM_INNOVATION * input && e[t].abs() < MAX_CALM_INNOVATION * output;
    let calm: Vec<bool> = (0..a.len()).map(calm).collect();
    let counted = || (RESPONSE_LAGS..a.len()).filter(|t| !calm[t - RESPONSE_LAGS..=*t].contains(&false));
    let count = counted().count();
    if count < MIN_COUNTED {
        return None;
    }
    let n = count as f64;
    // About the means of the samples that count: one-sided jumps, which do not, leave one.
    let correlation = |cause: &[f64], lag: usize| {
        let mean = |x: &[f64], lag: usize| counted().map(|t| x[t - lag]).sum::<f64>() / n;
        let (own, other) = (mean(&a, 0), mean(cause, lag));
        let products = |(aa, cc, ac): (f64, f64, f64), t: usize| {
            let (answer, cause) = (a[t] - own, cause[t - lag] - other);
            (aa + answer * answer, cc + cause * cause, ac + answer * cause)
        };
        let (aa, cc, ac) = counted().fold((0.0, 0.0, 0.0), products);
        (aa > 0.0 && cc > 0.0).then(|| ac / (aa * cc).sqrt())
    };
    if correlation(&a, 1)?.abs() > MAX_SAMPLE_CORRELATION {
        return None;
    }
    let all: Vec<f64> = (0..=RESPONSE_LAGS).map(|lag| correlation(&e, lag)).collect::<Option<_>>()?;
    let least = all.iter().copied().fold(0.0, f64::min);
    let deviation = 1.0 / n.sqrt();
    let threshold = MIN_CORRELATION.max(MIN_DEVIATIONS * deviation);
    let is_clear = least < -threshold && least < all[RESPONSE_LAGS] - MIN_DEVIATIONS * deviation;
    let [least, deviations] = [least, -least / deviation].map(short);
    let text = format!(
        "the record was taken in closed loop: the input falls when noise raises the output (correlation {least}, \
         {deviations} standard deviations), so the model takes part of the noise for a response: drive the actuator in \
         open loop"
    );
    is_clear.then(|| text.into())
}

/// What the last samples of the `causes` do not predict of `x`, by least squares.
fn innovations(x: &[f64], causes: &[&[f64]]) -> Option<Vec<f64>> {
    let columns = 1 + PREDICTION_LAGS * causes.len();
    let past: Vec<Lags> = causes.iter().map(|cause| Lags::new(&cause[..x.len() - 1], PREDICTION_LAGS)).collect();
    let x = &x[PREDICTION_LAGS..];
    let one = vec![1.0; x.len()];
    let (mut gram, mut right) = (DMatrix::<f64>::zeros(columns, columns), DVector::<f64>::zeros(columns));
    (gram[(0, 0)], right[0]) = (x.len() as f64, x.iter().sum());
    for (i, lags) in past.iter().enumerate() {
        let at = 1 + PREDICTION_LAGS * i;
        right.rows_mut(at, PREDICTION_LAGS).copy_from(&lags.with(x));
        gram.view_mut((at, 0), (PREDICTION_LAGS, 1)).copy_from(&lags.with(&one));
        for (j, other) in past.iter().enumerate().take(i + 1) {
            gram.view_mut((at, 1 + PREDICTION_LAGS * j), (PREDICTION_LAGS, PREDICTION_LAGS))
                .copy_from(&lags.products(other));
        }
    }
    drop(one);
    gram.fill_upper_triangle_with_lower_triangle();
    let ridge = 1e-10 * gram.trace() / columns as f64;
    (0..columns).for_each(|i| gram[(i, i)] += ridge);
    let weights = gram.cholesky()?.solve(&right);
    let mut left = x.to_vec();
    for (i, lags) in past.iter().enumerate() {
        lags.add_to(&mut left, weights.rows(1 + PREDICTION_LAGS * i, PREDICTION_LAGS).iter().map(|weight| -weight));
    }
    let mean = mean(&left);
    left.iter_mut().for_each(|left| *left -= mean);
    Some(left)
}
