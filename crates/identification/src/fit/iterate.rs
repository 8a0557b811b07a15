//! A point of the search for the minimum: an estimate, its equations, and what these predict.

use super::equations::{RecordEquations, ReducedEquations, equations};
use super::estimate::Estimate;
use super::fitted::Fitted;
use super::held_out::{HeldOut, Smoothness, cross_validate};
use super::hidden::Hidden;
use super::layout::ColumnLayout;
use super::products::{Segment, products};
use super::runs::TrainingRecord;
use super::solve::{FreeParameters, Prior, Scales};
use nalgebra::DVector;
use std::sync::Arc;

/// Initial damping of a step, relative to the diagonal of the equations.
pub(crate) const INITIAL_DAMPING: f64 = 1e-7;

/// Mean squared error over squared peak-to-peak that is next to nothing: one step of Gauss-Newton does not predict the
/// end of the search.
const NEGLIGIBLE_ERROR: f64 = 1e-8;

/// Number of weights above which a step is first tried with z alone, which is much less work than all columns.
const MANY_WEIGHTS: usize = 64;

/// Largest number of products that a fit keeps: 80 MB.
const MAX_KEPT_PRODUCTS: usize = 10_000_000;

/// An estimate and its equations.
pub(crate) struct Iterate {
    pub(super) estimate: Estimate,
    pub(super) prior: Prior,
    segments: Arc<[Segment]>,
    pub(super) normal: ReducedEquations,
    each: Vec<RecordEquations>,
    /// The parameters that the equations have.
    pub(super) free: FreeParameters,
}

impl Iterate {
    pub(crate) fn at(estimate: Estimate, runs: &[TrainingRecord], own: &[Vec<f64>], free: FreeParameters) -> Self {
        let segments = products(&estimate, runs, own, free, &[]);
        Iterate::with(estimate, segments.into(), free, None)
    }

    /// With the scales of the penalties, and the priors of the runs' own coefficients, of `like`, or of this estimate.
    fn with(estimate: Estimate, segments: Arc<[Segment]>, free: FreeParameters, like: Option<&Iterate>) -> Self {
        let (normal, each) = equations(&estimate, &segments, |_| true, like.map_or(&[], |like| &like.each));
        let scales = like.map_or_else(|| Scales::of(&estimate, &normal), |like| like.prior.scales);
        Iterate { prior: Prior::of(&estimate, scales), estimate, segments, normal, each, free }
    }

    /// The same with the scales of the penalties, and the priors of the runs' own coefficients, of this estimate.
    pub(super) fn rescaled(self) -> Self {
        Iterate::with(self.estimate, self.segments, self.free, None)
    }

    /// At another estimate, after a step in the parameters `moved`; the penalties keep their scales.
    pub(super) fn after_step(
        &self,
        next: Estimate,
        runs: &[TrainingRecord],
        own: &[Vec<f64>],
        moved: FreeParameters,
    ) -> Self {
        let before = if moved == FreeParameters::Weights { &self.segments[..] } else { &[] };
        let segments = products(&next, runs, own, self.free, before);
        Iterate::with(next, segments.into(), self.free, Some(self))
    }

    /// The same after the weight of the small-signal records was multiplied by `factor`.
    pub(super) fn reweighted(mut self, runs: &[TrainingRecord], factor: f64) -> Self {
        if factor != 1.0 {
            let segments = Arc::make_mut(&mut self.segments).iter_mut();
            segments.filter(|s| !runs[s.run].large_signal).for_each(|s| s.gram *= factor.powi(2));
        }
        self.rescaled()
    }

    /// At the end of a fit of these runs, with all parameters free.
    pub(super) fn at_end_of(fit: &Fitted, runs: &[TrainingRecord]) -> Self {
        let (estimate, free) = (fit.estimate.clone(), FreeParameters::All);
        match &fit.segments {
            Some(segments) if fit.is_of(runs) => Iterate::with(estimate, segments.clone(), free, None),
            _ => Iterate::known(estimate, runs, free),
        }
    }

    /// The solution of the linearised equations.
    fn solution(&self, lambda: f64) -> Option<DVector<f64>> {
        self.prior.solve(&self.normal, lambda, INITIAL_DAMPING, self.free, &mut self.prior.positive())
    }

    /// The estimate at the solution of the linearised equations; the same one if there is none.
    pub(super) fn solved(self, lambda: f64) -> Estimate {
        self.solution(lambda).and_then(|x| self.estimate.moved(x.as_slice())).unwrap_or(self.estimate)
    }

    /// The current parameters as the unknowns of the equations.
    fn unknowns(&self) -> DVector<f64> {
        self.prior.steps(self.prior.current())
    }

    pub(crate) fn cost(&self, lambda: f64) -> f64 {
        self.cost_at(self.prior.current(), lambda)
    }

    /// At an estimate whose weights are known too, with the runs' own coefficients of this estimate.
    pub(super) fn known(estimate: Estimate, runs: &[TrainingRecord], free: FreeParameters) -> Self {
        let Some(alone) = Iterate::alone(&estimate, runs, None) else {
            let point = Iterate::at(estimate, runs, &[], free);
            let own = point.own(point.prior.current());
            return Iterate::at(point.estimate, runs, &own, free);
        };
        Iterate::at(estimate, runs, &alone.own(alone.prior.current()), free)
    }

    /// With z in place of the columns of the weights; `None` if the weights give no operator.
    fn alone(estimate: &Estimate, runs: &[TrainingRecord], like: Option<&Iterate>) -> Option<Self> {
        let hidden = Hidden::of_all(estimate, runs).ok()?;
        let runs: Vec<_> = hidden.iter().zip(runs).map(|(z, run)| z.run(run)).collect();
        let alone = Hidden::alone(estimate.lags.clone(), estimate.linear.clone()).ok()?;
        let segments = products(&alone, &runs, &[], FreeParameters::All, &[]);
        Some(Iterate::with(alone, segments.into(), FreeParameters::All, like))
    }

    /// The cost of a next estimate with z alone, if that saves work.
    pub(super) fn cost_of(&self, next: &Estimate, runs: &[TrainingRecord], lambda: f64) -> Option<f64> {
        let alone = (next.weights.len() > MANY_WEIGHTS).then(|| Iterate::alone(next, runs, Some(self)))??;
        let prior = Prior::of(next, self.prior.scales);
        Some(alone.normal.residual(&alone.unknowns()) + prior.penalty(&alone.normal, lambda, prior.current()))
    }

    /// True if the linearised equations promise less than `ratio` times the minimum of a fit, or next to nothing.
    pub(super) fn promises(&self, ratio: f64, fit: &Fitted) -> bool {
        self.predicted(fit.held_out.lambda) < (ratio * fit.minimum).max(self.negligible())
    }

    /// A sum of squares that is next to nothing.
    pub(crate) fn negligible(&self) -> f64 {
        NEGLIGIBLE_ERROR * self.normal.samples
    }

    /// The sum of squares and penalties at the solution of the linearised equations.
    pub(crate) fn predicted(&self, lambda: f64) -> f64 {
        self.solution(lambda).map_or(f64::INFINITY, |x| self.cost_at(&x, lambda))
    }

    pub(super) fn cost_at(&self, x: &DVector<f64>, lambda: f64) -> f64 {
        self.normal.residual(&self.prior.steps(x)) + self.prior.penalty(&self.normal, lambda, x)
    }

    /// The held-out errors by the linearised equations.
    pub(super) fn held_out(&self, free: FreeParameters, smoothness: Smoothness) -> HeldOut {
        cross_validate(&self.estimate, &self.prior, &self.segments, INITIAL_DAMPING, free, smoothness)
    }

    /// The runs' own coefficients at `x`; zeros for a run without usable samples, which has no equations.
    pub(super) fn own(&self, x: &DVector<f64>) -> Vec<Vec<f64>> {
        let (steps, count) = (self.prior.steps(x), ColumnLayout::of(&self.estimate).own());
        let runs = self.segments.last().map_or(0, |last| last.run + 1);
        let mut own = vec![vec![0.0; count]; runs];
        self.each.iter().for_each(|run| own[run.run] = run.own(&steps));
        own
    }

    /// For each run, the mean squared error over the squared peak-to-peak; NaN for a run without usable samples.
    pub(super) fn residuals(&self, runs: &[TrainingRecord]) -> Vec<f64> {
        let unknowns = self.unknowns();
        let mut residuals = vec![f64::NAN; runs.len()];
        for RecordEquations { run, normal, .. } in &self.each {
            residuals[*run] = normal.residual(&unknowns) / normal.samples / runs[*run].heavier.powi(2);
        }
        residuals
    }

    /// The products, if they have all columns and are not too many to keep.
    fn kept_segments(&self) -> Option<Arc<[Segment]>> {
        let is_whole = self.free == FreeParameters::All || ColumnLayout::of(&self.estimate).shape.is_empty();
        let numbers: usize = self.segments.iter().map(|segment| segment.gram.len()).sum();
        (is_whole && numbers <= MAX_KEPT_PRODUCTS).then(|| self.segments.clone())
    }

    /// The fit that ends here.
    pub(super) fn fitted(self, held_out: HeldOut, runs: &[TrainingRecord]) -> Fitted {
        let n = self.estimate.weights.len();
        Fitted {
            initial_conditions: runs.iter().map(|run| run.initial).collect(),
            heavier: runs.iter().map(|run| run.heavier).collect(),
            own: self.own(self.prior.current()),
            residuals: self.residuals(runs),
            products: self.normal.h.view((0, 0), (n, n)).into_owned(),
            segments: self.kept_segments(),
            minimum: self.cost(held_out.lambda),
            held_out,
            estimate: self.estimate,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{refine::refine, runs::training_records, testing::estimate};
    use super::*;
    use piezoid_models::creep::Lag;
    use piezoid_models::driver::DriverModel;
    use piezoid_models::hammerstein::InitialCondition;
    use piezoid_models::linear::Arx;
    use piezoid_records::record::Record;

    #[test]
    fn the_cost_with_z_alone_is_that_of_all_columns() {
        let range = (-23.0, 33.0);
        let wave = |t: u32| 5.0 + 28.0 * (0.3 + 0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).cos();
        let u: Vec<f64> = (0..1500).map(wave).collect();
        let mut y: Vec<f64> = u.iter().map(|u| u + 0.01 * u * u).collect();
        y[700] = 1e4;
        let records = [Record::new(5e-4, u, y).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        assert!(!runs[0].usable[700]);
        runs[0].heavier = 3.0;
        for driver in [None, Some(DriverModel::new(1e-3, None).unwrap())] {
            for initial in InitialCondition::of(records[0].u()) {
                runs[0].start_from(initial, range);
                let lags = vec![Lag { tau_s: 0.02, gain: 0.05 }, Lag { tau_s: 0.1, gain: 0.02 }];
                let start = Estimate { driver, seeks_lag: driver.is_some(), lags, ..estimate("preisach", 15) };
                let weights = (0..start.weights.len()).map(|k| (k as f64).sin().powi(2)).collect();
                let start = Estimate { weights, ..start };
                let next = start.with_linear(Arx::new(5e-4, vec![0.5], vec![1.6]).unwrap());
                let point = Iterate::at(start, &runs, &[], FreeParameters::All);
                let alone = point.cost_of(&next, &runs, 0.1).unwrap();
                let all = point.after_step(next, &runs, &[], FreeParameters::All);
                let residual = all.normal.residual(&all.unknowns());
                let penalty = all.prior.penalty(&all.normal, 0.1, all.prior.current());
                let off = (alone / (residual + penalty) - 1.0).abs();
                assert!(off < 1e-9 && penalty > 0.01 * residual, "{initial:?} {alone:e} {residual:e} {penalty:e}");
            }
        }
    }

    /// The scales of the penalties once moved with the parameters, which no step predicts.
    #[test]
    fn along_a_step_the_cost_falls_as_predicted() {
        let u: Vec<f64> = (0..900).map(|t| 5.0 + 28.0 * (0.3 + 0.01 * f64::from(t)).sin()).collect();
        let ringing = |t: usize| 400.0 * 0.8f64.powi(t as i32);
        let y = u.iter().enumerate().map(|(t, u)| u + u * u + ringing(t)).collect();
        let records = [Record::new(5e-4, u, y).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let lags = vec![Lag { tau_s: 0.02, gain: 0.05 }, Lag { tau_s: 0.1, gain: 0.02 }];
        let start = Estimate { lags, ..estimate("generalised-prandtl-ishlinskii", 6) };
        let fit = refine(start, &mut runs, FreeParameters::Creep, &mut |_| Ok(())).unwrap();
        for lambda in [0.0, 0.1] {
            let point = Iterate::known(fit.estimate.clone(), &runs, FreeParameters::All);
            let (from, to) = (point.prior.current(), point.solution(lambda).unwrap());
            let x = from + (&to - from) * 1e-5;
            let next = point.estimate.moved(x.as_slice()).unwrap();
            let next = point.after_step(next, &runs, &point.own(&x), FreeParameters::All);
            let fall = (point.cost(lambda) - next.cost(lambda)) / (point.cost(lambda) - point.cost_at(&x, lambda));
            assert!((fall - 1.0).abs() < 1e-2, "{lambda} {fall}");
        }
    }

    #[test]
    fn a_fit_goes_on_with_its_products_while_the_runs_are_its_own() {
        let u: Vec<f64> = (0..900).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let rough = |(t, u): (usize, &f64)| u + 0.1 * ((t * t) as f64 * 0.618_034).fract();
        let y = u.iter().enumerate().map(rough).collect();
        let records = [Record::new(5e-4, u, y).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let start = estimate("prandtl-ishlinskii", 6);
        let fit = refine(start, &mut runs, FreeParameters::Weights, &mut |_| Ok(())).unwrap();
        let segments = fit.segments.clone().unwrap();
        let next = Iterate::at_end_of(&fit, &runs);
        assert!(Arc::ptr_eq(&next.segments, &segments));
        let known = Iterate::known(fit.estimate.clone(), &runs, FreeParameters::All);
        let lambda = fit.held_out.lambda;
        assert!((next.cost(lambda) / known.cost(lambda) - 1.0).abs() < 1e-6);
        assert!((next.predicted(lambda) / known.predicted(lambda) - 1.0).abs() < 1e-3);
        runs[0].start_from(InitialCondition::FromAbove, (-28.0, 28.0));
        assert!(!Arc::ptr_eq(&Iterate::at_end_of(&fit, &runs).segments, &segments));
    }

    #[test]
    fn products_with_another_weight_of_small_signal_records_are_those_of_all_samples() {
        let u: Vec<f64> = (0..900).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let records = [0.1, 1.0].map(|k| {
            let u: Vec<f64> = u.iter().map(|u| k * u).collect();
            Record::new(5e-4, u.clone(), u).unwrap()
        });
        let mut runs = training_records(&records[..1], &records[1..], &mut Vec::new()).unwrap();
        let at = |runs: &[TrainingRecord]| {
            Iterate::at(estimate("prandtl-ishlinskii", 6), runs, &[], FreeParameters::Weights).normal.h
        };
        let before = Iterate::at(estimate("prandtl-ishlinskii", 6), &runs, &[], FreeParameters::Weights);
        runs.iter_mut().filter(|run| !run.large_signal).for_each(|run| run.heavier = 3.0);
        let (scaled, all) = (before.reweighted(&runs, 3.0).normal.h, at(&runs));
        assert!((&scaled - &all).amax() < 1e-12 * all.amax());
        runs.iter_mut().for_each(|run| run.heavier = 1.0);
        assert!((&scaled - at(&runs)).amax() > 1e-3 * all.amax());
    }
}
