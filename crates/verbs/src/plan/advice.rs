//! Which drive of a plan would lower the error of prediction most, and by how much.
//!
//! ```text
//! J  = dy / dp along a drive (free run), without its mean
//! G  = mean over the drives of J'J / n, without what the gain of the model imitates
//! V  = trace(C G)                                        mean square that the covariance C of p adds to a prediction
//! C  = diag(e^2) before,   (diag(1 / e^2) + J'J / sigma^2)^-1 after the record of a drive
//! ```
//! p are the creep gains and modes of the model, e their standard errors, and sigma is the noise of the output. The
//! gain of the model and the offset of each record are fitted to the records too. For this reason what they imitate
//! adds no error of prediction, and their own uncertainty keeps a fast creep gain, which acts like a gain, from seeming
//! to be known from any record. Parameters are ranked by sqrt(V), which is in the unit of the output: a parameter may
//! be known badly and matter to no prediction.
//!
//! It does not do: the covariance between the parameters, which the file of a model does not state. Noise counts as
//! white, the model as true, and y as linear in p within e.
//!
//! Reference: Ljung, System Identification: Theory for the User, 1999, chapter 13, DOI 10.1002/047134608X.W1046;
//! Atkinson & Donev, Optimum Experimental Designs, 1992, section 10.6 (V-optimality).

use super::{Plan, PlannedDrive};
use crate::verdict::StatedVerdict;
use libm::{cos, exp};
use nalgebra::DMatrix;
use piezoid_models::creep::{Creep, Lag};
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_models::linear::{Arx, Pole};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::mean;
use piezoid_numerics::system::System;
use piezoid_validation::rough;
use serde::Serialize;
use serde_json::Value;
use std::f64::consts::TAU;

/// Step of the central difference, as a share of the parameter: rounding and curvature are then both far below 1 %.
const STEP: f64 = 1e-4;

/// Most operations of all free runs together: seconds of work.
const OPERATIONS: f64 = 1e10;

/// Repetitions of a record beyond which none is proposed.
const REPEATED: u32 = 100;

/// Error that uncertain parameters add to a prediction, over that of the model, up to which no record is proposed:
/// without it, the error of the model would be 5 % lower.
const NEGLIGIBLE: f64 = 0.3;

/// A parameter of the model with its standard error.
#[derive(Debug, Clone)]
pub(super) struct Uncertain {
    /// Its name in sentences.
    shown: String,
    unit: &'static str,
    pub(super) value: f64,
    /// Infinite if it is not known.
    pub(super) error: f64,
    what: What,
}

#[derive(Debug, Clone, Copy)]
enum What {
    Creep(usize),
    Frequency(Pole),
    Damping(Pole),
}

/// Pivot of a scaled information matrix below which a parameter cannot be distinguished from the others.
const SINGULAR: f64 = 1e-9;

/// The error of prediction that uncertain parameters of a first model cause, rms along the drives of a plan, and the
/// record that lowers it most.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Unit of the errors.
    pub unit: String,
    /// The error of the model, as its verdict states it [unit of the output].
    pub model_error: f64,
    /// The noise of the output [unit of the output].
    pub noise: f64,
    /// What all parameters together add to the error of prediction [unit of the output].
    pub adds: f64,
    /// The drive whose record lowers this most.
    pub drive: &'static str,
    /// What they are expected to add after one record of it [unit of the output].
    pub after: f64,
    /// Number of records that are expected to halve what they add; `None` if not even 100 do.
    pub halved_by: Option<u32>,
    /// The parameters, the one that adds most first.
    pub parameters: Vec<UncertainParameter>,
}

/// A parameter with its standard error, and what this causes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UncertainParameter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its standard error; `None` if that is unknown. Then its whole value counts.
    pub error: Option<f64>,
    /// What it adds to the error of prediction [unit of the output].
    pub adds: f64,
    #[serde(skip)]
    unit: &'static str,
}

/// The error of prediction that the uncertain parameters of `model` cause along the drives of `plan`.
pub(super) fn uncertainty(model: &Model, plan: &Plan) -> Result<Uncertainty, Error> {
    let none = |because: &str| Error::Unsuited { what: "advice".into(), because: because.into() };
    let known = uncertain(model);
    if known.is_empty() {
        return Err(none(
            "its file states no standard error of a creep gain or a mode: identify it by the joint method",
        ));
    }
    let (model_error, sigma) =
        errors(model).ok_or_else(|| none("its file has no verdict, which states the noise: identify it again"))?;
    let samples: usize = plan.drives.iter().map(|drive| drive.u.len()).sum();
    let (runs, effort) = (2 * known.len() + 1, model.effort()?);
    let operations = effort * samples as f64 * runs as f64;
    if operations > OPERATIONS {
        return Err(none(&format!(
            "a sample of it takes {} operations, and {runs} runs of {samples} samples would take {}, more than \
             {OPERATIONS:e}: plan without the model, or identify one with fewer elements",
            short(effort),
            short(operations)
        )));
    }
    let products = |drive: &PlannedDrive| products(model, &known, &drive.u);
    let products = plan.drives.iter().map(products).collect::<Result<Vec<_>, _>>()?;
    let predicted = predicted(&products);
    let (each, adds) = added(&known, &predicted);
    let mut best: Option<(f64, &PlannedDrive, DMatrix<f64>)> = None;
    // The path stays apart from the training data.
    for (drive, products) in plan.drives.iter().zip(&products).filter(|(drive, _)| drive.name != "path") {
        let gained = products * (drive.u.len() as f64 / (sigma * sigma));
        let after = expected(&known, &gained, &predicted);
        if best.as_ref().is_none_or(|best| after < best.0) {
            best = Some((after, drive, gained));
        }
    }
    let (after, drive, gained) = best.ok_or_else(|| none("the plan has no drives"))?;
    let is_half = |n: &u32| expected(&known, &(&gained * f64::from(*n)), &predicted) <= 0.5 * adds;
    let parameter = |(p, adds): (Uncertain, f64)| {
        let error = Some(p.error).filter(|error| error.is_finite());
        UncertainParameter { name: p.shown, value: p.value, error, adds, unit: p.unit }
    };
    let mut parameters: Vec<_> = known.iter().cloned().zip(each).map(parameter).collect();
    parameters.sort_by(|p, q| q.adds.total_cmp(&p.adds));
    Ok(Uncertainty {
        unit: model.units().y.clone(),
        model_error,
        noise: sigma,
        adds,
        drive: drive.name,
        after,
        halved_by: (1..=REPEATED).find(is_half),
        parameters,
    })
}

impl Uncertainty {
    /// The sentence on what to measure, or that nothing is to be gained.
    pub(super) fn advice(&self) -> String {
        let length = |x: f64| format!("{} {}", rough(x), self.unit);
        let [adds, after, error, noise] = [self.adds, self.after, self.model_error, self.noise].map(length);
        let of_model = format!("the error of the model is {error} rms, its noise {noise}");
        let Some(worst) = self.parameters.first().filter(|_| self.adds > NEGLIGIBLE * self.model_error) else {
            return format!(
                "Nothing to gain by further records: the uncertainty of creep and modes adds {adds} rms to the error of \
                 prediction along these drives; {of_model}."
            );
        };
        let figure = |x: f64| format!("{}{}", round(x), worst.unit);
        let stated = worst.error.map_or("unknown".into(), figure);
        let (name, value, most, drive) = (&worst.name, figure(worst.value), length(worst.adds), self.drive);
        let remedy = match self.halved_by {
            Some(1) => format!("Record {drive}_u.csv, which is expected to lower this to {after}"),
            Some(n) => format!(
                "Record {drive}_u.csv: one record is expected to lower this to {after}, {n} of them to less than half"
            ),
            None => format!(
                "No drive of this plan halves this, not even {REPEATED} records of it; one of {drive}_u.csv is expected \
                 to lower it to {after}"
            ),
        };
        format!(
            "The {name} ({value}, standard error {stated}) adds most to the error of prediction, {most} rms along these \
             drives, of {adds} that all uncertain parameters add. {remedy}; {of_model}."
        )
    }
}

/// What the parameters add to predictions with these products [unit of the output]: each alone, and all together.
pub(super) fn added(known: &[Uncertain], predicted: &DMatrix<f64>) -> (Vec<f64>, f64) {
    let squares = known.iter().enumerate().map(|(k, p)| p.relative().powi(2) * predicted[(k, k)].max(0.0));
    let squares: Vec<f64> = squares.collect();
    (squares.iter().map(|square| square.sqrt()).collect(), squares.iter().sum::<f64>().sqrt())
}

/// What they are expected to add once `information` is added.
fn expected(known: &[Uncertain], information: &DMatrix<f64>, predicted: &DMatrix<f64>) -> f64 {
    let Some(covariance) = covariance(known, information) else { return added(known, predicted).1 };
    let n = known.len();
    covariance.view((0, 0), (n, n)).component_mul(predicted).sum().max(0.0).sqrt()
}

/// The covariance of the parameters, each relative to its value, and of the gain, once `information` is added; `None`
/// if it does not distinguish them.
pub(super) fn covariance(known: &[Uncertain], information: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut all = information.clone();
    for (k, p) in known.iter().enumerate() {
        all[(k, k)] += p.relative().powi(-2);
    }
    // Of a unit diagonal, the pivots state how much of a parameter the others cannot imitate.
    let scale: Vec<f64> = all.diagonal().iter().map(|d| d.sqrt().recip()).collect();
    let scaled = |of: &DMatrix<f64>| DMatrix::from_fn(of.nrows(), of.ncols(), |i, j| of[(i, j)] * scale[i] * scale[j]);
    let factor = scaled(&all).cholesky().filter(|factor| factor.l_dirty().diagonal().iter().all(|l| l * l > SINGULAR));
    factor.map(|factor| scaled(&factor.inverse()))
}

/// The products of predictions along all drives, each of equal weight, without what the gain imitates.
pub(super) fn predicted(products: &[DMatrix<f64>]) -> DMatrix<f64> {
    let Some(first) = products.first() else { return DMatrix::zeros(0, 0) };
    let all = products[1..].iter().fold(first.clone(), |sum, next| sum + next) / products.len() as f64;
    let gain = all.nrows() - 1;
    let share = |k: usize| if all[(gain, gain)] > 0.0 { all[(k, gain)] / all[(gain, gain)] } else { 0.0 };
    DMatrix::from_fn(gain, gain, |j, k| all[(j, k)] - share(j) * all[(gain, k)])
}

/// The creep gains and modes of the model whose standard errors its file states.
pub(super) fn uncertain(model: &Model) -> Vec<Uncertain> {
    let lags = model.creep().lags().iter().enumerate().map(|(k, lag)| {
        let name = |tau: String| format!("creep gain at {tau} s");
        (name(short(lag.tau_s)) + " [-]", name(round(lag.tau_s)), "", What::Creep(k))
    });
    let modes = model.linear().modal_form().modes().into_iter().enumerate().flat_map(|(k, mode)| {
        let [hz, damping] = ["frequency", "damping"].map(|of| format!("mode {} {of}", k + 1));
        let shown = |of| format!("{of} of mode {}", k + 1);
        [
            (hz + " [Hz]", shown("frequency"), " Hz", What::Frequency(mode.pole)),
            (damping, shown("damping"), "", What::Damping(mode.pole)),
        ]
    });
    let known: Vec<_> = lags.chain(modes).collect();
    let read = |row: &Value| {
        let (_, shown, unit, what) = known.iter().find(|(name, ..)| row["name"] == **name)?;
        let value = row["value"].as_f64().filter(|value| *value != 0.0)?;
        let error = row["error"].as_f64().unwrap_or(f64::INFINITY);
        Some(Uncertain { shown: shown.clone(), unit, value, error, what: *what })
    };
    model.provenance()["parameters"].as_array().into_iter().flatten().filter_map(read).collect()
}

/// Rms error of the model, and standard deviation of the noise [unit of the output], as its verdict states them. If it
/// states no noise, that is at most the error.
pub(super) fn errors(model: &Model) -> Option<(f64, f64)> {
    let verdict = model.verdict()?;
    let held = |u: f64| model.step(&mut model.settled(u), u);
    let range = (held(verdict.u[1]) - held(verdict.u[0])).abs();
    let noise = verdict.noise_percent.filter(|noise| *noise > 0.0).unwrap_or(verdict.error_percent);
    let [error, sigma] = [verdict.error_percent, noise].map(|percent| 0.01 * percent * range);
    (sigma > 0.0 && sigma.is_finite()).then_some((error.max(sigma), sigma))
}

/// The mean products along the input `u` of the slopes of the free run [unit of the output squared]: of the parameters,
/// each relative to its value, and last of the gain.
pub(super) fn products(model: &Model, known: &[Uncertain], u: &[f64]) -> Result<DMatrix<f64>, Error> {
    let run = |model: &Model| {
        let mut x = model.before(u, InitialCondition::Settled);
        model.resume(&mut x, u)
    };
    let slope = |p: &Uncertain| -> Result<Vec<f64>, Error> {
        let at = |factor: f64| p.moved(model, p.value * factor).map(|moved| run(&moved));
        let (above, below) = (at(1.0 + STEP)?, at(1.0 - STEP)?);
        Ok(above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * STEP)).collect())
    };
    let mut slopes = known.iter().map(slope).collect::<Result<Vec<_>, _>>()?;
    slopes.push(run(model));
    for slope in &mut slopes {
        // Every record has an offset of its own.
        let mean = mean(slope);
        slope.iter_mut().for_each(|j| *j -= mean);
    }
    let product = |j: usize, k: usize| slopes[j].iter().zip(&slopes[k]).map(|(a, b)| a * b).sum::<f64>();
    Ok(DMatrix::from_fn(slopes.len(), slopes.len(), |j, k| product(j, k) / u.len() as f64))
}

impl Uncertain {
    /// Its standard error over its value; of an unknown one, its whole value counts.
    fn relative(&self) -> f64 {
        if self.error.is_finite() { self.error / self.value.abs() } else { 1.0 }
    }

    /// The model with another value of the parameter.
    pub(super) fn moved(&self, model: &Model, value: f64) -> Result<Model, Error> {
        match self.what {
            What::Creep(k) => {
                let mut lags: Vec<Lag> = model.creep().lags().to_vec();
                lags[k].gain = value;
                model.clone().with_creep(Creep::new(model.ts(), lags)?)
            }
            What::Frequency(pole) => model.clone().with_linear(replaced(model.linear(), pole, value, pole.damping)?),
            What::Damping(pole) => model.clone().with_linear(replaced(model.linear(), pole, pole.hz, value)?),
        }
    }
}

/// The block with another natural frequency and damping ratio of one pair of poles; DC gain and zeros stay.
fn replaced(linear: &Arx, pole: Pole, hz: f64, damping: f64) -> Result<Arx, Error> {
    let of = linear.denominator();
    // A = (1 + p q^-1 + r q^-2) rest
    let (p, r) = (-2.0 * pole.z.re, pole.z.modulus() * pole.z.modulus());
    let mut rest: Vec<f64> = Vec::with_capacity(of.len());
    for k in 0..of.len() - 2 {
        let before = |lag: usize| if k >= lag { rest[k - lag] } else { 0.0 };
        rest.push(of[k] - p * before(1) - r * before(2));
    }
    let w = TAU * hz * linear.ts();
    let modulus = exp(-damping * w);
    let (p, r) = (-2.0 * modulus * cos(w * (1.0 - damping * damping).sqrt()), modulus * modulus);
    let mut new = vec![0.0; of.len()];
    for (k, c) in rest.iter().enumerate() {
        for (lag, factor) in [1.0, p, r].into_iter().enumerate() {
            new[k + lag] += c * factor;
        }
    }
    let gain = new.iter().sum::<f64>() / of.iter().sum::<f64>();
    let a = new[1..].iter().map(|a| -a).collect();
    Arx::new(linear.ts(), a, linear.b().iter().map(|b| b * gain).collect())
}
