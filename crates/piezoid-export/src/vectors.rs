//! Test vectors for exported code: inputs, outputs, and operation counts of each entry.

use super::ExportRequest;
use super::exported::{Entry, ExportedProgram};
use super::guard::UNGUARDED;
use piezoid::{Error, System};
use piezoid_models::program::{Counts, Machine, Program};
use piezoid_numerics::series::ends;

/// Test vectors of an entry.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Vectors {
    /// Inputs, one row per sample.
    pub inputs: Vec<Vec<f64>>,
    /// Its outputs.
    pub outputs: Vec<f64>,
    /// Mean number of operations per sample.
    pub mean: Counts,
    /// Largest number of operations in one of these samples; others may take more.
    pub most: usize,
    /// Largest number of operations in one sample, whatever the input.
    pub bound: usize,
    /// The same of each kind; their sum may be larger.
    pub bounds: Counts,
    /// Largest difference to double precision, over the height of the outputs.
    pub off: f64,
    /// Rms error of feed-forward and model along the wandering part, over the height of the reference.
    pub missed: Option<f64>,
}

/// Inputs of a model without a known range.
pub(super) const UNKNOWN_RANGE: (f64, f64) = (-1.0, 1.0);

/// Number of samples: a wandering part, one pass through the whole range, and jumps.
pub(super) const SAMPLES: usize = 400;
const WANDERING: usize = 280;
const RANGE_SAMPLES: usize = 81;

/// Samples at which the input of a guarded model is too far out, and its sign: the first one, some among slow ones, and
/// one among jumps.
const FAR: [(usize, f64); 5] = [(0, 1.0), (40, 1.0), (41, -1.0), (42, 1.0), (370, -1.0)];

/// Operations after which the vectors of an entry end early: seconds of interpretation. The default sizes of all
/// operators take less than a fifth of it.
const OPERATIONS: usize = 100_000_000;

/// Samples until a feed-forward from rest has settled.
const SETTLING_SAMPLES: usize = 60;

/// The vectors of each entry, for inputs in the range of the model, in the requested precision.
pub(super) fn of(whole: &ExportedProgram, request: &ExportRequest) -> Result<Vec<Vectors>, Error> {
    let model = request.model;
    let u = inputs(model.known_inputs().unwrap_or(UNKNOWN_RANGE));
    let y = model.simulate(&u);
    let of = |entry: &Entry| {
        let missed = if entry.step == "ff_step" { missed(request, &y) } else { None };
        // As if the response were a fifth too large and the feed-forward were the input.
        let mut inputs = entry.rows(&u, &y, 1.2);
        if entry.step == "step" && whole.program.function(UNGUARDED).is_some() {
            let far = if request.options.float { f32::MAX.into() } else { 1e300 };
            FAR.iter().for_each(|(t, sign)| inputs[*t] = vec![sign * far]);
        }
        Ok(Vectors { missed, ..answers(whole, entry, inputs, request.options.float)? })
    };
    whole.entries.iter().map(of).collect()
}

/// Outputs and operations of an entry for these inputs, or for the first of them if all would take too long.
pub(super) fn counted(program: &Program, entry: &Entry, inputs: &[Vec<f64>], single: bool) -> Result<Vectors, Error> {
    let mut machine = Machine::new(program, entry.state, single);
    let (mut outputs, mut most, mut before) = (Vec::with_capacity(inputs.len()), 0, 0);
    for (t, input) in inputs.iter().enumerate() {
        let output = machine.call(entry.step, input)?[0];
        if !output.is_finite() || input.iter().any(|v| !v.is_finite()) {
            let because = format!(
                "the output of {} becomes {output} at sample {t} for inputs in the range of the model: check that the \
                 linear block is stable",
                entry.step
            );
            return Err(Error::Unsuited { what: "export".into(), because });
        }
        outputs.push(output);
        let total = machine.counts.total();
        (most, before) = (most.max(total - before), total);
        if total > OPERATIONS {
            break;
        }
    }
    let (all, n) = (machine.counts, outputs.len().max(1));
    let mean = Counts {
        sums: all.sums / n,
        products: all.products / n,
        quotients: all.quotients / n,
        comparisons: all.comparisons / n,
    };
    let (bound, bounds) = (program.bound(entry.step)?, program.bound_by_kind(entry.step)?);
    Ok(Vectors { outputs, mean, most, bound, bounds, ..Vectors::default() })
}

fn answers(whole: &ExportedProgram, entry: &Entry, mut inputs: Vec<Vec<f64>>, single: bool) -> Result<Vectors, Error> {
    let run = |single: bool| counted(&whole.program, entry, &inputs, single);
    let mut found = run(single)?;
    let mut exact = if single { run(false)?.outputs } else { found.outputs.clone() };
    let n = found.outputs.len().min(exact.len());
    inputs.truncate(n);
    found.outputs.truncate(n);
    exact.truncate(n);
    let (low, high) = ends(exact.iter().copied());
    let differs = found.outputs.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let off = if differs == 0.0 { 0.0 } else { differs / (high - low) };
    if (off.is_nan() || off >= MAX_SINGLE_ERROR_SHARE) && entry.step == "step" {
        let because = format!(
            "its error would be {off:.1e} of the stroke, because large numbers such as the offset leave too few \
             digits: use double precision, or remove the offset of the output"
        );
        return Err(Error::Unsuited { what: "export in single precision".into(), because });
    }
    Ok(Vectors { inputs, off, ..found })
}

/// Error of single precision, as a share of the stroke, from which it is an error.
const MAX_SINGLE_ERROR_SHARE: f64 = 1e-2;

/// Rms error of feed-forward and model along the wandering part of `r`, over its height.
fn missed(request: &ExportRequest, r: &[f64]) -> Option<f64> {
    let causal = request.causal().ok()?;
    let y = request.model.simulate(&causal.simulate(r));
    let pairs = || r.iter().zip(y.iter().skip(causal.delay_samples())).take(WANDERING).skip(SETTLING_SAMPLES);
    let (low, high) = ends(pairs().map(|(r, _)| *r));
    let mean = pairs().map(|(r, y)| (r - y) * (r - y)).sum::<f64>() / pairs().count() as f64;
    Some(mean.sqrt() / (high - low))
}

/// Two rotations at different speeds, within 95 % of the range. Only sums and products, so that all machines agree bit
/// by bit.
pub(super) fn wander((low, high): (f64, f64), n: usize) -> Vec<f64> {
    // Steps of 0.13 and 0.0481 rad.
    let (quick, slow) = ((0.9915618937147881, 0.12963414261969486), (0.9988434179553187, 0.04808145522014453));
    let (mut a, mut b) = ((1.0, 0.0), (1.0, 0.0));
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let share = |_| {
        (a, b) = (turned(quick, a), turned(slow, b));
        middle + half * (0.35 * a.1 + 0.6 * b.1)
    };
    (0..n).map(share).collect()
}

/// The sum of two angles, each as its cosine and sine.
pub(super) fn turned((c, s): (f64, f64), (x, y): (f64, f64)) -> (f64, f64) {
    (c * x - s * y, s * x + c * y)
}

/// Inputs within a range, the same on every machine.
fn inputs((low, high): (f64, f64)) -> Vec<f64> {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    // From the lower end to the upper one and back.
    let through = (0..RANGE_SAMPLES).map(|t| {
        let way = 2.0 * t as f64 / (RANGE_SAMPLES - 1) as f64;
        middle + half * if way <= 1.0 { 2.0 * way - 1.0 } else { 3.0 - 2.0 * way }
    });
    let mut drawn = 1u32;
    let jumps = (WANDERING + RANGE_SAMPLES..SAMPLES).map(|_| {
        drawn = drawn.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        middle + half * (f64::from(drawn >> 8) / f64::from(1 << 23) - 1.0)
    });
    wander((low, high), WANDERING).into_iter().chain(through).chain(jumps).collect()
}
