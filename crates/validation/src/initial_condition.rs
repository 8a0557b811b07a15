//! The free run from the initial condition that fits the first part of a record.
//!
//! Why: docs/decisions/initial-conditions.md, "Six initial conditions are tried, and the one used is named".

use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_numerics::series::mean;
use piezoid_records::record::Record;

/// Share of a record, and of the path of its input, that determines the initial condition: before the input moves, all
/// are alike.
const FIRST_PART_SHARE: f64 = 0.1;

/// A less likely initial condition is used if its squared error is below this share of that of the likelier.
const MAX_ERROR_RATIO: f64 = 0.8;

/// The free run from the initial condition with the smallest error in the first part of the record, in its unit: the
/// input alone does not determine it. Only the first `known` outputs count.
pub(super) fn free_run_from(
    model: &Model,
    record: &Record,
    known: usize,
    k: f64,
    free_offset: bool,
) -> (Vec<f64>, InitialCondition) {
    let u = record.u();
    let path = u.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
    let initial_condition = likeliest(model, (u, &record.y()[..known.min(u.len())]), (u.len(), path), k, free_offset);
    let simulated = model.follow(&mut model.before(u, initial_condition), u);
    (simulated.into_iter().map(|y| k * y).collect(), initial_condition)
}

/// The initial condition with the smallest error in the first part of a record of `n` samples, whose input moves along
/// this `path`; `u` and `y` are as many of its samples as are held.
pub(super) fn likeliest(
    model: &Model,
    (u, y): (&[f64], &[f64]),
    (n, all): (usize, f64),
    k: f64,
    free_offset: bool,
) -> InitialCondition {
    let enough = FIRST_PART_SHARE * all;
    let mut path = 0.0;
    let before_enough = u.windows(2).map(|w| (w[1] - w[0]).abs()).take_while(|step| {
        path += step;
        path < enough
    });
    let part = (before_enough.count() + 2).max((n as f64 * FIRST_PART_SHARE).ceil() as usize);
    let part = part.min(u.len()).min(y.len());
    let error = |initial_condition: InitialCondition| {
        let simulated = model.follow(&mut model.before(u, initial_condition), &u[..part]);
        let e: Vec<f64> = y.iter().zip(&simulated).map(|(y, s)| y - k * s).collect();
        let offset = if free_offset { mean(&e) } else { 0.0 };
        e.iter().map(|e| (e - offset).powi(2)).sum::<f64>()
    };
    let [likely, others @ ..] = InitialCondition::of(u).map(|condition| (error(condition), condition));
    let (_, initial_condition) =
        others.into_iter().fold(likely, |best, one| if one.0 < MAX_ERROR_RATIO * best.0 { one } else { best });
    initial_condition
}
