//! The linear block alone: z, the output of the hysteresis block, is its input.
//!
//! With z held, an estimate has few columns, so its equations cost little.

use super::estimate::Estimate;
use super::refine::Fitted;
use super::runs::TrainingRecord;
use crate::creep::{Creep, Lag};
use crate::driver::DriverModel;
use crate::error::Error;
use crate::hammerstein::InitialCondition;
use crate::hysteresis::Proportional;
use crate::linear::Arx;
use crate::record::Record;
use crate::system::System;
use rayon::prelude::*;

/// The inputs of the hysteresis block in a run, behind the driver: the first of those before the record, which is the
/// path from rest, then each substep.
pub(super) struct Inputs {
    pub(super) v: Vec<f64>,
    steps: usize,
}

impl Inputs {
    pub(super) fn of(run: &TrainingRecord, driver: Option<DriverModel>) -> Self {
        let steps = if driver.is_some() { DriverModel::SUBSTEPS } else { 1 };
        let substep = run.record.ts() / steps as f64;
        let mut v = run.before[0];
        let inputs = run.before[1..].iter().chain(run.record.u()).flat_map(|&u| std::iter::repeat_n(u, steps));
        let behind = inputs.map(|u| {
            v = driver.map_or(u, |driver| driver.advance(v, u, substep));
            v
        });
        Inputs { v: std::iter::once(run.before[0]).chain(behind).collect(), steps }
    }

    /// The responses to these inputs as the mean of each sample, by the trapezoidal rule, about the level at which
    /// creep and linear block are settled; from the inputs before the record on that pass them.
    pub(super) fn by_sample(&self, responses: &[f64], run: &TrainingRecord) -> Vec<f64> {
        let steps = self.steps;
        let at = |t: usize| {
            let last = t * steps;
            let mean = |k: usize| 0.5 * (responses[k - 1] + responses[k]) / steps as f64;
            if steps == 1 { responses[last] } else { (last + 1 - steps..=last).map(mean).sum() }
        };
        let (moving, before) = (run.moving(), run.before.len());
        let level = match run.initial {
            InitialCondition::Rest => 0.0,
            InitialCondition::Motion => (before - moving..before).map(at).sum::<f64>() / moving as f64,
            _ => responses[(before - 1) * steps],
        };
        (before - moving..before + run.record.len()).map(|t| at(t) - level).collect()
    }
}

/// z in a run.
pub(super) struct Hidden {
    /// z about the level at which the block is settled, and y.
    pub(super) record: Record,
    /// z before the record, for one in motion.
    before: Vec<f64>,
}

impl Hidden {
    /// z of each run.
    pub(super) fn of_all(estimate: &Estimate, runs: &[TrainingRecord]) -> Result<Vec<Self>, Error> {
        let of = |run: &TrainingRecord| {
            let inputs = Inputs::of(run, estimate.driver);
            let z = estimate.basis.operator(&estimate.weights)?.simulate(&inputs.v);
            let mut z = inputs.by_sample(&z, run);
            let before = z.drain(..run.moving()).collect();
            Ok(Hidden { record: Record::new(estimate.ts(), z, run.record.y().to_vec())?, before })
        };
        runs.par_iter().map(of).collect()
    }

    /// z with its creep, and y without drift, for each run of a fit.
    pub(super) fn crept(fitted: &Fitted, runs: &[TrainingRecord]) -> Result<Vec<Self>, Error> {
        let estimate = &fitted.estimate;
        let of = |((Hidden { record, before }, run), own): ((Hidden, &TrainingRecord), &Vec<f64>)| {
            let creep = Creep::new(estimate.ts(), estimate.lags.clone())?;
            let mut crept = creep.simulate(&[&before, record.u()].concat());
            let before: Vec<f64> = crept.drain(..before.len()).collect();
            // The state of creep comes first in a run's own coefficients, the drift last.
            for (lag, began) in estimate.lags.iter().zip(own) {
                let stays = (-estimate.ts() / lag.tau_s).exp();
                let mut began = *began;
                for z in &mut crept {
                    began *= stays;
                    *z += began;
                }
            }
            let rise = own.last().map_or(0.0, |trend| trend / crept.len() as f64);
            let y = run.bridged().iter().enumerate().map(|(t, y)| y - rise * t as f64).collect();
            Ok(Hidden { record: Record::new(estimate.ts(), crept, y)?, before })
        };
        Hidden::of_all(estimate, runs)?.into_iter().zip(runs).zip(&fitted.own).map(of).collect()
    }

    /// The run with z in place of u.
    pub(super) fn run<'a>(&'a self, run: &TrainingRecord) -> TrainingRecord<'a> {
        let moving = run.moving() > 0;
        TrainingRecord {
            record: &self.record,
            name: run.name.clone(),
            initial: if moving { InitialCondition::Motion } else { InitialCondition::Rest },
            before: [&[0.0], &self.before[..]].concat(),
            tried: Vec::new(),
            usable: run.usable.clone(),
            segments: run.segments.clone(),
            ..*run
        }
    }

    /// The estimate of these blocks behind z.
    pub(super) fn alone(lags: Vec<Lag>, linear: Arx) -> Result<Estimate, Error> {
        let basis = Box::new(Proportional::new(linear.ts(), 1.0)?);
        Ok(Estimate { weights: vec![1.0], ..Estimate::new(None, basis, lags, linear) })
    }
}
