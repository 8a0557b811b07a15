//! Every operator with the other blocks of one candidate: a comparison of operators needs one structure search.
//!
//! An operator starts from its fit in the search, or from the best of its shapes if it has none, takes driver, creep
//! and linear block of the candidate, and is fitted in all parameters to its minimum. Its own blocks in the search stay
//! if they predict held-out parts better.

use super::fit::{Estimate, Fitted, FreeParameters, Smoothness, StepCallback, refine_from, refine_to_minimum};
use super::operators::{refined, shapes, trial_of, with_own_shape};
use super::structure::with_other_blocks;
use super::trials::Trial;
use super::{Candidate, OperatorTrial, Search};
use crate::side_by_side::side_by_side;
use crate::{Clock, Effort};
use piezoid_models::hysteresis::{BasisDesign, Operator};
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::Stage;

/// An operator with its candidate, or with the reason why there is none, and the time that its own fits took [s].
pub(crate) type Finished = (&'static Operator, Result<Candidate, Error>, f64);

impl Search<'_> {
    /// Each of these operators with the other blocks of `best`. If the search is cancelled, those that are finished.
    pub(crate) fn each(&mut self, best: &Candidate, rows: &[&'static Operator], clock: Clock) -> Vec<Finished> {
        self.apply_to(best);
        let design = self.design_for(&best.fitted.estimate);
        let Search { settings, runs, reporter, trials, cancelled, .. } = self;
        reporter.total = rows.len();
        let (runs, trials) = (&runs[..], &trials[..]);
        let Estimate { driver, seeks_lag, lags, linear, .. } = &best.fitted.estimate;
        let with_blocks = |row: &'static Operator, before: &Fitted, watch: StepCallback| -> Result<Fitted, Error> {
            let basis = |ts: f64| (row.basis)(&BasisDesign { ts, ..design.clone() });
            let blocks = (*driver, *seeks_lag);
            let start = with_other_blocks(&before.estimate, blocks, lags, linear.clone(), &basis)?;
            let runs = &mut runs.to_vec();
            before.apply_to(runs, design.range);
            refine_from(start, Smoothness::Near(before.held_out.lambda), runs, FreeParameters::All, watch)
        };
        let new = |row: &'static Operator, watch: StepCallback| -> Result<Fitted, Error> {
            let (blocks, runs) = (&best.fitted.estimate, &mut runs.to_vec());
            let own = with_own_shape(row, &design, blocks, runs, watch)?;
            let shapes = match settings.effort {
                Effort::Quick => own,
                _ => shapes(own, &design, blocks, settings, runs, watch)?,
            };
            Ok(refined(row, shapes, (f64::INFINITY, f64::INFINITY), runs, design.range, watch)?.1)
        };
        let fit = |row: &'static Operator, watch: StepCallback| -> (Result<Candidate, Error>, f64) {
            let start = clock();
            let mut fitted = || -> Result<Candidate, Error> {
                if row.name == best.operator.name {
                    return Ok(best.clone());
                }
                let trial = trials.iter().find(|trial| trial.result.operator == row.name);
                let fitted = match trial.and_then(|trial| trial.fitted.as_ref()) {
                    Some(own) => match with_blocks(row, own, watch) {
                        Ok(other) if other.held_out.rms_pp() < own.held_out.rms_pp() => other,
                        Err(cancelled @ Error::Cancelled { .. }) => return Err(cancelled),
                        _ => own.clone(),
                    },
                    None => new(row, watch)?,
                };
                let runs = &mut runs.to_vec();
                fitted.apply_to(runs, design.range);
                let fitted = refine_to_minimum(&fitted, runs, watch)?;
                Ok(Candidate { operator: row, ..best.with_fit(fitted) })
            };
            (fitted(), clock() - start)
        };
        let mut finished = Vec::new();
        let report = |k: usize, result: Option<&(Result<Candidate, Error>, f64)>| {
            let Some((candidate, seconds)) = result else {
                return reporter.report(Stage::new(rows[k].name, k, rows.len()));
            };
            finished.push((rows[k], candidate.clone(), *seconds));
            let Ok(Candidate { fitted, .. }) = candidate else { return Ok(()) };
            let result = trial_of(rows[k], fitted, &mut runs.to_vec(), design.range);
            reporter.tried_apart(&Trial::of(result, fitted.clone()), k, runs)
        };
        *cancelled = side_by_side(rows.to_vec(), fit, report).err();
        finished
    }

    /// Makes a candidate the one that the search ends with: its trial is the only one.
    pub(crate) fn end_with_alone(&mut self, candidate: &Candidate) {
        self.apply_to(candidate);
        let range = self.design.range;
        let result: OperatorTrial = trial_of(candidate.operator, &candidate.fitted, &mut self.runs, range);
        self.trials = vec![Trial::selected(result, candidate.fitted.clone())];
    }
}
