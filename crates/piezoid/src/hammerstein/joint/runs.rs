//! Records as the joint way sees them: with a past, a scale, and parts that are held out in turn.

use crate::error::Error;
use crate::quality::{Need, inspect};
use crate::record::Record;
use crate::series::ends;
use crate::waveform::{in_motion, lead};

/// Stretches a record is cut into when parts of it are held out.
const STRETCHES: usize = 10;

/// Groups of held-out parts.
pub(super) const FOLDS: usize = 5;

/// How far the inputs of a record may run beyond those of the others, over the range of all, for the others to tell what
/// it will do.
const COVERED: f64 = 0.02;

/// A record.
#[derive(Debug, Clone)]
pub(super) struct Run<'a> {
    pub(super) record: &'a Record,
    /// Whether it exercises the hysteresis; else it is a small-signal record.
    pub(super) rich: bool,
    /// The inputs it is taken to have had before; none if it came from rest and settled.
    pub(super) past: Vec<f64>,
    /// 1 / peak-to-peak of y: what its errors are multiplied by.
    pub(super) scale: f64,
    /// And by how much more its kind counts.
    pub(super) heavier: f64,
    /// Samples that may be fitted.
    pub(super) usable: Vec<bool>,
    /// Where stretches end, and the fold each belongs to; none is always trained on.
    pub(super) stretches: Vec<(usize, Option<usize>)>,
}

impl<'a> Run<'a> {
    /// None where the output never moves.
    pub(super) fn new(record: &'a Record, rich: bool, usable: Vec<bool>) -> Option<Self> {
        let (low, high) = ends(record.y().iter().copied());
        (low < high).then(|| Run {
            record,
            rich,
            past: if in_motion(record.u()) { lead(record.u()) } else { Vec::new() },
            scale: 1.0 / (high - low),
            heavier: 1.0,
            usable,
            stretches: vec![(record.len(), None)],
        })
    }
}

/// All records, with what is held out in turn.
///
/// # Errors
/// Refuses a record nothing can be identified from.
pub(super) fn of<'a>(small: &'a [Record], rich: &'a [Record]) -> Result<Vec<Run<'a>>, Error> {
    let mut runs = Vec::new();
    for (record, rich) in small.iter().map(|r| (r, false)).chain(rich.iter().map(|r| (r, true))) {
        let seen = inspect(record, &Need::default());
        seen.sound()?;
        runs.extend(Run::new(record, rich, seen.usable));
    }
    fold(&mut runs);
    Ok(runs)
}

/// Says what is held out in turn: whole rich records where at least three can be foretold by the others, else stretches
/// of each.
fn fold(runs: &mut [Run]) {
    let range = |run: &Run| ends(run.record.u().iter().copied());
    let rich: Vec<usize> = (0..runs.len()).filter(|&k| runs[k].rich).collect();
    let (low, high) = ends(rich.iter().flat_map(|&k| <[f64; 2]>::from(range(&runs[k]))));
    let slack = COVERED * (high - low);
    let foretold = |&k: &usize| {
        let (others_low, others_high) =
            ends(rich.iter().filter(|&&other| other != k).flat_map(|&other| <[f64; 2]>::from(range(&runs[other]))));
        let (low, high) = range(&runs[k]);
        low >= others_low - slack && high <= others_high + slack
    };
    let whole: Vec<usize> = rich.iter().copied().filter(foretold).collect();
    if whole.len() >= 3 {
        for (fold, k) in whole.into_iter().enumerate() {
            let n = runs[k].record.len();
            runs[k].stretches = vec![(n, Some(fold % FOLDS))];
        }
    } else {
        for k in rich {
            let n = runs[k].record.len();
            let stretch = |s: usize| ((s + 1) * n / STRETCHES, Some(s % FOLDS));
            runs[k].stretches = (0..STRETCHES).map(stretch).collect();
        }
    }
}
