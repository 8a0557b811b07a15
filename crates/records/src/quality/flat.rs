//! Intervals in which one of the two signals is constant and the other is not.
//!
//! Consider the time for which a signal is within a small height below its maximum. At a smooth peak it spends half of
//! this time within a quarter of the height, at a limit nearly all of it. This distinguishes limits from peaks, with
//! and without noise.

use super::Detection;
use super::detector::{Consequence, Detector};
use super::runs::{places, resolution, runs};
use crate::record::Record;
use piezoid_numerics::number::short;
use piezoid_numerics::series::{ends, mean, range};
use std::ops::Range;

/// Height below an extreme, relative to the range.
const PEAK_HEIGHT_SHARE: f64 = 0.01;

/// A peak is cut off if a larger share of this time is within a quarter of the height.
const FLAT_TIME_SHARE: f64 = 0.8;

/// An input is clipped if y has an arc in this share of the times that u rests at its extreme.
const CLIPPED_REST_SHARE: f64 = 0.8;

/// The other signal must move by this share of its range.
pub(super) const MIN_MOVEMENT_SHARE: f64 = 0.02;

/// Number of parts of an interval, of whose means the movement is taken.
const PART_COUNT: usize = 32;

/// Minimum length of a reported interval [samples].
const MIN_RUN_SAMPLES: usize = 8;

/// Maximum delay between input and output [samples]: the last inputs of an interval do not act on the output yet.
const MAX_DELAY_SAMPLES: usize = 5;

pub(super) static SATURATED_OUTPUT: Detector = Detector {
    name: "saturated-output",
    criterion: "the output is constant at its extreme while the input moves",
    consequence: Consequence::Masked,
    loop_remedy: Some("lower the voltage or take a larger range of the sensor"),
    run: |context| saturated(context.record()),
};

pub(super) static CLIPPED_INPUT: Detector = Detector {
    name: "clipped-input",
    criterion: "the input is constant at its extreme while the output still moves",
    consequence: Consequence::Masked,
    loop_remedy: None,
    run: |context| clipped(context.record()),
};

pub(super) static FROZEN_OUTPUT: Detector = Detector {
    name: "frozen-output",
    criterion: "the output repeats exactly while the input moves",
    consequence: Consequence::Masked,
    loop_remedy: None,
    run: |context| frozen(context.record()),
};

/// The output is constant at an extreme while the input moves.
fn saturated(record: &Record) -> Option<Detection> {
    let (u, y) = (record.u(), record.y());
    let mut cut: Vec<Range<usize>> = Vec::new();
    for sign in [1.0, -1.0] {
        cut.extend(cut_off(y, sign).into_iter().filter(|run| moved_before(u, run) > MIN_MOVEMENT_SHARE));
        cut.extend(capped(u, y, sign));
    }
    cut.sort_by_key(|run| run.start);
    cut = cut.into_iter().fold(Vec::new(), |mut all: Vec<Range<usize>>, run| {
        match all.last_mut() {
            Some(last) if run.start <= last.end => last.end = last.end.max(run.end),
            _ => all.push(run),
        }
        all
    });
    let (low, high) = ends(cut.iter().flat_map(|run| y[run.clone()].iter().copied()));
    let ([low, high], unit) = ([low, high].map(short), &record.units().y);
    let (places, levels) = match cut.len() {
        0 => return None,
        1 => (places(&cut, record.ts()), format!("at {high} {unit}")),
        _ => (places(&cut, record.ts()), format!("at or between {low} and {high} {unit}")),
    };
    let text = format!("the output is saturated: it is constant {levels} while the input moves, in {places}");
    Some(Detection { samples: cut, text })
}

/// The samples at exactly the maximum of `sign` y if they are reached and left in large steps and cannot be smooth
/// peaks. The criteria: three samples in a row (at a smooth peak with three samples within one sensor step, the next
/// sample is at most three steps away), or more such samples than half of the many different values nearby. While the
/// input moves one such peak is enough.
fn capped(u: &[f64], y: &[f64], sign: f64) -> Vec<Range<usize>> {
    let (low, high) = ends(y.iter().map(|y| sign * y));
    let step = resolution(y);
    let far = (4.0 * step).max(2e-3 * (high - low));
    let at_top = |y: f64| sign * y >= high - 0.5 * step.min(1e-9 * (high - low));
    let top = runs(y.len(), 0, |t| at_top(y[t]));
    let steep = |t: Option<usize>| t.and_then(|t| y.get(t)).is_none_or(|y| sign * y < high - far);
    let sudden = |run: &&Range<usize>| steep(run.start.checked_sub(1)) && steep(Some(run.end));
    let peaks: Vec<Range<usize>> = top.iter().filter(sudden).cloned().collect();
    let moves = |run: &Range<usize>| {
        u[run.clone()].windows(2).all(|w| w[0] != w[1]) && moved(u, run.clone()) > 0.5 * MIN_MOVEMENT_SHARE
    };
    // A settled output leaves its maximum only after the input moves.
    let held = |run: &Range<usize>| {
        let before = run.end.saturating_sub(MAX_DELAY_SAMPLES + 1);
        u[before..u.len().min(run.end + 1)].windows(2).all(|w| w[0] == w[1])
    };
    let long: Vec<Range<usize>> = peaks.iter().filter(|run| run.len() >= 3).cloned().collect();
    let suspicious = long.iter().filter(|run| moves(run) || held(run)).count();
    let next = |y: &f64| sign * y > high - 0.1 * (high - low) && !at_top(*y);
    let mut near: Vec<f64> = y.iter().copied().filter(next).collect();
    let below = near.len();
    near.sort_by(f64::total_cmp);
    near.dedup();
    let crowded = near.len() >= 10 && peaks.len() >= 10 && 2 * peaks.iter().map(Range::len).sum::<usize>() > below;
    if near.len() >= 3 && (crowded || suspicious >= 3 || long.iter().any(moves)) { top } else { Vec::new() }
}

/// The input is constant at an extreme while the output still moves and returns, nearly every time.
fn clipped(record: &Record) -> Option<Detection> {
    let (u, y) = (record.u(), record.y());
    let (height, rising) = (MIN_MOVEMENT_SHARE * range(y), output_sign(u, y));
    let mut all = Vec::new();
    for (sign, end) in [(1.0, ends(u.iter().copied()).1), (-1.0, -ends(u.iter().copied()).0)] {
        let stands = runs(u.len(), 0, |t| sign * u[t] == end);
        let long = stands.into_iter().filter(|run| run.len() >= MIN_RUN_SAMPLES && slides_in(u, run));
        all.extend(long.map(|run| (arches(y, &run, sign * rising, height), run)));
    }
    let mut arched: Vec<Range<usize>> = all.iter().filter(|(arched, _)| *arched).map(|(_, run)| run.clone()).collect();
    if arched.len() < 2 || (arched.len() as f64) < CLIPPED_REST_SHARE * all.len() as f64 {
        return None;
    }
    arched.sort_by_key(|run| run.start);
    let places = places(&arched, record.ts());
    let text = format!(
        "the recorded input is clipped: it is constant at its extreme while the output still moves, in {places}"
    );
    Some(Detection { samples: arched, text })
}

/// The output repeats exactly while the input moves, away from its extremes.
fn frozen(record: &Record) -> Option<Detection> {
    let (u, y) = (record.u(), record.y());
    let (low, high) = ends(y.iter().copied());
    // Near a peak of the output, the input may move by this share while the output stays within one sensor step.
    let hidden = 4.0 * (resolution(y) / (high - low)).sqrt();
    let stands = |t: usize| t > 0 && y[t] == y[t - 1];
    let near = |run: &Range<usize>| (y[run.start] - low).min(high - y[run.start]) < PEAK_HEIGHT_SHARE * (high - low);
    let moves = |run: &Range<usize>| moved_before(u, run) > MIN_MOVEMENT_SHARE.max(hidden);
    let held = runs(y.len(), 0, stands).into_iter().map(|run| run.start - 1..run.end);
    let frozen: Vec<Range<usize>> =
        held.filter(|run| run.len() >= MIN_RUN_SAMPLES && !near(run) && moves(run)).collect();
    let places = places(&frozen, record.ts());
    let text = format!("the output is frozen: its values repeat exactly while the input moves, in {places}");
    (!frozen.is_empty()).then_some(Detection { samples: frozen, text })
}

/// The intervals in which `sign` x is at a limit.
fn cut_off(x: &[f64], sign: f64) -> Vec<Range<usize>> {
    let ((_, high), range) = (ends(x.iter().map(|x| sign * x)), range(x));
    let top = (PEAK_HEIGHT_SHARE * range).max(16.0 * resolution(x).min(range / 64.0));
    let near = |t: usize, height: f64| sign * x[t] >= high - height;
    let excursions = runs(x.len(), 2, |t| near(t, top));
    let flat = excursions.into_iter().filter_map(|run| {
        let inner = runs(run.len(), 2, |t| near(run.start + t, 0.25 * top));
        let longest = inner.into_iter().max_by_key(|r| r.len())?;
        let cut = longest.len() >= MIN_RUN_SAMPLES && longest.len() as f64 >= FLAT_TIME_SHARE * run.len() as f64;
        cut.then(|| run.start + longest.start..run.start + longest.end)
    });
    flat.collect()
}

/// Movement of `u` during a run, without the last inputs, which do not act on the output yet.
fn moved_before(u: &[f64], run: &Range<usize>) -> f64 {
    moved(u, run.start..run.end.saturating_sub(MAX_DELAY_SAMPLES))
}

/// Movement of `u` during a run, relative to its range: of the means of its parts, because noise is no movement.
fn moved(u: &[f64], run: Range<usize>) -> f64 {
    let run = &u[run.start..run.end.max(run.start + 1)];
    let parts: Vec<f64> = run.chunks(run.len().div_ceil(PART_COUNT)).map(mean).collect();
    range(&parts) / range(u)
}

/// True if `u` reaches the run no faster than it moved before: a clipped wave, not a step.
fn slides_in(u: &[f64], run: &Range<usize>) -> bool {
    run.start >= 3 && {
        let (last, before) = (u[run.start] - u[run.start - 1], u[run.start - 1] - u[run.start - 2]);
        last.abs() <= 1.5 * before.abs() && before != 0.0
    }
}

/// True if `sign` y exceeds both ends of the run by more than `height`, with its maximum near the middle.
fn arches(y: &[f64], run: &Range<usize>, sign: f64, height: f64) -> bool {
    let part: Vec<f64> = y[run.clone()].iter().map(|y| sign * y).collect();
    let (k, peak) = part.iter().enumerate().fold((0, f64::MIN), |m, (k, y)| if *y > m.1 { (k, *y) } else { m });
    let middle = k as f64 / part.len() as f64;
    (0.3..=0.7).contains(&middle) && peak - part[0] > height && peak - part[part.len() - 1] > height
}

/// 1 if the output increases with the input, -1 if it decreases.
fn output_sign(u: &[f64], y: &[f64]) -> f64 {
    let (mu, my) = (piezoid_numerics::series::mean(u), piezoid_numerics::series::mean(y));
    u.iter().zip(y).map(|(u, y)| (u - mu) * (y - my)).sum::<f64>().signum()
}
