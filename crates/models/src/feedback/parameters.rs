//! The parameters of a feedback model, and the derivatives of its output by all of them.

use super::{FeedbackMode, FeedbackModel, run};
use crate::hysteresis::{Real, Sensitive, Several};
use piezoid_numerics::error::Error;
use rayon::prelude::*;

/// A parameter of a feedback model.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedbackParameter {
    /// Its name, with the index of its mode or weight.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its limits.
    pub limits: (f64, f64),
    /// False for one that is fixed.
    pub(super) is_free: bool,
}

/// Derivatives that are computed at a time.
const LANES: usize = 8;

/// A mode of less damping rings for ever, and one of more is two lags.
const DAMPING: (f64, f64) = (1e-5, 20.0);

/// gamma / beta of Bouc-Wen: below -1 the hysteretic force grows with a rise, as in the benchmark.
const GAMMA: (f64, f64) = (-10.0, 10.0);

impl FeedbackModel {
    /// The coefficients of the linear part in the order of a run, then weights and shape of the hysteresis.
    pub(super) fn rows(&self) -> Vec<FeedbackParameter> {
        let any = (f64::NEG_INFINITY, f64::INFINITY);
        let row = |name: String, value: f64, limits: (f64, f64), is_free: bool| FeedbackParameter {
            name,
            value,
            limits,
            is_free,
        };
        let first = |of: fn(&FeedbackMode) -> f64| self.modes.iter().position(|mode| of(mode) != 0.0);
        let (hysteretic, sensed) = (first(|mode| mode.hysteretic), first(|mode| mode.sensed));
        // Of the factors of a scale that the hysteresis has too, the first one is fixed.
        let (is_direct, drives) = (self.direct[1] != 0.0, self.sensed != 0.0);
        let mut rows = Vec::new();
        for (i, mode) in self.modes.iter().enumerate() {
            let fixed = |first: Option<usize>, before: bool| !before && first == Some(i);
            rows.push(row(format!("hz {i}"), mode.hz, (0.0, 0.5 * self.substeps as f64 / self.ts), true));
            rows.push(row(format!("damping {i}"), mode.damping, DAMPING, true));
            rows.push(row(format!("input {i}"), mode.input, any, mode.input != 0.0));
            let is_free = mode.hysteretic != 0.0 && !fixed(hysteretic, false);
            rows.push(row(format!("hysteretic {i}"), mode.hysteretic, any, is_free));
            let is_free = mode.sensed != 0.0 && !fixed(sensed, drives);
            rows.push(row(format!("sensed {i}"), mode.sensed, any, is_free));
        }
        rows.push(row("sensed input".into(), self.sensed, any, false));
        rows.push(row("direct".into(), self.direct[0], any, self.direct[0] != 0.0));
        rows.push(row("direct hysteretic".into(), self.direct[1], any, is_direct && hysteretic.is_some()));
        rows.push(row("offset".into(), self.offset, any, true));
        for (k, &weight) in self.weights.iter().enumerate() {
            rows.push(row(format!("weight {k}"), weight, any, weight != 0.0));
        }
        for shape in self.basis.shape() {
            let limits = if shape.name == "gamma_over_beta" { GAMMA } else { (shape.low, shape.high) };
            rows.push(row(shape.name.into(), shape.value, limits, true));
        }
        rows
    }

    /// Its parameters: those that are free.
    pub fn parameters(&self) -> Vec<FeedbackParameter> {
        self.rows().into_iter().filter(|row| row.is_free).collect()
    }

    pub(super) fn values(&self) -> Vec<f64> {
        self.parameters().iter().map(|row| row.value).collect()
    }

    /// The same model with these values of its [parameters](Self::parameters).
    ///
    /// # Errors
    /// Returns an error for a value out of its limits, or if their number differs.
    pub fn with_parameters(&self, x: &[f64]) -> Result<Self, Error> {
        let mut rows = self.rows();
        let free: Vec<_> = rows.iter_mut().filter(|row| row.is_free).collect();
        if free.len() != x.len() {
            let (left, right) = ("the values".into(), "the parameters".into());
            return Err(Error::Lengths { left, left_len: x.len(), right, right_len: free.len() });
        }
        for (row, &value) in free.into_iter().zip(x) {
            if !(row.limits.0..=row.limits.1).contains(&value) || !value.is_finite() {
                let rule = format!("must be from {} to {}", row.limits.0, row.limits.1);
                return Err(Error::parameter(&row.name, value, rule));
            }
            row.value = value;
        }
        let mut values = rows.iter().map(|row| row.value);
        let mut next = || values.next().unwrap_or_default();
        let mode = |_: &FeedbackMode| FeedbackMode {
            hz: next(),
            damping: next(),
            input: next(),
            hysteretic: next(),
            sensed: next(),
        };
        let modes = self.modes.iter().map(mode).collect();
        let (sensed, direct, offset) = (next(), [next(), next()], next());
        let weights: Vec<f64> = self.weights.iter().map(|_| next()).collect();
        let basis = self.basis.reshaped(&values.collect::<Vec<_>>())?;
        let steps = (self.substeps, self.intersample);
        FeedbackModel::new(self.ts, steps, modes, sensed, (basis.into(), weights))?.with_direct(direct, offset)
    }

    /// The [response](Self::simulate_from) to `u`, and its derivatives by each of the [parameters](Self::parameters),
    /// then by each number of `start`.
    ///
    /// # Errors
    /// Returns an error if the operator has no derivatives.
    pub fn sensitivities(&self, start: &[[f64; 2]], u: &[f64]) -> Result<(Vec<f64>, Vec<Vec<f64>>), Error> {
        let (path, mut x) = (self.path(u), self.values());
        let parameters = x.len();
        x.extend(start.as_flattened());
        let of = |from: usize| {
            let seeded = |k: usize, value: f64| {
                let slope = Several(std::array::from_fn(|j| f64::from(u8::from(from + j == k))));
                Sensitive { value, slope }
            };
            let x: Vec<Sensitive> = x.iter().enumerate().map(|(k, value)| seeded(k, *value)).collect();
            let (parameters, start) = x.split_at(parameters);
            let coefficients = self.coefficients(parameters);
            let (weights, shape) = self.of_hysteresis(parameters);
            let start = start.chunks_exact(2).map(|x| [x[0], x[1]]).collect();
            let mut state = vec![Sensitive::from(0.0); self.basis.order()];
            let (mut y, mut slopes) = (Vec::with_capacity(u.len()), vec![Vec::new(); LANES]);
            let mut known = true;
            let mut hysteresis = |s: Sensitive| {
                let z = self.basis.sensitive_step(&weights, &shape, &mut state, s);
                known &= z.is_some();
                z.unwrap_or(Sensitive::from(0.0))
            };
            run(&coefficients, &mut hysteresis, start, (&path, self.substeps), |v: Sensitive| {
                y.push(v.value());
                slopes.iter_mut().zip(v.slope.0).for_each(|(slopes, slope)| slopes.push(slope));
            });
            slopes.truncate(x.len() - from);
            known.then_some((y, slopes))
        };
        let parts: Option<Vec<_>> = (0..x.len()).step_by(LANES).collect::<Vec<_>>().into_par_iter().map(of).collect();
        let Some(parts) = parts else {
            let name = self.operator.operator().name;
            let because = format!("the operator {name} has no derivatives by its input: take another one");
            return Err(Error::Unidentifiable { what: "hysteresis in feedback".into(), because });
        };
        let y = parts.first().map(|part| part.0.clone()).unwrap_or_default();
        Ok((y, parts.into_iter().flat_map(|part| part.1).collect()))
    }

    /// Weights and shape of the hysteresis, for the parameters `x`.
    fn of_hysteresis(&self, x: &[Sensitive]) -> (Vec<Sensitive>, Vec<Sensitive>) {
        let rows = self.rows();
        let mut x = x.iter();
        let all = rows.iter().map(|row| {
            let free = if row.is_free { x.next() } else { None };
            free.copied().unwrap_or(row.value.into())
        });
        let mut all: Vec<Sensitive> = all.collect();
        let shape = all.split_off(all.len() - self.basis.shape().len());
        (all.split_off(all.len() - self.weights.len()), shape)
    }
}
