//! Folds: the parts of the large-signal records that are held out together.
//!
//! A part that is held out tests a fit only if the other parts do not show the same. For inputs that rise or wander,
//! segments of time do. If an input turns at a few levels again and again, segments of time only test the repetition.
//! Then the branches between two levels are held out together, in every record and at every rate, so that the error is
//! that of an unknown path.

use super::runs::TrainingRecord;
use crate::series::ends;
use crate::waveform::reversals;
use std::collections::BTreeMap;

/// Number of segments of a record.
const SEGMENTS: usize = 11;

/// Number of folds.
pub(super) const FOLDS: usize = 5;

/// Least movement between two reversals, over the range of the record.
const MOVEMENT: f64 = 0.03;

/// Distance of two levels, over the range of all inputs, up to which they are the same.
const SAME: f64 = 0.02;

/// Least number of loops that are held out in turn.
const LOOPS: usize = 3;

/// Assigns the folds of the large-signal records. Each fold also has a segment of each small-signal record: its error
/// does not count, but the parameters determined by these records alone get an uncertainty too.
pub(super) fn fold(runs: &mut [TrainingRecord]) {
    for run in runs.iter_mut().filter(|run| run.large_signal) {
        let n = run.record.len();
        // The first segment shows the state before the record.
        let segment = |s: usize| ((s + 1) * n / SEGMENTS, (s > 0).then_some(s % FOLDS));
        run.segments = (0..SEGMENTS).map(segment).collect();
    }
    by_path(runs);
    let last = runs.iter().flat_map(|run| &run.segments).filter_map(|(_, fold)| *fold).max();
    let folds = last.map_or(1, |last| last + 1);
    for run in runs.iter_mut().filter(|run| !run.large_signal) {
        let n = run.record.len();
        run.segments = (0..folds).map(|fold| ((fold + 1) * n / folds, Some(fold))).collect();
    }
}

/// The branches of a record: end, lowest and highest input.
fn branches(u: &[f64]) -> Vec<(usize, f64, f64)> {
    let turns = reversals(u, MOVEMENT).into_iter().filter(|turn| (1..u.len() - 1).contains(turn));
    let mut start = 0;
    let branch = |end: usize| {
        // With both reversals.
        let (low, high) = ends(u[start..u.len().min(end + 1)].iter().copied());
        start = end;
        (end, low, high)
    };
    turns.chain([u.len()]).map(branch).collect()
}

/// Assigns folds to the branches of the large-signal records, if these turn at a few levels again and again. A branch
/// that no other contains is never held out, nor is the first of a record.
fn by_path(runs: &mut [TrainingRecord]) {
    let of_all: Vec<_> = runs.iter().filter(|run| run.large_signal).map(|run| branches(run.record.u())).collect();
    let mut levels: Vec<f64> = of_all.iter().flatten().flat_map(|(_, low, high)| [*low, *high]).collect();
    levels.sort_by(f64::total_cmp);
    let Some(same) = levels.first().zip(levels.last()).map(|(low, high)| SAME * (high - low)) else { return };
    // The first of each group of levels.
    let groups: Vec<f64> = levels.chunk_by(|p, q| q - p <= same).map(|group| group[0]).collect();
    let level = |u: f64| groups.partition_point(|first| *first <= u);
    let between = |low: f64, high: f64| (level(low), level(high));

    // The number of branches of each loop, without the first and the last of a record, which are not whole.
    let mut loops: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (_, low, high) in of_all.iter().flat_map(|of_one| &of_one[1..of_one.len().max(2) - 1]) {
        *loops.entry(between(*low, *high)).or_default() += 1;
    }
    let is_inside = |(low, high): (usize, usize)| {
        loops.keys().any(|other| *other != (low, high) && other.0 <= low && high <= other.1)
    };
    let mut inner: Vec<(usize, usize)> = loops.keys().copied().filter(|one| is_inside(*one)).collect();
    let branches: usize = inner.iter().map(|one| loops[one]).sum();
    if inner.len() < LOOPS || branches < 2 * inner.len() {
        return;
    }
    inner.sort_by_key(|(low, high)| (high - low, *low));
    let folds = inner.len().min(FOLDS);
    for (run, branches) in runs.iter_mut().filter(|run| run.large_signal).zip(&of_all) {
        let fold = |(k, (end, low, high)): (usize, &(usize, f64, f64))| {
            let position = inner.iter().position(|one| *one == between(*low, *high));
            (*end, position.filter(|_| k > 0).map(|position| position % folds))
        };
        run.segments = branches.iter().enumerate().map(fold).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::super::runs;
    use super::*;
    use crate::record::Record;
    use std::collections::BTreeSet;

    /// Straight lines through these levels, `n` samples each.
    fn through(levels: &[f64], n: usize) -> Vec<f64> {
        let line = |w: &[f64]| {
            let (from, to) = (w[0], w[1]);
            (0..n).map(move |t| from + (to - from) * t as f64 / n as f64)
        };
        levels.windows(2).flat_map(line).collect()
    }

    fn segments(inputs: &[Vec<f64>]) -> Vec<Vec<(usize, Option<usize>)>> {
        let records: Vec<Record> = inputs.iter().map(|u| Record::new(1e-3, u.clone(), u.clone()).unwrap()).collect();
        let runs = runs::of(&[], &records, &mut Vec::new()).unwrap();
        runs.into_iter().map(|run| run.segments).collect()
    }

    #[test]
    fn a_path_that_returns_is_held_out_everywhere_at_once() {
        let once = [0.0, 100.0, 40.0, 80.0, 20.0, 60.0];
        let path = [&once[..], &once, &once, &[0.0]].concat();
        let folds = segments(&[through(&path, 50), through(&path, 20)]);
        let ends = |n: usize| (1..=18).map(|k| k * n).collect::<Vec<_>>();
        for (found, n) in folds.iter().zip([50, 20]) {
            assert_eq!(found.iter().map(|(end, _)| *end).collect::<Vec<_>>(), ends(n));
        }
        let of = |found: &[(usize, Option<usize>)]| found.iter().map(|(_, fold)| *fold).collect::<Vec<_>>();
        assert_eq!(of(&folds[0]), of(&folds[1]));
        let folds = of(&folds[0]);
        assert_eq!(folds[..6], folds[6..12]);
        assert_eq!(folds[6], None, "the branch over the whole range");
        assert_eq!(folds[7..12].iter().collect::<BTreeSet<_>>().len(), 5, "{folds:?}");
    }

    #[test]
    fn inputs_that_rise_or_have_one_loop_are_divided_in_time() {
        let rising: Vec<f64> = (0..41).map(|k| f64::from(k) * if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let single = [0.0, 100.0].repeat(10);
        for levels in [rising, single] {
            let u = through(&levels, 100);
            let folds = &segments(std::slice::from_ref(&u))[0];
            assert_eq!(folds.len(), SEGMENTS);
            assert_eq!(folds[0], (u.len() / SEGMENTS, None));
        }
    }
}
