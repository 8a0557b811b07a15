//! The parameters of a feedback model, and the derivatives of its output by all of them.

use super::input::Path;
use super::modes::ModeStep;
use super::run::{Coefficients, run};
use super::{FeedbackDynamics, FeedbackMode, FeedbackModel};
use crate::creep::Lag;
use crate::hysteresis::{Basis, LANES, Real, Sensitive, Several};
use libm::exp;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A parameter of a feedback model.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedbackParameter {
    /// Its name, with the unit.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its limits.
    pub limits: (f64, f64),
    /// False for one that is fixed.
    pub(super) is_free: bool,
}

/// Coefficients of a mode.
const OF_MODE: usize = 6;

/// Coefficients after those of the modes: of s and y.
const OF_OUTPUT: usize = 5;

/// A mode of less damping rings for ever, and one of more is two lags.
const DAMPING: (f64, f64) = (1e-5, 20.0);

/// gamma / beta of Bouc-Wen: below -1 the hysteretic force grows with a rise, as in the benchmark.
const GAMMA: (f64, f64) = (-10.0, 10.0);

impl FeedbackParameter {
    /// Returns an error for a value out of its limits.
    pub(super) fn checked(&self, value: f64) -> Result<f64, Error> {
        let (low, high) = self.limits;
        if value.is_finite() && value >= low && value <= high {
            return Ok(value);
        }
        Err(Error::parameter(&self.name, value, format!("must be a number from {low} to {high}")))
    }
}

impl<R: Real> Coefficients<R> {
    /// Those of the dynamics, from all [rows].
    pub(super) fn of(ts: f64, dynamics: &FeedbackDynamics, rows: &[R]) -> Self {
        let h = ts / dynamics.substeps as f64;
        let (of_modes, rest) = rows.split_at(OF_MODE * dynamics.modes.len());
        let step = |mode: &[R]| ModeStep::new(mode[0] * R::from(TAU), mode[1], h);
        let steps = of_modes.chunks_exact(OF_MODE).map(step).collect();
        let of_mode = |mode: &[R]| [mode[2], mode[3], mode[4], mode[5]];
        let coupled: Vec<[R; 4]> = of_modes.chunks_exact(OF_MODE).map(of_mode).collect();
        let returned = coupled.iter().fold(R::from(0.0), |sum, [_, e, k, _]| sum + *k * *e);
        let lag = |(lag, gain): (&Lag, &R)| (exp(-h / lag.tau_s), *gain);
        let lags = dynamics.creep.iter().zip(&rest[OF_OUTPUT..]).map(lag).collect();
        Coefficients {
            steps,
            coupled,
            sensed: rest[0],
            senses_vibration: dynamics.senses_vibration,
            returned,
            direct: [rest[1], rest[2]],
            curve: rest[3],
            offset: rest[4],
            lags,
            delay: dynamics.delay,
        }
    }
}

/// The coefficients of the dynamics in the order of a run, then weights and shape of the hysteresis.
pub(super) fn rows(
    ts: f64,
    dynamics: &FeedbackDynamics,
    operator: &str,
    weighted: Option<&(Arc<dyn Basis>, Vec<f64>)>,
) -> Vec<FeedbackParameter> {
    let FeedbackDynamics { substeps, modes, sensed: input_sensed, direct, creep, curve, offset, .. } = dynamics;
    let any = (f64::NEG_INFINITY, f64::INFINITY);
    let fastest = (f64::MIN_POSITIVE, 0.5 * *substeps as f64 / ts);
    let first = |of: fn(&FeedbackMode) -> f64| modes.iter().position(|mode| of(mode) != 0.0);
    let (hysteretic, sensed) = (first(|mode| mode.hysteretic), first(|mode| mode.sensed));
    // Factors of a scale that the weights have too; an operator without them has none of its own.
    let is_scaled = weighted.is_some();
    let mut rows = Vec::new();
    let mut row = |name: String, value: f64, limits: (f64, f64), is_free: bool| {
        rows.push(FeedbackParameter { name, value, limits, is_free });
    };
    for (i, mode) in modes.iter().enumerate() {
        let name = |what: &str| format!("mode {} {what}", i + 1);
        // Of the factors of a scale that the hysteresis has too, the first one is fixed.
        let is_scale = is_scaled && *input_sensed == 0.0 && sensed == Some(i);
        let is_output_scale = is_scaled && hysteretic == Some(i);
        row(name("frequency [Hz]"), mode.hz, fastest, true);
        row(name("damping"), mode.damping, DAMPING, true);
        row(name("input [output unit/input unit]"), mode.input, any, mode.input != 0.0);
        row(name("hysteretic"), mode.hysteretic, any, mode.hysteretic != 0.0 && !is_output_scale);
        row(name("sensed [1/output unit]"), mode.sensed, any, mode.sensed != 0.0 && !is_scale);
        row(name("softening [1/output unit]"), mode.softening, any, mode.softening != 0.0);
    }
    let is_direct = direct[1] != 0.0 && hysteretic.is_some();
    row("sensed input [1/input unit]".into(), *input_sensed, any, false);
    row("direct [output unit/input unit]".into(), direct[0], any, direct[0] != 0.0);
    row("direct hysteretic".into(), direct[1], any, is_direct);
    row("curve [1/output unit]".into(), *curve, any, *curve != 0.0);
    row("offset [output unit]".into(), *offset, any, true);
    for lag in creep {
        row(format!("creep of {} s", short(lag.tau_s)), lag.gain, any, lag.gain != 0.0);
    }
    let Some((basis, weights)) = weighted else { return rows };
    for (k, &weight) in weights.iter().enumerate() {
        row(format!("weight {k}"), weight, any, weight != 0.0);
    }
    for shape in basis.shape() {
        let is_wider = operator == "bouc-wen" && shape.name == "gamma_over_beta";
        row(shape.name.into(), shape.value, if is_wider { GAMMA } else { (shape.low, shape.high) }, true);
    }
    rows
}

impl FeedbackModel {
    fn rows(&self) -> Vec<FeedbackParameter> {
        rows(self.ts, &self.dynamics, self.hysteresis.operator().name, self.weighted.as_ref())
    }

    /// The values of all rows, with those of the parameters `x`.
    fn expanded<R: Real>(&self, x: &[R]) -> Vec<R> {
        let (rows, mut x) = (self.rows(), x.iter());
        let value =
            |row: &FeedbackParameter| if row.is_free { x.next().copied() } else { None }.unwrap_or(row.value.into());
        rows.iter().map(value).collect()
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
            row.value = row.checked(value)?;
        }
        let mut values = rows.iter().map(|row| row.value);
        let mut next = || values.next().unwrap_or_default();
        let mode = |_: &FeedbackMode| FeedbackMode {
            hz: next(),
            damping: next(),
            input: next(),
            hysteretic: next(),
            sensed: next(),
            softening: next(),
        };
        let modes = self.dynamics.modes.iter().map(mode).collect();
        let (sensed, direct, curve, offset) = (next(), [next(), next()], next(), next());
        let creep = self.dynamics.creep.iter().map(|lag| Lag { gain: next(), ..*lag }).collect();
        let dynamics = FeedbackDynamics { modes, sensed, direct, curve, offset, creep, ..self.dynamics };
        let Some((basis, weights)) = &self.weighted else {
            return FeedbackModel::new(self.ts, dynamics, self.hysteresis.clone());
        };
        let weights: Vec<f64> = weights.iter().map(|_| next()).collect();
        let basis = basis.reshaped(&values.collect::<Vec<_>>())?;
        FeedbackModel::weighted(self.ts, dynamics, basis.into(), weights)
    }

    /// The [response](Self::simulate_from) to `u`, and its derivatives by each of the [parameters](Self::parameters),
    /// then by each number of `start`. At a start with s = 0 the way of the hysteresis is unknown, and its share of
    /// the derivatives by p is missing.
    ///
    /// # Errors
    /// Returns an error if the operator has no derivatives.
    pub fn sensitivities(&self, start: &[[f64; 2]], u: &[f64]) -> Result<(Vec<f64>, Vec<Vec<f64>>), Error> {
        let mut x = self.values();
        let parameters = x.len();
        x.extend(start.as_flattened());
        let unknown = || {
            let name = self.hysteresis.operator().name;
            let because = format!("the operator {name} has no derivatives by its input: take another one");
            Error::Unidentifiable { what: "hysteresis in feedback".into(), because }
        };
        let (basis, weights) = self.weighted.as_ref().ok_or_else(unknown)?;
        let of = |from: usize| {
            let seeded = |k: usize, value: f64| {
                let slope = Several(std::array::from_fn(|j| f64::from(u8::from(from + j == k))));
                Sensitive { value, slope }
            };
            let x: Vec<Sensitive> = x.iter().enumerate().map(|(k, value)| seeded(k, *value)).collect();
            let (parameters, start) = x.split_at(parameters);
            let mut rows = self.expanded(parameters);
            let coefficients = Coefficients::of(self.ts, &self.dynamics, &rows);
            let shape = rows.split_off(rows.len() - basis.shape().len());
            let weights = rows.split_off(rows.len() - weights.len());
            let start = start.chunks_exact(2).map(|x| [x[0], x[1]]).collect();
            let mut hysteresis = basis.sensitive(&weights, &shape)?;
            let run = run(&coefficients, &mut *hysteresis, start, Path::of(self, u));
            let y = run.iter().map(|v| v.value).collect::<Vec<_>>();
            let slope = |k: usize| run.iter().map(|v| v.slope.0[k]).collect::<Vec<_>>();
            let slopes = (0..LANES.min(x.len() - from)).map(slope).collect::<Vec<_>>();
            Some((y, slopes))
        };
        let parts: Option<Vec<_>> = (0..x.len()).step_by(LANES).collect::<Vec<_>>().into_par_iter().map(of).collect();
        let parts = parts.ok_or_else(unknown)?;
        let y = parts.first().map(|part| part.0.clone()).unwrap_or_default();
        Ok((y, parts.into_iter().flat_map(|part| part.1).collect()))
    }
}
