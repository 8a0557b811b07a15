//! Held-out errors and their comparison.

use super::equations::{RecordEquations, ReducedEquations, equations};
use super::estimate::Estimate;
use super::folds::FOLDS;
use super::products::Segment;
use super::solve::{FreeParameters, Prior};
use libm::log;
use nalgebra::DVector;
use piezoid_numerics::series::{mean, scatter};
use rayon::prelude::*;
use tracing::trace_span;

/// Smoothness weights, from rough to smooth.
const SMOOTHNESS_WEIGHTS: [f64; 10] = [0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];

/// Number of fits in a row, each worse than the best, after which no rougher one is tried.
const MAX_WORSE_FITS: usize = 2;

/// Ratio of rms up to which a smoother fit is accepted, even if the difference is uncertain.
const ACCEPTED_RMS_RATIO: f64 = 1.05;

/// Mean squared error over squared peak-to-peak that is rounding, for records without noise.
pub(crate) const ROUNDING_ERROR: f64 = 1e-14;

/// Difference of ln(rms) up to which two models are equal, even if the difference is certain.
const EQUAL_LOG_RMS: f64 = 0.005;

/// Held-out errors of the folds, each predicted by a fit to all others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeldOut {
    /// Smoothness weight.
    pub(crate) lambda: f64,
    /// For each fold, the mean squared error over the squared peak-to-peak of its records.
    pub(crate) folds: Vec<f64>,
    /// The parameters fitted without each fold.
    pub(crate) without: Vec<DVector<f64>>,
}

impl HeldOut {
    /// Root of the mean over all folds: rms over peak-to-peak.
    pub(crate) fn rms_pp(&self) -> f64 {
        mean(&self.folds).sqrt()
    }

    /// True if this is as good as `best`: equal, or worse by at most one standard error over the folds, as a ratio, and
    /// by at most the ratio `accepted`.
    pub(crate) fn is_as_good_as(&self, best: &HeldOut, accepted: f64) -> bool {
        let ratio = |(e, best): (&f64, &f64)| 0.5 * log((e + ROUNDING_ERROR) / (best + ROUNDING_ERROR));
        let ratios: Vec<f64> = self.folds.iter().zip(&best.folds).map(ratio).collect();
        let n = ratios.len() as f64;
        let error = (scatter(&ratios) / (n * (n - 1.0).max(1.0))).sqrt();
        let ratio = ((self.rms_pp().powi(2) + ROUNDING_ERROR) / (best.rms_pp().powi(2) + ROUNDING_ERROR)).sqrt();
        mean(&ratios) <= error.max(EQUAL_LOG_RMS) && ratio <= accepted
    }
}

/// The smoothness weights to try.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Smoothness {
    /// All, from smooth to rough.
    Any,
    /// The next smoother than this one, this one, and all rougher ones.
    Near(f64),
    /// This one.
    Fixed(f64),
}

impl Smoothness {
    /// The one known.
    pub(crate) fn lambda(self) -> f64 {
        match self {
            Smoothness::Any => SMOOTHNESS_WEIGHTS[0],
            Smoothness::Near(lambda) | Smoothness::Fixed(lambda) => lambda,
        }
    }

    /// From smooth to rough.
    fn lambdas(self) -> Vec<f64> {
        let all = SMOOTHNESS_WEIGHTS.into_iter().rev();
        match self {
            Smoothness::Any => all.collect(),
            Smoothness::Near(lambda) => {
                let smoother = SMOOTHNESS_WEIGHTS.iter().position(|l| *l > lambda);
                all.filter(|l| smoother.is_none_or(|k| *l <= SMOOTHNESS_WEIGHTS[k])).collect()
            }
            Smoothness::Fixed(lambda) => vec![lambda],
        }
    }
}

/// The held-out errors of the smoothest fit that is as good as the best. Without a fold only the `free` parameters are
/// fitted again.
pub(crate) fn cross_validate(
    estimate: &Estimate,
    prior: &Prior,
    segments: &[Segment],
    damping: f64,
    free: FreeParameters,
    smoothness: Smoothness,
) -> HeldOut {
    let _stage = trace_span!(target: "stage", "held-out folds").entered();
    let lambdas = match smoothness {
        Smoothness::Any | Smoothness::Near(_) if estimate.basis.roughness().is_empty() => vec![SMOOTHNESS_WEIGHTS[0]],
        _ => smoothness.lambdas(),
    };
    let folds: Vec<usize> = (0..FOLDS)
        .filter(|fold| segments.iter().any(|s| s.fold == Some(*fold) && s.judged && s.samples > 0.0))
        .collect();
    // Each smoothness starts from the signs of the one before.
    let signs = prior.positive();
    let mut held_out: Vec<_> =
        folds.iter().map(|&fold| HeldOutFold::new(estimate, segments, fold, signs.clone())).collect();
    let mut tried: Vec<HeldOut> = Vec::new();
    for lambda in lambdas {
        let each: Vec<_> =
            held_out.par_iter_mut().map(|fold| fold.error(estimate, prior, lambda, damping, free)).collect();
        let (folds, without) = each.into_iter().unzip();
        tried.push(HeldOut { lambda, folds, without });
        let errors = tried.iter().map(HeldOut::rms_pp).collect::<Vec<_>>();
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        if errors.iter().rev().take(MAX_WORSE_FITS).filter(|error| **error > ACCEPTED_RMS_RATIO * least).count()
            == MAX_WORSE_FITS
        {
            break;
        }
    }
    let best = tried.iter().min_by(|p, q| p.rms_pp().total_cmp(&q.rms_pp()));
    let smoothest =
        tried.iter().find(|one| best.is_none_or(|best| one.is_as_good_as(best, ACCEPTED_RMS_RATIO))).or(best);
    smoothest.cloned().unwrap_or(HeldOut { lambda: SMOOTHNESS_WEIGHTS[0], folds: Vec::new(), without: Vec::new() })
}

/// A fold: the equations of all other segments, and its own segments.
struct HeldOutFold<'s> {
    train: ReducedEquations,
    each: Vec<RecordEquations>,
    tests: Vec<&'s Segment>,
    positive: Vec<bool>,
}

impl<'s> HeldOutFold<'s> {
    fn new(estimate: &Estimate, segments: &'s [Segment], fold: usize, positive: Vec<bool>) -> Self {
        let is_training = |s: &Segment| s.fold != Some(fold);
        let (train, mut each) = equations(estimate, segments, is_training, &[]);
        // Where less than half of a run is left, or not its beginning, its own coefficients are fitted to all of it:
        // offset and initial states are no knowledge of the path.
        let samples = |run: usize, selected: &dyn Fn(&Segment) -> bool| -> f64 {
            segments.iter().filter(|s| s.run == run && selected(s)).map(|s| s.samples).sum()
        };
        let is_little = |s: &Segment| {
            let begins = segments.iter().any(|first| first.run == s.run && first.is_first && is_training(first));
            !begins || samples(s.run, &is_training) < 0.5 * samples(s.run, &|_| true)
        };
        if segments.iter().any(is_little) {
            each = equations(estimate, segments, |s| is_training(s) || is_little(s), &[]).1;
        }
        let tests = segments.iter().filter(|s| s.fold == Some(fold) && s.judged && s.samples > 0.0).collect();
        HeldOutFold { train, each, tests, positive }
    }

    /// The mean squared error of the fit without the fold, and its parameters.
    fn error(
        &mut self,
        estimate: &Estimate,
        prior: &Prior,
        lambda: f64,
        damping: f64,
        free: FreeParameters,
    ) -> (f64, DVector<f64>) {
        let Some(x) = prior.solve(&self.train, lambda, damping, free, &mut self.positive) else {
            return (f64::INFINITY, prior.current().clone());
        };
        let steps = prior.steps(&x);
        // The run's own coefficients are those of its other segments; without any, they are fitted to this one.
        let error_of = |test: &&Segment| match self.each.iter().find(|run| run.run == test.run) {
            Some(run) => test.residual(&steps, &run.own(&steps)),
            None => equations(estimate, std::slice::from_ref(*test), |_| true, &[]).0.residual(&steps),
        };
        (mean(&self.tests.iter().map(|test| error_of(test) / test.samples).collect::<Vec<_>>()), x)
    }
}

#[cfg(test)]
mod tests {
    use super::super::solve::Scales;
    use super::super::{products::products, runs::training_records, testing::estimate};
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_records::record::Record;
    use piezoid_testing::assert_close;

    /// With only a gain, the error is that of a gain for all records and a line over time for each, fitted to the
    /// other segments.
    #[test]
    fn held_out_data_are_predicted_by_a_refit_to_all_others() {
        let wave = |k: usize, t: usize| 30.0 * (0.03 * (k + 1) as f64 * t as f64).sin();
        let records: Vec<Record> = (0..3)
            .map(|k| {
                let u: Vec<f64> = (0..880).map(|t| wave(k, t)).collect();
                let y = |(t, u): (usize, &f64)| {
                    (2.0 + 0.1 * k as f64) * u + 0.02 * u * u + (0.7 * t as f64).cos() + 50.0 * k as f64
                };
                let y = u.iter().enumerate().map(y).collect();
                Record::new(5e-4, u, y).unwrap()
            })
            .collect();
        let estimate = estimate("proportional", 1);
        let runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let segments = products(&estimate, &runs, &[], FreeParameters::All, &[]);
        let prior = Prior::of(&estimate, Scales::of(&estimate, &equations(&estimate, &segments, |_| true, &[]).0));
        let found = cross_validate(&estimate, &prior, &segments, 1e-6, FreeParameters::Weights, Smoothness::Fixed(0.0));
        assert_eq!(found.folds.len(), FOLDS);

        // Rows [gain, constants, slopes], for each sample; the first of 11 segments is in no fold.
        let row = |k: usize, t: usize, u: f64| {
            let own = |j: usize, v: f64| if j == k { v } else { 0.0 };
            let own = |v: f64| (0..3).map(move |j| own(j, v));
            let row = std::iter::once(u).chain(own(1.0)).chain(own(t as f64 / 880.0));
            nalgebra::SVector::<f64, 7>::from_iterator(row.map(|v| v * runs[k].scale))
        };
        let filtered: Vec<Vec<f64>> = records.iter().map(|r| estimate.linear.simulate(r.u())).collect();
        let fold_of = |t: usize| Some(t / 80).filter(|segment| *segment > 0).map(|segment| segment % FOLDS);
        let explicit = (0..FOLDS).map(|fold| {
            let mut h = nalgebra::SMatrix::<f64, 7, 7>::zeros();
            let mut g = nalgebra::SVector::<f64, 7>::zeros();
            let samples = || (0..3).flat_map(|k| (0..880).map(move |t| (k, t)));
            for (k, t) in samples().filter(|(_, t)| fold_of(*t) != Some(fold)) {
                let row = row(k, t, filtered[k][t]);
                h += row * row.transpose();
                g += row * (records[k].y()[t] * runs[k].scale);
            }
            // A drift is expected to be small: 0.3 % for one error in 100 samples, against 1 % of peak-to-peak.
            let kept = (0..880).filter(|t| fold_of(*t) != Some(fold)).count() as f64;
            (0..3).for_each(|k| h[(4 + k, 4 + k)] += 0.09 * kept / 100.0 * runs[k].scale.powi(2));
            let x = h.lu().solve(&g).unwrap();
            let error = |(k, t): (usize, usize)| {
                (records[k].y()[t] * runs[k].scale - row(k, t, filtered[k][t]).dot(&x)).powi(2)
            };
            let errors: Vec<f64> = samples().filter(|(_, t)| fold_of(*t) == Some(fold)).map(error).collect();
            mean(&errors)
        });
        assert_close(&found.folds, &explicit.collect::<Vec<_>>(), 1e-6, 0.0);
    }

    #[test]
    fn as_good_means_within_one_standard_error_and_five_percent() {
        let of = |folds: &[f64]| HeldOut { lambda: 0.0, folds: folds.to_vec(), without: Vec::new() };
        let best = of(&[1.0, 1.0, 1.0]);
        assert!(of(&[1.08, 0.97, 1.02]).is_as_good_as(&best, 1.05), "better and worse by turns");
        assert!(!of(&[1.03, 1.03, 1.03]).is_as_good_as(&best, 1.05), "worse every time");
        let (some, half) = (of(&[4e-17, 4e-17, 4e-17]), of(&[1e-17, 1e-17, 1e-17]));
        assert!(some.is_as_good_as(&half, 1.05), "both are rounding");
        assert!(!of(&[2.0, 0.6, 1.0]).is_as_good_as(&best, 1.05), "worse by more than the limit");
    }
}
