//! Where a program is taken to see how large its numbers become, and how far off counts are.

use crate::export::Wanted;
use crate::export::whole::{Entry, Whole, wander};
use crate::series::ends;
use crate::system::System;

/// Samples of each part of a journey.
const PART: usize = 1000;

/// Inputs of each entry over all that the model knows and a tenth more: they wander, jump, and sweep from slow to fast.
pub(super) fn journeys(whole: &Whole, wanted: &Wanted) -> Vec<Vec<Vec<f64>>> {
    let model = wanted.model;
    let known = model.identified().map(|known| (known.u[0], known.u[1])).or(model.hysteresis().range());
    let (low, high) = known.unwrap_or((-1.0, 1.0));
    let more = 0.05 * (high - low);
    let (slow, quick) = (wander((low - more, high + more), PART), jumping((low - more, high + more), PART));
    let u = [&slow[..], &quick, &sweep((low - more, high + more), PART)].concat();
    let still = model.simulate(&slow);
    let (least, most) = ends(still.iter().copied());
    let r = [&still[..], &jumping((least, most), PART)].concat();
    let inputs = |entry: &Entry| match entry.step {
        "step" => u.iter().map(|u| vec![*u]).collect::<Vec<_>>(),
        "ff_step" => r.iter().map(|r| vec![*r]).collect(),
        _ => r.iter().zip(&u).map(|(r, u)| vec![*r, 1.2 * r, *u]).collect(),
    };
    whole.entries.iter().map(inputs).collect()
}

/// Jumps to anywhere, and to the ends, each kept for up to 16 samples.
fn jumping((low, high): (f64, f64), n: usize) -> Vec<f64> {
    let (mut state, mut level, mut left) = (1u64, low, 0);
    (0..n)
        .map(|_| {
            if left == 0 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let share = (state >> 40) as f64 / (1u64 << 24) as f64;
                level = low + (high - low) * (1.5 * share - 0.25).clamp(0.0, 1.0);
                left = (state >> 20) % 16 + 1;
            }
            left -= 1;
            level
        })
        .collect()
}

/// A sine that goes from standing still to half the sampling rate: sums and products alone, for the same bits on every machine.
fn sweep((low, high): (f64, f64), n: usize) -> Vec<f64> {
    let turned = |(c, s): (f64, f64), (x, y): (f64, f64)| (c * x - s * y, s * x + c * y);
    // Of pi / 1000 more in each sample.
    let faster = (0.9999950652018582, 0.0031415874858795635);
    let (mut turn, mut at) = ((1.0, 0.0), (1.0, 0.0));
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    (0..n)
        .map(|_| {
            turn = turned(faster, turn);
            at = turned(turn, at);
            middle + half * at.1
        })
        .collect()
}
