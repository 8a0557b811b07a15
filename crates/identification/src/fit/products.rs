//! The products of the columns of the linearised free-run error with each other and with y, by run and fold.
//!
//! They are summed in blocks of samples, so records may have any length.

use super::columns::{FILTERED_SAMPLES, RunColumns};
use super::estimate::Estimate;
use super::gram::Rows;
use super::layout::ColumnLayout;
use super::runs::TrainingRecord;
use super::solve::FreeParameters;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::collections::BTreeMap;
use tracing::trace_span;

/// Rows per block.
const BLOCK_ROWS: usize = 256;

/// Maximum number of large-signal rows kept of all runs: neighbouring rows have similar information.
const MAX_ROWS: usize = 20_000;

/// Products of the columns with each other and with y, over all samples of a run in one fold.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    /// Index of the run.
    pub(crate) run: usize,
    /// The fold it is held out in; `None` is never held out.
    pub(crate) fold: Option<usize>,
    /// True if its held-out error counts, as for large-signal records.
    pub(crate) judged: bool,
    /// True if its output drifts.
    pub(crate) drifts: bool,
    /// True if the run begins in it: it shows the initial states.
    pub(crate) is_first: bool,
    /// All columns, then y.
    pub(crate) gram: DMatrix<f64>,
    /// Number of usable samples, kept or not.
    pub(crate) samples: f64,
}

impl Segment {
    /// The sum of squares for the parameters `x` and the run's own coefficients.
    pub(crate) fn residual(&self, x: &DVector<f64>, own: &[f64]) -> f64 {
        let n = self.gram.nrows() - 1;
        let all = DVector::from_iterator(n, x.iter().chain(own).copied());
        let (h, g) = (self.gram.view((0, 0), (n, n)), self.gram.view((0, n), (n, 1)));
        (self.gram[(n, n)] + all.dot(&(h * &all - g * 2.0).column(0))).max(0.0)
    }
}

/// The products of each fold of each run. `own` are the last own coefficients of the runs; empty at first. The
/// columns of the shape are zero if it is not among the `free` parameters. `before` are the products of an estimate
/// that differs in the weights alone; empty if there are none.
pub(crate) fn products(
    estimate: &Estimate,
    runs: &[TrainingRecord],
    own: &[Vec<f64>],
    free: FreeParameters,
    before: &[Segment],
) -> Vec<Segment> {
    let _span = trace_span!("rows", weights = estimate.weights.len()).entered();
    let large_signal: usize = runs.iter().filter(|r| r.large_signal).map(|r| r.record.len()).sum();
    let thin = large_signal.div_ceil(MAX_ROWS).max(1);
    let layout = ColumnLayout::of(estimate);
    let of = |(k, run): (usize, &TrainingRecord)| {
        let own = own.get(k).map_or(&[] as &[f64], Vec::as_slice);
        let columns = RunColumns::new(estimate, run, &layout, own, free);
        let before = before.iter().filter(|segment| segment.run == k).collect();
        of_run(columns, k, if run.large_signal { thin } else { 1 }, before)
    };
    runs.par_iter().enumerate().flat_map_iter(of).collect()
}

fn of_run(mut columns: RunColumns, index: usize, thin: usize, before: Vec<&Segment>) -> Vec<Segment> {
    let run = columns.run;
    columns.pass_earlier_inputs();
    let size = columns.layout.columns() + 1;
    // The columns of the weights do not depend on the weights.
    let known = if before.is_empty() { 0 } else { Rows::whole(columns.layout.weights.len()) };
    let weight = run.scale * run.heavier * (thin as f64).sqrt();
    let selected = kept(run, thin);
    let starts = std::iter::once(0).chain(run.segments.iter().map(|(end, _)| *end));
    let pieces: Vec<_> = starts.zip(&run.segments).map(|(start, (end, fold))| (start..*end, *fold)).collect();
    let mut segments: BTreeMap<Option<usize>, Segment> = BTreeMap::new();
    for (samples, fold) in &pieces {
        let segment = segments.entry(*fold).or_insert_with(|| {
            let (judged, drifts, is_first) = (run.large_signal, run.drifts, samples.start == 0);
            let mut gram = DMatrix::zeros(size, size);
            if let Some(before) = before.iter().find(|before| before.fold == *fold) {
                gram.view_mut((0, 0), (known, known)).copy_from(&before.gram.view((0, 0), (known, known)));
            }
            Segment { run: index, fold: *fold, judged, drifts, is_first, gram, samples: 0.0 }
        });
        segment.samples += run.usable[samples.clone()].iter().filter(|usable| **usable).count() as f64;
    }
    let mut filtered = pieces.iter().flat_map(|(samples, fold)| {
        let of = |from: usize| (from..samples.end.min(from + FILTERED_SAMPLES), *fold);
        samples.clone().step_by(FILTERED_SAMPLES).map(of)
    });
    // Per fold, rows that are not in its products yet.
    let mut open: BTreeMap<Option<usize>, Rows> = BTreeMap::new();
    let mut next_rows = |mut spare: Option<Rows>| {
        for (samples, fold) in filtered.by_ref() {
            let mut empty = || spare.take().unwrap_or_else(|| Rows::new(size, BLOCK_ROWS));
            let rows = open.entry(fold).or_insert_with(&mut empty);
            columns.advance(samples, &selected, weight, rows);
            if rows.room() < FILTERED_SAMPLES {
                return Some((fold, std::mem::replace(rows, empty())));
            }
        }
        open.pop_first()
    };
    let (mut full, mut spare) = (next_rows(None), None);
    while let Some((fold, mut rows)) = full {
        let add = || {
            if let Some(segment) = segments.get_mut(&fold) {
                rows.add_to(&mut segment.gram, known);
            }
        };
        // The next rows are computed beside the products of these.
        (full, ()) = rayon::join(|| next_rows(spare.take()), add);
        spare = Some(rows);
    }
    let whole = |mut segment: Segment| {
        segment.gram.fill_upper_triangle_with_lower_triangle();
        segment
    };
    segments.into_values().map(whole).collect()
}

/// The usable samples of a run that are kept: one of every `thin`, at non-periodic places.
fn kept(run: &TrainingRecord, thin: usize) -> Vec<usize> {
    let golden = |k: usize| ((k as f64 * 0.618_033_988_749_895).fract() * thin as f64) as usize;
    let samples = (0..run.usable.len().div_ceil(thin)).map(|k| thin * k + golden(k));
    samples.filter(|&t| run.usable.get(t) == Some(&true)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::runs::training_records;
    use super::super::testing::{self, TS, full_estimate};
    use super::*;
    use piezoid_models::hysteresis::OPERATORS;
    use piezoid_records::record::Record;

    #[test]
    fn products_are_relative_to_the_level_and_exclude_unusable_samples() {
        let estimate = full_estimate(OPERATORS[0], None);
        let u: Vec<f64> = (0..600).map(|t| 20.0 * (0.1 * f64::from(t)).sin()).collect();
        let sums = |offset: f64, spike: f64| {
            let y = u.iter().enumerate().map(|(t, u)| u + offset + if t == 300 { spike } else { 0.0 }).collect();
            let record = Record::new(TS, u.clone(), y).unwrap();
            let usable = (0..600).map(|t| t != 300).collect();
            let run = TrainingRecord::new(&record, "record", true, usable).unwrap();
            products(&estimate, &[run], &[], FreeParameters::All, &[])[0].gram.clone()
        };
        let plain = sums(0.0, 0.0);
        assert_eq!(plain, sums(0.0, 1e9));
        assert!((&plain - sums(1e6, 0.0)).amax() < 1e-9 * plain.amax());
    }

    #[test]
    fn products_after_a_step_in_the_weights_are_those_of_all_columns() {
        let u: Vec<f64> = (0..600).map(|t| 20.0 * (0.1 * f64::from(t)).sin() * (0.01 * f64::from(t)).sin()).collect();
        let records = [Record::new(TS, u.clone(), u).unwrap()];
        let runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        for name in ["prandtl-ishlinskii", "preisach", "krasnoselskii-pokrovskii"] {
            let start = testing::estimate(name, 20);
            let start = Estimate { weights: vec![0.5; start.weights.len()], ..start };
            let next = Estimate { weights: start.weights.iter().map(|w| w + 0.1).collect(), ..start.clone() };
            let of = |estimate: &Estimate, before: &[Segment]| {
                products(estimate, &runs, &[], FreeParameters::Weights, before)
            };
            let (before, all) = (of(&start, &[]), of(&next, &[]));
            assert!(all.len() > 1 && all[0].gram != before[0].gram, "{name}");
            for (reused, all) in of(&next, &before).iter().zip(&all) {
                assert_eq!((reused.fold, &reused.gram), (all.fold, &all.gram), "{name}");
            }
        }
    }
}
