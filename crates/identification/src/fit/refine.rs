//! Refinement of all parts: Gauss-Newton on the free-run error, with the damping of Levenberg and Marquardt if a step
//! does not lower it.
//!
//! First only the weights, then also the gains of creep, then all parameters.

use super::dynamics::{creep_pole, is_damped, slowest_observable, with_slow_lags_limited};
use super::estimate::Estimate;
use super::fitted::Fitted;
use super::held_out::{ROUNDING_ERROR, Smoothness};
use super::iterate::{INITIAL_DAMPING, Iterate};
use super::runs::TrainingRecord;
use super::solve::FreeParameters;
use crate::side_by_side::side_by_side;
use libm::pow;
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::series::mean;
use tracing::trace_span;

/// Maximum number of steps, and of tries per step.
const MAX_STEPS: usize = 60;
const MAX_TRIES: usize = 8;

/// The step from which record weights are fixed.
const RECORD_WEIGHT_STEPS: usize = 3;

/// Maximum number of changes of the smoothness, or of the scales of the penalties, after the first.
const MAX_CHANGES: usize = 3;

/// Relative decrease of the cost below which the search ends.
const MIN_COST_DECREASE: f64 = 3e-4;

/// The same for a fit to the minimum.
const MIN_SLOW_DECREASE: f64 = 1e-5;

/// The same by the linearised equations: below the first a step is not tried, and the last point promises less than the
/// second.
const MIN_PREDICTED_DECREASE: f64 = 1e-4;
const MAX_PREDICTED_DECREASE: f64 = 5e-4;

/// Frequency of a lag at its limit, over this limit: more than rounding of the roots.
const SLOWEST_RATIO: f64 = 1.0 + 1e-6;

/// Number of steps, each as good as the last one, within which a cost is within reach.
const EXTRAPOLATED_STEPS: f64 = 10.0;

/// Smallest damping, and its factor after a step that lowered the cost.
const MIN_DAMPING: f64 = 1e-9;
const DAMPING_DECREASE: f64 = 0.1;

/// Maximum weight of small-signal samples over large-signal ones.
const MAX_SMALL_SIGNAL_WEIGHT: f64 = 30.0;

/// Called before each step; an error ends the work.
pub(crate) type StepCallback<'a> = &'a mut dyn FnMut(usize) -> Result<(), Error>;

/// Fits the `free` parameters from `start`; its weights need not be known.
///
/// # Errors
/// The errors of `watch`, which is called before each step.
pub(crate) fn refine(
    start: Estimate,
    runs: &mut [TrainingRecord],
    free: FreeParameters,
    watch: StepCallback,
) -> Result<Fitted, Error> {
    runs.iter_mut().for_each(|run| run.heavier = 1.0);
    refine_from(start, Smoothness::Any, runs, free, watch)
}

/// Fits the `free` parameters from `start`. Without a known smoothness the start is its linear block and shape; with
/// one it is all its parameters, and for a fixed one the minimum exceeds the value at the start at most by what the
/// scales of the penalties change.
pub(crate) fn refine_from(
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
    descend(point, smoothness, &Goal::ANY, runs, watch)
}

/// The same with all parameters, as long as a cost of at most `most` seems within reach.
pub(crate) fn refine_within_reach(
    start: Estimate,
    smoothness: Smoothness,
    most: f64,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let point = Iterate::known(start, runs, FreeParameters::All);
    descend(point, smoothness, &Goal { most, ..Goal::ANY }, runs, watch)
}

/// The same from the end of a fit, with a smoothness near its own.
pub(crate) fn refine_further(
    from: &Fitted,
    most: f64,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let point = Iterate::at_end_of(from, runs);
    descend(point, Smoothness::Near(from.held_out.lambda), &Goal { most, ..Goal::ANY }, runs, watch)
}

/// Fits all parameters of a fit to the minimum, however slowly it is reached.
pub(crate) fn refine_to_minimum(
    from: &Fitted,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let point = Iterate::at_end_of(from, runs);
    let goal = Goal { left: MAX_PREDICTED_DECREASE, ..Goal::ANY };
    descend(point, Smoothness::Fixed(from.held_out.lambda), &goal, runs, watch)
}

/// Fits the `free` parameters from the shape and the linear block of `start`, with a fixed smoothness.
pub(crate) fn refine_from_unknown(
    start: Estimate,
    lambda: f64,
    runs: &mut [TrainingRecord],
    free: FreeParameters,
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let point = Iterate::at(start, runs, &[], FreeParameters::Weights);
    let known = point.solved(lambda);
    descend(Iterate::at(known, runs, &[], free), Smoothness::Fixed(lambda), &Goal::ANY, runs, watch)
}

/// What a fit must be able to reach.
struct Goal<'a> {
    /// True for a linear block that is possible.
    possible: &'a (dyn Fn(&Arx) -> bool + Sync),
    /// The highest cost at which the fit is of use.
    most: f64,
    /// The relative decrease of the cost that another step may promise at the end.
    left: f64,
}

impl Goal<'_> {
    const ANY: Goal<'static> = Goal { possible: &|_| true, most: f64::INFINITY, left: 1.0 };
}

/// Lowers the cost from `point` on, to its minimum or as long as the goal is within reach.
fn descend(
    mut point: Iterate,
    smoothness: Smoothness,
    goal: &Goal,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let _stage = trace_span!(target: "stage", "refinement").entered();
    let free = point.free;
    let (is_start, is_fixed) = (smoothness == Smoothness::Any, matches!(smoothness, Smoothness::Fixed(_)));
    let (mut lambda, mut damping) = (smoothness.lambda(), INITIAL_DAMPING);
    let mut changes = MAX_CHANGES;
    for step in 0..MAX_STEPS {
        watch(step)?;
        let now = match (step, free) {
            _ if !is_start => free,
            (0, _) => FreeParameters::Weights,
            (1, FreeParameters::All) => FreeParameters::Creep,
            (_, free) => free,
        };
        if step == 0 && is_start {
            lambda = point.held_out(now, smoothness).lambda;
        }
        let cost = if is_start && step == 0 { f64::INFINITY } else { point.cost(lambda) };
        let next = lower(&point, runs, cost, lambda, &mut damping, now);
        let is_lower = next.is_some();
        let fall = next.as_ref().map_or(0.0, |next| 1.0 - next.cost(lambda) / cost);
        point = next.unwrap_or(point);
        let most = goal.most.max(ROUNDING_ERROR * point.normal.samples);
        let is_within_reach = point.cost(lambda) * pow(1.0 - fall, EXTRAPOLATED_STEPS) <= most;
        if !(goal.possible)(&point.estimate.linear) || !is_within_reach {
            break;
        }
        if is_start && step + 1 < RECORD_WEIGHT_STEPS {
            let factor = weigh(runs, &point.residuals(runs));
            point = point.reweighted(runs, factor);
        }
        let is_left =
            |point: &Iterate| goal.left < 1.0 && point.predicted(lambda) < (1.0 - goal.left) * point.cost(lambda);
        let goes_on = is_lower && (fall >= MIN_COST_DECREASE || fall >= MIN_SLOW_DECREASE && is_left(&point));
        let ends = !goes_on || point.cost(lambda) < ROUNDING_ERROR * point.normal.samples;
        if !ends {
            continue;
        }
        (point, damping) = (point.rescaled(), INITIAL_DAMPING);
        // If more parameters are free in the next step, the search goes on.
        if now == free {
            let best =
                if changes > 0 && !is_fixed { point.held_out(free, Smoothness::Near(lambda)).lambda } else { lambda };
            if best == lambda && !(changes > 0 && is_left(&point)) {
                break;
            }
            (lambda, changes) = (best, changes - 1);
        }
    }
    let point = point.rescaled();
    let held_out = point.held_out(free, Smoothness::Fixed(lambda));
    Ok(point.fitted(held_out, runs))
}

/// Fits all parameters from each start that promises less than `ratio` times the minimum of `from`, or next to nothing,
/// by the linearised equations, while its linear block is `possible`; returns their names too.
pub(crate) fn refine_promising(
    starts: Vec<(String, Estimate)>,
    from: &Fitted,
    ratio: f64,
    possible: &(dyn Fn(&Arx) -> bool + Sync),
    runs: &[TrainingRecord],
    watch: StepCallback,
) -> Result<Vec<(String, Fitted)>, Error> {
    let smoothness = Smoothness::Fixed(from.held_out.lambda);
    let refined = |(name, start): (String, Estimate), watch: StepCallback| {
        let runs = &mut runs.to_vec();
        let point = Iterate::known(start, runs, FreeParameters::All);
        if !point.promises(ratio, from) {
            return Ok(None);
        }
        let fit = descend(point, smoothness, &Goal { possible, ..Goal::ANY }, runs, watch)?;
        Ok(Some((name, fit)).filter(|(_, fit)| possible(&fit.estimate.linear)))
    };
    let found = side_by_side(starts, refined, |_, _| watch(0))?;
    found.into_iter().filter_map(Result::transpose).collect()
}

/// Fits weights and creep from the parameters of `from`, if that promises a lower minimum with the present initial
/// conditions of the runs.
pub(crate) fn refine_if_better(
    from: &Fitted,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Option<Fitted>, Error> {
    let point = Iterate::known(from.estimate.clone(), runs, FreeParameters::Creep);
    let smoothness = Smoothness::Near(from.held_out.lambda);
    point.promises(1.0, from).then(|| descend(point, smoothness, &Goal::ANY, runs, watch)).transpose()
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
    let (mut positive, mut harder) = (point.prior.positive(), 2.0);
    for _ in 0..MAX_TRIES {
        let x = point.prior.solve(&point.normal, lambda, *damping, free, &mut positive)?;
        if cost.is_finite() && 1.0 - point.cost_at(&x, lambda) / cost < MIN_PREDICTED_DECREASE {
            return None;
        }
        let possible = |linear: &Arx| creep_pole(linear, slowest).is_none() && is_damped(linear);
        // Where a lag is at its limit, the other parameters go on.
        let same_sign = |linear: &Arx| linear.dc_gain() * point.estimate.linear.dc_gain() > 0.0;
        let limited = |linear: Arx| match possible(&linear) || !possible(&point.estimate.linear) {
            true => Some(linear),
            false => {
                let limited = with_slow_lags_limited(linear, SLOWEST_RATIO * slowest).ok();
                limited.filter(|limited| possible(limited) && same_sign(limited))
            }
        };
        if let Some(estimate) = point.estimate.moved_within(x.as_slice(), &limited) {
            let own = point.own(&x);
            // Any step lowers an infinite cost.
            let alone = cost.is_finite().then(|| point.cost_of(&estimate, runs, lambda)).flatten();
            let next = alone.is_none_or(|next| next < cost).then(|| point.after_step(estimate, runs, &own, free));
            if let Some(next) = next.filter(|next| next.cost(lambda) < cost) {
                *damping = (*damping * DAMPING_DECREASE).max(MIN_DAMPING);
                return Some(next);
            }
        }
        // Nielsen's rule: the damping grows faster with each failure.
        *damping *= harder;
        harder *= 2.0;
    }
    None
}

/// Weights the two kinds of records by their residuals; returns the factor by which the
/// weight of the small-signal records changed.
fn weigh(runs: &mut [TrainingRecord], residuals: &[f64]) -> f64 {
    let of = |large_signal: bool| {
        let is_of =
            |(run, residual): &(&TrainingRecord, &f64)| run.large_signal == large_signal && residual.is_finite();
        let kind = runs.iter().zip(residuals).filter(is_of);
        mean(&kind.map(|(_, residual)| *residual).collect::<Vec<_>>())
    };
    let heavier = (of(true) / of(false)).sqrt().clamp(1.0, MAX_SMALL_SIGNAL_WEIGHT);
    let small_signal = runs.iter_mut().filter(|run| !run.large_signal && heavier.is_finite());
    // All of them have the same weight.
    small_signal.fold(1.0, |_, run| heavier / std::mem::replace(&mut run.heavier, heavier))
}

#[cfg(test)]
mod tests {
    use super::super::{optimality::optimality, runs::training_records, testing::estimate};
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_records::record::Record;
    use piezoid_testing::assert_close;

    #[test]
    fn a_start_without_damping_is_fitted_too() {
        let radius = 0.9999f64;
        let block = Arx::new(5e-4, vec![2.0 * radius * 0.9, -radius * radius], vec![0.1]).unwrap();
        assert!(!is_damped(&block));
        let u: Vec<f64> = (0..900).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let records = [Record::new(5e-4, u.clone(), block.simulate(&u)).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let start = estimate("prandtl-ishlinskii", 6).with_linear(block);
        let fit = refine(start, &mut runs, FreeParameters::Weights, &mut |_| Ok(())).unwrap();
        assert!(fit.cost() < 1e-4, "{:e}", fit.cost());
    }

    #[test]
    fn a_lag_slower_than_the_records_stays_at_its_limit_and_the_others_go_on() {
        let lag = |p: f64| Arx::new(5e-4, vec![0.5 + p, -0.5 * p], vec![0.3, 0.3 * (p - 1.0)]).unwrap();
        let wave = |t: f64| 28.0 * (0.01 * t).sin() * (0.13 * t).sin() + 0.02 * t;
        let u: Vec<f64> = (0..900).map(|t| wave(f64::from(t))).collect();
        let records = [Record::new(5e-4, u.clone(), lag(0.99995).simulate(&u)).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let start = estimate("prandtl-ishlinskii", 6).with_linear(lag(0.99));
        let fit = refine_from(start, Smoothness::Any, &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
        let (slowest, poles) = (slowest_observable(records.iter()), fit.estimate.linear.poles());
        assert!((poles[0].hz / slowest - 1.0).abs() < 1e-5, "{slowest} {poles:?}");
        // Without the limit, the fit ends at 5.4e-5.
        assert!(fit.cost() < 3e-5, "{:e}", fit.cost());
    }

    #[test]
    fn a_minimum_that_is_approached_slowly_is_reached() {
        let lag = Arx::new(5e-4, vec![0.9], vec![0.1]).unwrap();
        let wave = |t: f64| 28.0 * (0.01 * t).sin() * (0.0013 * t).sin();
        let u: Vec<f64> = (0..1800).map(|t| wave(f64::from(t))).collect();
        let mut play = 0.0f64;
        let bent = |u: &f64| {
            play += (u - play).clamp(-0.2, 0.2);
            u + 0.4 * play + 0.004 * u * u
        };
        let driven: Vec<f64> = u.iter().map(bent).collect();
        let records = [Record::new(5e-4, u, lag.simulate(&driven)).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let start = estimate("rate-dependent-prandtl-ishlinskii", 6).with_linear(lag);
        let fit = refine_from(start, Smoothness::Any, &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
        assert!(optimality(&fit, &runs).left_percent.is_some());
        let end = refine_to_minimum(&fit, &mut runs, &mut |_| Ok(())).unwrap();
        assert!(end.cost() < 0.9 * fit.cost(), "{:e} {:e}", end.cost(), fit.cost());
        assert_eq!(optimality(&end, &runs).left_percent, None);
    }

    #[test]
    fn small_signal_records_weigh_by_the_ratio_of_the_residuals_within_limits() {
        let u: Vec<f64> = (0..900).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let records = [0.1, 0.9, 1.0].map(|k| {
            let u: Vec<f64> = u.iter().map(|u| k * u).collect();
            Record::new(5e-4, u.clone(), u).unwrap()
        });
        let mut runs = training_records(&records[..1], &records[1..], &mut Vec::new()).unwrap();
        // The mean of the large-signal records decides; a record without a residual does not count.
        for (residuals, factor, heavier) in [
            ([1e-6, 4e-6, 14e-6], 3.0, 3.0),
            ([1e-6, 4e-6, 28e-6], 4.0 / 3.0, 4.0),
            ([1e-6, f64::NAN, 4e-6], 0.5, 2.0),
            ([1e-12, 1e-6, 1e-6], 15.0, 30.0),
            ([f64::NAN, 1e-6, 1e-6], 1.0, 30.0),
            ([1.0, 1e-6, 1e-6], 1.0 / 30.0, 1.0),
        ] {
            let found = weigh(&mut runs, &residuals);
            assert_close(&[found, runs[0].heavier], &[factor, heavier], 1e-12, 0.0);
            assert_eq!([runs[1].heavier, runs[2].heavier], [1.0; 2]);
        }
    }
}
