//! Control schemes along references, on a simulated actuator.

use super::{File, blamed};
use crate::compensation::{FeedForward, FeedForwardSettings};
use crate::control::{
    ClosedLoopRun, Comparison, ControlLoop, MarginTarget, NamedReference, Reference, ReferenceResult, Scheme,
    Tolerance, TunedScheme,
};
use crate::error::Error;
use crate::excitation::LimitOptions;
use crate::formats::{ColumnSelection, Table};
use crate::hammerstein::Model;
use crate::number::{round, short};
use crate::options::{OptionKind, OptionRow, options};
use crate::plant::Spec;
use crate::progress::Progress;
use crate::record::Units;
use crate::system::System;

/// The schemes and references that are compared by default.
const SCHEMES: [&str; 6] =
    ["gain", "feed-forward", "integral-notch", "feed-forward+integral-notch", "learning", "predictive"];
const ALONG: [&str; 10] = [
    "sine:1",
    "sine:5",
    "sine:20",
    "sine:40",
    "triangle:1",
    "triangle:5",
    "triangle:20",
    "triangle:40",
    "staircase:1",
    "random:20",
];

/// Default frequency [Hz].
const FREQUENCY: f64 = 5.0;

/// Peak of a named reference, as a share of the displacement that the model can hold.
const SHARE: f64 = 0.8;

/// Minimum duration of a named reference [s], and its minimum number of periods.
const SECONDS: f64 = 1.0;
const PERIODS: f64 = 4.0;

/// Its maximum number of samples.
const LONGEST: f64 = 1e6;

const COUNT: OptionKind = OptionKind::Integer(0, u64::MAX);
const PERCENT: OptionKind = OptionKind::Number { least: 0.0, open: false, below: 100.0 };

options! {
    /// What controllers are tuned to.
    #[derive(Copy)]
    pub struct TuneOptions {
        /// Sensor delay in samples; controllers are tuned for it.
        late: usize = 0, OptionRow::new(OptionKind::Integer(0, ControlLoop::LATEST as u64));
        /// Gain margin to tune to [dB].
        gain_margin: f64 = MarginTarget::default().gain_db, OptionRow::positive("dB");
        /// Phase margin to tune to [degrees].
        phase_margin: f64 = MarginTarget::default().phase_deg, OptionRow::positive("degrees");
    }
}

impl TuneOptions {
    /// Tunes `scheme` for `model`.
    ///
    /// # Errors
    /// The errors of [`TunedScheme::new`].
    pub fn drive(&self, scheme: Scheme, model: &Model, settings: FeedForwardSettings) -> Result<TunedScheme, Error> {
        let target =
            MarginTarget { gain_db: self.gain_margin, phase_deg: self.phase_margin, ..MarginTarget::default() };
        TunedScheme::new(scheme, model, settings, self.late, &target)
    }
}

options! {
    /// What to compare, along what.
    pub struct ControlOptions {
        /// Controllers to compare, such as feed-forward+pi.
        controller: Vec<String> = Vec::new(), OptionRow::new(OptionKind::Texts("NAME")).absent("six schemes");
        /// References: files, or names such as sine:5.
        reference: Vec<String> = Vec::new(), OptionRow::new(OptionKind::Texts("FILE|NAME[:HZ]")).absent("ten named \
                                                                               references");
        /// Peak of named references, in the model's output unit.
        amplitude: Option<f64> = None, OptionRow::positive("").absent("0.8 of the displacement that the model can \
                                                            hold on both sides of 0");
        /// Number of future samples of the reference that controllers may use.
        preview: Option<usize> = None, OptionRow::new(COUNT).absent("all");
        /// Noise of the sensor, rms in the model's output unit.
        noise: Option<f64> = None, OptionRow::not_negative("").absent("the plant's own");
        /// Clip the feed-forward to the limits, instead of refusing a reference that exceeds them.
        clip: bool = false, OptionRow::new(OptionKind::Switch);
        /// Also simulate random plants whose parameters differ from those of the plant by up to this many percent, on
        /// the first reference.
        tolerance: Option<f64> = None, OptionRow { unit: "%", ..OptionRow::new(PERCENT) };
        /// Number of these random plants.
        draws: usize = 200, OptionRow::new(OptionKind::Integer(1, u64::MAX)).requires("tolerance");
        /// Seed of the noise and of the draws.
        seed: u64 = 1, OptionRow::new(COUNT);
    } with limits: LimitOptions with tuning: TuneOptions
}

impl ControlOptions {
    /// The references that are files.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        self.reference.iter().map(String::as_str).filter(|name| named(name).is_none())
    }

    /// Runs each scheme along each reference on a plant. A reference that is not in the list is one of the `files`.
    ///
    /// # Errors
    /// Returns an error for an unknown name, and for a file that is missing or contains no reference. The errors of
    /// [`ControlOptions::along`].
    pub fn run(
        &self,
        (plant, spec): (&str, &Spec),
        model: &File,
        files: &[File],
        columns: &ColumnSelection,
        progress: &mut Progress,
    ) -> Result<Comparison, Error> {
        self.schemes()?;
        let (file, model, mut spec) = (model, model.model()?, spec.clone());
        let settings = self.settings()?;
        if let Some(noise) = self.noise {
            let unit = &model.units().y;
            let none = || {
                Error::Content(format!(
                    "the output of the model is in {unit}, which is not a length: leave out the option noise"
                ))
            };
            let factor = Units::factor(unit, "m").ok_or_else(none).map_err(|e| e.of(&file.name))?;
            spec.sensor.noise_rms_m = noise * factor;
        }
        let names: Vec<&str> = match self.reference.is_empty() {
            true => ALONG.to_vec(),
            false => self.reference.iter().map(String::as_str).collect(),
        };
        let wanted = |name: &str| match (named(name), files.iter().find(|file| file.name == name)) {
            (Some((kind, hz)), _) => self.repeated(name, kind, hz?, &model, settings),
            (None, Some(file)) => Ok(NamedReference::new(file.short(), model.ts(), file.reference(columns, &model)?)),
            (None, None) => {
                Err(Reference::find(name).err().unwrap_or_else(|| Error::parameter("reference", name, "no file")))
            }
        };
        let wanted = names.into_iter().map(wanted).collect::<Result<_, _>>()?;
        self.along((plant, &spec), &model, wanted, progress).map_err(|e| blamed(e, file))
    }

    /// The same along given references.
    ///
    /// # Errors
    /// The errors of [`Comparison::run`], and errors for schemes that cannot be tuned and references that cannot be
    /// reached.
    pub fn along(
        &self,
        plant: (&str, &Spec),
        model: &Model,
        wanted: Vec<NamedReference>,
        progress: &mut Progress,
    ) -> Result<Comparison, Error> {
        let (settings, mut drives, mut notes) = (self.settings()?, Vec::new(), Vec::new());
        for scheme in self.schemes()? {
            match self.tuning.drive(scheme, model, settings) {
                // Default schemes that the model does not allow are left out.
                Err(e) if self.controller.is_empty() && scheme.law.is_some() => {
                    notes.push(format!("{} is left out: {e}", scheme.name()));
                }
                Err(e @ Error::Parameter { .. }) => return Err(e),
                made => {
                    let mut drive = made.map_err(|e| e.of(&scheme.name()))?;
                    drive.ahead = self.preview.unwrap_or(usize::MAX);
                    drives.push(drive);
                }
            }
        }
        for NamedReference { name, r, .. } in &wanted {
            drives.first().map_or(Ok(()), |drive| drive.check(r)).map_err(|e| e.of(name))?;
        }
        let share = |percent: f64| Tolerance { share: percent / 100.0, draws: self.draws, seed: self.seed };
        let mut compared =
            Comparison::run(plant, drives, wanted, self.seed, self.tolerance.map(share).as_ref(), progress)?;
        compared.notes = notes;
        Ok(compared)
    }

    fn settings(&self) -> Result<FeedForwardSettings, Error> {
        FeedForwardSettings::within(&self.limits, self.clip)
    }

    fn schemes(&self) -> Result<Vec<Scheme>, Error> {
        match self.controller.is_empty() {
            true => SCHEMES.iter().map(|name| Scheme::named(name)).collect(),
            false => self.controller.iter().map(|name| Scheme::named(name)).collect(),
        }
    }

    /// The samples of a named reference.
    fn repeated(
        &self,
        name: &str,
        kind: &Reference,
        hz: f64,
        model: &Model,
        settings: FeedForwardSettings,
    ) -> Result<NamedReference, Error> {
        let (peak, ts) = (self.amplitude.map_or_else(|| held(model, settings), Ok)?, model.ts());
        let n = (SECONDS.max(PERIODS / hz) / ts).round();
        if n > LONGEST {
            let least = short(PERIODS / (LONGEST * ts));
            let rule = format!("four periods are {n} samples, more than 1000000: choose {least} Hz or more");
            return Err(Error::parameter("reference", name, rule));
        }
        let r = (kind.samples)(ts, n as usize, peak, hz).map_err(|e| match e {
            // The frequency stands in the name of the reference.
            Error::Parameter { name: field, rule, .. } if field.starts_with("frequency") || field == "hz" => {
                Error::parameter("reference", name, rule)
            }
            other => other,
        })?;
        Ok(NamedReference::new(format!("{} {} Hz", kind.name, round(hz)), ts, r))
    }
}

impl Comparison {
    /// The first run as a record with the reference, in a file of this name.
    ///
    /// # Errors
    /// Returns an error if there is no run. The errors of [`Table::write`].
    pub fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        let first = self.driven.first().and_then(|d| Some((&d.drive, d.attempts.first()?.as_ref().ok()?)));
        let Some((drive, ReferenceResult { run: ClosedLoopRun { u, y, r, .. }, .. })) = first else {
            return Err(Error::Content("there is no run to write: no controller could follow the reference".into()));
        };
        let (ts, units) = (drive.model().ts(), drive.model().units());
        let names = [format!("u_{}", units.u), format!("y_{}", units.y), format!("r_{}", units.y)];
        Table::write(name, ts, &[(&names[0], u), (&names[1], y), (&names[2], r)])
    }

    /// Remarks for the reader, one sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let mut told = self.notes.clone();
        told.extend(self.driven.first().map(|d| d.drive.model().proven()));
        if let Some(hz) = self.driven.first().and_then(|d| d.drive.known_hz()) {
            told.push(format!(
                "the model was identified up to {} Hz only: feedback is tuned slow enough for an unknown resonance \
                 above; identify the model with a PRBS record as well to allow faster feedback",
                short(hz)
            ));
        }
        for d in &self.driven {
            for (wanted, attempt) in self.wanted.iter().zip(&d.attempts) {
                let along = &wanted.name;
                match attempt {
                    Err(error) => told.push(format!("{}, {along}: {error}", d.name())),
                    Ok(ReferenceResult { feed_forward, run, .. }) => {
                        // The notes of a feed-forward are the same with every controller.
                        for note in &feed_forward.notes {
                            let note = format!("{}, {along}: {note}", d.drive.scheme.feed.name);
                            if !told.contains(&note) {
                                told.push(note);
                            }
                        }
                        if run.limited > 0 {
                            let n = run.u.len();
                            told.push(format!("{}, {along}: {} of {n} voltages are at a limit", d.name(), run.limited));
                        }
                    }
                }
            }
        }
        told
    }
}

/// A reference in the list and its frequency [Hz]; `None` for another name, which is that of a file.
fn named(text: &str) -> Option<(&'static Reference, Result<f64, Error>)> {
    let (name, hz) = text.split_once(':').map_or((text, None), |(name, hz)| (name, Some(hz)));
    let kind = Reference::find(name).ok()?;
    let hz = hz.map_or(Ok(FREQUENCY), |hz| {
        let hz = hz.parse().ok().filter(|hz: &f64| hz.is_finite() && *hz > 0.0);
        hz.ok_or_else(|| Error::parameter("reference", text, "the frequency must be a positive number of hertz"))
    });
    Some((kind, hz))
}

/// The peak of named references: 0.8 of the displacement that can be held on both sides of 0.
fn held(model: &Model, settings: FeedForwardSettings) -> Result<f64, Error> {
    let (low, high) = FeedForward::new(model, settings)?.reach();
    let both = high.min(-low);
    if both > 0.0 {
        return Ok(SHARE * both);
    }
    let (low, high, unit) = (round(low), round(high), &model.units().y);
    Err(Error::Content(format!(
        "the model can hold {low} to {high} {unit}, but named references need both signs: give a file as reference"
    )))
}
