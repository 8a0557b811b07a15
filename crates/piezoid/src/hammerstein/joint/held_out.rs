//! Held-out errors and their comparison.

use super::equations::equations;
use super::estimate::Estimate;
use super::products::Segment;
use super::runs::FOLDS;
use super::solve::{FreeParameters, Prior};
use crate::series::{mean, scatter};
use nalgebra::DVector;
use rayon::prelude::*;

/// Smoothness weights tried, from rough to smooth.
const LAMBDAS: [f64; 10] = [0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];

/// Ratio of rms up to which a simpler model is accepted, even if the difference is uncertain.
const WORSE: f64 = 1.05;

/// Mean squared error over squared peak-to-peak that is rounding, for records without noise.
const ROUNDING: f64 = 1e-14;

/// Held-out errors of the folds, each predicted by a fit to all others.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HeldOut {
    /// Smoothness weight.
    pub(super) lambda: f64,
    /// For each fold, the mean squared error over the squared peak-to-peak of its records.
    pub(super) folds: Vec<f64>,
    /// The parameters fitted without each fold.
    pub(super) without: Vec<DVector<f64>>,
}

impl HeldOut {
    /// Root of the mean over all folds: rms over peak-to-peak.
    pub(super) fn rms_pp(&self) -> f64 {
        mean(&self.folds).sqrt()
    }

    /// True if this is as good as `best`: worse by at most one standard error over the folds, as a ratio, and by at
    /// most the factor accepted for a simpler model.
    pub(super) fn is_as_good_as(&self, best: &HeldOut) -> bool {
        let ratio = |(e, best): (&f64, &f64)| 0.5 * ((e + ROUNDING) / (best + ROUNDING)).ln();
        let ratios: Vec<f64> = self.folds.iter().zip(&best.folds).map(ratio).collect();
        let n = ratios.len() as f64;
        let error = (scatter(&ratios) / (n * (n - 1.0).max(1.0))).sqrt();
        let ratio = ((self.rms_pp().powi(2) + ROUNDING) / (best.rms_pp().powi(2) + ROUNDING)).sqrt();
        mean(&ratios) <= error && ratio <= WORSE
    }
}

/// The held-out errors of the smoothest fit that is as good as the best, or for a `fixed` smoothness. Without a fold
/// only the `free` parameters are fitted again.
pub(super) fn cross_validate(
    estimate: &Estimate,
    prior: &Prior,
    segments: &[Segment],
    damping: f64,
    free: FreeParameters,
    fixed: Option<f64>,
) -> HeldOut {
    let lambdas: Vec<f64> = match fixed {
        Some(lambda) => vec![lambda],
        None if estimate.basis.roughness().is_empty() => vec![LAMBDAS[0]],
        None => LAMBDAS.to_vec(),
    };
    let folds: Vec<usize> =
        (0..FOLDS).filter(|fold| segments.iter().any(|s| s.fold == Some(*fold) && s.judged)).collect();
    let of = |&fold: &usize| -> Vec<(f64, DVector<f64>)> {
        let (train, each) = equations(estimate, segments, |s| s.fold != Some(fold));
        let tests: Vec<&Segment> =
            segments.iter().filter(|s| s.fold == Some(fold) && s.judged && s.samples > 0.0).collect();
        // The run's own coefficients are those of its other segments; without any, they are fitted to this one.
        let error_of = |test: &Segment, steps: &DVector<f64>| match each.iter().find(|run| run.run == test.run) {
            Some(run) => test.residual(steps, &run.own(steps)),
            None => equations(estimate, std::slice::from_ref(test), |_| true).0.residual(steps),
        };
        // From smooth to rough, each starting from the previous signs.
        let mut positive = vec![true; prior.current().len()];
        let error = |lambda: &f64| match prior.solve(&train, *lambda, damping, free, &mut positive) {
            None => (f64::INFINITY, prior.current().clone()),
            Some(x) => {
                let steps = prior.steps(&x);
                (mean(&tests.iter().map(|test| error_of(test, &steps) / test.samples).collect::<Vec<_>>()), x)
            }
        };
        let mut errors: Vec<_> = lambdas.iter().rev().map(error).collect();
        errors.reverse();
        errors
    };
    let by_fold: Vec<Vec<_>> = folds.par_iter().map(of).collect();
    let of_lambda = |k: usize| HeldOut {
        lambda: lambdas[k],
        folds: by_fold.iter().map(|fold| fold[k].0).collect(),
        without: by_fold.iter().map(|fold| fold[k].1.clone()).collect(),
    };
    let tried: Vec<HeldOut> = (0..lambdas.len()).map(of_lambda).collect();
    let best = tried.iter().min_by(|p, q| p.rms_pp().total_cmp(&q.rms_pp()));
    let smoothest = tried.iter().rfind(|one| best.is_none_or(|best| one.is_as_good_as(best))).or(best);
    smoothest.cloned().unwrap_or(HeldOut { lambda: LAMBDAS[0], folds: Vec::new(), without: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::super::{products::products, runs::of, testing::estimate};
    use super::*;
    use crate::record::Record;
    use crate::series::dot;
    use crate::system::System;
    use crate::testing::assert_close;

    /// With only a gain and one offset per record, the error is that of a line through the other records.
    #[test]
    fn held_out_data_are_predicted_by_a_refit_to_all_others() {
        let wave = |k: usize, t: usize| 30.0 * (0.03 * (k + 1) as f64 * t as f64).sin();
        let records: Vec<Record> = (0..3)
            .map(|k| {
                let u: Vec<f64> = (0..800).map(|t| wave(k, t)).collect();
                let y = |(t, u): (usize, &f64)| {
                    (2.0 + 0.1 * k as f64) * u + 0.02 * u * u + (0.7 * t as f64).cos() + 50.0 * k as f64
                };
                let y = u.iter().enumerate().map(y).collect();
                Record::new(5e-4, u, y).unwrap()
            })
            .collect();
        let estimate = estimate("proportional", 1);
        let runs = of(&[], &records, &mut Vec::new()).unwrap();
        let segments = products(&estimate, &runs, &[]);
        let prior = Prior::of(&estimate);
        let found = cross_validate(&estimate, &prior, &segments, 1e-6, FreeParameters::Weights, Some(0.0));
        assert_eq!(found.folds.len(), 3);

        let about_mean = |x: &[f64]| x.iter().map(|v| v - mean(x)).collect::<Vec<_>>();
        let parts: Vec<(Vec<f64>, Vec<f64>, f64)> = records
            .iter()
            .zip(&runs)
            .map(|(r, run)| {
                let filtered = estimate.linear.simulate(&r.u().iter().map(|u| u - r.u()[0]).collect::<Vec<_>>());
                (about_mean(&filtered), about_mean(r.y()), run.scale * run.scale)
            })
            .collect();
        let explicit: Vec<f64> = (0..3)
            .map(|k| {
                let others = || parts.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, part)| part);
                let gain = others().map(|(u, y, s)| s * dot(u, y)).sum::<f64>()
                    / others().map(|(u, _, s)| s * dot(u, u)).sum::<f64>();
                let (u, y, s) = &parts[k];
                s * u.iter().zip(y).map(|(u, y)| (y - gain * u).powi(2)).sum::<f64>() / 800.0
            })
            .collect();
        assert_close(&found.folds, &explicit, 1e-6, 0.0);
    }

    #[test]
    fn as_good_means_within_one_standard_error_and_five_percent() {
        let of = |folds: &[f64]| HeldOut { lambda: 0.0, folds: folds.to_vec(), without: Vec::new() };
        let best = of(&[1.0, 1.0, 1.0]);
        assert!(of(&[1.08, 0.97, 1.02]).is_as_good_as(&best), "better and worse by turns");
        assert!(!of(&[1.03, 1.03, 1.03]).is_as_good_as(&best), "worse every time");
        assert!(!of(&[2.0, 0.6, 1.0]).is_as_good_as(&best), "worse by more than the limit");
    }
}
