//! Search of the shape of the operator, where the problem is not convex, on part of the data.
//!
//! Shapes are spread evenly over their domain, each with its optimal weights. The best of them are refined by
//! Gauss-Newton in weights, creep and shape. The result is only a start for the whole data.

use super::JointOptions;
use super::fit::{Estimate, FreeParameters, Iterate, StepCallback, TrainingRecord, refine_from_unknown};
use crate::side_by_side::side_by_side;
use libm::pow;
use piezoid_models::hysteresis::ShapeParameter;
use piezoid_numerics::error::Error;
use piezoid_records::record::Record;
use rayon::prelude::*;

/// Smoothness weight of the fits: only the order of the shapes matters.
const SMOOTHNESS_WEIGHT: f64 = 1e-6;

/// The bases of the sequences, one for each shape parameter.
const PRIMES: [usize; 6] = [2, 3, 5, 7, 11, 13];

/// Number of seeds with sequences of their own.
const MAX_SEED: usize = 1000;

/// The estimate with the best shape that is found, and unknown weights; `None` if there is nothing to search.
pub(super) fn best_shape(
    estimate: &Estimate,
    runs: &[TrainingRecord],
    settings: &JointOptions,
    watch: StepCallback,
) -> Result<Option<Estimate>, Error> {
    let shape = estimate.basis.shape();
    if shape.is_empty() || shape.len() > PRIMES.len() {
        return Ok(None);
    }
    let large_signal: Vec<&TrainingRecord> = runs.iter().filter(|run| run.large_signal).collect();
    let breadth = settings.effort.breadth();
    let each = breadth.shape_samples / large_signal.len().max(1);
    // The ends, where rising amplitudes are largest.
    let from = |run: &TrainingRecord| run.record.len().saturating_sub(each);
    let end = |run: &&TrainingRecord| run.record.slice(from(run)..run.record.len());
    let parts: Vec<Record> = large_signal.iter().map(end).collect::<Result<_, _>>()?;
    let part = |(part, run): (_, &&TrainingRecord)| {
        let end = TrainingRecord::new(part, &run.name, true, run.usable[from(run)..].to_vec())?;
        // The largest of rising amplitudes wipe out the memory of the inputs long before.
        let before = [&run.before, &run.record.u()[..from(run)]].concat();
        let before = before[before.len().saturating_sub(each.max(1))..].to_vec();
        let end = TrainingRecord { drifts: run.drifts, ..end };
        let moving = part.len().min(before.len() - 1);
        Some(match from(run) {
            0 => TrainingRecord { initial: run.initial, before, moving: run.moving.min(moving), ..end },
            _ => end.later_part(before, moving),
        })
    };
    let parts: Vec<TrainingRecord> = parts.iter().zip(&large_signal).filter_map(part).collect();

    let at = |x: &[f64]| -> Option<Estimate> {
        let p: Vec<f64> = shape.iter().zip(x).map(|(shape, x)| from_unit(shape, *x)).collect();
        let basis = estimate.basis.reshaped(&p).ok()?;
        Some(estimate.with_basis(basis))
    };
    let cost = |estimate: Estimate| -> (f64, Estimate) {
        let point = Iterate::at(estimate.clone(), &parts, &[], FreeParameters::Weights);
        (point.predicted(SMOOTHNESS_WEIGHT), estimate)
    };
    // Spread evenly over all shapes, and the operator's own.
    let count = breadth.shapes + breadth.shapes_per_parameter * shape.len();
    let first = first_shape(settings.seed, count);
    let spread = |k: usize| -> Vec<f64> { PRIMES[..shape.len()].iter().map(|&base| halton(k, base)).collect() };
    let starts: Vec<Estimate> = (first..first + count).filter_map(|k| at(&spread(k))).collect();
    let mut costs: Vec<_> = starts.into_par_iter().chain([estimate.clone()]).map(cost).collect();
    costs.sort_by(|p, q| p.0.total_cmp(&q.0));
    costs.truncate(breadth.shape_starts);
    let refined = |(_, start): (f64, Estimate), watch: StepCallback| {
        refine_from_unknown(start, SMOOTHNESS_WEIGHT, &mut parts.clone(), FreeParameters::Shape, watch)
    };
    let fits = side_by_side(costs, refined, |_, _| watch(0))?.into_iter().collect::<Result<Vec<_>, _>>()?;
    let best = fits.into_iter().min_by(|p, q| p.minimum.total_cmp(&q.minimum));
    best.map(|fit| Ok(estimate.with_basis(fit.estimate.basis.reshaped(&fit.estimate.shape())?))).transpose()
}

/// The first element of the sequences of a seed, each with `count` elements.
fn first_shape(seed: u64, count: usize) -> usize {
    1 + seed as usize % MAX_SEED * count
}

/// Element `k` of the Van der Corput sequence of a base, from 0 to 1; those of several primes are spread evenly.
/// J. H. Halton, Numer. Math. 2, 84 (1960), DOI 10.1007/BF01386213.
fn halton(mut k: usize, base: usize) -> f64 {
    let (mut x, mut digit) = (0.0, 1.0);
    while k > 0 {
        digit /= base as f64;
        x += digit * (k % base) as f64;
        k /= base;
    }
    x
}

/// The shape parameter at a share of its domain, on a logarithmic scale if that is positive.
fn from_unit(shape: &ShapeParameter, share: f64) -> f64 {
    if shape.low > 0.0 {
        shape.low * pow(shape.high / shape.low, share)
    } else {
        shape.low + share * (shape.high - shape.low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_sequences_are_those_of_van_der_corput() {
        let of = |base| (0..8).map(|k| halton(k, base)).collect::<Vec<_>>();
        assert_close(&of(2), &[0.0, 0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875], 1e-15, 0.0);
        let ninths = [0.0, 3.0, 6.0, 1.0, 4.0, 7.0, 2.0, 5.0].map(|k| k / 9.0);
        assert_close(&of(3), &ninths, 1e-14, 0.0);
    }

    #[test]
    fn seeds_have_no_shape_in_common() {
        assert_eq!([0, 1, 2, 999].map(|seed| first_shape(seed, 12)), [1, 13, 25, 11989]);
    }

    #[test]
    fn a_share_of_a_positive_domain_is_on_a_logarithmic_scale() {
        let shape = |low, high| ShapeParameter { name: "p", value: 1.0, low, high };
        for (low, high, share, expected) in
            [(1.0, 100.0, 0.5, 10.0), (2.0, 32.0, 0.75, 16.0), (0.0, 4.0, 0.25, 1.0), (-2.0, 6.0, 0.25, 0.0)]
        {
            assert_close(&[from_unit(&shape(low, high), share)], &[expected], 1e-15, 1e-15);
        }
    }
}
