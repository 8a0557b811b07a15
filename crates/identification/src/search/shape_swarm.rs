//! A swarm over the shape of the operator, where the problem is not convex, on part of the data.
//!
//! For each shape the weights are optimal, so the swarm has one dimension per shape parameter. Its result is only the
//! start of the refinement.

use super::POLICY;
use super::fit::{Estimate, FreeParameters, Prior, TrainingRecord, equations, products};
use libm::pow;
use piezoid_models::hammerstein::InitialCondition;
use piezoid_models::hysteresis::ShapeParameter;
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::{Bounds, swarm};
use piezoid_numerics::progress::Stage;
use piezoid_records::record::Record;

/// Smoothness weight and damping of the fits: only the order of the shapes matters.
const SMOOTHNESS_WEIGHT: f64 = 1e-6;
const DAMPING: f64 = 1e-6;

/// The estimate with the best shape of a swarm and unknown weights; `None` if there is nothing to search.
pub(super) fn best_shape(estimate: &Estimate, runs: &[TrainingRecord], seed: u64) -> Result<Option<Estimate>, Error> {
    let shape = estimate.basis.shape();
    if shape.is_empty() || shape.len() > POLICY.swarm_parameters {
        return Ok(None);
    }
    let large_signal: Vec<&TrainingRecord> = runs.iter().filter(|run| run.large_signal).collect();
    let each = POLICY.swarm_samples / large_signal.len().max(1);
    // The ends, where rising amplitudes are largest.
    let from = |run: &TrainingRecord| run.record.len().saturating_sub(each);
    let end = |run: &&TrainingRecord| run.record.slice(from(run)..run.record.len());
    let parts: Vec<Record> = large_signal.iter().map(end).collect::<Result<_, _>>()?;
    let part = |(part, run): (_, &&TrainingRecord)| {
        let end = TrainingRecord::new(part, &run.name, true, run.usable[from(run)..].to_vec())?;
        // The largest of rising amplitudes wipe out the memory of the inputs long before.
        let before = [&run.before, &run.record.u()[..from(run)]].concat();
        let before = before[before.len().saturating_sub(each.max(1))..].to_vec();
        let initial = if from(run) > 0 { InitialCondition::Motion } else { run.initial };
        Some(TrainingRecord { drifts: run.drifts, initial, before, ..end })
    };
    let parts: Vec<TrainingRecord> = parts.iter().zip(&large_signal).filter_map(part).collect();

    let at = |x: &[f64]| -> Option<Estimate> {
        let p: Vec<f64> = shape.iter().zip(x).map(|(shape, x)| from_unit(shape, *x)).collect();
        let basis = estimate.basis.reshaped(&p).ok()?;
        Some(estimate.with_basis(basis))
    };
    let cost = |x: &[f64]| -> f64 {
        let Some(estimate) = at(x) else { return f64::INFINITY };
        let segments = products(&estimate, &parts, &[], FreeParameters::Weights);
        let (normal, _) = equations(&estimate, &segments, |_| true);
        let prior = Prior::of(&estimate);
        let mut positive = vec![true; prior.current().len()];
        match prior.solve(&normal, SMOOTHNESS_WEIGHT, DAMPING, FreeParameters::Weights, &mut positive) {
            Some(x) => normal.residual(&prior.steps(&x)),
            None => f64::INFINITY,
        }
    };
    let settings = swarm::SwarmSettings {
        particles: POLICY.swarm_particles,
        iterations: POLICY.swarm_iterations,
        seed,
        parallel: true,
        ..swarm::SwarmSettings::default()
    };
    let bounds = Bounds::new(vec![0.0; shape.len()], vec![1.0; shape.len()])?;
    let found = settings.minimise(&cost, bounds, &mut Stage::ignore)?;
    Ok(at(&found.x))
}

/// The shape parameter at a share of its domain, on a logarithmic scale if that is positive.
fn from_unit(shape: &ShapeParameter, share: f64) -> f64 {
    if shape.low > 0.0 {
        shape.low * pow(shape.high / shape.low, share)
    } else {
        shape.low + share * (shape.high - shape.low)
    }
}
