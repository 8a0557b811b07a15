//! Closed loop: the input answers the noise of the output.
//!
//! What the last samples of both signals do not tell of the next input and of the next output (their innovations) is
//! independent in open loop. A controller answers a rise of the output by lowering the input, at once or a few samples
//! later: the correlation is negative there, and not at larger lags. An input that was measured with noise gives a
//! positive one. Only samples without sharp changes count.

use super::lags::Lags;
use super::runs::{quantile, standardised};
use super::{Defect, Finding};
use crate::number::short;
use crate::record::Record;
use crate::series::{dot, mean};
use nalgebra::{DMatrix, DVector};

/// Samples that tell the next one.
const PAST: usize = 6;

/// The controller answers within this number of samples; at the last of these lags and beyond nothing is expected.
const LAGS: usize = 4;

/// The correlation must be this number of standard deviations below zero, and below that at the last lag.
const CLEAR: f64 = 8.0;

/// A weaker correlation is not worth a word.
const WEAK: f64 = 0.1;

/// Innovations of the input above this multiple of those of the output are a drive signal, not an answer.
const DRIVE: f64 = 0.2;

/// Innovations of the input with a larger correlation from sample to sample are a drive signal as well.
const SMOOTH: f64 = 0.5;

/// Smaller ones, over the rms, are rounding of the numbers in a file.
const ROUNDING: f64 = 1e-6;

/// Larger innovations, over their usual size, are changes of the drive.
const SHARP: f64 = 4.0;

/// A finding if the record was taken in closed loop. `None` if a sample is not usable: a limit is no noise.
pub(super) fn closed(record: &Record, usable: &[bool]) -> Option<Finding> {
    if usable.contains(&false) {
        return None;
    }
    let (u, mut y) = (standardised(record.u())?, standardised(record.y())?);
    if dot(&u, &y) < 0.0 {
        y.iter_mut().for_each(|y| *y = -*y);
    }
    let (a, e) = (innovations(&u, &[&u])?, innovations(&y, &[&u, &y])?);
    // The median of absolute values of normal noise is 0.6745 standard deviations.
    let usual = |x: &[f64]| quantile(x.iter().map(|x| x.abs()).collect(), 0.5) / 0.6745;
    let (input, output) = (usual(&a), usual(&e));
    if !(ROUNDING..=DRIVE * output).contains(&input) {
        return None;
    }
    let calm = |t: usize| a[t].abs() < SHARP * input && e[t].abs() < SHARP * output;
    let calm: Vec<bool> = (0..a.len()).map(calm).collect();
    let counted: Vec<usize> = (LAGS..a.len()).filter(|t| !calm[t - LAGS..=*t].contains(&false)).collect();
    if counted.len() < 100 {
        return None;
    }
    let correlation = |cause: &[f64], lag: usize| {
        let answer = standardised(&counted.iter().map(|t| a[*t]).collect::<Vec<f64>>())?;
        let cause = standardised(&counted.iter().map(|t| cause[t - lag]).collect::<Vec<f64>>())?;
        Some(dot(&answer, &cause) / counted.len() as f64)
    };
    if correlation(&a, 1)?.abs() > SMOOTH {
        return None;
    }
    let all: Vec<f64> = (0..=LAGS).map(|lag| correlation(&e, lag)).collect::<Option<_>>()?;
    let least = all.iter().copied().fold(0.0, f64::min);
    let deviation = 1.0 / (counted.len() as f64).sqrt();
    let enough = WEAK.max(CLEAR * deviation);
    let clear = least < -enough && least < all[LAGS] - CLEAR * deviation;
    let text = format!(
        "the record was taken in closed loop: the input lowers when noise raises the output (correlation {}, {} \
         standard deviations), so the model takes part of the noise for a response: drive the actuator in open loop",
        short(least),
        short(-least / deviation)
    );
    clear.then_some(Finding { defect: Defect::ClosedLoop, samples: Vec::new(), text })
}

/// What the last samples of the `causes` do not tell of `x`, by least squares.
fn innovations(x: &[f64], causes: &[&[f64]]) -> Option<Vec<f64>> {
    let columns = 1 + PAST * causes.len();
    let past: Vec<Lags> = causes.iter().map(|cause| Lags::new(&cause[..x.len() - 1], PAST)).collect();
    let (x, one) = (&x[PAST..], vec![1.0; x.len() - PAST]);
    let (mut gram, mut right) = (DMatrix::<f64>::zeros(columns, columns), DVector::<f64>::zeros(columns));
    (gram[(0, 0)], right[0]) = (x.len() as f64, x.iter().sum());
    for (i, lags) in past.iter().enumerate() {
        let at = 1 + PAST * i;
        right.rows_mut(at, PAST).copy_from(&lags.with(x));
        gram.view_mut((at, 0), (PAST, 1)).copy_from(&lags.with(&one));
        for (j, other) in past.iter().enumerate().take(i + 1) {
            gram.view_mut((at, 1 + PAST * j), (PAST, PAST)).copy_from(&lags.products(other));
        }
    }
    gram.fill_upper_triangle_with_lower_triangle();
    let ridge = 1e-10 * gram.trace() / columns as f64;
    (0..columns).for_each(|i| gram[(i, i)] += ridge);
    let weights = gram.cholesky()?.solve(&right);
    let mut left = x.to_vec();
    for (i, lags) in past.iter().enumerate() {
        let told = lags.combined(weights.rows(1 + PAST * i, PAST).iter().copied());
        left.iter_mut().zip(told).for_each(|(left, told)| *left -= told);
    }
    let level = mean(&left);
    Some(left.iter().map(|x| x - level).collect())
}
