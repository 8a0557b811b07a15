//! The free run, from the beginning that the first part of a record makes likely.

use crate::hammerstein::{InitialCondition, Model};
use crate::record::Record;
use crate::series::mean;
use crate::system::System;

/// Share of a record that tells how it began.
const FIRST: f64 = 0.1;

/// Share of the squared error of a likelier beginning that a less likely one must stay below.
const CLEARLY: f64 = 0.8;

/// The free run from the beginning that leaves least of the first part of the record, in its unit: the input alone does not
/// tell what the actuator did before.
pub(super) fn free_run_from(model: &Model, record: &Record, k: f64, free_offset: bool) -> (Vec<f64>, InitialCondition) {
    let u = record.u();
    let part = (u.len() as f64 * FIRST).ceil() as usize;
    let left = |initial_condition: InitialCondition| {
        let simulated = model.resume(&mut model.before(u, initial_condition), &u[..part]);
        let e: Vec<f64> = record.y().iter().zip(&simulated).map(|(y, s)| y - k * s).collect();
        let offset = if free_offset { mean(&e) } else { 0.0 };
        e.iter().map(|e| (e - offset).powi(2)).sum::<f64>()
    };
    let [likely, others @ ..] =
        InitialCondition::of(u).map(|initial_condition| (left(initial_condition), initial_condition));
    let (_, initial_condition) =
        others.into_iter().fold(likely, |best, one| if one.0 < CLEARLY * best.0 { one } else { best });
    let simulated = model.resume(&mut model.before(u, initial_condition), u);
    (simulated.into_iter().map(|y| k * y).collect(), initial_condition)
}
