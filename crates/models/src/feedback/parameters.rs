//! The parameters of a feedback model, and the derivatives of its output by all of them.

use super::input::Path;
use super::modes::ModeStep;
use super::run::{Coefficients, run};
use super::{FeedbackDynamics, FeedbackMode, FeedbackModel, FeedbackRun, Intersample};
use crate::creep::Lag;
use crate::driver::DriverModel;
use crate::hysteresis::{Basis, LANES, Real, Sensitive, Several};
use libm::exp;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;
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

/// Coefficients after those of the modes: of s, y and the driver.
const OF_OUTPUT: usize = 6;

/// The name of the lag of a driver, and the step of a difference over it, in samples.
const LAG: &str = "driver lag [s]";
const LAG_STEP: f64 = 1e-5;

/// A mode of less damping rings for ever, and one of more is two lags.
const DAMPING: (f64, f64) = (1e-5, 20.0);

/// gamma / beta of Bouc-Wen: below -1 the hysteretic force grows with a rise, as in the benchmark.
const GAMMA: (f64, f64) = (-10.0, 10.0);

/// What is unknown besides the dynamics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unknown {
    /// Weights and shape of the hysteresis.
    pub hysteresis: bool,
    /// The lag of a driver that has one.
    pub driver: bool,
}

impl Default for Unknown {
    fn default() -> Self {
        Unknown { hysteresis: true, driver: false }
    }
}

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

/// The coefficients of the dynamics in the order of a run, then weights and shape of the hysteresis. Those of the
/// hysteresis are parameters if it is unknown, and so is the lag of a driver.
pub(super) fn rows(
    ts: f64,
    dynamics: &FeedbackDynamics,
    operator: &str,
    weighted: Option<&(Arc<dyn Basis>, Vec<f64>)>,
    Unknown { hysteresis: is_unknown, driver: lag_is_unknown }: Unknown,
) -> Vec<FeedbackParameter> {
    let FeedbackDynamics { substeps, intersample, modes, sensed: input_sensed, direct, creep, curve, offset, .. } =
        dynamics;
    let (any, positive) = ((f64::NEG_INFINITY, f64::INFINITY), (0.0, f64::INFINITY));
    let fastest = (f64::MIN_POSITIVE, 0.5 * *substeps as f64 / ts);
    let first = |of: fn(&FeedbackMode) -> f64| modes.iter().position(|mode| of(mode) != 0.0);
    let (hysteretic, sensed) = (first(|mode| mode.hysteretic), first(|mode| mode.sensed));
    // Factors of a scale that the weights have too; an operator without them has none of its own.
    let is_scaled = weighted.is_some() && is_unknown;
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
    let lag_s = if let Intersample::Driven(driver) = intersample { driver.lag_s } else { 0.0 };
    row(LAG.into(), lag_s, positive, lag_s > 0.0 && lag_is_unknown);
    for lag in creep {
        row(format!("creep of {} s", short(lag.tau_s)), lag.gain, positive, lag.gain != 0.0);
    }
    let Some((basis, weights)) = weighted else { return rows };
    for (k, (&weight, is_positive)) in weights.iter().zip(basis.non_negative()).enumerate() {
        row(format!("weight {k}"), weight, if is_positive { positive } else { any }, weight != 0.0 && is_unknown);
    }
    for shape in basis.shape() {
        let is_wider = operator == "bouc-wen" && shape.name == "gamma_over_beta";
        row(shape.name.into(), shape.value, if is_wider { GAMMA } else { (shape.low, shape.high) }, is_unknown);
    }
    rows
}

impl FeedbackModel {
    fn rows(&self) -> Vec<FeedbackParameter> {
        let mut rows = self.rows_of(Unknown::default());
        rows.iter_mut().zip(&self.free).for_each(|(row, is_free)| row.is_free = *is_free);
        rows
    }

    fn rows_of(&self, unknown: Unknown) -> Vec<FeedbackParameter> {
        rows(self.ts, &self.dynamics, self.hysteresis.operator().name, self.weighted.as_ref(), unknown)
    }

    /// The same model with the parameters of what is unknown.
    pub fn with_unknown(self, unknown: Unknown) -> Self {
        let free = self.rows_of(unknown).iter().map(|row| row.is_free).collect();
        FeedbackModel { free, ..self }
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
        let (sensed, direct, curve, offset, lag_s) = (next(), [next(), next()], next(), next(), next());
        let creep = self.dynamics.creep.iter().map(|lag| Lag { gain: next(), ..*lag }).collect();
        let intersample = match self.dynamics.intersample {
            Intersample::Driven(driver) => Intersample::Driven(DriverModel { lag_s, ..driver }),
            other => other,
        };
        let dynamics = FeedbackDynamics { intersample, modes, sensed, direct, curve, offset, creep, ..self.dynamics };
        let new = match &self.weighted {
            None => FeedbackModel::new(self.ts, dynamics, self.hysteresis.clone()),
            Some((basis, weights)) => {
                let weights: Vec<f64> = weights.iter().map(|_| next()).collect();
                let basis = basis.reshaped(&values.collect::<Vec<_>>())?;
                FeedbackModel::weighted(self.ts, dynamics, basis.into(), weights)
            }
        };
        Ok(FeedbackModel { free: self.free.clone(), ..new? })
    }

    /// The [response](Self::follow_run), and its derivatives by `which` of the [parameters](Self::parameters) and,
    /// after them, the numbers of the start. At a start with s = 0 the way of the hysteresis is unknown, and its share
    /// of the derivatives by p is missing.
    ///
    /// # Errors
    /// Returns an error if the operator has no derivatives.
    pub fn sensitivities(&self, of: FeedbackRun, which: Range<usize>) -> Result<(Vec<f64>, Vec<Vec<f64>>), Error> {
        let mut x = self.values();
        let parameters = x.len();
        x.extend(of.start.as_flattened());
        let unknown = || {
            let name = self.hysteresis.operator().name;
            let because = format!("the operator {name} has no derivatives by its input: take another one");
            Error::Unidentifiable { what: "hysteresis in feedback".into(), because }
        };
        let (basis, weights) = self.weighted.as_ref().ok_or_else(unknown)?;
        let lanes = |from: usize| {
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
            let run = run(&coefficients, &mut *hysteresis, start, Path::of(self, of.u), of.observer);
            let y = run.iter().map(|v| v.value).collect::<Vec<_>>();
            let slope = |k: usize| run.iter().map(|v| v.slope.0[k]).collect::<Vec<_>>();
            let slopes = (0..LANES.min(which.end - from)).map(slope).collect::<Vec<_>>();
            Some((y, slopes))
        };
        let from: Vec<usize> = which.clone().step_by(LANES).collect();
        let parts: Option<Vec<_>> = from.into_par_iter().map(lanes).collect();
        let parts = parts.ok_or_else(unknown)?;
        let y = parts.first().map(|part| part.0.clone()).unwrap_or_default();
        let mut slopes: Vec<Vec<f64>> = parts.into_iter().flat_map(|part| part.1).collect();
        // The input behind a driver is no number with derivatives.
        let lag = self.parameters().iter().position(|p| p.name == LAG);
        if let Some(k) = lag.filter(|k| which.contains(k)) {
            let with_lag = |lag: f64| {
                let mut x = x[..parameters].to_vec();
                x[k] = lag;
                Ok(self.with_parameters(&x)?.follow_run(of))
            };
            let [longer, shorter] = [x[k] + LAG_STEP * self.ts, (x[k] - LAG_STEP * self.ts).max(0.0)];
            let (more, less) = (with_lag(longer)?, with_lag(shorter)?);
            let difference = |(p, q): (f64, f64)| (p - q) / (longer - shorter);
            slopes[k - which.start] = more.into_iter().zip(less).map(difference).collect();
        }
        Ok((y, slopes))
    }
}
