//! Folds: the parts of the large-signal records that are held out together.
//!
//! A held-out segment is no test if the same path occurs in the training segments. For inputs that wander, and for one
//! that rises, segments of time are a test. If the inputs turn at a few levels again and again, the branches between
//! two levels are held out together, in every record and at every rate, so that the error is that of an unknown path.
//!
//! Why: docs/decisions/identification.md, "Paths are held out".

use super::runs::TrainingRecord;
use piezoid_numerics::series::ends;
use piezoid_records::waveform::reversals;
use std::collections::BTreeMap;

/// Number of segments of a record.
const SEGMENTS: usize = 11;

/// Number of folds.
pub(crate) const FOLDS: usize = 5;

/// Least movement between two reversals, over the range of all inputs.
const MIN_MOVEMENT: f64 = 0.03;

/// Range of levels that are the same, over the range of all inputs.
const SAME_LEVEL_RANGE: f64 = 0.02;

/// Least number of loops that are held out in turn, and of branches of each on average.
const MIN_LOOPS: usize = 3;
const MIN_BRANCHES_PER_LOOP: usize = 2;

/// Largest share of the samples in one fold.
const MAX_FOLD_SHARE: f64 = 0.5;

/// Assigns the folds of the large-signal records. Each fold also has a segment of each small-signal record: its error
/// does not count, but the parameters determined by these records alone get an uncertainty too.
pub(crate) fn fold(runs: &mut [TrainingRecord]) {
    if by_path(runs).is_none() {
        for run in runs.iter_mut().filter(|run| run.large_signal) {
            let n = run.record.len();
            // The first segment shows the state before the record.
            let segment = |s: usize| ((s + 1) * n / SEGMENTS, (s > 0).then_some(s % FOLDS));
            run.segments = (0..SEGMENTS).map(segment).collect();
        }
    }
    let last = runs.iter().flat_map(|run| &run.segments).filter_map(|(_, fold)| *fold).max();
    let folds = last.map_or(1, |last| last + 1);
    for run in runs.iter_mut().filter(|run| !run.large_signal) {
        let n = run.record.len();
        run.segments = (0..folds).map(|fold| ((fold + 1) * n / folds, Some(fold))).collect();
    }
}

/// From one reversal of the input to the next, or to an end of the record.
struct Branch {
    /// Number of samples, and the sample after the last.
    samples: usize,
    end: usize,
    /// The lowest and the highest input, reversals included.
    low: f64,
    high: f64,
}

/// The branches of an input between movements of at least `movement` [input unit].
fn branches(u: &[f64], movement: f64) -> Vec<Branch> {
    let (low, high) = ends(u.iter().copied());
    let turns = reversals(u, movement / (high - low)).into_iter().filter(|turn| (1..u.len() - 1).contains(turn));
    let mut start = 0;
    let branch = |end: usize| {
        let (low, high) = ends(u[start..u.len().min(end + 1)].iter().copied());
        let samples = end - std::mem::replace(&mut start, end);
        Branch { samples, end, low, high }
    };
    turns.chain([u.len()]).map(branch).collect()
}

/// Assigns folds to the branches of the large-signal records; `None` if these do not turn at a few levels again and
/// again. A branch that no other contains is never held out, nor is the first of a record.
fn by_path(runs: &mut [TrainingRecord]) -> Option<()> {
    let inputs: Vec<&[f64]> = runs.iter().filter(|run| run.large_signal).map(|run| run.record.u()).collect();
    let (low, high) = ends(inputs.iter().flat_map(|u| u.iter()).copied());
    let of_all: Vec<Vec<Branch>> = inputs.iter().map(|u| branches(u, MIN_MOVEMENT * (high - low))).collect();
    // Those from one reversal to the next.
    let whole = || of_all.iter().flat_map(|of_one| &of_one[1..of_one.len().max(2) - 1]);
    let mut levels: Vec<f64> = whole().flat_map(|branch| [branch.low, branch.high]).collect();
    levels.sort_by(f64::total_cmp);
    let same = SAME_LEVEL_RANGE * (high - low);
    let groups: Vec<&[f64]> = levels.chunk_by(|p, q| q - p <= same).collect();
    if groups.iter().any(|group| group[group.len() - 1] - group[0] > same) {
        return None;
    }
    let level = |u: f64| groups.partition_point(|group| group[0] <= u + 0.5 * same);
    let between = |branch: &Branch| (level(branch.low), level(branch.high));

    // For each loop, the number of its branches and of their samples.
    let mut loops: BTreeMap<(usize, usize), (usize, usize)> = BTreeMap::new();
    for branch in whole() {
        let (branches, samples) = loops.entry(between(branch)).or_default();
        *branches += 1;
        *samples += branch.samples;
    }
    let is_inside = |(low, high): (usize, usize)| {
        loops.keys().any(|other| *other != (low, high) && other.0 <= low && high <= other.1)
    };
    let mut inner: Vec<(usize, usize)> = loops.keys().copied().filter(|one| is_inside(*one)).collect();
    let branches: usize = inner.iter().map(|one| loops[one].0).sum();
    if inner.len() < MIN_LOOPS || branches < MIN_BRANCHES_PER_LOOP * inner.len() {
        return None;
    }
    // The longest loops first, each into the smallest fold.
    inner.sort_by_key(|one| (std::cmp::Reverse(loops[one].1), *one));
    let mut sizes = vec![0; inner.len().min(FOLDS)];
    let mut folds: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for one in inner {
        let smallest = (0..sizes.len()).min_by_key(|&fold| sizes[fold])?;
        sizes[smallest] += loops[&one].1;
        folds.insert(one, smallest);
    }
    let samples: usize = inputs.iter().map(|u| u.len()).sum();
    if sizes.iter().any(|size| *size as f64 > MAX_FOLD_SHARE * samples as f64) {
        return None;
    }
    for (run, branches) in runs.iter_mut().filter(|run| run.large_signal).zip(&of_all) {
        let fold = |(k, branch): (usize, &Branch)| (branch.end, folds.get(&between(branch)).copied().filter(|_| k > 0));
        run.segments = branches.iter().enumerate().map(fold).collect();
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::super::runs;
    use super::*;
    use piezoid_records::record::Record;
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
        let runs = runs::training_records(&[], &records, &mut Vec::new()).unwrap();
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
    fn sines_of_several_amplitudes_are_held_out_by_amplitude() {
        let sine = |amplitude: f64, step: f64| (0..2000).map(|t| amplitude * (step * f64::from(t)).sin()).collect();
        let inputs = [(100.0, 0.02), (75.0, 0.02), (50.0, 0.02), (25.0, 0.02), (50.0, 0.07), (25.0, 0.07)];
        let found = segments(&inputs.map(|(amplitude, step)| sine(amplitude, step)));
        let of = |k: usize| found[k].iter().filter_map(|(_, fold)| *fold).collect::<BTreeSet<_>>();
        assert_eq!(of(0), BTreeSet::new(), "the largest amplitude");
        assert_eq!([of(2), of(3)], [of(4), of(5)]);
        assert_eq!([1, 2, 3].map(|k| of(k).len()), [1; 3]);
        assert_eq!(&(&of(1) | &of(2)) | &of(3), BTreeSet::from([0, 1, 2]));
    }

    #[test]
    fn inputs_that_rise_wander_or_have_one_loop_are_divided_in_time() {
        let rising: Vec<f64> = (0..41).map(|k| f64::from(k) * if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let single = [0.0, 100.0].repeat(10);
        let random: Vec<f64> = (0..301).map(|k| 100.0 * (f64::from(k * k) * 0.618_034).fract()).collect();
        for levels in [rising, single, random] {
            let u = through(&levels, 100);
            let folds = &segments(std::slice::from_ref(&u))[0];
            assert_eq!(folds.len(), SEGMENTS);
            assert_eq!(folds[0], (u.len() / SEGMENTS, None));
        }
    }
}
