//! The initial conditions of the records, which a coarse fit shows.
//!
//! Why: docs/decisions/initial-conditions.md, "The past of a record is chosen again with the operator".

use super::JointOptions;
use super::estimate::Estimate;
use super::held_out::Smoothness;
use super::refine::{Fitted, StepCallback, refine, refine_from, refine_if_better};
use super::runs::{CLEARLY, TrainingRecord};
use super::solve::FreeParameters;
use crate::creep::Lag;
use crate::error::Error;
use crate::hammerstein::{Domain, InitialCondition};
use crate::hysteresis::{BasisDesign, Operator};
use crate::linear::Arx;

/// Rows of the grid that represents the hysteresis.
pub(super) const COARSE: usize = 12;

/// An estimate with a coarse hysteresis and this linear block.
pub(super) fn coarse(
    linear: Arx,
    settings: &JointOptions,
    design: &BasisDesign,
    lags: &[Lag],
) -> Result<Estimate, Error> {
    let design = BasisDesign { elements: Some(COARSE), ..design.clone() };
    let basis = (Operator::find("preisach")?.basis)(&design)?;
    Ok(Estimate::new(settings.driver, basis, lags.to_vec(), linear))
}

/// A fit with the initial conditions of the large-signal records that it shows. Hysteresis without a past, and
/// hysteresis after cycles over the whole range, explain the same records by different weights, so both are fitted.
pub(super) fn begin_all(
    start: &dyn Fn() -> Result<Estimate, Error>,
    runs: &mut [TrainingRecord],
    range: (f64, f64),
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let mut fitted = refine(start()?, runs, FreeParameters::Creep, watch)?;
    for run in runs.iter_mut().filter(|run| run.large_signal) {
        run.begin_from(InitialCondition::FromBelow, range);
    }
    let cycled = refine(start()?, runs, FreeParameters::Creep, watch)?;
    if cycled.cost() < fitted.cost() {
        fitted = cycled;
    } else {
        fitted.begin_again(runs, range);
    }
    while begin(&fitted, runs, range)? {
        fitted = refine(start()?, runs, FreeParameters::Creep, watch)?;
    }
    Ok(fitted)
}

/// The fit with the other of the two pasts of [`begin_all`], if it is clearly better. The runs begin as in `fitted`.
pub(super) fn with_other_past(
    fitted: &Fitted,
    runs: &mut [TrainingRecord],
    range: (f64, f64),
    watch: StepCallback,
) -> Result<Option<Fitted>, Error> {
    let likely = |run: &TrainingRecord| InitialCondition::of(run.record.u())[0];
    // Rest and motion are seen in the dynamics too.
    let settled = |run: &&mut TrainingRecord| {
        run.large_signal && !matches!(run.initial, InitialCondition::Rest | InitialCondition::Motion)
    };
    let is_likely = runs.iter_mut().filter(settled).all(|run| run.initial == likely(run));
    for run in runs.iter_mut().filter(settled) {
        run.begin_from(if is_likely { InitialCondition::FromBelow } else { likely(run) }, range);
    }
    let other = refine_if_better(fitted, runs, watch);
    fitted.begin_again(runs, range);
    Ok(other?.filter(|other| other.held_out.rms_pp() < CLEARLY * fitted.held_out.rms_pp()))
}

/// The better of the fits with the two pasts of [`begin_all`], with the initial conditions that it shows: a coarse
/// hysteresis may not show which are right.
pub(super) fn reconsider(
    fitted: Fitted,
    runs: &mut [TrainingRecord],
    range: (f64, f64),
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let other = with_other_past(&fitted, runs, range, watch)?;
    let is_better = other.is_some();
    let best = other.unwrap_or(fitted);
    best.begin_again(runs, range);
    if !(begin(&best, runs, range)? || is_better) {
        return Ok(best);
    }
    refine_from(best.estimate, Smoothness::Near(best.held_out.lambda), runs, FreeParameters::All, watch)
}

/// Selects the initial conditions of the records; true if one changed to another than before.
pub(super) fn begin(fitted: &Fitted, runs: &mut [TrainingRecord], range: (f64, f64)) -> Result<bool, Error> {
    let domain = Domain { u: range.into(), hz: None, slew: 0.0, mean: range.into() };
    let model = fitted.estimate.model(0.0)?.with_identified(domain);
    let mut changed = false;
    for run in runs.iter_mut() {
        changed |= run.begin(&model, range);
    }
    Ok(changed)
}
