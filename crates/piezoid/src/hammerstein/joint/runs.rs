//! Records of the joint method: with a past, a scale, and parts that are held out in turn.

use crate::error::Error;
use crate::hammerstein::paper::called;
use crate::quality::{Defect, Need, bridged, compare, inspect};
use crate::record::Record;
use crate::series::{ends, scatter};
use crate::waveform::{in_motion, inputs_before};

/// Number of segments of a record whose parts are held out.
const STRETCHES: usize = 10;

/// Number of folds.
pub(super) const FOLDS: usize = 5;

/// How far the inputs of a record may exceed those of the others, over the range of all, if the others are to predict
/// it.
const COVERED: f64 = 0.02;

/// A record with what the fit needs.
#[derive(Debug, Clone)]
pub(super) struct TrainingRecord<'a> {
    pub(super) record: &'a Record,
    /// Its name in messages.
    pub(super) name: String,
    /// True if it exercises the hysteresis; false for a small-signal record.
    pub(super) large_signal: bool,
    /// The assumed inputs before the record; empty if it started settled.
    pub(super) past: Vec<f64>,
    /// 1 / peak-to-peak of y, the factor of its errors.
    pub(super) scale: f64,
    /// The middle of y, its origin.
    pub(super) level: f64,
    /// True if its output drifts; then it has a trend.
    pub(super) drifts: bool,
    /// Weight of its kind.
    pub(super) heavier: f64,
    /// True for samples that are fitted.
    pub(super) usable: Vec<bool>,
    /// End of each segment, and its fold; `None` is never held out.
    pub(super) segments: Vec<(usize, Option<usize>)>,
}

impl<'a> TrainingRecord<'a> {
    /// `None` if the usable part of the output is constant.
    pub(super) fn new(record: &'a Record, name: &str, large_signal: bool, usable: Vec<bool>) -> Option<Self> {
        let (low, high) = ends(sound(record.y(), &usable));
        (low < high).then(|| TrainingRecord {
            record,
            name: name.into(),
            large_signal,
            past: if in_motion(record.u()) { inputs_before(record.u()) } else { Vec::new() },
            scale: 1.0 / (high - low),
            level: 0.5 * (low + high),
            drifts: false,
            heavier: 1.0,
            usable,
            segments: vec![(record.len(), None)],
        })
    }

    /// Mean square of the output about its mean, over the squared peak-to-peak.
    pub(super) fn power(&self) -> f64 {
        let y: Vec<f64> = sound(self.record.y(), &self.usable).collect();
        self.scale.powi(2) * scatter(&y) / y.len() as f64
    }

    /// The output with unusable samples interpolated.
    pub(super) fn bridged(&self) -> Vec<f64> {
        bridged(self.record.y(), &self.usable)
    }
}

/// The usable samples of a series.
fn sound<'s>(x: &'s [f64], usable: &'s [bool]) -> impl Iterator<Item = f64> + 's {
    x.iter().zip(usable).filter(|(_, usable)| **usable).map(|(x, _)| *x)
}

/// All records, with their folds; adds their defects to `notes`.
///
/// # Errors
/// Returns an error if nothing can be identified from a record.
pub(super) fn of<'a>(
    small: &'a [Record],
    large_signal: &'a [Record],
    notes: &mut Vec<String>,
) -> Result<Vec<TrainingRecord<'a>>, Error> {
    let mut runs = Vec::new();
    for (kind, records, is_large) in
        [("small-signal record", small, false), ("large-signal record", large_signal, true)]
    {
        for (k, record) in records.iter().enumerate() {
            let (seen, name) = (inspect(record, &Need::default()), called(kind, k, records.len()));
            let refused = |because: String| Error::Unidentifiable {
                what: "a model".into(),
                because: format!("{name}: {because}"),
            };
            match seen.sound() {
                Err(Error::Unidentifiable { because, .. }) => return Err(refused(because)),
                sound => sound?,
            }
            notes.extend(seen.findings.iter().map(|finding| format!("{name}: {}", finding.text)));
            let drifts = seen.findings.iter().any(|finding| finding.defect == Defect::Drift);
            let run = TrainingRecord::new(record, &name, is_large, seen.usable);
            let still = || refused("the valid samples of the output are constant: measure again".into());
            runs.push(TrainingRecord { drifts, ..run.ok_or_else(still)? });
        }
    }
    compare(&runs.iter().map(|run| (&*run.name, run.record)).collect::<Vec<_>>(), notes)?;
    fold(&mut runs);
    Ok(runs)
}

/// Assigns the folds: whole large-signal records if the others can predict at least three of them, otherwise segments
/// of each. Each fold also has a segment of each small-signal record. Its error does not count, but the parameters
/// determined by these records alone get an uncertainty too.
fn fold(runs: &mut [TrainingRecord]) {
    let range = |run: &TrainingRecord| ends(run.record.u().iter().copied());
    let large_signal: Vec<usize> = (0..runs.len()).filter(|&k| runs[k].large_signal).collect();
    let (low, high) = ends(large_signal.iter().flat_map(|&k| <[f64; 2]>::from(range(&runs[k]))));
    let slack = COVERED * (high - low);
    let predictable = |&k: &usize| {
        let (others_low, others_high) = ends(
            large_signal.iter().filter(|&&other| other != k).flat_map(|&other| <[f64; 2]>::from(range(&runs[other]))),
        );
        let (low, high) = range(&runs[k]);
        low >= others_low - slack && high <= others_high + slack
    };
    let whole: Vec<usize> = large_signal.iter().copied().filter(predictable).collect();
    if whole.len() >= 3 {
        for (fold, k) in whole.into_iter().enumerate() {
            let n = runs[k].record.len();
            runs[k].segments = vec![(n, Some(fold % FOLDS))];
        }
    } else {
        for k in large_signal {
            let n = runs[k].record.len();
            let segment = |s: usize| ((s + 1) * n / STRETCHES, Some(s % FOLDS));
            runs[k].segments = (0..STRETCHES).map(segment).collect();
        }
    }
    let folds =
        runs.iter().flat_map(|run| &run.segments).filter_map(|(_, fold)| *fold).max().map_or(1, |last| last + 1);
    for run in runs.iter_mut().filter(|run| !run.large_signal) {
        let n = run.record.len();
        run.segments = (0..folds).map(|fold| ((fold + 1) * n / folds, Some(fold))).collect();
    }
}
