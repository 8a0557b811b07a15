//! Refinement of all parts: Gauss-Newton on the free-run error, with the damping of Levenberg and Marquardt if a step
//! does not lower it.
//!
//! First only the weights, then also the gains of creep, then all parameters.

use super::dynamics::{creep_pole, is_damped, slowest_observable};
use super::equations::{RecordEquations, ReducedEquations, equations};
use super::estimate::Estimate;
use super::held_out::{HeldOut, Smoothness, cross_validate};
use super::hidden::Hidden;
use super::products::{Segment, products};
use super::runs::TrainingRecord;
use super::solve::{FreeParameters, Prior};
use crate::error::Error;
use crate::hammerstein::InitialCondition;
use crate::linear::Arx;
use crate::series::mean;
use nalgebra::DVector;

/// Initial damping.
const DAMPING: f64 = 1e-7;

/// Maximum number of steps, and of tries per step.
const STEPS: usize = 60;
const TRIES: usize = 8;

/// The step from which record weights are fixed.
const SETTLED: usize = 3;

/// Maximum number of changes of the smoothness after the first.
const CHANGES: usize = 3;

/// Relative decrease of the cost below which the search ends.
const ENOUGH: f64 = 3e-4;

/// The same by the linearised equations, below which a step is not tried.
const NOTHING: f64 = 1e-4;

/// Mean squared error over squared peak-to-peak that is next to nothing: one step of Gauss-Newton does not predict the
/// end of the search.
const SMALL: f64 = 1e-8;

/// Mean squared error over squared peak-to-peak that is rounding, for records without noise.
pub(super) const ROUNDING: f64 = 1e-14;

/// Number of weights above which a step is first tried with z alone, much less work than all columns; and ratio of the
/// costs up to which all columns decide: the scale of the penalty may have changed.
const MANY: usize = 64;
const NEARLY: f64 = 1.01;

/// Maximum weight of small-signal samples over large-signal ones.
const HEAVIEST: f64 = 30.0;

/// Called before each step; an error ends the work.
pub(super) type StepCallback<'a> = &'a mut dyn FnMut(usize) -> Result<(), Error>;

/// A fitted estimate.
#[derive(Debug)]
pub(super) struct Fitted {
    pub(super) estimate: Estimate,
    /// The initial condition of each run.
    pub(super) begun: Vec<InitialCondition>,
    /// Initial states and constant of each run.
    pub(super) own: Vec<Vec<f64>>,
    pub(super) held_out: HeldOut,
    /// For each run, the mean squared error over the squared peak-to-peak.
    pub(super) residuals: Vec<f64>,
    /// The minimised sum of squares and penalties.
    pub(super) minimum: f64,
}

impl Fitted {
    /// Mean over the runs of the mean squared error over the squared peak-to-peak.
    pub(super) fn cost(&self) -> f64 {
        mean(&self.residuals)
    }

    /// Sets the initial conditions of the runs to those of this fit: later fits may have tried others.
    pub(super) fn begin_again(&self, runs: &mut [TrainingRecord], range: (f64, f64)) {
        let others = runs.iter_mut().zip(&self.begun).filter(|(run, begun)| run.initial != **begun);
        others.for_each(|(run, begun)| run.begin_from(*begun, range));
    }
}

/// An estimate and its equations.
pub(super) struct Iterate {
    estimate: Estimate,
    prior: Prior,
    segments: Vec<Segment>,
    normal: ReducedEquations,
    each: Vec<RecordEquations>,
    /// The parameters that the equations have.
    free: FreeParameters,
}

impl Iterate {
    pub(super) fn at(estimate: Estimate, runs: &[TrainingRecord], own: &[Vec<f64>], free: FreeParameters) -> Self {
        let segments = products(&estimate, runs, own, free);
        let (normal, each) = equations(&estimate, &segments, |_| true);
        Iterate { prior: Prior::of(&estimate), estimate, segments, normal, each, free }
    }

    /// The current parameters as the unknowns of the equations.
    fn unknowns(&self) -> DVector<f64> {
        self.prior.steps(self.prior.current())
    }

    pub(super) fn cost(&self, lambda: f64) -> f64 {
        self.cost_at(self.prior.current(), lambda)
    }

    /// At an estimate whose weights are known too, with the runs' own coefficients of this estimate.
    fn known(estimate: Estimate, runs: &[TrainingRecord], free: FreeParameters) -> Self {
        let Some(alone) = Iterate::alone(&estimate, runs) else {
            let point = Iterate::at(estimate, runs, &[], free);
            let own = point.own(point.prior.current());
            return Iterate::at(point.estimate, runs, &own, free);
        };
        Iterate::at(estimate, runs, &alone.own(alone.prior.current()), free)
    }

    /// With z in place of the columns of the weights; `None` if the weights give no operator.
    fn alone(estimate: &Estimate, runs: &[TrainingRecord]) -> Option<Self> {
        let hidden = Hidden::of_all(estimate, runs).ok()?;
        let runs: Vec<_> = hidden.iter().zip(runs).map(|(z, run)| z.run(run)).collect();
        let alone = Hidden::alone(estimate.lags.clone(), estimate.linear.clone()).ok()?;
        Some(Iterate::at(alone, &runs, &[], FreeParameters::All))
    }

    /// The cost of a next estimate with z alone, if that saves work; the penalty is scaled by the present equations.
    fn cost_of(&self, next: &Estimate, runs: &[TrainingRecord], lambda: f64) -> Option<f64> {
        let alone = (next.weights.len() > MANY).then(|| Iterate::alone(next, runs))??;
        let prior = Prior::of(next);
        Some(alone.normal.residual(&alone.unknowns()) + prior.penalty(&self.normal, lambda, prior.current()))
    }

    /// True if the linearised equations promise less than `ratio` times the minimum of a fit, or next to nothing.
    fn promises(&self, ratio: f64, fit: &Fitted) -> bool {
        self.predicted(fit.held_out.lambda) < (ratio * fit.minimum).max(SMALL * self.normal.samples)
    }

    /// The sum of squares and penalties at the solution of the linearised equations.
    pub(super) fn predicted(&self, lambda: f64) -> f64 {
        let mut positive = vec![true; self.prior.current().len()];
        let x = self.prior.solve(&self.normal, lambda, DAMPING, self.free, &mut positive);
        x.map_or(f64::INFINITY, |x| self.cost_at(&x, lambda))
    }

    fn cost_at(&self, x: &DVector<f64>, lambda: f64) -> f64 {
        self.normal.residual(&self.prior.steps(x)) + self.prior.penalty(&self.normal, lambda, x)
    }

    /// The held-out errors by the linearised equations.
    fn held_out(&self, free: FreeParameters, smoothness: Smoothness) -> HeldOut {
        cross_validate(&self.estimate, &self.prior, &self.segments, DAMPING, free, smoothness)
    }

    /// The runs' own coefficients at `x`.
    fn own(&self, x: &DVector<f64>) -> Vec<Vec<f64>> {
        let steps = self.prior.steps(x);
        self.each.iter().map(|run| run.own(&steps)).collect()
    }

    /// For each run, the mean squared error over the squared peak-to-peak.
    fn residuals(&self, runs: &[TrainingRecord]) -> Vec<f64> {
        let unknowns = self.unknowns();
        let of =
            |run: &RecordEquations| run.normal.residual(&unknowns) / run.normal.samples / runs[run.run].heavier.powi(2);
        self.each.iter().map(of).collect()
    }
}

/// Fits the `free` parameters from `start`; its weights need not be known.
///
/// # Errors
/// The errors of `watch`, which is called before each step.
pub(super) fn refine(
    start: Estimate,
    runs: &mut [TrainingRecord],
    free: FreeParameters,
    watch: StepCallback,
) -> Result<Fitted, Error> {
    runs.iter_mut().for_each(|run| run.heavier = 1.0);
    refine_from(start, Smoothness::Any, runs, free, watch)
}

/// Fits the `free` parameters from `start`. Without a known smoothness the start is its linear block and shape; with
/// one it is all its parameters, and for a fixed one the minimum never exceeds the value at the start.
pub(super) fn refine_from(
    start: Estimate,
    smoothness: Smoothness,
    runs: &mut [TrainingRecord],
    free: FreeParameters,
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let point = match smoothness {
        Smoothness::Any => Iterate::at(start, runs, &[], free),
        _ => Iterate::known(start, runs, free),
    };
    descend(point, smoothness, &|_| true, runs, watch)
}

/// Lowers the cost from `point` on, to its minimum or to the first linear block that is not `possible`.
fn descend(
    mut point: Iterate,
    smoothness: Smoothness,
    possible: &dyn Fn(&Arx) -> bool,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let free = point.free;
    let (is_start, is_fixed) = (smoothness == Smoothness::Any, matches!(smoothness, Smoothness::Fixed(_)));
    let (mut lambda, mut damping) = (smoothness.lambda(), DAMPING);
    let mut changes = if is_fixed { 0 } else { CHANGES };
    for step in 0..STEPS {
        watch(step)?;
        let now = match (step, free) {
            _ if !is_start => free,
            (0, _) => FreeParameters::Weights,
            (1, FreeParameters::All) => FreeParameters::Creep,
            (_, free) => free,
        };
        if step == 0 && !is_fixed {
            lambda = point.held_out(now, smoothness).lambda;
        }
        let cost = if is_start && step == 0 { f64::INFINITY } else { point.cost(lambda) };
        let next = lower(&point, runs, cost, lambda, &mut damping, now);
        let fall = next.as_ref().map_or(0.0, |next| 1.0 - next.cost(lambda) / cost);
        point = next.unwrap_or(point);
        if !possible(&point.estimate.linear) {
            break;
        }
        if is_start && step + 1 < SETTLED && weigh(runs, &point.residuals(runs)) {
            let own = point.own(point.prior.current());
            point = Iterate::at(point.estimate, runs, &own, free);
        }
        let ends = fall < ENOUGH || point.cost(lambda) < ROUNDING * point.normal.samples;
        if ends && now != free {
            // More parameters are free in the next step.
            damping = DAMPING;
        } else if ends {
            let best = if changes > 0 { point.held_out(free, Smoothness::Near(lambda)).lambda } else { lambda };
            if best == lambda {
                break;
            }
            (lambda, damping, changes) = (best, DAMPING, changes - 1);
        }
    }
    let own = point.own(point.prior.current());
    let (held_out, residuals) = (point.held_out(free, Smoothness::Fixed(lambda)), point.residuals(runs));
    let minimum = point.cost(lambda);
    let begun = runs.iter().map(|run| run.initial).collect();
    Ok(Fitted { estimate: point.estimate, begun, own, held_out, residuals, minimum })
}

/// Fits all parameters from each start that promises less than `ratio` times the minimum of `from`, or next to nothing,
/// by the linearised equations, while its linear block is `possible`; returns their names too.
pub(super) fn refine_promising(
    starts: Vec<(String, Estimate)>,
    from: &Fitted,
    ratio: f64,
    possible: &dyn Fn(&Arx) -> bool,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Vec<(String, Fitted)>, Error> {
    let smoothness = Smoothness::Fixed(from.held_out.lambda);
    let mut found = Vec::new();
    for (name, start) in starts {
        let point = Iterate::known(start, runs, FreeParameters::All);
        if point.promises(ratio, from) {
            let fit = descend(point, smoothness, possible, runs, watch)?;
            found.extend(Some((name, fit)).filter(|(_, fit)| possible(&fit.estimate.linear)));
        }
    }
    Ok(found)
}

/// Fits weights and creep from the parameters of `from`, if that promises a lower minimum with the present initial
/// conditions of the runs.
pub(super) fn refine_if_better(
    from: &Fitted,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Option<Fitted>, Error> {
    let Some(same) = from.estimate.with_linear(from.estimate.linear.clone()) else { return Ok(None) };
    let point = Iterate::known(same, runs, FreeParameters::Creep);
    let smoothness = Smoothness::Near(from.held_out.lambda);
    point.promises(1.0, from).then(|| descend(point, smoothness, &|_| true, runs, watch)).transpose()
}

/// The next point with lower cost, if one is found.
fn lower(
    point: &Iterate,
    runs: &[TrainingRecord],
    cost: f64,
    lambda: f64,
    damping: &mut f64,
    free: FreeParameters,
) -> Option<Iterate> {
    let slowest = slowest_observable(runs.iter().map(|run| run.record));
    let (mut positive, mut harder) = (vec![true; point.prior.current().len()], 2.0);
    for _ in 0..TRIES {
        let x = point.prior.solve(&point.normal, lambda, *damping, free, &mut positive)?;
        if cost.is_finite() && 1.0 - point.cost_at(&x, lambda) / cost < NOTHING {
            return None;
        }
        let moved = point.estimate.moved(x.as_slice());
        let possible = |linear: &Arx| creep_pole(linear, slowest).is_none() && is_damped(linear);
        if let Some(estimate) = moved.filter(|next| possible(&next.linear) || !possible(&point.estimate.linear)) {
            let own = point.own(&x);
            // Any step lowers an infinite cost.
            let alone = cost.is_finite().then(|| point.cost_of(&estimate, runs, lambda)).flatten();
            let next =
                alone.is_none_or(|next| next < NEARLY * cost).then(|| Iterate::at(estimate, runs, &own, point.free));
            if let Some(next) = next.filter(|next| next.cost(lambda) < cost) {
                *damping = (*damping * 0.1).max(1e-9);
                return Some(next);
            }
        }
        // Nielsen's rule: the damping grows faster with each failure.
        *damping *= harder;
        harder *= 2.0;
    }
    None
}

/// Weights the two kinds of records by their residuals; returns true if that changes anything.
fn weigh(runs: &mut [TrainingRecord], residuals: &[f64]) -> bool {
    let of = |large_signal: bool| {
        let kind = runs.iter().zip(residuals).filter(|(run, _)| run.large_signal == large_signal);
        mean(&kind.map(|(_, residual)| *residual).collect::<Vec<_>>())
    };
    let heavier = (of(true) / of(false)).sqrt().clamp(1.0, HEAVIEST);
    if !heavier.is_finite() {
        return false;
    }
    for run in runs.iter_mut().filter(|run| !run.large_signal) {
        run.heavier = heavier;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::super::{runs::of, testing::estimate};
    use super::*;
    use crate::creep::Lag;
    use crate::driver::DriverModel;
    use crate::hammerstein::InitialCondition;
    use crate::record::Record;
    use crate::system::System;

    #[test]
    fn a_start_without_damping_is_fitted_too() {
        let radius = 0.9999f64;
        let block = Arx::new(5e-4, vec![2.0 * radius * 0.9, -radius * radius], vec![0.1]).unwrap();
        assert!(!is_damped(&block));
        let u: Vec<f64> = (0..900).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let records = [Record::new(5e-4, u.clone(), block.simulate(&u)).unwrap()];
        let mut runs = of(&[], &records, &mut Vec::new()).unwrap();
        let start = estimate("prandtl-ishlinskii", 6).with_linear(block).unwrap();
        let fit = refine(start, &mut runs, FreeParameters::Weights, &mut |_| Ok(())).unwrap();
        assert!(fit.cost() < 1e-4, "{:e}", fit.cost());
    }

    #[test]
    fn runs_begin_again_as_in_a_fit() {
        let u: Vec<f64> = (0..900).map(|t| 28.0 * (0.01 * f64::from(t)).cos()).collect();
        let records = [Record::new(5e-4, u.clone(), u).unwrap()];
        let mut runs = of(&[], &records, &mut Vec::new()).unwrap();
        let start = estimate("prandtl-ishlinskii", 6);
        let fit = refine(start, &mut runs, FreeParameters::Weights, &mut |_| Ok(())).unwrap();
        let (initial, before) = (runs[0].initial, runs[0].before.clone());
        runs[0].begin_from(InitialCondition::FromAbove, (-28.0, 28.0));
        assert_ne!(runs[0].before, before);
        fit.begin_again(&mut runs, (-28.0, 28.0));
        assert_eq!((runs[0].initial, &runs[0].before), (initial, &before));
    }

    #[test]
    fn the_cost_with_z_alone_is_that_of_all_columns() {
        let range = (-23.0, 33.0);
        let wave = |t: u32| 5.0 + 28.0 * (0.3 + 0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).cos();
        let u: Vec<f64> = (0..1500).map(wave).collect();
        let mut y: Vec<f64> = u.iter().map(|u| u + 0.01 * u * u).collect();
        y[700] = 1e4;
        let records = [Record::new(5e-4, u, y).unwrap()];
        let mut runs = of(&[], &records, &mut Vec::new()).unwrap();
        assert!(!runs[0].usable[700]);
        runs[0].heavier = 3.0;
        for driver in [None, Some(DriverModel::new(1e-3, None).unwrap())] {
            for initial in InitialCondition::of(records[0].u()) {
                runs[0].begin_from(initial, range);
                let lags = vec![Lag { tau_s: 0.02, gain: 0.05 }, Lag { tau_s: 0.1, gain: 0.02 }];
                let start = Estimate { driver, seeks_lag: driver.is_some(), lags, ..estimate("preisach", 15) };
                let weights = (0..start.weights.len()).map(|k| (k as f64).sin().powi(2)).collect();
                let start = Estimate { weights, ..start };
                let next = start.with_linear(Arx::new(5e-4, vec![0.5], vec![1.6]).unwrap()).unwrap();
                let point = Iterate::at(start, &runs, &[], FreeParameters::All);
                let alone = point.cost_of(&next, &runs, 0.1).unwrap();
                let all = Iterate::at(next, &runs, &[], FreeParameters::All);
                let residual = all.normal.residual(&all.unknowns());
                let penalty = all.prior.penalty(&point.normal, 0.1, all.prior.current());
                let off = (alone / (residual + penalty) - 1.0).abs();
                assert!(off < 1e-9 && penalty > 0.01 * residual, "{initial:?} {alone:e} {residual:e} {penalty:e}");
            }
        }
    }
}
