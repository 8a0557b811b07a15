//! The path that is followed, and the voltages for it.
//!
//! ```text
//! straight line:   u = middle + (r - y_rest) / k,   k by least squares on the record `path`
//! inverse:         u = H^-1 (r),   from the demagnetised state, with the offset of the model at y_rest
//! ```
//! The path begins and ends at rest at the middle of the range, from where a minimum-jerk move leads to its first
//! value.

use super::CampaignOptions;
use crate::bench::Bench;
use piezoid::compensation::{FeedForward, FeedForwardSettings};
use piezoid::excitation::Multisine;
use piezoid::formats::{ColumnSelection, Table};
use piezoid::hammerstein::InitialCondition;
use piezoid::validation::Metrics;
use piezoid::{Error, Model, Record, System};
use piezoid_numerics::number::round;
use piezoid_numerics::series::mean;
use piezoid_records::excitation::minimum_jerk;
use piezoid_verbs::{Compared, DataFile, Plan};
use serde_json::{Value, json};
use std::ops::Range;

/// A path that was played.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Sampling period [s].
    pub ts: f64,
    /// Requested displacement [unit of the sensor].
    pub r: Vec<f64>,
    /// Measured voltage and displacement.
    pub record: Record,
    /// The samples of the path itself, without the moves to it and from it.
    pub path: Range<usize>,
    /// Errors of the displacement over these samples.
    pub metrics: Metrics,
}

/// Share of the stroke on each side of the middle that a path of its own uses, in relation to that of the record
/// `path`.
const SHARE: f64 = 0.9;

/// Reduction of a path of its own that exceeds the limits, and how often it is tried.
const SMALLER: f64 = 0.8;
const TRIES: usize = 12;

/// Periods of the bandwidth at rest before and after the path, and in which a move leads to it.
const HOLD: f64 = 4.0;
const MOVE: f64 = 8.0;

/// The path.
pub(super) struct Path<'p> {
    plan: &'p Plan,
    /// The model; its offset is that of its records.
    model: &'p Model,
    settings: FeedForwardSettings,
    /// The displacement at rest, as the model has it.
    modelled: f64,
    target: Target,
    hold: usize,
    moves: usize,
}

enum Target {
    /// Displacements [unit of the sensor].
    Requested(Vec<f64>),
    /// Displacements from that at rest [unit of the sensor].
    Own(Vec<f64>),
}

impl<'p> Path<'p> {
    pub(super) fn new(
        options: &CampaignOptions,
        plan: &'p Plan,
        model: &'p Model,
        reference: Option<(&DataFile, &ColumnSelection)>,
    ) -> Result<Self, Error> {
        let settings = FeedForwardSettings::within(&options.instrument.limits, false)?;
        let (middle, period) = ([plan.middle()], 1.0 / (options.bandwidth * plan.ts));
        let modelled = model.resume(&mut model.before(&middle, InitialCondition::Demagnetised), &middle)[0];
        let [hold, moves] = [HOLD, MOVE].map(|periods| (periods * period).ceil() as usize);
        let target = Target::Own(Vec::new());
        let mut path = Path { plan, model, settings, modelled, target, hold, moves };
        path.target = match reference {
            Some((file, columns)) => Target::Requested(file.reference(columns, model)?),
            None => Target::Own(path.own(options.bandwidth)?),
        };
        Ok(path)
    }

    /// Sines up to the bandwidth with random phases, other than those of the record `path`, as large as the stroke and
    /// the limits allow.
    fn own(&mut self, bandwidth: f64) -> Result<Vec<f64>, Error> {
        let Some(drive) = self.plan.drives.last() else { return Ok(Vec::new()) };
        let (ts, n) = (self.plan.ts, drive.u.len().saturating_sub(2 * self.hold).max(2));
        let sines =
            Multisine { frequency_low: bandwidth / 20.0, frequency_high: bandwidth, seed: 2, ..Multisine::default() };
        let sines = sines.samples(ts, n)?;
        let fade = |t: usize| minimum_jerk((t.min(n - 1 - t) as f64 / self.moves.min(n / 4).max(1) as f64).min(1.0));
        let shape: Vec<f64> = sines.iter().enumerate().map(|(t, s)| s * fade(t)).collect();
        let peak = shape.iter().fold(f64::MIN_POSITIVE, |peak: f64, s| peak.max(s.abs()));
        let (low, high) = FeedForward::new(self.model, self.settings)?.reach();
        let mut amplitude = SHARE * self.plan.used(drive) * (high - self.modelled).min(self.modelled - low);
        for _ in 1..TRIES {
            let own: Vec<f64> = shape.iter().map(|s| amplitude * (s / peak)).collect();
            let (r, _) = self.around(&own.iter().map(|d| self.modelled + d).collect::<Vec<_>>(), self.modelled);
            match self.inverse(&r, self.modelled) {
                Err(Error::Limits { .. } | Error::Unreachable { .. }) => amplitude *= SMALLER,
                Err(other) => return Err(other),
                Ok(_) => return Ok(own),
            }
        }
        Err(Error::Content("the limits leave no path that the model can follow: lower the bandwidth".into()))
    }

    /// A path with its moves from `rest` and back, and its samples.
    fn around(&self, path: &[f64], rest: f64) -> (Vec<f64>, Range<usize>) {
        let [first, last] = [path.first(), path.last()].map(|r| r.copied().unwrap_or(rest));
        let leads = |from: f64, to: f64| {
            let moves = if from == to { 0 } else { self.moves };
            (0..moves).map(move |t| from + (to - from) * minimum_jerk(t as f64 / moves as f64))
        };
        let hold = |r: f64| std::iter::repeat_n(r, self.hold);
        let mut r: Vec<f64> = hold(rest).chain(leads(rest, first)).collect();
        let start = r.len();
        r.extend(path);
        let end = r.len();
        r.extend(leads(last, rest).chain(hold(rest)));
        (r, start..end)
    }

    /// The voltages of a straight line of slope `gain` through the middle of the range, where the displacement is
    /// `rest`.
    pub(super) fn straight(&self, r: &[f64], rest: f64, gain: f64) -> Result<Vec<f64>, Error> {
        let (low, high) = self.plan.range();
        Ok(r.iter().map(|r| (self.plan.middle() + (r - rest) / gain).max(low).min(high)).collect())
    }

    /// The voltages of the inverse, if the displacement at rest is `rest`.
    pub(super) fn inverse(&self, r: &[f64], rest: f64) -> Result<Vec<f64>, Error> {
        let shifted: Vec<f64> = r.iter().map(|r| r - rest + self.modelled).collect();
        let inverse = FeedForward::new(self.model, self.settings)?;
        Ok(inverse.whole_from(InitialCondition::Demagnetised, self.plan.middle(), &shifted)?.u)
    }

    /// Measures the displacement at rest, then the path with the voltages for it.
    pub(super) fn on(
        &self,
        bench: &mut Bench,
        voltages: impl FnOnce(&[f64], f64) -> Result<Vec<f64>, Error>,
        notes: &mut Vec<String>,
    ) -> Result<Track, Error> {
        let rest = bench.at_rest()?;
        let (r, path) = match &self.target {
            Target::Requested(r) => self.around(r, rest),
            Target::Own(own) => self.around(&own.iter().map(|d| rest + d).collect::<Vec<_>>(), rest),
        };
        let u = voltages(&r, rest)?;
        let record = bench.play("", &u, self.plan.ts, 0.0)?;
        let factor = piezoid::Units::factor(&record.units().y, &self.model.units().y);
        if factor != Some(1.0) {
            notes.push(format!("the path is in {}, the model in {}", record.units().y, self.model.units().y));
        }
        let metrics = Metrics::of(&r[path.clone()], &record.y()[path.clone()]);
        Ok(Track { ts: self.plan.ts, r, record, path, metrics })
    }
}

/// The slope of the straight line through a record.
pub(super) fn gain(path: &[Compared]) -> f64 {
    let of = |record: &Record| {
        let (u, y) = (record.u(), record.y());
        let (a, b) = (mean(u), mean(y));
        let product: f64 = u.iter().zip(y).map(|(u, y)| (u - a) * (y - b)).sum();
        product / u.iter().map(|u| (u - a) * (u - a)).sum::<f64>()
    };
    path.first().map_or(1.0, |path| of(&path.record))
}

impl Track {
    /// The errors as a document.
    pub fn to_json(&self) -> Value {
        let Metrics { rmse, max_abs, rms_pp_percent, n, .. } = self.metrics;
        let unit = &self.record.units().y;
        json!({"unit": unit, "path": [self.path.start, self.path.end], "n": n, "rmse": rmse, "max_abs": max_abs, "rms_pp_percent": rms_pp_percent})
    }

    /// Time, voltage, requested and measured displacement as a file of this name.
    ///
    /// # Errors
    /// Those of [`Table::write`].
    pub fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        let units = self.record.units();
        let [u, r, y] = [format!("u_{}", units.u), format!("r_{}", units.y), format!("y_{}", units.y)];
        Table::write(name, self.ts, &[(&u, self.record.u()), (&r, &self.r), (&y, self.record.y())])
    }

    /// The errors in words.
    pub fn text(&self) -> String {
        let (m, unit) = (&self.metrics, &self.record.units().y);
        format!(
            "rms {} {unit} ({} % of peak-to-peak), largest {} {unit}",
            round(m.rmse),
            piezoid_numerics::number::short(m.rms_pp_percent),
            piezoid_numerics::number::short(m.max_abs)
        )
    }
}
