//! Parts of long records, in which is searched: most decisions need not all samples.
//!
//! Each run has its own initial states and trend in a fit. Therefore parts of a record show operator and linear block
//! as well as the whole of it, if they begin with the hysteresis that the inputs before them have left. Only slow creep
//! does not show.
//!
//! Half of the parts of a record are spread evenly over it. The others are those that a gain explains worst: there a
//! sine passes a mode, or a step lets it ring.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "Long records are searched in parts".

use super::runs::TrainingRecord;
use super::windows::WARM_UP;
use piezoid_numerics::error::Error;
use piezoid_numerics::series::{explained, scatter};
use piezoid_records::record::Record;
use std::collections::BTreeSet;
use std::ops::Range;

/// Length of a part [samples], and the number of parts up to which a record is used whole.
const PART: usize = 5_000;
const MIN_PARTS: usize = 2;

/// Parts of runs.
pub(crate) struct Parts(Vec<Part>);

/// A part of a run.
struct Part {
    /// The number of the run, and its samples.
    run: usize,
    samples: Range<usize>,
    record: Record,
}

impl Parts {
    /// Parts with about so many large-signal samples together, if there are more than `most`; small-signal records are
    /// used whole.
    ///
    /// # Errors
    /// The error of a record that is not one.
    pub(crate) fn of(runs: &[TrainingRecord], most: usize, samples: usize) -> Result<Self, Error> {
        let total: usize = runs.iter().filter(|run| run.large_signal).map(|run| run.record.len()).sum();
        let mut parts = Vec::new();
        for (run, TrainingRecord { record, large_signal, .. }) in runs.iter().enumerate() {
            let is_whole = !large_signal || total <= most;
            let count = if is_whole { usize::MAX } else { (record.len() * samples / total).div_ceil(PART) };
            for samples in selected(record, count.max(MIN_PARTS)) {
                parts.push(Part { run, record: record.slice(samples.clone())?, samples });
            }
        }
        Ok(Parts(parts))
    }

    /// The parts as runs; those later in a run begin after the inputs before them.
    pub(crate) fn runs<'a>(&'a self, runs: &'a [TrainingRecord<'a>], range: (f64, f64)) -> Vec<TrainingRecord<'a>> {
        let of = |Part { run, samples, record }: &'a Part| {
            let run = &runs[*run];
            let part = TrainingRecord { record, whole: Some(run), ..run.within(samples) };
            match samples.start {
                0 => part.starting_from(run.initial, range),
                start => {
                    let (past, last) = run.record.u()[..start].split_at(start - WARM_UP.min(start));
                    part.later_part([&extremes(past)[..], last].concat(), last.len().min(record.len()))
                }
            }
        };
        self.0.iter().map(of).collect()
    }
}

/// The samples of so many parts of a record, neighbours joined; the first begins with the record.
fn selected(record: &Record, count: usize) -> Vec<Range<usize>> {
    let (n, cells) = (record.len(), record.len() / PART);
    if count >= cells {
        return std::iter::once(0..n).collect();
    }
    let samples = |cell: usize| cell * n / cells..(cell + 1) * n / cells;
    let even = count.div_ceil(2);
    let mut selected: BTreeSet<usize> = (0..even).map(|k| k * (cells - 1) / (even - 1).max(1)).collect();
    // What a gain and a constant leave of y.
    let unexplained = |cell: usize| {
        let (u, y) = (&record.u()[samples(cell)], &record.y()[samples(cell)]);
        // A held input explains nothing.
        scatter(y) * (1.0 - explained(u, y).max(0.0))
    };
    let others = (0..cells).filter(|cell| !selected.contains(cell));
    let mut others: Vec<_> = others.map(|cell| (unexplained(cell), cell)).collect();
    others.sort_by(|p, q| q.0.total_cmp(&p.0));
    selected.extend(others.iter().take(count - even).map(|(_, cell)| *cell));
    let selected: Vec<usize> = selected.into_iter().collect();
    let joined = selected.chunk_by(|cell, next| cell + 1 == *next);
    joined.map(|cells| samples(cells[0]).start..samples(cells[cells.len() - 1]).end).collect()
}

/// The inputs that determine what hysteresis remembers of `u`, if it wipes out minor loops: from the largest on, each
/// the largest or the smallest after the one before it.
fn extremes(u: &[f64]) -> Vec<f64> {
    let Some(&last) = u.last() else { return Vec::new() };
    let (mut low, mut high) = (last, last);
    let mut extremes = vec![last];
    // From the last on: a new extreme replaces one of the same kind.
    let mut was_high = None;
    for &now in u.iter().rev().filter(|now| now.is_finite()) {
        let is_high = now > high;
        if is_high || now < low {
            if was_high == Some(is_high) {
                extremes.pop();
            }
            extremes.push(now);
            was_high = Some(is_high);
        }
        (low, high) = (low.min(now), high.max(now));
    }
    extremes.reverse();
    extremes
}

#[cfg(test)]
mod tests {
    use super::super::free_run::free_run_residual;
    use super::super::hidden::Hidden;
    use super::super::runs::training_records;
    use super::super::testing::estimate;
    use super::*;
    use piezoid_testing::assert_close;

    /// A path of major and minor loops; its output rings after sample 33 000.
    fn record(n: usize) -> Record {
        let part = |t: f64| (6e-4 * t).sin() * (0.3 + 0.7 * (5e-5 * t).cos().abs()) + 0.1 * (0.011 * t).sin();
        let u: Vec<f64> = (0..n).map(|t| 25.0 * part(t as f64)).collect();
        let ringing = |t: usize| if t > 33_000 { 5.0 * (-1e-3 * (t - 33_000) as f64).exp() } else { 0.0 };
        let y = u.iter().enumerate().map(|(t, u)| u + ringing(t) * (0.3 * t as f64).cos()).collect();
        Record::new(1e-4, u, y).unwrap()
    }

    #[test]
    fn parts_are_the_beginning_the_end_and_what_a_gain_explains_worst() {
        let of = |lengths: &[usize], samples: usize| {
            let records: Vec<Record> = lengths.iter().map(|n| record(*n)).collect();
            let runs = training_records(&[], &records, &mut Vec::new()).unwrap();
            let parts = Parts::of(&runs, 50_000, samples).unwrap();
            parts.0.into_iter().map(|part| (part.run, part.samples)).collect::<Vec<_>>()
        };
        assert_eq!(of(&[40_000, 9000], 15_000), [(0, 0..40_000), (1, 0..9000)]);
        assert_eq!(of(&[60_000, 9000], 15_000), [(0, 0..5000), (0, 30_000..35_000), (0, 55_000..60_000), (1, 0..9000)]);
        assert_eq!(of(&[60_000], 20_000)[1], (0, 30_000..40_000), "neighbours are joined");
    }

    #[test]
    fn a_later_part_begins_with_the_hysteresis_that_the_inputs_before_it_have_left() {
        let records = [record(60_000)];
        let runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let parts = Parts::of(&runs, 0, 15_000).unwrap();
        let estimate = estimate("preisach", 12);
        let of_whole = &Hidden::of_all(&estimate, &runs).unwrap()[0].record;
        let runs = parts.runs(&runs, (-25.0, 25.0));
        let of_parts = Hidden::of_all(&estimate, &runs).unwrap();
        for (Part { samples, .. }, of_part) in parts.0.iter().zip(&of_parts) {
            let (z, whole) = (of_part.record.u(), &of_whole.u()[samples.clone()]);
            // About another level.
            let about_first = |z: &[f64]| z.iter().map(|v| v - z[0]).collect::<Vec<_>>();
            assert_close(&about_first(z), &about_first(whole), 1e-9, 1e-9);
        }
        assert_eq!(runs.iter().map(|run| run.is_later_part).collect::<Vec<_>>(), [false, true, true]);
    }

    #[test]
    fn the_free_run_of_a_part_is_that_of_its_record() {
        let records = [record(60_000)];
        let runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let parts = Parts::of(&runs, 0, 15_000).unwrap();
        let model = estimate("prandtl-ishlinskii", 6).model(0.0).unwrap();
        assert_eq!(
            free_run_residual(&parts.runs(&runs, (-25.0, 25.0))[0], &model),
            free_run_residual(&runs[0], &model)
        );
    }

    #[test]
    fn extremes_are_those_that_later_inputs_have_not_passed() {
        assert_eq!(extremes(&[0.0, 9.0, 1.0, 5.0, -3.0, 4.0, 1.0, 3.0, 2.0]), [9.0, -3.0, 4.0, 1.0, 3.0, 2.0]);
        assert_eq!(extremes(&[3.0, 1.0, 2.0, 7.0]), [1.0, 7.0]);
        assert_eq!(extremes(&[]), [0.0; 0]);
        // What plays remember of them is what they remember of the whole path.
        let path = record(20_000);
        let pi = (piezoid_models::hysteresis::Operator::find("prandtl-ishlinskii").unwrap().example)(1e-4).unwrap();
        let last = |u: &[f64]| *pi.simulate(u).last().unwrap();
        assert_close(&[last(&extremes(path.u()))], &[last(path.u())], 1e-12, 0.0);
    }
}
