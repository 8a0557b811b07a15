//! Missing rows: a smooth input jumps while it moves, and the output jumps with it.
//!
//! A step of the drive jumps too. It differs in one of these:
//! - the input rests before the step or after it: over no interval it moves by more than its noise;
//! - the output has not moved in the row of the jump, or is still moving fast in the rows after it. Where rows are
//!   missing, both signals are smooth up to the gap and after it.

use super::Detection;
use super::detector::{Consequence, Detector};
use super::flat::MIN_MOVEMENT_SHARE;
use super::runs::places;
use crate::record::Record;
use crate::waveform::noise;
use libm::sqrt;
use piezoid_numerics::number::short;
use piezoid_numerics::series::{ends, largest, mean, quantile, range};
use std::ops::Range;

/// Share of the samples whose steps are usual ones.
const USUAL_SHARE: f64 = 0.99;

/// A jump exceeds the usual step of the input by this factor.
const MIN_JUMP_RATIO: f64 = 8.0;

/// Most jumps: an input with more of them is a staircase. So is one with more than this share of equal neighbours.
const MAX_JUMPS: usize = 3;
const MAX_STILL_SHARE: f64 = 0.1;

/// Intervals before and after a jump in which an input moves [samples], if it does.
const INTERVALS: [usize; 4] = [8, 16, 32, 64];

/// An input moves in an interval if its trend exceeds this share of its usual step, and this number of standard
/// deviations of the trend of noise.
const REST_STEP_RATIO: f64 = 0.25;
const MIN_TREND_DEVIATIONS: f64 = 4.0;

/// The output jumps with the input if it moves by this share of what the input's jump usually moves it. Hysteresis may
/// hide the rest.
const MIN_OUTPUT_JUMP_SHARE: f64 = 0.25;

/// The output responds to a step if it moves faster than usual by this factor in one of so many samples after the jump.
const MIN_RESPONSE_RATIO: f64 = 3.0;
const RESPONSE_SAMPLES: usize = 8;

pub(super) static MISSING_ROWS: Detector = Detector {
    name: "missing-rows",
    criterion: "a smooth input jumps while it moves, and the output with it; masked until the input has again covered \
                its earlier range",
    consequence: Consequence::Masked,
    loop_remedy: None,
    run: |context| missing(context.record()),
};

fn missing(record: &Record) -> Option<Detection> {
    let (u, y) = (record.u(), record.y());
    let steps = |x: &[f64]| x.windows(2).map(|w| (w[1] - w[0]).abs()).collect::<Vec<f64>>();
    let (steps, responses) = (steps(u), steps(y));
    let usual = quantile(steps.clone(), USUAL_SHARE);
    let mut jumps: Vec<usize> = (1..u.len()).filter(|&t| steps[t - 1] > MIN_JUMP_RATIO * usual).collect();
    let still = steps.iter().filter(|step| **step == 0.0).count();
    if jumps.is_empty() || still as f64 > MAX_STILL_SHARE * steps.len() as f64 {
        return None;
    }
    let least_trend = REST_STEP_RATIO * usual;
    let deviation = noise(u);
    let moves = |part: &[f64]| trend(part) > least_trend.max(MIN_TREND_DEVIATIONS * trend_deviation(part, deviation));
    let moves_before = |t: usize| INTERVALS.iter().any(|n| moves(&u[t.saturating_sub(*n)..t]));
    let moves_after = |t: usize| INTERVALS.iter().any(|n| moves(&u[t..(t + n).min(u.len())]));
    let gain = range(y) / range(u);
    let usual_response = quantile(responses.clone(), USUAL_SHARE);
    let follows = |t: usize| {
        let after = largest(&responses[t..(t + RESPONSE_SAMPLES).min(responses.len())]);
        responses[t - 1] > MIN_OUTPUT_JUMP_SHARE * gain * steps[t - 1] && after < MIN_RESPONSE_RATIO * usual_response
    };
    jumps.retain(|t| moves_before(*t) && moves_after(*t) && follows(*t));
    let least = MIN_MOVEMENT_SHARE * range(u);
    if jumps.is_empty() || jumps.len() > MAX_JUMPS || jumps.iter().any(|t| steps[t - 1] <= least) {
        return None;
    }
    // A reversal may be lost: the hysteresis state is known again when the input has covered its earlier range.
    let again = |t: usize| {
        let (low, high) = ends(u[..t].iter().copied());
        let up = u[t..].iter().position(|u| *u >= high - least);
        let down = u[t..].iter().position(|u| *u <= low + least);
        up.zip(down).map_or(t + 1, |(up, down)| t + 1 + up.max(down))
    };
    let ranges: Vec<Range<usize>> = jumps.iter().map(|&t| t..again(t).min(y.len())).collect();
    let places = places(&jumps.iter().map(|&t| t..t + 1).collect::<Vec<_>>(), record.ts());
    let text = format!(
        "rows seem to be missing: the otherwise smooth input jumps by {} {} at {places}: split the record there",
        short(jumps.iter().fold(0.0, |m: f64, &t| m.max(steps[t - 1]))),
        record.units().u
    );
    Some(Detection { samples: ranges, text })
}

/// The movement in a part of a series, by the means of its halves; 0 for fewer than two samples.
fn trend(part: &[f64]) -> f64 {
    let (first, last) = part.split_at(part.len() / 2);
    if first.is_empty() { 0.0 } else { 2.0 * (mean(last) - mean(first)).abs() }
}

/// The standard deviation of this movement for noise of this standard `deviation`.
fn trend_deviation(part: &[f64], deviation: f64) -> f64 {
    4.0 * deviation / sqrt(part.len().max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::noise;

    const TS: f64 = 1e-3;

    /// The output of a fast actuator: a play, and what `response` makes of the input.
    fn found(u: Vec<f64>, response: impl Fn(&[f64]) -> Vec<f64>) -> Option<Detection> {
        let y = response(&u);
        missing(&Record::new(TS, u, y).unwrap())
    }

    fn play(u: &[f64]) -> Vec<f64> {
        let held = |s: &mut f64, u: &f64| {
            *s = s.clamp(u - 5.0, u + 5.0);
            Some(0.1 * u + 0.1 * *s)
        };
        u.iter().scan(u[0], held).collect()
    }

    fn with_noise(u: impl Iterator<Item = f64>, deviation: f64) -> Vec<f64> {
        let u: Vec<f64> = u.collect();
        u.iter().zip(noise(3, u.len())).map(|(u, e)| u + deviation * e).collect()
    }

    /// Steps to these levels, each held for 1000 samples. The voltage is measured, with noise: no two are equal.
    #[test]
    fn steps_between_holds_are_no_missing_rows() {
        for levels in [&[0.0, 100.0][..], &[0.0, 60.0, 120.0, 0.0]] {
            let steps = || levels.iter().flat_map(|level| [*level; 1000]);
            for deviation in [0.0, 1e-3, 0.1] {
                let log = |t: u32| 0.1 * f64::from(1 + t % 1000).ln();
                let creep = |u: &[f64]| play(u).iter().zip(0..).map(|(y, t)| y + log(t)).collect();
                assert_eq!(found(with_noise(steps(), deviation), creep), None, "{levels:?} {deviation}");
            }
        }
    }

    #[test]
    fn a_sawtooth_that_the_output_follows_with_delay_or_ringing_has_all_rows() {
        let saw: Vec<f64> = (0..4000).map(|t| 0.05 * f64::from(t % 2000)).collect();
        let delayed = |u: &[f64]| [&[0.0, 0.0], &play(u)[..u.len() - 2]].concat();
        let ringing = |u: &[f64]| {
            let (mut x, mut v) = (0.0, 0.0);
            let swings = |z: &f64| {
                v += 0.5 * (z - x) - 0.1 * v;
                x += v;
                x
            };
            play(u).iter().map(swings).collect()
        };
        assert_eq!((found(saw.clone(), delayed), found(saw.clone(), ringing)), (None, None));
        // A pulse of the voltage that is too short to be followed.
        let pulse: Vec<f64> = saw[..2000].iter().zip(0..).map(|(u, t)| if t == 900 { u + 30.0 } else { *u }).collect();
        assert_eq!(found(pulse, |u| u.iter().zip(0..).map(|(_, t)| 0.01 * f64::from(t)).collect()), None);
    }

    #[test]
    fn rows_that_are_missing_in_motion_are_found_with_a_noisy_input() {
        let sine = (0..6000).map(|t| 50.0 - 50.0 * (std::f64::consts::TAU * f64::from(t) / 2000.0).cos());
        for deviation in [0.0, 0.01] {
            let u = with_noise(sine.clone(), deviation);
            let y = play(&u);
            let cut = |x: &[f64]| [&x[..2400], &x[2600..]].concat();
            let detection = missing(&Record::new(TS, cut(&u), cut(&y)).unwrap()).expect("a gap");
            assert_eq!(detection.samples[0].start, 2400);
        }
    }
}
