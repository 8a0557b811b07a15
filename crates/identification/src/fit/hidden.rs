//! The linear block alone: z, the output of the hysteresis block, is its input.
//!
//! With z held, an estimate has few columns, so its equations cost little.

use super::estimate::Estimate;
use super::fitted::Fitted;
use super::runs::TrainingRecord;
use libm::exp;
use piezoid_models::creep::{Creep, Lag};
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::InitialCondition;
use piezoid_models::hysteresis::Proportional;
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use rayon::prelude::*;
use tracing::trace_span;

/// The inputs of the hysteresis block in a run, behind the driver, substep by substep. The first is the one at which it
/// settles from rest: the first of those before the record.
pub(crate) struct Inputs {
    pub(crate) v: Vec<f64>,
    steps: usize,
}

impl Inputs {
    pub(super) fn of(run: &TrainingRecord, driver: Option<DriverModel>) -> Self {
        let steps = if driver.is_some() { DriverModel::SUBSTEPS } else { 1 };
        let substep = run.record.ts() / steps as f64;
        let mut v = run.before[0];
        let inputs = run.before[1..].iter().chain(run.record.u()).skip(settled(run));
        let behind = inputs.flat_map(|&u| std::iter::repeat_n(u, steps)).map(|u| {
            v = driver.map_or(u, |driver| driver.advance(v, u, substep));
            v
        });
        let mut all = Vec::with_capacity((run.before.len() + run.record.len()) * steps);
        all.push(run.before[0]);
        all.extend(behind);
        Inputs { v: all, steps }
    }

    /// The responses to these inputs in each sample, about the level at which creep and linear block are settled: the
    /// mean over the substeps, by the trapezoidal rule. They begin with the inputs before the record that pass these
    /// blocks.
    pub(crate) fn by_sample(&self, responses: &[f64], run: &TrainingRecord) -> Vec<f64> {
        let steps = self.steps;
        let at = |t: usize| match t.saturating_sub(settled(run)) * steps {
            0 => responses[0],
            last if steps == 1 => responses[last],
            last => (last + 1 - steps..=last).map(|k| 0.5 * (responses[k - 1] + responses[k]) / steps as f64).sum(),
        };
        let (moving, before) = (run.moving, run.before.len());
        let level = match run.initial {
            InitialCondition::Rest => 0.0,
            InitialCondition::Motion => (before - moving..before).map(at).sum::<f64>() / moving as f64,
            _ => responses[(before - 1).saturating_sub(settled(run)) * steps],
        };
        (before - moving..before + run.record.len()).map(|t| at(t) - level).collect()
    }
}

/// The number of samples that are no step: the first one, if it is the one at which a record is settled.
fn settled(run: &TrainingRecord) -> usize {
    usize::from(run.initial == InitialCondition::Settled)
}

/// z in a run.
pub(crate) struct Hidden {
    /// z about the level at which the block is settled, and y.
    pub(crate) record: Record,
    /// z before the record, for one in motion.
    pub(super) before: Vec<f64>,
}

impl Hidden {
    /// z of each run.
    pub(crate) fn of_all(estimate: &Estimate, runs: &[TrainingRecord]) -> Result<Vec<Self>, Error> {
        let _span = trace_span!("hidden variable").entered();
        let of = |run: &TrainingRecord| {
            let inputs = Inputs::of(run, estimate.driver);
            let z = estimate.basis.output(&estimate.weights, &inputs.v)?;
            let mut z = inputs.by_sample(&z, run);
            let before = z.drain(..run.moving).collect();
            Ok(Hidden { record: Record::new(estimate.ts(), z, run.record.y().to_vec())?, before })
        };
        runs.par_iter().map(of).collect()
    }

    /// z with its creep, and y without drift, for each run of a fit.
    pub(crate) fn crept(fitted: &Fitted, runs: &[TrainingRecord]) -> Result<Vec<Self>, Error> {
        let estimate = &fitted.estimate;
        let of = |((Hidden { record, before }, run), own): ((Hidden, &TrainingRecord), &Vec<f64>)| {
            let creep = Creep::new(estimate.ts(), estimate.lags.clone())?;
            let mut crept = creep.simulate(&[&before, record.u()].concat());
            let before: Vec<f64> = crept.drain(..before.len()).collect();
            // The state of creep comes first in a run's own coefficients, the drift last.
            for (lag, initial) in estimate.lags.iter().zip(own) {
                let stays = exp(-estimate.ts() / lag.tau_s);
                let mut initial = *initial;
                for z in &mut crept {
                    initial *= stays;
                    *z += initial;
                }
            }
            let rise = own.last().map_or(0.0, |trend| trend / crept.len() as f64);
            let y = run.bridged().iter().enumerate().map(|(t, y)| y - rise * t as f64).collect();
            Ok(Hidden { record: Record::new(estimate.ts(), crept, y)?, before })
        };
        Hidden::of_all(estimate, runs)?.into_iter().zip(runs).zip(&fitted.own).map(of).collect()
    }

    /// The run with z in place of u.
    pub(crate) fn run<'a>(&'a self, run: &TrainingRecord) -> TrainingRecord<'a> {
        let moving = !self.before.is_empty();
        TrainingRecord {
            record: &self.record,
            name: run.name.clone(),
            initial: if moving { InitialCondition::Motion } else { InitialCondition::Rest },
            before: [&[0.0], &self.before[..]].concat(),
            moving: self.before.len(),
            whole: None,
            tried: Vec::new(),
            usable: run.usable.clone(),
            segments: run.segments.clone(),
            ..*run
        }
    }

    /// The estimate of these blocks behind z.
    pub(crate) fn alone(lags: Vec<Lag>, linear: Arx) -> Result<Estimate, Error> {
        let basis = Box::new(Proportional::new(linear.ts(), 1.0)?);
        Ok(Estimate { weights: vec![1.0], ..Estimate::new(None, basis, lags, linear) })
    }
}

#[cfg(test)]
mod tests {
    use super::super::estimate::Responses;
    use super::super::runs;
    use super::*;
    use piezoid_models::hysteresis::{BasisDesign, OPERATORS};
    use piezoid_numerics::series::dot;

    #[test]
    fn z_is_the_weighted_sum_of_the_responses_from_every_initial_condition() {
        let u: Vec<f64> = (0..300).map(|t| 12.0 + 20.0 * (0.05 * f64::from(t)).sin()).collect();
        let records = [Record::new(5e-4, u.clone(), u).unwrap()];
        let range = (-8.0, 32.0);
        for row in OPERATORS {
            for driver in [None, Some(DriverModel::new(1e-3, None).unwrap())] {
                let ts = if driver.is_some() { 5e-4 / DriverModel::SUBSTEPS as f64 } else { 5e-4 };
                let design = BasisDesign { ts, range, elements: Some(4), frequencies: vec![5.0, 16.0] };
                let basis = (row.basis)(&design).unwrap();
                let weights = (0..basis.len()).map(|k| 1.0 + 0.5 * (1.7 * k as f64).sin()).collect();
                let gain = Arx::gain(5e-4, 1.0).unwrap();
                let estimate = Estimate { weights, ..Estimate::new(driver, basis, Vec::new(), gain) };
                let mut runs = runs::training_records(&[], &records, &mut Vec::new()).unwrap();
                for initial in InitialCondition::of(records[0].u()) {
                    runs[0].start_from(initial, range);
                    let hidden = Hidden::of_all(&estimate, &runs).unwrap();
                    let run = &runs[0];
                    let level = dot(&Responses::level(&estimate, run), &estimate.weights);
                    let mut responses = Responses::from_rest(&estimate, run);
                    let inputs = run.before[1..].iter().chain(run.record.u());
                    let z: Vec<f64> = inputs.map(|&u| dot(responses.next(u), &estimate.weights) - level).collect();
                    let z = &z[run.before.len() - 1..];
                    let size = z.iter().fold(0.0f64, |size, z| size.max(z.abs()));
                    let largest = hidden[0].record.u().iter().zip(z).fold(0.0f64, |d, (p, q)| d.max((p - q).abs()));
                    assert!(largest <= 1e-9 * size, "{} {initial:?}: {largest:e} of {size}", row.name);
                }
            }
        }
    }
}
