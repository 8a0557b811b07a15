//! Which drive of a plan would tell most about a model: the one that lowers the largest uncertainty most.
//!
//! ```text
//! J_t = dy_t / dp (free run along the drive, less its mean),   I = J'J / sigma^2,   e_new = 1 / sqrt(1 / e^2 + I)
//! ```
//! e is the standard error of the parameter p in the model's file, and sigma the noise of the output. The mean is left
//! out, because every record has an offset of its own. All other parameters count as known and noise as white, so a
//! measured record lowers the error less where parameters compensate each other. Considered are creep gains and modes.
//!
//! Reference: Ljung, System Identification: Theory for the User, 1999, chapter 13, DOI 10.1002/047134608X.W1046.

use super::Plan;
use crate::creep::{Creep, Lag};
use crate::error::Error;
use crate::hammerstein::{InitialCondition, Model};
use crate::linear::{Arx, Pole};
use crate::number::{round, short};
use crate::series::mean;
use crate::system::System;
use serde_json::Value;
use std::f64::consts::TAU;

/// Step of the central difference, as a share of the parameter: rounding and curvature are then both far below 1 %.
const STEP: f64 = 1e-4;

/// Repetitions of a record beyond which none is proposed.
const REPEATED: f64 = 100.0;

/// A parameter of the model with its standard error.
#[derive(Debug, Clone)]
pub(super) struct Uncertain {
    name: String,
    unit: String,
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

/// The sentence on the largest uncertainty and the drive that lowers it.
pub(super) fn advise(model: &Model, plan: &Plan) -> Result<String, Error> {
    let none = |because: &str| Error::Unsuited { what: "advice".into(), because: because.into() };
    let known = uncertain(model);
    let relative = |p: &Uncertain| p.error / p.value.abs();
    let Some(worst) = known.iter().max_by(|p, q| relative(p).total_cmp(&relative(q))) else {
        return Err(none(
            "its file states no standard error of a creep gain or a mode: identify it with `--method joint`",
        ));
    };
    let sigma =
        noise(model).ok_or_else(|| none("its file has no verdict, which states the noise: identify it again"))?;
    let mut best = (0.0, "");
    for drive in &plan.drives {
        let gained = information(model, worst, &drive.u, sigma)?;
        // The path stays apart from the training data.
        if gained > best.0 && drive.name != "path" {
            best = (gained, drive.name);
        }
    }
    let told = |x: f64| format!("{}{}", short(x), worst.unit);
    let error = if worst.error.is_finite() { told(worst.error) } else { "unknown".into() };
    let begin =
        format!("The largest uncertainty is the {} ({}, standard error {error})", worst.name, told(worst.value));
    let (gained, name) = best;
    // Records needed to halve the error: 1 / e^2 + n I = 4 / e^2.
    let needed = (3.0 / (worst.error * worst.error * gained)).ceil().max(1.0);
    let after = told(expected(worst.error, gained * needed.min(REPEATED)));
    Ok(match needed {
        n if n <= 1.0 => format!("{begin}: record {name}_u.csv, which is expected to lower it to {after}."),
        n if n <= REPEATED => format!(
            "{begin}: no single record halves it; record {name}_u.csv {} times, which is expected to lower it to {after}.",
            round(n)
        ),
        _ => format!("{begin}: no drive of this plan halves it, not even {REPEATED} records of it."),
    })
}

/// Standard error after adding records of this information.
pub(super) fn expected(error: f64, information: f64) -> f64 {
    1.0 / (1.0 / (error * error) + information).sqrt()
}

/// The creep gains and modes of the model whose standard errors its file states.
pub(super) fn uncertain(model: &Model) -> Vec<Uncertain> {
    let lags = model.creep().lags().iter().enumerate();
    let lags = lags.map(|(k, lag)| (format!("creep gain at {} s", short(lag.tau_s)), "[-]", What::Creep(k)));
    let modes = model.linear().modal_form().modes().into_iter().enumerate().flat_map(|(k, mode)| {
        let name = |of| format!("mode {} {of}", k + 1);
        [(name("frequency"), "[Hz]", What::Frequency(mode.pole)), (name("damping"), "", What::Damping(mode.pole))]
    });
    let known: Vec<_> = lags.chain(modes).collect();
    let stated = model.provenance()["parameters"].as_array().into_iter().flatten();
    let read = |row: &Value| {
        let given = row["name"].as_str()?;
        let (name, unit, what) = known.iter().find(|(name, unit, _)| given == format!("{name} {unit}").trim_end())?;
        let value = row["value"].as_f64().filter(|value| *value != 0.0)?;
        let unit = if *unit == "[Hz]" { " Hz" } else { "" };
        let error = row["error"].as_f64().unwrap_or(f64::INFINITY);
        Some(Uncertain { name: name.clone(), unit: unit.into(), value, error, what: *what })
    };
    stated.filter_map(read).collect()
}

/// Standard deviation of the output's noise [unit of the output]: as the verdict states it, otherwise its error.
pub(super) fn noise(model: &Model) -> Option<f64> {
    let verdict = model.verdict()?;
    let percent = verdict.noise_percent.filter(|noise| *noise > 0.0).unwrap_or(verdict.error_percent);
    let held = |u: f64| model.step(&mut model.settled(u), u);
    let range = (held(verdict.u[1]) - held(verdict.u[0])).abs();
    Some(0.01 * percent * range).filter(|sigma| *sigma > 0.0 && sigma.is_finite())
}

/// The Fisher information of a record along the input `u` about a parameter, with noise of standard deviation `sigma`.
pub(super) fn information(model: &Model, of: &Uncertain, u: &[f64], sigma: f64) -> Result<f64, Error> {
    let step = STEP * of.value.abs();
    let run = |value: f64| -> Result<Vec<f64>, Error> {
        let moved = of.moved(model, value)?;
        let mut x = moved.before(u, InitialCondition::Settled);
        Ok(moved.resume(&mut x, u))
    };
    let (above, below) = (run(of.value + step)?, run(of.value - step)?);
    let slope: Vec<f64> = above.iter().zip(&below).map(|(a, b)| (a - b) / (2.0 * step)).collect();
    let mean = mean(&slope);
    Ok(slope.iter().map(|j| (j - mean) * (j - mean)).sum::<f64>() / (sigma * sigma))
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
    let modulus = (-damping * w).exp();
    let (p, r) = (-2.0 * modulus * (w * (1.0 - damping * damping).sqrt()).cos(), modulus * modulus);
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
