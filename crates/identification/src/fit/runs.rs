//! Records of the joint method: with an initial condition, a scale, and parts that are held out in turn.
//!
//! Why: docs/decisions/identification.md, "Every record has its own linear trend".

use super::folds::fold;
use crate::called;
use piezoid_models::hammerstein::InitialCondition;
use piezoid_numerics::error::Error;
use piezoid_numerics::series::{ends, scatter};
use piezoid_records::quality::{Consequence, DRIFT, Finding, bridged, compare, inspect};
use piezoid_records::record::Record;
use std::ops::Range;

/// A record with what the fit needs.
#[derive(Debug, Clone)]
pub(crate) struct TrainingRecord<'a> {
    pub(crate) record: &'a Record,
    /// Its name in messages.
    pub(crate) name: String,
    /// True if it exercises the hysteresis; false for a small-signal record.
    pub(crate) large_signal: bool,
    /// The state before it.
    pub(crate) initial: InitialCondition,
    /// The initial conditions selected so far.
    pub(crate) tried: Vec<InitialCondition>,
    /// The inputs before it, from rest; never empty.
    pub(crate) before: Vec<f64>,
    /// Number of the last of these that pass creep and linear block too: those of a record in motion.
    pub(crate) moving: usize,
    /// The whole record, of a part.
    pub(crate) whole: Option<&'a TrainingRecord<'a>>,
    /// True for a part that is not the first one of its record: the inputs before it are known.
    pub(crate) is_later_part: bool,
    /// 1 / peak-to-peak of y, the factor of its errors.
    pub(crate) scale: f64,
    /// The middle of y, its origin.
    pub(crate) level: f64,
    /// True if its output drifts; then its trend may be large.
    pub(crate) drifts: bool,
    /// Weight of its kind.
    pub(crate) heavier: f64,
    /// True for samples that are fitted.
    pub(crate) usable: Vec<bool>,
    /// End of each segment, and its fold; `None` is never held out.
    pub(crate) segments: Vec<(usize, Option<usize>)>,
}

impl<'a> TrainingRecord<'a> {
    /// `None` if the usable part of the output is constant.
    pub(crate) fn new(record: &'a Record, name: &str, large_signal: bool, usable: Vec<bool>) -> Option<Self> {
        let (low, high) = ends(sound(record.y(), &usable));
        let initial = InitialCondition::of(record.u())[0];
        let mut run = (low < high).then(|| TrainingRecord {
            record,
            name: name.into(),
            large_signal,
            initial,
            tried: vec![initial],
            before: Vec::new(),
            moving: 0,
            whole: None,
            is_later_part: false,
            scale: 1.0 / (high - low),
            level: 0.5 * (low + high),
            drifts: false,
            heavier: 1.0,
            usable,
            segments: vec![(record.len(), None)],
        })?;
        run.start_from(initial, ends(record.u().iter().copied()));
        Some(run)
    }

    /// The same with another initial condition.
    pub(crate) fn starting_from(mut self, initial: InitialCondition, range: (f64, f64)) -> Self {
        self.start_from(initial, range);
        self
    }

    /// Sets the initial condition; a later part of a record keeps the inputs before it.
    pub(crate) fn start_from(&mut self, initial: InitialCondition, range: (f64, f64)) {
        if self.is_later_part {
            return;
        }
        self.initial = initial;
        self.before = initial.inputs_before(self.record.u(), range);
        let is_moving = initial == InitialCondition::Motion;
        self.moving = if is_moving { self.record.len().min(self.before.len() - 1) } else { 0 };
    }

    /// The same with the usable samples and the segments of a part of its record.
    pub(crate) fn within(&self, part: &Range<usize>) -> Self {
        let segments = self.segments.iter().filter(|(end, _)| *end > part.start);
        let mut segments: Vec<_> = segments.map(|(end, fold)| (end.min(&part.end) - part.start, *fold)).collect();
        segments.dedup_by_key(|(end, _)| *end);
        TrainingRecord { usable: self.usable[part.clone()].to_vec(), segments, ..self.clone() }
    }

    /// The same as a later part of its record, after the inputs `before`.
    pub(crate) fn later_part(self, before: Vec<f64>, moving: usize) -> Self {
        TrainingRecord { initial: InitialCondition::Motion, before, moving, is_later_part: true, ..self }
    }

    /// Mean square of the output about its mean, over the squared peak-to-peak.
    pub(crate) fn power(&self) -> f64 {
        let y: Vec<f64> = sound(self.record.y(), &self.usable).collect();
        self.scale.powi(2) * scatter(&y) / y.len() as f64
    }

    /// The output with unusable samples interpolated.
    pub(crate) fn bridged(&self) -> Vec<f64> {
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
pub(crate) fn training_records<'a>(
    small: &'a [Record],
    large_signal: &'a [Record],
    notes: &mut Vec<String>,
) -> Result<Vec<TrainingRecord<'a>>, Error> {
    let mut runs = Vec::new();
    for (kind, records, is_large) in
        [("small-signal record", small, false), ("large-signal record", large_signal, true)]
    {
        for (k, record) in records.iter().enumerate() {
            let (inspection, name) = (inspect(&record.measured()?), called(kind, k, records.len()));
            let refused = |because: String| Error::Unidentifiable {
                what: "a model".into(),
                because: format!("{name}: {because}"),
            };
            match inspection.require_usable() {
                Err(Error::Unidentifiable { because, .. }) => return Err(refused(because)),
                sound => sound?,
            }
            notes.extend(inspection.findings.iter().map(|Finding { detector, text, .. }| match detector.consequence {
                Consequence::Masked => format!("{name}: {text}; the fit leaves these samples out"),
                _ => format!("{name}: {text}"),
            }));
            let drifts = inspection.has(&DRIFT);
            let every = record.every();
            let is_usable = |t: usize| t.is_multiple_of(every) && inspection.usable[t / every];
            let run = TrainingRecord::new(record, &name, is_large, (0..record.len()).map(is_usable).collect());
            let still = || refused("the valid samples of the output are constant: measure again".into());
            runs.push(TrainingRecord { drifts, ..run.ok_or_else(still)? });
        }
    }
    compare(&runs.iter().map(|run| (&*run.name, run.record)).collect::<Vec<_>>(), notes)?;
    fold(&mut runs);
    Ok(runs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> Record {
        let u: Vec<f64> = (0..100).map(|t| f64::from(t % 20)).collect();
        let y = u.iter().map(|u| 3.0 + 2.0 * u).collect();
        Record::new(1e-3, u, y).unwrap()
    }

    #[test]
    fn scale_and_level_are_those_of_the_usable_samples() {
        let (record, mut usable) = (record(), vec![true; 100]);
        let limited = record.y().iter().map(|y| y.min(31.0)).collect();
        let whole = Record::new(1e-3, record.u().to_vec(), limited).unwrap();
        usable[19..].fill(false);
        let run = TrainingRecord::new(&whole, "r", true, usable).unwrap();
        // Outputs 3, 5, ..., 31, which 14 to 18 share.
        assert_eq!((run.scale, run.level), (1.0 / 28.0, 17.0));
        let outputs: Vec<f64> = (0..19).map(|k| (3.0 + 2.0 * f64::from(k)).min(31.0)).collect();
        let mean = outputs.iter().sum::<f64>() / 19.0;
        let power = outputs.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / 19.0 / 28.0f64.powi(2);
        assert!((run.power() - power).abs() < 1e-12);
        assert!(TrainingRecord::new(&whole, "r", true, vec![false; 100]).is_none());
        let mut one = vec![false; 100];
        one[4] = true;
        assert!(TrainingRecord::new(&whole, "r", true, one).is_none());
    }

    #[test]
    fn the_inputs_before_a_record_are_those_of_its_initial_condition() {
        let record = record();
        let run = TrainingRecord::new(&record, "r", true, vec![true; 100]).unwrap();
        let range = (-5.0, 40.0);
        for initial in [InitialCondition::Rest, InitialCondition::Settled, InitialCondition::FromAbove] {
            let run = run.clone().starting_from(initial, range);
            assert_eq!((run.initial, run.moving), (initial, 0));
            assert_eq!(run.before, initial.inputs_before(record.u(), range));
        }
        let moving = run.clone().starting_from(InitialCondition::Motion, range);
        assert_eq!(moving.moving, 100.min(moving.before.len() - 1));
        assert!(moving.moving > 0);
        let later = run.later_part(vec![1.0, 2.0, 3.0], 2).starting_from(InitialCondition::Rest, range);
        assert_eq!(
            (later.initial, later.moving, &later.before[..]),
            (InitialCondition::Motion, 2, &[1.0, 2.0, 3.0][..])
        );
    }

    #[test]
    fn a_part_has_the_usable_samples_and_segments_of_its_place() {
        let record = record();
        let mut usable = vec![true; 100];
        usable[35] = false;
        let run = TrainingRecord::new(&record, "r", true, usable).unwrap();
        let run = TrainingRecord { segments: vec![(20, None), (40, Some(0)), (60, Some(1)), (100, Some(2))], ..run };
        let part = run.within(&(30..60));
        assert_eq!((part.usable.len(), part.usable[5], part.usable[6]), (30, false, true));
        assert_eq!(part.segments, [(10, Some(0)), (30, Some(1))]);
        assert_eq!(run.within(&(0..100)).segments, run.segments);
    }
}
