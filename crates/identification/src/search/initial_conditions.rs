//! The initial conditions of the records, selected by the free run of a fit.
//!
//! Why: docs/decisions/initial-conditions.md, "The initial conditions are retried with the operator".

use super::fit::{
    Estimate, Fitted, FreeParameters, StepCallback, TrainingRecord, free_run_squares, refine, refine_further,
    refine_if_better,
};
use super::{Candidate, POLICY, Search};
use crate::side_by_side::side_by_side;
use piezoid_models::hammerstein::{Domain, InitialCondition, Model};
use piezoid_numerics::error::Error;
use rayon::prelude::*;
use tracing::trace_span;

/// A fit with the initial conditions of the large-signal records that it shows. Hysteresis at rest before the records,
/// and hysteresis after cycles over the whole range, explain the same records by different weights, so both are fitted.
pub(super) fn fit_with_initial_conditions(
    start: &(dyn Fn() -> Result<Estimate, Error> + Sync),
    runs: &mut [TrainingRecord],
    range: (f64, f64),
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let mut cycled = runs.to_vec();
    for run in cycled.iter_mut().filter(|run| run.large_signal) {
        run.start_from(InitialCondition::FromBelow, range);
    }
    let fit =
        |mut runs: Vec<TrainingRecord>, watch: StepCallback| refine(start()?, &mut runs, FreeParameters::Creep, watch);
    let fits = side_by_side(vec![runs.to_vec(), cycled], fit, |_, _| watch(0))?;
    let fits = fits.into_iter().collect::<Result<Vec<_>, _>>()?;
    let best = fits.into_iter().min_by(|p, q| p.cost().total_cmp(&q.cost()));
    let mut fitted = best.ok_or_else(|| Error::Content("no initial condition was tried".into()))?;
    fitted.apply_to(runs, range);
    while select_initial_conditions(&fitted, runs, range)? {
        fitted = refine(start()?, runs, FreeParameters::Creep, watch)?;
    }
    Ok(fitted)
}

/// The fit with the other initial conditions of [`fit_with_initial_conditions`], if it is clearly better. The runs
/// start as in `fitted`.
pub(super) fn fit_with_other_initial_conditions(
    fitted: &Fitted,
    runs: &mut [TrainingRecord],
    range: (f64, f64),
    watch: StepCallback,
) -> Result<Option<Fitted>, Error> {
    let likely = |run: &TrainingRecord| InitialCondition::of(run.record.u())[0];
    // Rest and motion show in the dynamics too.
    let settled = |run: &&mut TrainingRecord| {
        run.large_signal && !matches!(run.initial, InitialCondition::Rest | InitialCondition::Motion)
    };
    let is_likely = runs.iter_mut().filter(settled).all(|run| run.initial == likely(run));
    for run in runs.iter_mut().filter(settled) {
        run.start_from(if is_likely { InitialCondition::FromBelow } else { likely(run) }, range);
    }
    let other = refine_if_better(fitted, runs, watch);
    fitted.apply_to(runs, range);
    let most = POLICY.initial_condition_ratio * fitted.held_out.rms_pp();
    Ok(other?.filter(|other| other.held_out.rms_pp() < most))
}

/// The better of the fits with both initial conditions of [`fit_with_initial_conditions`], then with those that it
/// shows.
pub(super) fn retry_initial_conditions(candidate: &Candidate, search: &mut Search) -> Result<Option<Candidate>, Error> {
    let _stage = trace_span!(target: "stage", "initial conditions").entered();
    let Search { runs, design, reporter, .. } = search;
    let watch = &mut reporter.last_stage(candidate.operator.name);
    let other = fit_with_other_initial_conditions(&candidate.fitted, runs, design.range, watch)?;
    let best = other.as_ref().unwrap_or(&candidate.fitted);
    best.apply_to(runs, design.range);
    if !select_initial_conditions(best, runs, design.range)? && other.is_none() {
        return Ok(None);
    }
    Ok(Some(candidate.with_fit(refine_further(best, f64::INFINITY, runs, watch)?)))
}

/// Selects the initial conditions of the records; true if one changed to another than before.
pub(super) fn select_initial_conditions(
    fitted: &Fitted,
    runs: &mut [TrainingRecord],
    range: (f64, f64),
) -> Result<bool, Error> {
    let domain = Domain { u: range.into(), hz: None, slew: 0.0, mean: range.into() };
    let model = fitted.estimate.model(0.0)?.with_identified(domain);
    let mut changed = false;
    for run in runs.iter_mut().filter(|run| !run.is_later_part) {
        changed |= select_initial_condition(run, &model, range);
    }
    Ok(changed)
}

/// Selects the initial condition of a record with the smallest free-run error of `model`, with a line through the
/// errors. True if it is another than those selected before.
fn select_initial_condition(run: &mut TrainingRecord, model: &Model, range: (f64, f64)) -> bool {
    let mut tried = InitialCondition::of(run.record.u()).map(|initial| (f64::INFINITY, initial));
    tried.par_iter_mut().for_each(|(squares, initial)| *squares = free_run_squares(run, model, *initial));
    let [likely, others @ ..] = tried;
    let better =
        |best: (f64, _), one: (f64, _)| if one.0 < POLICY.initial_condition_ratio * best.0 { one } else { best };
    let selected = others.into_iter().fold(likely, better).1;
    let changed = selected != run.initial && !run.tried.contains(&selected);
    if changed {
        run.tried.push(selected);
        run.start_from(selected, range);
    }
    changed
}
