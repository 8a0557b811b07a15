//! Hysteresis in feedback: all parameters of a feedback model by its free-run error, with exact derivatives.
//!
//! ```text
//! min sum over records of |y - model|^2 / ((pp^2 + (0.15 largest pp)^2) sqrt(samples)),   pp: peak-to-peak of y
//! ```
//! Unknowns are the parameters of the model, and the state of the modes at the start of each record, unless it is known
//! from the inputs before: the record is one period of a longer one, or begins at rest. An oscillator is found from its
//! records alone: first without hysteresis, then from several starts with it, of which the best goes on to the minimum.
//!
//! Reference: L. Ljung, System Identification (1999), section 10.2 (output error, Gauss-Newton).

mod free_run;
mod oscillator;
mod structure;
#[cfg(test)]
mod tests;
mod vibrating;
mod weights;

pub use structure::{Structure, identify_structure};

use crate::fit::FittedParameter;
use free_run::{Counted, FreeRun, Initial, Run, likelier, peak_to_peak, periodic, runs, square, states};
use piezoid_models::feedback::{FeedbackModel, FeedbackParameter, FeedbackRun};
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::levenberg_marquardt::{SearchSettings, minimise};
use piezoid_numerics::optimize::{Minimum, Reason};
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use std::borrow::Cow;

/// Steps of the search from each start, and from the best one.
const FIRST_STEPS: usize = 8;
const MOST_STEPS: usize = 100;

/// Relative decrease of the sum of squares, predicted for another step, below which the search ends.
const TOLERANCE: f64 = 1e-9;

/// Periods of the slowest mode in a window, and the largest number of windows.
const WINDOW: f64 = 10.0;
const MAX_WINDOWS: usize = 64;

/// Its name in progress and errors.
const STAGE: &str = "hysteresis in feedback";

/// A fitted feedback model.
#[derive(Debug, Clone)]
pub struct FeedbackFit {
    /// The model.
    pub model: FeedbackModel,
    /// Its parameters without weights that are smooth, with standard errors for white residuals; infinite for one
    /// without effect.
    pub parameters: Vec<FittedParameter>,
    /// The rms error of the free run along each record [output unit].
    pub rms: Vec<f64>,
    /// The same of all records, each over its peak-to-peak [%].
    pub percent: f64,
    /// For each record, true if it is taken for one period of a longer one.
    pub periodic: Vec<bool>,
    /// How the search ended.
    pub minimum: Minimum,
}

impl FeedbackFit {
    /// The fit of all parameters of `start`.
    ///
    /// # Errors
    /// Returns an error if there is no record, the operator has no derivatives, the records have another sampling
    /// period, or the free run from the start is not finite; [`Error::Cancelled`].
    pub fn from(start: &FeedbackModel, records: &[Record], progress: &mut Progress) -> Result<Self, Error> {
        FeedbackFit::of_counted(start, records, Counted::All, progress)
    }

    /// The fit to the samples that count.
    fn of_counted(
        start: &FeedbackModel,
        records: &[Record],
        counted: Counted,
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        let [first, ..] = records else {
            let because = "there is no record".into();
            return Err(Error::Unidentifiable { what: STAGE.into(), because });
        };
        start.sensitivities(FeedbackRun { u: &first.u()[..first.len().min(1)], ..FeedbackRun::default() }, 0..1)?;
        for record in records {
            Record::same_sampling("the record", record.ts(), "the model", start.ts())?;
        }
        let start = &windowed(start, records, counted, progress)?;
        let mut first = |of: fn(&FeedbackModel, &Record) -> Initial| {
            search(&FreeRun::of(start, &runs(records, counted, |record| of(start, record))), FIRST_STEPS, progress)
        };
        let Found { model, runs, .. } = best([first(states), first(periodic)].into_iter())?;
        let runs: Vec<Run> = runs.into_iter().map(|run| likelier(&model, run)).collect();
        let mut found = search(&FreeRun::of(&model, &runs), MOST_STEPS, progress)?;
        // Which initial condition a record has shows when the parameters are known.
        let runs: Vec<Run> = found.runs.iter().map(|run| likelier(&found.model, run.clone())).collect();
        if runs.iter().zip(&found.runs).any(|(run, before)| run.initial != before.initial) {
            found = search(&FreeRun::of(&found.model, &runs), MOST_STEPS, progress)?;
        }
        let errors = FreeRun::of(&found.model, &found.runs).errors(&found.minimum);
        Ok(FeedbackFit::of(found, errors))
    }

    /// `errors` are the standard errors of the first parameters.
    fn of(found: Found, errors: Vec<f64>) -> Self {
        let Found { model, runs, minimum } = found;
        let samples: usize = runs.iter().map(|run| run.record.len()).sum();
        let squares: Vec<f64> = runs.iter().map(|run| square(&model, run)).collect();
        let relative =
            |(run, square): (&Run, &f64)| run.record.len() as f64 * square / peak_to_peak(&run.record).powi(2);
        let relative: f64 = runs.iter().zip(&squares).map(relative).sum();
        let of = |(p, error): (FeedbackParameter, f64)| FittedParameter { name: p.name, value: p.value, error };
        FeedbackFit {
            parameters: model.parameters().into_iter().zip(errors).map(of).collect(),
            rms: squares.iter().map(|square| square.sqrt()).collect(),
            percent: 100.0 * (relative / samples as f64).sqrt(),
            periodic: runs.iter().map(|run| matches!(run.initial, Initial::Periodic(_))).collect(),
            model,
            minimum,
        }
    }
}

/// The end of one search.
struct Found<'r> {
    model: FeedbackModel,
    runs: Vec<Run<'r>>,
    minimum: Minimum,
}

/// Searches from the start of the problem for at most so many `steps`.
fn search<'r>(problem: &FreeRun<'_, 'r>, steps: usize, progress: &mut Progress) -> Result<Found<'r>, Error> {
    let settings = SearchSettings { iterations: steps, tolerance: TOLERANCE, ..SearchSettings::default() };
    let named = &mut |stage: Stage| progress(Stage { what: STAGE, ..stage });
    let minimum = minimise(problem, &problem.unknowns(), &settings, named)?;
    if minimum.reason == Reason::Cancelled {
        return Err(Error::Cancelled { what: STAGE.into(), done: minimum.history.len() - 1, total: steps });
    }
    let (model, runs) = problem.at(&minimum.x)?;
    Ok(Found { model, runs, minimum })
}

/// The search with the lowest cost; the first error if there is none, or if one was cancelled.
fn best<'r>(searches: impl Iterator<Item = Result<Found<'r>, Error>>) -> Result<Found<'r>, Error> {
    let mut best: Result<Found, Error> =
        Err(Error::Unidentifiable { what: STAGE.into(), because: "there is no start".into() });
    for (k, next) in searches.enumerate() {
        best = match (best, next) {
            (_, Err(cancelled @ Error::Cancelled { .. })) => return Err(cancelled),
            (Ok(best), Ok(next)) if next.minimum.cost < best.minimum.cost => Ok(next),
            (Err(_), next) if k == 0 || next.is_ok() => next,
            (best, _) => best,
        };
    }
    best
}

/// The fit of `start` in windows with states of their own: a frequency that is far off then has no other minimum. What
/// the hysteresis remembers at the start of a window is missing.
fn windowed(
    start: &FeedbackModel,
    records: &[Record],
    counted: Counted,
    progress: &mut Progress,
) -> Result<FeedbackModel, Error> {
    let slowest = start.dynamics().modes.iter().map(|mode| mode.hz).fold(f64::INFINITY, f64::min);
    let all: usize = records.iter().map(Record::len).sum();
    let samples = ((WINDOW / slowest / start.ts()).ceil() as usize).max(all.div_ceil(MAX_WINDOWS));
    let mut windows = Vec::new();
    for whole in runs(records, counted, |record| states(start, record)) {
        let record = &whole.record;
        let counts: Vec<bool> = counted.of(record.len()).collect();
        for range in (0..record.len() / samples).map(|k| k * samples..(k + 1) * samples) {
            let window = record.slice(range.clone())?;
            let initial = states(start, &window);
            if counts[range].iter().all(|counts| *counts) {
                let record = Cow::Owned(window);
                windows.push(Run { record, initial, weight: whole.weight, counted: Counted::All });
            }
        }
    }
    if windows.is_empty() {
        return Ok(start.clone());
    }
    Ok(search(&FreeRun::of(start, &windows), FIRST_STEPS, progress)?.model)
}
