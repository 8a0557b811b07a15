//! Windows of long records: a structure search needs not all samples, because what it looks for is fast.
//!
//! Lags as slow as creep are not part of the linear block, and each record in a fit has its own initial states and
//! trend. Therefore parts of a record show the linear block as well as the whole of it.

use super::hidden::Hidden;
use super::runs::TrainingRecord;
use std::ops::Range;

/// Number of samples up to which a structure search uses all.
const SEARCH_SAMPLES: usize = 20_000;

/// Length of a window, and the least one, unless the record is shorter.
const WINDOW: usize = 5_000;
const MIN_WINDOW: usize = 1_000;

/// Number of inputs before a window that pass the linear block.
pub(super) const WARM_UP: usize = 1_000;

/// A part of a run.
#[derive(Debug, Clone)]
pub(super) struct Window {
    /// The number of the run.
    pub(super) run: usize,
    /// Its samples.
    pub(super) samples: Range<usize>,
    /// The number of samples before it that pass the linear block, those before the record included.
    pub(super) moving: usize,
}

/// The windows of these runs, spread evenly over each; the first begins with the record.
pub(super) fn windows(runs: &[TrainingRecord]) -> Vec<Window> {
    let total: usize = runs.iter().map(|run| run.record.len()).sum();
    let of = |(k, run): (usize, &TrainingRecord)| -> Vec<Window> {
        let n = run.record.len();
        let kept = if total <= SEARCH_SAMPLES { n } else { (n * SEARCH_SAMPLES).div_ceil(total) };
        let count = if kept == n { 1 } else { kept.div_ceil(WINDOW) };
        let window = |i: usize| {
            let length = (kept / count).max(n.min(MIN_WINDOW));
            let start = if count > 1 { (n - length) * i / (count - 1) } else { 0 };
            let moving = if start > 0 { WARM_UP.min(start) } else { run.moving };
            Window { run: k, samples: start..start + length, moving }
        };
        (0..count).map(window).collect()
    };
    runs.iter().enumerate().flat_map(of).collect()
}

impl Window {
    /// The run with the signals of this window, which are those of `part`.
    pub(super) fn run<'a>(&self, part: &'a Hidden, run: &TrainingRecord) -> TrainingRecord<'a> {
        part.run(&run.within(&self.samples))
    }
}

#[cfg(test)]
mod tests {
    use super::super::runs::training_records;
    use super::*;
    use piezoid_models::hammerstein::InitialCondition;
    use piezoid_records::record::Record;

    #[test]
    fn short_records_are_used_whole_and_long_ones_in_part() {
        let record = |n: u32| {
            let u: Vec<f64> = (0..n).map(|t| (0.3 + 0.01 * f64::from(t)).sin()).collect();
            Record::new(1e-4, u.clone(), u).unwrap()
        };
        let of = |lengths: &[u32]| {
            let records: Vec<Record> = lengths.iter().map(|n| record(*n)).collect();
            let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
            runs.iter_mut().for_each(|run| run.start_from(InitialCondition::Motion, (-1.0, 1.0)));
            windows(&runs).into_iter().map(|w| (w.run, w.samples, w.moving)).collect::<Vec<_>>()
        };
        assert_eq!(of(&[9000, 11_000]), [(0, 0..9000, 9000), (1, 0..11_000, 11_000)]);
        let long = of(&[90_000, 10_000]);
        assert_eq!(long.iter().map(|w| w.0).collect::<Vec<_>>(), [0, 0, 0, 0, 1]);
        assert_eq!([&long[0].1, &long[3].1], [&(0..4500), &(85_500..90_000)]);
        assert_eq!(long.iter().map(|w| w.2).collect::<Vec<_>>(), [90_000, 1000, 1000, 1000, 10_000]);
    }
}
