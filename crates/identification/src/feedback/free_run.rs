//! The free run of a feedback model along a record, from an unknown initial condition, and its errors.

use super::weights::Weights;
use nalgebra::{DMatrix, DVector};
use piezoid_models::feedback::{FeedbackModel, FeedbackRun, Intersample, Observer};
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::Minimum;
use piezoid_numerics::optimize::levenberg_marquardt::{NormalEquations, SumOfSquares};
use piezoid_numerics::series::{ends, mean};
use piezoid_records::record::Record;
use rayon::prelude::*;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::Range;

/// Time constants of a mode that are simulated before a record in motion: what is left is 1e-5. And the largest number
/// of periods.
const REMEMBERED: f64 = 12.0;
const MAX_PERIODS: usize = 10;

/// Share of the largest peak-to-peak that is added to that of each record in its weight: noise counts less in a small
/// one.
const LEAST_SHARE: f64 = 0.15;

/// The initial condition of a record.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Initial {
    /// Unknown: p and step times p' of each mode at its start. The hysteresis was at rest.
    States(Vec<[f64; 2]>),
    /// In motion: the record came before it too, this number of times.
    Periodic(usize),
    /// At rest before these inputs. The record has an own constant: what crept before it is unknown.
    After(Vec<f64>),
}

/// Which samples of a record count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Counted {
    /// All.
    All,
    /// All but the third and the sixth of eight parts.
    Most,
}

impl Counted {
    /// For each of so many samples, true if it counts.
    pub(super) fn of(self, samples: usize) -> impl Iterator<Item = bool> {
        (0..samples).map(move |t| self == Counted::All || ![2, 5].contains(&(t * 8 / samples)))
    }
}

/// A record with what its free run needs.
#[derive(Debug, Clone)]
pub(super) struct Run<'a> {
    pub(super) record: Cow<'a, Record>,
    pub(super) initial: Initial,
    /// Weight of its squared errors.
    pub(super) weight: f64,
    pub(super) counted: Counted,
}

impl Run<'_> {
    /// Without the mean of a record that has an own constant, and 0 where a sample does not count.
    pub(super) fn mask(&self, values: &mut [f64]) {
        let counted: Vec<bool> = self.counted.of(values.len()).collect();
        if matches!(self.initial, Initial::After(_)) {
            let inside = values.iter().zip(&counted).filter(|(_, counts)| **counts).map(|(value, _)| *value);
            let mean = mean(&inside.collect::<Vec<_>>());
            values.iter_mut().for_each(|value| *value -= mean);
        }
        values.iter_mut().zip(counted).filter(|(_, counts)| !counts).for_each(|(value, _)| *value = 0.0);
    }

    /// The errors of a run of the model that count.
    pub(super) fn errors(&self, run: &[f64]) -> DVector<f64> {
        let errors = run.iter().zip(self.record.y()).map(|(m, y)| m - y);
        let mut errors = DVector::from_iterator(self.record.len(), errors);
        self.mask(errors.as_mut_slice());
        errors
    }
}

pub(super) fn peak_to_peak(record: &Record) -> f64 {
    let (low, high) = ends(record.y().iter().copied());
    if low < high { high - low } else { 1.0 }
}

/// The records from their initial conditions. The weight of a record grows with the root of its length.
pub(super) fn runs(records: &[Record], counted: Counted, initial: impl Fn(&Record) -> Initial) -> Vec<Run<'_>> {
    let largest = records.iter().map(peak_to_peak).fold(0.0, f64::max);
    let weight = |record: &Record| {
        let size = libm::hypot(peak_to_peak(record), LEAST_SHARE * largest);
        1.0 / (size * size * (record.len() as f64).sqrt())
    };
    records.iter().map(|r| Run { record: Cow::Borrowed(r), initial: initial(r), weight: weight(r), counted }).collect()
}

/// The first mode alone is at the first sample.
pub(super) fn states(model: &FeedbackModel, record: &Record) -> Initial {
    let mut modes = model.at_rest();
    if let (Some(first), Some(y)) = (modes.first_mut(), record.y().first()) {
        first[0] = y - model.dynamics().offset;
    }
    Initial::States(modes)
}

/// Whole periods, as far as the modes remember.
pub(super) fn periodic(model: &FeedbackModel, record: &Record) -> Initial {
    let slowest =
        model.dynamics().modes.iter().map(|mode| mode.damping.min(1.0) * TAU * mode.hz).fold(f64::INFINITY, f64::min);
    let remembered = REMEMBERED / slowest / (record.ts() * record.len() as f64);
    Initial::Periodic((remembered.ceil() as usize).clamp(1, MAX_PERIODS))
}

/// The run with the initial condition with which the model is nearest to the record: its own, at the first sample, or
/// periodic.
pub(super) fn likelier<'a>(model: &FeedbackModel, run: Run<'a>) -> Run<'a> {
    let others =
        [states(model, &run.record), periodic(model, &run.record)].map(|initial| Run { initial, ..run.clone() });
    let square = |run: &Run| square(model, run);
    others.into_iter().fold(run, |best, one| if square(&one) < square(&best) { one } else { best })
}

/// What a free run along a record needs.
pub(super) struct Whole<'a> {
    /// The input with what was before the record, and after it as far as the interpolation needs.
    u: Cow<'a, [f64]>,
    /// The samples that count.
    pub(super) inside: Range<usize>,
    /// The modes at the start; empty at rest.
    start: &'a [[f64; 2]],
    /// What an observer sees: the output measured at each of them, NaN where it does not count; and its gain.
    observer: Option<(Vec<f64>, f64)>,
}

impl<'a> Whole<'a> {
    /// With an observer if its gain is not 0.
    pub(super) fn of(run: &'a Run, gain: f64) -> Self {
        let u = run.record.u();
        let observer = |before: usize| {
            let y = run.record.y().iter().zip(run.counted.of(u.len()));
            let y = y.map(|(y, counts)| if counts { *y } else { f64::NAN });
            (gain != 0.0).then(|| (std::iter::repeat_n(f64::NAN, before).chain(y).collect(), gain))
        };
        let after = |before: &[f64], after: &[f64]| Whole {
            u: [before, u, after].concat().into(),
            inside: before.len()..before.len() + u.len(),
            start: &[],
            observer: observer(before.len()),
        };
        match &run.initial {
            Initial::States(modes) => Whole { u: u.into(), inside: 0..u.len(), start: modes, observer: observer(0) },
            Initial::Periodic(n) => after(&u.repeat(*n), &u[..u.len().min(Intersample::REACH)]),
            Initial::After(before) => after(before, &[]),
        }
    }

    pub(super) fn run(&self) -> FeedbackRun<'_> {
        let observer = self.observer.as_ref().map(|(measured, gain)| Observer { measured, gain: *gain });
        FeedbackRun { start: self.start, u: &self.u, observer }
    }
}

/// The sum of the squared errors that count, of the free run or the run with an observer of this gain.
fn sum_of_squares(model: &FeedbackModel, run: &Run, gain: f64) -> f64 {
    let whole = Whole::of(run, gain);
    let y = model.follow_run(whole.run());
    run.errors(&y[whole.inside]).norm_squared()
}

/// The mean squared error of the free run.
pub(super) fn square(model: &FeedbackModel, run: &Run) -> f64 {
    let counted = run.counted.of(run.record.len()).filter(|counts| *counts).count();
    sum_of_squares(model, run, 0.0) / counted as f64
}

/// The weighted free-run errors.
pub(super) struct FreeRun<'s, 'r> {
    pub(super) start: &'s FeedbackModel,
    pub(super) runs: &'s [Run<'r>],
    /// Gain of an observer; 0 for free runs.
    pub(super) gain: f64,
    /// The weights of the hysteresis, which are the last parameters, if their derivatives do not follow the search.
    pub(super) weights: Option<&'s Weights>,
}

impl<'s, 'r> FreeRun<'s, 'r> {
    pub(super) fn of(start: &'s FeedbackModel, runs: &'s [Run<'r>]) -> Self {
        FreeRun { start, runs, gain: 0.0, weights: None }
    }

    /// The unknowns at the start.
    pub(super) fn unknowns(&self) -> Vec<f64> {
        let mut x: Vec<f64> = self.start.parameters().iter().map(|p| p.value).collect();
        for run in self.runs {
            if let Initial::States(modes) = &run.initial {
                x.extend(modes.as_flattened());
            }
        }
        x
    }

    /// The model, and the records from their initial conditions.
    pub(super) fn at(&self, x: &[f64]) -> Result<(FeedbackModel, Vec<Run<'r>>), Error> {
        let (parameters, states) = x.split_at(self.start.parameters().len());
        let mut states = states.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
        let mut runs = self.runs.to_vec();
        for run in &mut runs {
            if let Initial::States(modes) = &mut run.initial {
                modes.iter_mut().zip(&mut states).for_each(|(mode, state)| *mode = state);
            }
        }
        Ok((self.start.with_parameters(parameters)?, runs))
    }

    /// Standard errors of the parameters of the model.
    pub(super) fn errors(&self, minimum: &Minimum) -> Vec<f64> {
        let (normal, d) = (self.normal(&minimum.x), minimum.x.len());
        let samples: usize = self.runs.iter().map(|run| run.record.len()).sum();
        let variance = normal.cost / samples.saturating_sub(d).max(1) as f64;
        let size = |k: usize| normal.hessian[k * d + k].sqrt();
        let shown: Vec<usize> = (0..d).filter(|k| size(*k) > 0.0).collect();
        let of = |i: usize, j: usize| normal.hessian[shown[i] * d + shown[j]] / (size(shown[i]) * size(shown[j]));
        let inverse = DMatrix::from_fn(shown.len(), shown.len(), of).try_inverse();
        let error = |k: usize| {
            let place = shown.iter().position(|shown| *shown == k)?;
            Some((inverse.as_ref()?[(place, place)] * variance).sqrt() / size(k)).filter(|error| error.is_finite())
        };
        (0..self.start.parameters().len()).map(|k| error(k).unwrap_or(f64::INFINITY)).collect()
    }

    /// Number of parameters whose derivatives follow the search.
    fn followed(&self) -> usize {
        self.start.parameters().len() - self.weights.map_or(0, Weights::len)
    }
}

impl SumOfSquares for FreeRun<'_, '_> {
    fn dimension(&self) -> usize {
        let of = |run: &Run| if let Initial::States(modes) = &run.initial { 2 * modes.len() } else { 0 };
        self.start.parameters().len() + self.runs.iter().map(of).sum::<usize>()
    }

    fn cost(&self, x: &[f64]) -> f64 {
        let Ok((model, runs)) = self.at(x) else { return f64::INFINITY };
        let of = |run: &Run| run.weight * sum_of_squares(&model, run, self.gain);
        let each: Vec<f64> = runs.par_iter().map(of).collect();
        each.iter().sum::<f64>() + self.weights.map_or(0.0, |weights| weights.penalty(&x[self.followed()..]))
    }

    fn normal(&self, x: &[f64]) -> NormalEquations {
        let (d, parameters, followed) = (self.dimension(), self.start.parameters().len(), self.followed());
        let mut sums = NormalEquations::empty(d);
        let failed = NormalEquations { cost: f64::INFINITY, ..sums.clone() };
        let Ok((model, runs)) = self.at(x) else { return failed };
        let mut own = parameters;
        for (k, run) in runs.iter().enumerate() {
            let whole = Whole::of(run, self.gain);
            let states = 2 * whole.start.len();
            let which = if self.weights.is_some() { 0..followed } else { 0..parameters + states };
            let Ok((y, slopes)) = model.sensitivities(whole.run(), which) else { return failed };
            let error = run.errors(&y[whole.inside.clone()]);
            let column = |slope: &Vec<f64>| {
                let mut column = DVector::from_column_slice(&slope[whole.inside.clone()]);
                run.mask(column.as_mut_slice());
                column
            };
            let columns: Vec<_> = slopes.iter().map(column).collect();
            let place = |j: usize| if j < parameters { j } else { j - parameters + own };
            sums.cost += run.weight * error.norm_squared();
            for (i, column) in columns.iter().enumerate() {
                sums.gradient[place(i)] += run.weight * column.dot(&error);
                for (j, other) in columns.iter().enumerate() {
                    sums.hessian[place(i) * d + place(j)] += run.weight * column.dot(other);
                }
            }
            if let Some(weights) = self.weights {
                weights.add(k, (&columns, &error, run.weight), &mut sums);
            }
            own += states;
        }
        if let Some(weights) = self.weights {
            weights.add_own(&x[followed..], &mut sums);
        }
        sums
    }

    fn lowest(&self) -> Vec<f64> {
        let mut lowest: Vec<f64> = self.start.parameters().iter().map(|p| p.limits.0).collect();
        lowest.resize(self.dimension(), f64::NEG_INFINITY);
        lowest
    }
}
