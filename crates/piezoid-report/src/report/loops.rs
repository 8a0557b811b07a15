//! Loops of output over input, measured and in free run, and beside them what a straight line leaves of them.

use super::cycles::{self, Drawn};
use crate::each::Each;
use crate::hysteresis_part::StraightLine;
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::Record;
use piezoid_verbs::Compared;
use std::ops::Range;

/// A free run to draw: its name, its samples, and the style of its lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct FreeRun<'a> {
    pub(super) name: &'a str,
    pub(super) y: &'a [f64],
    pub(super) role: Role,
    pub(super) dashes: usize,
}

/// The sample of the largest residual.
pub(super) fn worst(trial: &Compared) -> usize {
    let Compared { record, validation, .. } = trial;
    let error = |k: usize| (record.y()[k] - validation.simulated[k]).abs();
    (validation.start..record.len()).max_by(|&i, &j| error(i).total_cmp(&error(j)).then(j.cmp(&i))).unwrap_or_default()
}

/// Both figures, and words for the caption: which loops are drawn. `None` if the record has none after sample `start`.
pub(super) fn figures(record: &Record, start: usize, about: usize, runs: &[FreeRun]) -> Option<([Figure; 2], String)> {
    let (units, u) = (record.units(), record.u());
    let Drawn { parts, words } = cycles::loops(record, start, about)?;
    let lines = parts.iter().map(|part| StraightLine::through(&u[part.clone()], &record.y()[part.clone()]));
    let lines: Vec<StraightLine> = lines.collect();
    // The parts with gaps between them.
    let joined = |of: &dyn Fn(usize, Range<usize>) -> Vec<f64>| {
        let each = parts.iter().enumerate().flat_map(|(k, part)| of(k, part.clone()).into_iter().chain([f64::NAN]));
        each.collect::<Vec<f64>>()
    };
    let x = joined(&|_, part| u[part].to_vec());
    let whole = |y: &[f64]| joined(&|_, part| y[part].to_vec());
    let rest = |y: &[f64]| joined(&|k, part| lines[k].taken_from(&u[part.clone()], &y[part]));
    let panel = |title: &str, label: &str, of: &dyn Fn(&[f64]) -> Vec<f64>| {
        let line = |run: &FreeRun| Series::line(&x, &of(run.y)).role(run.role).dashes(run.dashes).named(run.name);
        let axes = Axes::new(Axis::new(format!("u [{}]", units.u)), Axis::new(format!("{label} [{}]", units.y)))
            .titled(title)
            .with(Series::wide(&x, &of(record.y())).named("measured"))
            .each(runs.iter().map(line), Axes::with);
        Figure::new(title, "").medium().panel(axes)
    };
    Some(([panel("loops", "y", &whole), panel("without the straight line", "y − line", &rest)], words))
}
