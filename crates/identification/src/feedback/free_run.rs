//! The free run of a feedback model along a record, from an unknown initial condition, and its errors.

use nalgebra::{DMatrix, DVector};
use piezoid_models::feedback::{FeedbackModel, Intersample};
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::Minimum;
use piezoid_numerics::optimize::levenberg_marquardt::{NormalEquations, SumOfSquares};
use piezoid_numerics::series::ends;
use piezoid_records::record::Record;
use rayon::prelude::*;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::Range;

/// Time constants of a mode that are simulated before a record in motion: what is left is 1e-5. And the largest number
/// of periods.
const REMEMBERED: f64 = 12.0;
const MAX_PERIODS: usize = 10;

/// The initial condition of a record.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Initial {
    /// Unknown: p and step times p' of each mode at its start. The hysteresis was at rest.
    States(Vec<[f64; 2]>),
    /// In motion: the record came before it too, this number of times.
    Periodic(usize),
}

/// A record with what its free run needs.
#[derive(Debug, Clone)]
pub(super) struct Run<'a> {
    pub(super) record: Cow<'a, Record>,
    pub(super) initial: Initial,
    /// Weight of its squared errors: 1 / (peak-to-peak of y)^2.
    pub(super) weight: f64,
}

pub(super) fn run<'a>(record: &'a Record, initial: Initial) -> Run<'a> {
    let (low, high) = ends(record.y().iter().copied());
    let weight = if low < high { (high - low).powi(-2) } else { 1.0 };
    Run { record: Cow::Borrowed(record), initial, weight }
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

/// The initial condition with which the free run of the model is nearest to the record: this one, at its first sample,
/// or periodic.
pub(super) fn likelier(model: &FeedbackModel, initial: Initial, record: &Record) -> Initial {
    let square = |initial: &Initial| square(model, initial, record);
    let others = [states(model, record), periodic(model, record)].into_iter();
    others.fold(initial, |best, one| if square(&one) < square(&best) { one } else { best })
}

/// What a free run along a record needs.
struct Whole<'a> {
    /// The input with what was before the record, and after it as far as the interpolation needs.
    u: Cow<'a, [f64]>,
    /// The samples that count.
    inside: Range<usize>,
    /// The modes at the start; empty at rest.
    start: &'a [[f64; 2]],
}

impl<'a> Whole<'a> {
    fn of(initial: &'a Initial, record: &'a Record) -> Self {
        let u = record.u();
        match initial {
            Initial::States(modes) => Whole { u: u.into(), inside: 0..u.len(), start: modes },
            Initial::Periodic(n) => {
                let after = &u[..u.len().min(Intersample::REACH)];
                let all = [&u.repeat(n + 1), after].concat();
                Whole { u: all.into(), inside: n * u.len()..(n + 1) * u.len(), start: &[] }
            }
        }
    }
}

/// The mean squared error of the free run.
pub(super) fn square(model: &FeedbackModel, initial: &Initial, record: &Record) -> f64 {
    let Whole { u, inside, start } = Whole::of(initial, record);
    let run = model.simulate_from(start, &u);
    let squares = record.y().iter().zip(&run[inside]).map(|(y, m)| (y - m).powi(2));
    squares.sum::<f64>() / record.len() as f64
}

/// The weighted free-run errors.
pub(super) struct FreeRun<'a> {
    pub(super) start: &'a FeedbackModel,
    pub(super) runs: &'a [Run<'a>],
}

impl FreeRun<'_> {
    /// The model and the initial conditions of the records.
    pub(super) fn at(&self, x: &[f64]) -> Result<(FeedbackModel, Vec<Initial>), Error> {
        let (parameters, states) = x.split_at(self.start.parameters().len());
        let mut states = states.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
        let of = |run: &Run| match &run.initial {
            Initial::States(modes) => Initial::States(states.by_ref().take(modes.len()).collect()),
            periodic => periodic.clone(),
        };
        Ok((self.start.with_parameters(parameters)?, self.runs.iter().map(of).collect()))
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
}

impl SumOfSquares for FreeRun<'_> {
    fn dimension(&self) -> usize {
        let of = |run: &Run| if let Initial::States(modes) = &run.initial { 2 * modes.len() } else { 0 };
        self.start.parameters().len() + self.runs.iter().map(of).sum::<usize>()
    }

    fn cost(&self, x: &[f64]) -> f64 {
        let Ok((model, initial)) = self.at(x) else { return f64::INFINITY };
        let of = |(run, initial): (&Run, &Initial)| {
            run.weight * run.record.len() as f64 * square(&model, initial, &run.record)
        };
        let each: Vec<f64> = self.runs.par_iter().zip(&initial).map(of).collect();
        each.iter().sum()
    }

    fn normal(&self, x: &[f64]) -> NormalEquations {
        let (d, parameters) = (self.dimension(), self.start.parameters().len());
        let mut sums = NormalEquations::empty(d);
        let failed = NormalEquations { cost: f64::INFINITY, ..sums.clone() };
        let Ok((model, initial)) = self.at(x) else { return failed };
        let mut own = parameters;
        for (run, initial) in self.runs.iter().zip(&initial) {
            let Whole { u, inside, start } = Whole::of(initial, &run.record);
            let Ok((y, slopes)) = model.sensitivities(start, &u) else { return failed };
            let errors = y[inside.clone()].iter().zip(run.record.y()).map(|(m, y)| m - y);
            let error = DVector::from_iterator(inside.len(), errors);
            let columns: Vec<_> =
                slopes.iter().map(|slope| DVector::from_column_slice(&slope[inside.clone()])).collect();
            let place = |j: usize| if j < parameters { j } else { j - parameters + own };
            sums.cost += run.weight * error.norm_squared();
            for (i, column) in columns.iter().enumerate() {
                sums.gradient[place(i)] += run.weight * column.dot(&error);
                for (j, other) in columns.iter().enumerate() {
                    sums.hessian[place(i) * d + place(j)] += run.weight * column.dot(other);
                }
            }
            own += columns.len() - parameters;
        }
        sums
    }
}
