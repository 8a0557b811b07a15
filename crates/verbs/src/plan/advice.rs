//! Which drive of a plan would tell most about a model: the one that lowers the largest uncertainty most.
//!
//! ```text
//! J = dy / dp along the drive (free run),   C_new = (diag(1 / e^2) + J'J / sigma^2)^-1,   e_new = sqrt(C_new[k, k])
//! ```
//! p are the creep gains and modes of the model, e their standard errors, and sigma is the noise of the output. The
//! gain of the model and the offset of the record are unknown too: without them, a fast creep gain, which acts like a
//! gain, would seem to be known from any record. Noise counts as white and the model as true, so an error of the model
//! itself is not lowered as much.
//!
//! Reference: Ljung, System Identification: Theory for the User, 1999, chapter 13, DOI 10.1002/047134608X.W1046.

use super::Plan;
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
use serde_json::Value;
use std::f64::consts::TAU;

/// Step of the central difference, as a share of the parameter: rounding and curvature are then both far below 1 %.
const STEP: f64 = 1e-4;

/// Most operations of all free runs together: seconds of work.
const OPERATIONS: f64 = 1e10;

/// Repetitions of a record beyond which none is proposed.
const REPEATED: u32 = 100;

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

/// The sentence on the largest uncertainty and the drive that lowers it.
pub(super) fn advise(model: &Model, plan: &Plan) -> Result<String, Error> {
    let none = |because: &str| Error::Unsuited { what: "advice".into(), because: because.into() };
    let known = uncertain(model);
    let relative = |k: usize| known[k].error / known[k].value.abs();
    let Some(worst) = (0..known.len()).max_by(|&p, &q| relative(p).total_cmp(&relative(q))) else {
        return Err(none(
            "its file states no standard error of a creep gain or a mode: identify it by the joint method",
        ));
    };
    let sigma =
        noise(model).ok_or_else(|| none("its file has no verdict, which states the noise: identify it again"))?;
    let samples: usize = plan.drives.iter().filter(|drive| drive.name != "path").map(|drive| drive.u.len()).sum();
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
    let mut best: Option<(f64, &'static str, DMatrix<f64>)> = None;
    // The path stays apart from the training data.
    for drive in plan.drives.iter().filter(|drive| drive.name != "path") {
        let gained = information(model, &known, &drive.u, sigma)?;
        let after = expected(&known, worst, &gained, 1);
        if best.as_ref().is_none_or(|best| after < best.0) {
            best = Some((after, drive.name, gained));
        }
    }
    let (_, name, gained) = best.ok_or_else(|| none("the plan has no drives"))?;
    let Uncertain { value, error, unit, .. } = &known[worst];
    let message = |x: f64| format!("{}{unit}", round(x));
    let stated = if error.is_finite() { message(*error) } else { "unknown".into() };
    let begin =
        format!("The largest uncertainty is the {} ({}, standard error {stated})", known[worst].shown, message(*value));
    let after = |n: u32| {
        Some((n, expected(&known, worst, &gained, n))).filter(|(_, after)| after.is_finite() && *after <= 0.5 * error)
    };
    Ok(match (1..=REPEATED).find_map(after) {
        Some((1, after)) => {
            format!("{begin}: record {name}_u.csv, which is expected to lower it to {}.", message(after))
        }
        Some((n, after)) => format!(
            "{begin}: no single record halves it; record {name}_u.csv {n} times, which is expected to lower it to {}.",
            message(after)
        ),
        None => format!("{begin}: no drive of this plan halves it, not even {REPEATED} records of it."),
    })
}

/// Standard error of the parameter `k` after adding `n` records of this information.
pub(super) fn expected(known: &[Uncertain], k: usize, information: &DMatrix<f64>, n: u32) -> f64 {
    let mut all = information * f64::from(n);
    for (k, p) in known.iter().enumerate() {
        all[(k, k)] += (p.value / p.error).powi(2);
    }
    // Of a unit diagonal, the pivots tell how much of a parameter the others cannot imitate.
    let scale: Vec<f64> = all.diagonal().iter().map(|d| d.sqrt().recip()).collect();
    let unit = DMatrix::from_fn(all.nrows(), all.ncols(), |i, j| all[(i, j)] * scale[i] * scale[j]);
    let Some(factor) = unit.cholesky().filter(|factor| factor.l_dirty().diagonal().iter().all(|l| l * l > SINGULAR))
    else {
        return f64::INFINITY;
    };
    factor.inverse()[(k, k)].sqrt() * scale[k] * known[k].value.abs()
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

/// Standard deviation of the output's noise [unit of the output]: as the verdict states it, otherwise its error.
pub(super) fn noise(model: &Model) -> Option<f64> {
    let verdict = model.verdict()?;
    let percent = verdict.noise_percent.filter(|noise| *noise > 0.0).unwrap_or(verdict.error_percent);
    let held = |u: f64| model.step(&mut model.settled(u), u);
    let range = (held(verdict.u[1]) - held(verdict.u[0])).abs();
    Some(0.01 * percent * range).filter(|sigma| *sigma > 0.0 && sigma.is_finite())
}

/// The Fisher information of a record along the input `u`, with noise of standard deviation `sigma`: of the parameters,
/// each relative to its value, and last of the gain.
pub(super) fn information(model: &Model, known: &[Uncertain], u: &[f64], sigma: f64) -> Result<DMatrix<f64>, Error> {
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
        slope.iter_mut().for_each(|j| *j = (*j - mean) / sigma);
    }
    let product = |j: usize, k: usize| slopes[j].iter().zip(&slopes[k]).map(|(a, b)| a * b).sum();
    Ok(DMatrix::from_fn(slopes.len(), slopes.len(), product))
}

impl Uncertain {
    /// The model with another value of the parameter.
    fn moved(&self, model: &Model, value: f64) -> Result<Model, Error> {
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
