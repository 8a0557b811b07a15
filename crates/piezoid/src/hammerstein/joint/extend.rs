//! Extensions of the linear block: a pole, a pair of poles, or one more coefficient of the numerator.
//!
//! ```text
//! B/A = B P / A P,    P = 1 - p q^-1   or   1 - 2 Re(p) q^-1 + |p|^2 q^-2
//! ```
//! The extended block is at first the same block, so a refinement from there cannot be worse. Where p helps most is
//! seen in the responses to z, which is held: for each p of a grid, and for the modes of free decays, the least-squares
//! problem in all coefficients and initial states is linear. The best of each kind is refined on these responses.

use super::estimate::{Estimate, Responses};
use super::refine::{Fitted, Iterate, StepCallback, refine};
use super::runs::TrainingRecord;
use super::solve::FreeParameters;
use crate::creep::Creep;
use crate::error::Error;
use crate::hammerstein::InitialCondition;
use crate::hysteresis::Proportional;
use crate::linear::{Arx, Pole};
use crate::number::short;
use crate::record::Record;
use crate::series::dot;
use crate::system::System;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Ratio of neighbouring time constants, and of neighbouring frequencies, of the grids.
const LAGS: f64 = 2.0;
const MODES: f64 = 1.3;

/// Number of extensions that are refined together with the hysteresis.
const REFINED: usize = 1;

/// Ratio of squared errors up to which an extension is refined beside the best.
const ALIKE: f64 = 1.2;

/// Damping of the modes of the grid.
const DAMPING: [f64; 2] = [0.03, 0.2];

/// The highest frequency of a mode, over the sampling rate.
const HIGHEST: f64 = 0.45;

/// Cycles of a mode in the longest record.
const CYCLES: f64 = 10.0;

/// An extended linear block.
pub(super) struct Extension {
    /// What was added.
    pub(super) name: String,
    pub(super) linear: Arx,
}

/// The responses of the linear block: the records with z in place of u.
struct Hidden {
    record: Record,
    /// z before the record, for one in motion.
    before: Vec<f64>,
}

/// The best extension of each kind of the linear block of `fitted`. `slowest` is the frequency of the slowest lag [Hz];
/// `modes` are those seen in free decays.
pub(super) fn extensions(
    fitted: &Fitted,
    runs: &[TrainingRecord],
    modes: &[Pole],
    slowest: f64,
    least: f64,
    most: usize,
    watch: StepCallback,
) -> Result<Vec<Extension>, Error> {
    let linear = &fitted.estimate.linear;
    let (ts, order) = (linear.ts(), linear.a().len());
    let hidden = runs.iter().zip(&fitted.own).map(|(run, own)| hidden(&fitted.estimate, run, own));
    let hidden: Vec<Hidden> = hidden.collect::<Result<_, _>>()?;
    let mut responses: Vec<_> = hidden.iter().zip(runs).map(|(z, run)| TrainingRecord::of_hidden(z, run)).collect();
    let estimate = |linear: Arx| -> Result<Estimate, Error> {
        Ok(Estimate::new(None, Box::new(Proportional::new(ts, 1.0)?), Vec::new(), linear))
    };
    let longest = runs.iter().map(|run| run.record.duration()).fold(0.0, f64::max);
    let slower = 1.0 / (TAU * slowest);
    let lags = std::iter::successors(Some(0.5 * ts), |tau| Some(LAGS * tau)).take_while(|tau| *tau < slower);
    let lags = lags.map(|tau| (format!("a lag of {} s", short(tau)), vec![1.0, -(-ts / tau).exp()]));
    let frequencies = std::iter::successors(Some(HIGHEST / ts), |hz| Some(hz / MODES));
    let frequencies = frequencies.take_while(|hz| *hz > least.max(CYCLES / longest));
    let grid = frequencies.flat_map(|hz| DAMPING.map(|damping| (hz, damping)));
    let pair = |(hz, damping): (f64, f64)| {
        let (radius, angle) = ((-damping * TAU * hz * ts).exp(), TAU * hz * ts * (1.0 - damping * damping).sqrt());
        (format!("a mode of {} Hz", short(hz)), vec![1.0, -2.0 * radius * angle.cos(), radius * radius])
    };
    let seen = modes.iter().map(|mode| {
        let (re, norm) = (mode.z.re, mode.z.modulus().powi(2));
        (format!("a mode of {} Hz, seen in free decays", short(mode.hz)), vec![1.0, -2.0 * re, norm])
    });
    let mut kinds: Vec<Vec<(String, Arx)>> = Vec::new();
    let with = |(name, factor): (String, Vec<f64>)| -> Option<(String, Arx)> {
        let a = times(&linear.denominator(), &factor);
        Some((name, Arx::new(ts, a[1..].iter().map(|a| -a).collect(), times(linear.b(), &factor)).ok()?))
    };
    if order < most {
        // A lag acts like a delay of its time constant.
        let (delay, b) = (linear.delay(), linear.b());
        let instead = |(name, factor): &(String, Vec<f64>)| -> Option<(String, Arx)> {
            let a = times(&linear.denominator(), factor);
            let b = b[delay..].iter().map(|b| b * (1.0 + factor[1])).collect();
            let arx = Arx::new(ts, a[1..].iter().map(|a| -a).collect(), b).ok()?;
            Some((format!("{name} instead of a delay"), arx))
        };
        let lags: Vec<_> = lags.collect();
        if delay > 0 {
            kinds.push(lags.iter().filter_map(instead).collect());
        }
        kinds.push(lags.into_iter().filter_map(with).collect());
    }
    if order + 2 <= most {
        kinds.push(grid.map(pair).filter_map(with).collect());
        kinds.extend(seen.filter_map(with).map(|one| vec![one]));
    }
    let longer = [linear.b(), &[1e-9 * linear.b().iter().sum::<f64>()]].concat();
    kinds.push(vec![("one more coefficient".into(), Arx::new(ts, linear.a().to_vec(), longer)?)]);
    let mut found = Vec::new();
    for kind in kinds {
        let score = |one: &(String, Arx)| estimate(one.1.clone()).map_or(f64::INFINITY, |e| predicted(e, &responses));
        let scores: Vec<f64> = if kind.len() > 1 { kind.par_iter().map(score).collect() } else { vec![0.0; kind.len()] };
        let best = scores.iter().zip(kind).min_by(|p, q| p.0.total_cmp(q.0));
        let Some((_, (name, linear))) = best else { continue };
        let alone = refine(estimate(linear)?, &mut responses, FreeParameters::All, watch)?;
        if std::env::var_os("PZ_DEBUG").is_some() {
            eprintln!("   {name}: {:.6} {:?}", 100.0 * (alone.residuals.iter().sum::<f64>() / alone.residuals.len() as f64).sqrt(),
            alone.estimate.linear.poles().iter().map(|p| (p.hz, p.damping)).collect::<Vec<_>>());
        }
        let left = alone.residuals.iter().sum::<f64>();
        found.push((left, Extension { name, linear: alone.estimate.linear }));
    }
    found.sort_by(|p, q| p.0.total_cmp(&q.0));
    let least = found.first().map_or(0.0, |best| best.0);
    found.truncate(REFINED);
    found.retain(|one| one.0 < ALIKE * least);
    Ok(found.into_iter().map(|(_, extension)| extension).collect())
}

/// The cost at the solution of the linearised problem.
fn predicted(estimate: Estimate, runs: &[TrainingRecord]) -> f64 {
    Iterate::at(estimate, runs, &[]).predicted()
}

/// The responses of the linear block in a run: z with its creep, about the level at which it is settled, and y without
/// drift.
fn hidden(estimate: &Estimate, run: &TrainingRecord, own: &[f64]) -> Result<Hidden, Error> {
    let (_, level) = Responses::before(estimate, run);
    let level = dot(&level, &estimate.weights);
    let mut responses = Responses::from_rest(estimate, run);
    let moving = run.moving();
    let z = run.before[1..].iter().chain(run.record.u()).map(|&u| dot(responses.next(u), &estimate.weights) - level);
    let z: Vec<f64> = z.skip(run.before.len() - 1 - moving).collect();
    let creep = Creep::new(estimate.ts(), estimate.lags.clone())?;
    let mut crept = creep.simulate(&z);
    let before: Vec<f64> = crept.drain(..moving).collect();
    for (k, lag) in estimate.lags.iter().enumerate() {
        let stays = (-estimate.ts() / lag.tau_s).exp();
        let mut began = own[k];
        for z in &mut crept {
            began *= stays;
            *z += began;
        }
    }
    let n = crept.len();
    let rise = own.last().map_or(0.0, |trend| trend / n as f64);
    let y = run.bridged().iter().enumerate().map(|(t, y)| y - rise * t as f64).collect();
    Ok(Hidden { record: Record::new(estimate.ts(), crept, y)?, before })
}

impl<'a> TrainingRecord<'a> {
    fn of_hidden(hidden: &'a Hidden, run: &TrainingRecord) -> Self {
        let moving = run.moving() > 0;
        TrainingRecord {
            record: &hidden.record,
            name: run.name.clone(),
            initial: if moving { InitialCondition::Motion } else { InitialCondition::Rest },
            before: [&[0.0], &hidden.before[..]].concat(),
            tried: Vec::new(),
            usable: run.usable.clone(),
            segments: run.segments.clone(),
            ..*run
        }
    }
}

/// The product of two polynomials.
fn times(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; p.len() + q.len() - 1];
    for (i, p) in p.iter().enumerate() {
        q.iter().enumerate().for_each(|(j, q)| product[i + j] += p * q);
    }
    product
}
