//! Records of the joint method: with a past, a scale, and parts that are held out in turn.
//!
//! Why: docs/decisions/identification.md, "Every record has its own linear trend".

use super::folds::fold;
use crate::error::Error;
use crate::hammerstein::paper::called;
use crate::hammerstein::{InitialCondition, Model};
use crate::quality::{DRIFT, bridged, compare, inspect};
use crate::record::Record;
use crate::series::{ends, scatter};
use crate::system::System;

/// A less likely initial condition is used if its squared error is below this share of that of the likelier.
pub(super) const CLEARLY: f64 = 0.9;

/// A record with what the fit needs.
#[derive(Debug, Clone)]
pub(super) struct TrainingRecord<'a> {
    pub(super) record: &'a Record,
    /// Its name in messages.
    pub(super) name: String,
    /// True if it exercises the hysteresis; false for a small-signal record.
    pub(super) large_signal: bool,
    /// The state before it.
    pub(super) initial: InitialCondition,
    /// Those selected so far.
    pub(super) tried: Vec<InitialCondition>,
    /// The inputs before it, from rest; never empty.
    pub(super) before: Vec<f64>,
    /// 1 / peak-to-peak of y, the factor of its errors.
    pub(super) scale: f64,
    /// The middle of y, its origin.
    pub(super) level: f64,
    /// True if its output drifts; then its trend may be large.
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
        let initial = InitialCondition::of(record.u())[0];
        (low < high).then(|| TrainingRecord {
            record,
            name: name.into(),
            large_signal,
            initial,
            tried: vec![initial],
            before: initial.inputs_before(record.u(), ends(record.u().iter().copied())),
            scale: 1.0 / (high - low),
            level: 0.5 * (low + high),
            drifts: false,
            heavier: 1.0,
            usable,
            segments: vec![(record.len(), None)],
        })
    }

    /// Number of inputs before the record that pass creep and linear block too: those of a record in motion.
    pub(super) fn moving(&self) -> usize {
        if self.initial == InitialCondition::Motion { self.record.len().min(self.before.len() - 1) } else { 0 }
    }

    /// Sets the initial condition.
    pub(super) fn begin_from(&mut self, initial: InitialCondition, range: (f64, f64)) {
        self.initial = initial;
        self.before = initial.inputs_before(self.record.u(), range);
    }

    /// Selects the initial condition with the smallest free-run error of `model`, with a line through the errors. True
    /// if it is another than those selected before.
    pub(super) fn begin(&mut self, model: &Model, range: (f64, f64)) -> bool {
        let error = |initial: InitialCondition| {
            let simulated = model.resume(&mut model.before(self.record.u(), initial), self.record.u());
            let errors = self.record.y().iter().zip(simulated).zip(&self.usable).enumerate();
            let errors = errors.filter(|(_, (_, usable))| **usable).map(|(t, ((y, s), _))| (t as f64, y - s));
            scatter_about_line(errors)
        };
        let [likely, others @ ..] = InitialCondition::of(self.record.u()).map(|initial| (error(initial), initial));
        let better = |best: (f64, _), one: (f64, _)| if one.0 < CLEARLY * best.0 { one } else { best };
        let found = others.into_iter().fold(likely, better).1;
        let changed = found != self.initial && !self.tried.contains(&found);
        if changed {
            self.tried.push(found);
            self.begin_from(found, range);
        }
        changed
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

/// The sum of squares of points (t, e) about the line of least squares.
fn scatter_about_line(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut n, mut mt, mut me, mut tt, mut te, mut ee) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (t, e) in points {
        n += 1.0;
        let (dt, de) = (t - mt, e - me);
        mt += dt / n;
        me += de / n;
        tt += dt * (t - mt);
        te += dt * (e - me);
        ee += de * (e - me);
    }
    if tt > 0.0 { ee - te * te / tt } else { ee }
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
            let (seen, name) = (inspect(record), called(kind, k, records.len()));
            let refused = |because: String| Error::Unidentifiable {
                what: "a model".into(),
                because: format!("{name}: {because}"),
            };
            match seen.sound() {
                Err(Error::Unidentifiable { because, .. }) => return Err(refused(because)),
                sound => sound?,
            }
            notes.extend(seen.findings.iter().map(|finding| format!("{name}: {}", finding.text)));
            let drifts = seen.has(&DRIFT);
            let run = TrainingRecord::new(record, &name, is_large, seen.usable);
            let still = || refused("the valid samples of the output are constant: measure again".into());
            runs.push(TrainingRecord { drifts, ..run.ok_or_else(still)? });
        }
    }
    compare(&runs.iter().map(|run| (&*run.name, run.record)).collect::<Vec<_>>(), notes)?;
    fold(&mut runs);
    Ok(runs)
}
