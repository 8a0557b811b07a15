//! Test runs of a program for the range of its numbers and for the error of integers.

use super::formats::{adding, fields, fitting};
use super::number::{counts, power};
use crate::ExportRequest;
use crate::exported::{Entry, ExportedProgram};
use crate::vectors::{UNKNOWN_RANGE, turned, wander};
use piezoid::system::System;
use piezoid_numerics::series::ends;

/// Number of samples in each part of a run.
pub(super) const PART: usize = 500;

/// The test runs of an entry: the same inputs from several states.
pub(super) struct TestInputs {
    /// The initial states: at rest, and with the slow parts settled at both ends.
    pub(super) starts: Vec<Vec<f64>>,
    /// Inputs over the range of the model and a tenth more: they wander, jump, die away with each reversal inside the
    /// one before, which fills every memory of reversals, and sweep from low to high frequency.
    pub(super) inputs: Vec<Vec<f64>>,
}

/// The test runs of each entry.
pub(super) fn test_inputs(whole: &ExportedProgram, request: &ExportRequest) -> Vec<TestInputs> {
    let model = request.model;
    let (low, high) = model.known_inputs().unwrap_or(UNKNOWN_RANGE);
    let more = 0.05 * (high - low);
    let far = (low - more, high + more);
    let slow = wander(far, PART);
    let u = in_counts([&slow[..], &jumping(far, PART), &dying(far, REVERSALS), &sweep(far, PART)].concat());
    let still = model.simulate(&slow);
    let r = in_counts([&still[..], &jumping(ends(still.iter().copied()), PART)].concat());
    let z = ends(model.hysteresis().simulate(&slow));
    let long = adding(&whole.program);
    let of = |entry: &Entry| {
        let numbers = fields(&whole.program, entry.state);
        let at_rest = whole.program.at_rest(entry.state);
        let settled = |u: f64, z: f64| {
            let crept = z * (1.0 + model.creep().lags().iter().map(|lag| lag.gain).sum::<f64>());
            let there = |(field, at_rest): (&(String, String), &f64)| match (&*field.0, &*field.1) {
                ("creep", _) => z,
                ("linear", "inputs") => crept,
                ("linear", _) if model.linear().dc_gain().is_finite() => model.linear().dc_gain() * crept,
                // An integral can become as large as its output.
                ("control_state", _) if long.contains(field) => u,
                _ => *at_rest,
            };
            numbers.iter().zip(&at_rest).map(there).collect()
        };
        let inputs = entry.rows(&u, &r, 1.25);
        TestInputs { starts: vec![at_rest.clone(), settled(far.0, z.0), settled(far.1, z.1)], inputs }
    };
    whole.entries.iter().map(of).collect()
}

/// The nearest numbers that are integer counts in any format, so that values equal in double precision are equal in
/// counts.
fn in_counts(values: Vec<f64>) -> Vec<f64> {
    let exponent = fitting(values.iter().fold(0.0, |most, v| v.abs().max(most))) + COARSER;
    values.into_iter().map(|v| counts(v, exponent) * power(exponent)).collect()
}

/// Bits that are dropped for that.
const COARSER: i32 = 8;

/// Jumps to random levels and to the ends, each held for up to 16 samples.
fn jumping((low, high): (f64, f64), n: usize) -> Vec<f64> {
    let (mut state, mut level, mut left) = (1u64, low, 0);
    let next = |_| {
        if left == 0 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let share = (state >> 40) as f64 / (1u64 << 24) as f64;
            level = low + (high - low) * (1.5 * share - 0.25).clamp(0.0, 1.0);
            left = (state >> 20) % 16 + 1;
        }
        left -= 1;
        level
    };
    (0..n).map(next).collect()
}

/// From one side of the middle to the other, each time a little less far: no two loops have the same area.
fn dying((low, high): (f64, f64), n: usize) -> Vec<f64> {
    let (middle, mut away) = (0.5 * (low + high), 0.5 * (high - low));
    let next = |_| {
        away *= -0.97;
        middle + away
    };
    (0..n).map(next).collect()
}

/// More reversals than any memory holds.
const REVERSALS: usize = 150;

/// A sine sweep from 0 to half the sampling rate. Only sums and products, so that all machines agree bit by bit.
fn sweep((low, high): (f64, f64), n: usize) -> Vec<f64> {
    // By pi / 500 in each sample.
    let faster = (0.9999802608561371, 0.006283143965558951);
    let (mut angle, mut at) = ((1.0, 0.0), (1.0, 0.0));
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let next = |_| {
        angle = turned(faster, angle);
        at = turned(angle, at);
        middle + half * at.1
    };
    (0..n).map(next).collect()
}
