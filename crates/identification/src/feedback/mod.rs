//! Hysteresis in feedback: all parameters of a feedback model by its free-run error, with exact derivatives.
//!
//! ```text
//! min sum over records of |y - model|^2 / (peak-to-peak of y)^2
//! ```
//! Unknowns are the parameters of the model, and the state of the modes at the start of each record, unless the record
//! is one period of a longer one. An oscillator is found from its records alone: first without hysteresis, then from
//! several starts with it, of which the best goes on to the minimum.
//!
//! Reference: L. Ljung, System Identification (1999), section 10.2 (output error, Gauss-Newton).

mod free_run;
mod oscillator;
mod structure;
#[cfg(test)]
mod tests;

pub use structure::{Structure, identify_structure};

use crate::fit::FittedParameter;
use free_run::{FreeRun, Initial, Run, likelier, periodic, run, square, states};
use piezoid_models::feedback::{FeedbackModel, FeedbackParameter};
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
    /// Its parameters, with standard errors for white residuals; infinite for one without effect.
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
        let [first, ..] = records else {
            let because = "there is no record".into();
            return Err(Error::Unidentifiable { what: STAGE.into(), because });
        };
        start.sensitivities(&[], &first.u()[..first.len().min(1)])?;
        for record in records {
            Record::same_sampling("the record", record.ts(), "the model", start.ts())?;
        }
        let start = &windowed(start, records, progress)?;
        let mut first = |of: fn(&FeedbackModel, &Record) -> Initial| {
            let runs: Vec<Run> = records.iter().map(|record| run(record, of(start, record))).collect();
            search(start, &runs, FIRST_STEPS, progress)
        };
        let Found { model, initial, .. } = best([first(states), first(periodic)].into_iter())?;
        let likelier = |(record, initial): (_, Initial)| run(record, likelier(&model, initial, record));
        let runs: Vec<Run> = records.iter().zip(initial).map(likelier).collect();
        let Found { model, initial, minimum } = search(&model, &runs, MOST_STEPS, progress)?;
        let samples: usize = runs.iter().map(|run| run.record.len()).sum();
        let percent = 100.0 * (minimum.cost / samples as f64).sqrt();
        let rms = runs.iter().zip(&initial).map(|(run, initial)| square(&model, initial, &run.record).sqrt()).collect();
        let errors = FreeRun { start: &model, runs: &runs }.errors(&minimum);
        let of = |(p, error): (FeedbackParameter, f64)| FittedParameter { name: p.name, value: p.value, error };
        let parameters = model.parameters().into_iter().zip(errors).map(of).collect();
        let periodic = initial.iter().map(|initial| matches!(initial, Initial::Periodic(_))).collect();
        Ok(FeedbackFit { parameters, rms, percent, periodic, model, minimum })
    }
}

/// The end of one search.
struct Found {
    model: FeedbackModel,
    initial: Vec<Initial>,
    minimum: Minimum,
}

/// Searches from `start` for at most so many `steps`.
fn search(start: &FeedbackModel, runs: &[Run], steps: usize, progress: &mut Progress) -> Result<Found, Error> {
    let problem = FreeRun { start, runs };
    let mut x: Vec<f64> = start.parameters().iter().map(|p| p.value).collect();
    for run in runs {
        let Initial::States(modes) = &run.initial else { continue };
        x.extend(modes.as_flattened());
    }
    let settings = SearchSettings { iterations: steps, tolerance: TOLERANCE, ..SearchSettings::default() };
    let named = &mut |stage: Stage| progress(Stage { what: STAGE, ..stage });
    let minimum = minimise(&problem, &x, &settings, named)?;
    if minimum.reason == Reason::Cancelled {
        return Err(Error::Cancelled { what: STAGE.into(), done: minimum.history.len() - 1, total: steps });
    }
    let (model, initial) = problem.at(&minimum.x)?;
    Ok(Found { model, initial, minimum })
}

/// The search with the lowest cost; the first error if there is none, or if one was cancelled.
fn best(searches: impl Iterator<Item = Result<Found, Error>>) -> Result<Found, Error> {
    let better = |best: Result<Found, Error>, next: Result<Found, Error>| match (best, next) {
        (Err(cancelled @ Error::Cancelled { .. }), _) | (_, Err(cancelled @ Error::Cancelled { .. })) => Err(cancelled),
        (Ok(best), Ok(next)) if next.minimum.cost < best.minimum.cost => Ok(next),
        (Err(_), Ok(next)) => Ok(next),
        (best, _) => best,
    };
    let none = || Err(Error::Unidentifiable { what: STAGE.into(), because: "there is no start".into() });
    searches.reduce(better).unwrap_or_else(none)
}

/// The fit of `start` in windows with states of their own: a frequency that is far off then has no other minimum. What
/// the hysteresis remembers at the start of a window is missing.
fn windowed(start: &FeedbackModel, records: &[Record], progress: &mut Progress) -> Result<FeedbackModel, Error> {
    let slowest = start.dynamics().modes.iter().map(|mode| mode.hz).fold(f64::INFINITY, f64::min);
    let all: usize = records.iter().map(Record::len).sum();
    let samples = ((WINDOW / slowest / start.ts()).ceil() as usize).max(all.div_ceil(MAX_WINDOWS));
    let mut windows = Vec::new();
    for record in records {
        for (u, y) in record.u().chunks(samples).zip(record.y().chunks(samples)).filter(|(u, _)| u.len() == samples) {
            let window = record.with_samples(record.ts(), u.to_vec(), y.to_vec())?;
            let initial = states(start, &window);
            windows.push(Run { record: Cow::Owned(window), ..run(record, initial) });
        }
    }
    Ok(search(start, &windows, FIRST_STEPS, progress)?.model)
}
