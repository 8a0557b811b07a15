//! Control schemes along references, on a simulated actuator.

use super::same_actuator::matched;
use super::verdict::StatedVerdict;
use super::{DataFile, File, blamed};
use piezoid_control::compensation::{FeedForward, FeedForwardSettings};
use piezoid_control::feedback::{
    ClosedLoopRun, Comparison, ControlLoop, MarginTarget, NamedReference, Reference, ReferenceResult, Scheme,
    SimulatedActuator, Tolerance, TunedScheme,
};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::progress::Progress;
use piezoid_numerics::system::System;
use piezoid_records::excitation::LimitOptions;
use piezoid_records::formats::{ColumnSelection, Table};

/// The schemes that are compared by default.
pub const SCHEMES: [&str; 6] =
    ["gain", "feed-forward", "integral-notch", "feed-forward+integral-notch", "learning", "predictive"];

/// The references along which they are compared by default, by name and frequency [Hz].
pub const PATHS: [(&str, f64); 10] = [
    ("sine", 1.0),
    ("sine", 5.0),
    ("sine", 20.0),
    ("sine", 40.0),
    ("triangle", 1.0),
    ("triangle", 5.0),
    ("triangle", 20.0),
    ("triangle", 40.0),
    ("staircase", 1.0),
    ("random", 20.0),
];

/// Default frequency [Hz].
const FREQUENCY: f64 = 5.0;

/// Peak of a named reference, as a share of the displacement that the model can hold.
const SHARE: f64 = 0.8;

/// Named references run about 0 if the displacement that can be held on both sides of it is at least this share of
/// half of the whole, otherwise about the middle of the whole.
const SIDED: f64 = 0.2;

/// Minimum duration of a named reference [s], and its minimum number of periods.
const SECONDS: f64 = 1.0;
const PERIODS: f64 = 4.0;

/// Its maximum number of samples.
const LONGEST: f64 = 1e6;

const COUNT: OptionKind = OptionKind::Integer(0, u64::MAX);
const PERCENT: OptionKind = OptionKind::Number { least: 0.0, open: false, below: 100.0 };

options! {
    /// Targets of the tuning of controllers.
    #[derive(Copy)]
    pub struct TuneOptions {
        /// Sensor delay in samples; controllers are tuned for it.
        delay_samples: usize = 0, OptionRow::new(OptionKind::Integer(0, ControlLoop::MAX_DELAY_SAMPLES as u64));
        /// Gain margin that controllers are tuned to.
        gain_margin: f64 = MarginTarget::default().gain_db, OptionRow::positive("dB");
        /// Phase margin that controllers are tuned to.
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
        TunedScheme::new(scheme, model, settings, self.delay_samples, &target)
    }
}

options! {
    /// How to compare control schemes.
    pub struct ControlOptions {
        /// Controllers to compare, such as feed-forward+pi.
        controller: Vec<String> = Vec::new(), OptionRow::new(OptionKind::Texts("NAME")).absent("six schemes");
        /// References: files, or names such as sine:5.
        reference: Vec<String> = Vec::new(), OptionRow::new(OptionKind::Texts("FILE|NAME[:HZ]")).absent("ten named \
                                                                               references");
        /// Peak of named references, in the model's output unit.
        amplitude: Option<f64> = None, OptionRow::positive("").absent("0.8 of the displacement that the model can \
                                                            hold on both sides of 0, or of half its range if it holds \
                                                            (nearly) none on one side");
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

    /// Runs each scheme along each reference on a plant. A name that is not in the list of references is that of one of
    /// the `files`.
    ///
    /// # Errors
    /// Returns an error for an unknown name, and for a file that is missing or contains no reference. The errors of
    /// [`ControlOptions::along`].
    pub fn run(
        &self,
        (plant, actuator): (&str, &SimulatedActuator),
        model: &File,
        files: &[DataFile],
        columns: &ColumnSelection,
        progress: &mut Progress,
    ) -> Result<Comparison, Error> {
        self.schemes()?;
        let (file, model, mut actuator) = (model, model.model()?, actuator.clone());
        let settings = self.settings()?;
        if let Some(noise) = self.noise {
            actuator = actuator.with_noise(noise, &model.units().y).map_err(|e| e.of(&file.name))?;
        }
        let names = match self.reference.is_empty() {
            true => PATHS.map(|(name, hz)| format!("{name}:{hz}")).into(),
            false => self.reference.clone(),
        };
        let mut about = None;
        let reference = |name: &String| match (named(name), files.iter().find(|file| file.name == *name)) {
            (Some((kind, hz)), _) => self.repeated(name, kind, hz?, &model, settings, &mut about),
            (None, Some(file)) => Ok(NamedReference::new(file.short(), model.ts(), file.reference(columns, &model)?)),
            (None, None) => {
                Err(Reference::find(name).err().unwrap_or_else(|| Error::parameter("reference", name, "no file")))
            }
        };
        let reference = names.iter().map(reference).collect::<Result<_, _>>()?;
        let mut result = self.along((plant, &actuator), &model, reference, progress).map_err(|e| blamed(e, file))?;
        result.notes.extend(about);
        Ok(result)
    }

    /// The same along given references.
    ///
    /// # Errors
    /// The errors of [`Comparison::run`], and errors for schemes that cannot be tuned and references that cannot be
    /// reached.
    pub fn along(
        &self,
        plant: (&str, &SimulatedActuator),
        model: &Model,
        reference: Vec<NamedReference>,
        progress: &mut Progress,
    ) -> Result<Comparison, Error> {
        let (settings, mut drives) = (self.settings()?, Vec::new());
        let (actuator, note) = matched(plant, model, &settings)?;
        let mut notes: Vec<String> = note.into_iter().collect();
        let mut refused = None;
        for scheme in self.schemes()? {
            match self.tuning.drive(scheme, model, settings) {
                Ok(mut drive) => {
                    drive.ahead = self.preview.unwrap_or(usize::MAX);
                    drives.push(drive);
                }
                // The others are worth seeing without a controller that the model does not allow.
                Err(e) if scheme.law.is_some() => {
                    notes.push(format!("{} is left out: {e}", scheme.name()));
                    refused = refused.or(Some(e.about(&scheme.name())));
                }
                Err(e) => return Err(e.about(&scheme.name())),
            }
        }
        if let (true, Some(e)) = (drives.is_empty(), refused) {
            return Err(e);
        }
        for NamedReference { name, r, .. } in &reference {
            drives.first().map_or(Ok(()), |drive| drive.check(r)).map_err(|e| e.of(name))?;
        }
        let share = |percent: f64| Tolerance { share: percent / 100.0, draws: self.draws, seed: self.seed };
        let plant = (plant.0, &actuator);
        let mut compared =
            Comparison::run(plant, drives, reference, self.seed, self.tolerance.map(share).as_ref(), progress)?;
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

    /// The samples of a named reference; `about` becomes a note if it does not run about 0.
    fn repeated(
        &self,
        name: &str,
        kind: &Reference,
        hz: f64,
        model: &Model,
        settings: FeedForwardSettings,
        about: &mut Option<String>,
    ) -> Result<NamedReference, Error> {
        let (ts, unit) = (model.ts(), &model.units().y);
        // What the model can hold: the middle, half of it, and the smaller of its parts above and below 0.
        let held = FeedForward::new(model, settings).map(|inverse| {
            let (low, high) = inverse.reach();
            (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low, high.min(-low))
        });
        let (middle, peak) = match (held, self.amplitude) {
            (Ok((_, half, both)), None) if both >= SIDED * half => (0.0, SHARE * both),
            (Ok((_, half, both)), Some(peak)) if both >= (SIDED * half).min(peak) => (0.0, peak),
            (Ok((middle, half, _)), peak) => {
                let [low, high, at] = [middle - half, middle + half, middle].map(short);
                *about = Some(format!(
                    "The model can hold {low} to {high} {unit}: named references are centred on {at} {unit}, the \
                     middle, not on 0"
                ));
                (middle, peak.unwrap_or(SHARE * half))
            }
            // Feedback alone needs no inverse.
            (Err(_), Some(peak)) => (0.0, peak),
            (Err(error), None) => return Err(error),
        };
        let n = (SECONDS.max(PERIODS / hz) / ts).round();
        if n > LONGEST {
            let least = short(PERIODS / (LONGEST * ts));
            let rule = format!("four periods are {n} samples, more than 1000000: choose {least} Hz or more");
            return Err(Error::parameter("reference", name, rule));
        }
        let mut r = kind.samples(ts, n as usize, peak, hz).map_err(|e| match e {
            // The frequency stands in the name of the reference.
            Error::Parameter { name: field, rule, .. } if field.starts_with("frequency") || field == "hz" => {
                Error::parameter("reference", name, rule)
            }
            other => other,
        })?;
        r.iter_mut().for_each(|r| *r += middle);
        Ok(NamedReference::new(format!("{} {} Hz", kind.name, round(hz)), ts, r))
    }
}

/// Output of a comparison of controllers: a record, and remarks.
pub trait ComparisonReport {
    /// The first run as a record with the reference, in a file of this name.
    ///
    /// # Errors
    /// Returns an error if there is no run. The errors of [`Table::write`].
    fn written(&self, name: &str) -> Result<Vec<u8>, Error>;

    /// Remarks for the reader, one sentence each.
    fn remarks(&self) -> Vec<String>;
}

impl ComparisonReport for Comparison {
    fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        let first = self.results.first().and_then(|d| Some((&d.tuned, d.attempts.first()?.as_ref().ok()?)));
        let Some((drive, ReferenceResult { run: ClosedLoopRun { u, y, r, .. }, .. })) = first else {
            return Err(Error::Content("there is no run to write: no controller could follow the reference".into()));
        };
        let (ts, units) = (drive.model().ts(), drive.model().units());
        let names = [format!("u_{}", units.u), format!("y_{}", units.y), format!("r_{}", units.y)];
        Table::write(name, ts, &[(&names[0], u), (&names[1], y), (&names[2], r)])
    }

    fn remarks(&self) -> Vec<String> {
        let mut message = self.notes.clone();
        message.extend(self.results.first().map(|d| d.tuned.model().proven()));
        if let Some(hz) = self.results.first().and_then(|d| d.tuned.known_hz()) {
            message.push(format!(
                "the model was identified up to {} Hz only: feedback is tuned slow enough for an unknown resonance \
                 above; identify the model with a PRBS record as well to allow faster feedback",
                short(hz)
            ));
        }
        for d in &self.results {
            for (reference, attempt) in self.references.iter().zip(&d.attempts) {
                let along = &reference.name;
                match attempt {
                    Err(error) => message.push(format!("{}, {along}: {error}", d.name())),
                    Ok(ReferenceResult { feed_forward, run, .. }) => {
                        // The notes of a feed-forward are the same with every controller.
                        for note in &feed_forward.notes {
                            let note = format!("{}, {along}: {note}", d.tuned.scheme.feed_forward.name);
                            if !message.contains(&note) {
                                message.push(note);
                            }
                        }
                        if run.limited > 0 {
                            let (name, limited, n) = (d.name(), run.limited, run.u.len());
                            message.push(format!("{name}, {along}: {limited} of {n} voltages are at a limit"));
                        }
                    }
                }
            }
        }
        message
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

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hammerstein::Domain;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::progress::Stage;
    use piezoid_twins::Preset;
    use std::sync::Arc;

    const TS: f64 = 1e-3;

    /// A gain with an offset, identified from `low` to `high` [V].
    fn model(gain: f64, offset: f64, [low, high]: [f64; 2]) -> File {
        let model = Model::new(Arc::new(Proportional::new(TS, 1.0).unwrap()), Arx::gain(TS, gain).unwrap(), offset);
        let domain = Domain::of_input(&[low, high, low], TS);
        File::new("m.json", model.unwrap().with_identified(domain).to_json())
    }

    fn compared(plant: &str, model: &File) -> Comparison {
        let spec = Preset::find(plant).unwrap().spec().into();
        let options = ControlOptions {
            controller: vec!["gain".into()],
            reference: vec!["sine:5".into()],
            ..ControlOptions::default()
        };
        options.run((plant, &spec), model, &[], &ColumnSelection::default(), &mut Stage::ignore).unwrap()
    }

    fn percent(compared: &Comparison) -> f64 {
        compared.results[0].attempts[0].as_ref().unwrap().tracking.percent_of_stroke
    }

    #[test]
    fn a_plant_of_another_actuator_is_told_first_with_the_numbers() {
        // A stack of 9 um at 100 V on a bender of 2 mm at +-30 V.
        let result = compared("pl140", &model(0.09, 0.0, [0.0, 100.0]));
        let first = &result.remarks()[0];
        assert!(first.starts_with("The plant `pl140` is not the actuator of this model: the model is used"), "{first}");
        for number in ["from 0 to 100.0 V", "gives -30.00 to 30.00 V", "moves by ", "model by 2.700 um", "say nothing"]
        {
            assert!(first.contains(number), "{number}: {first}");
        }
        let result = compared("pl140", &model(33.0, 0.0, [-30.0, 30.0]));
        assert_eq!(result.notes, Vec::<String>::new());
        assert!(percent(&result) < 20.0, "{}", percent(&result));
    }

    #[test]
    fn a_displacement_on_one_side_of_zero_is_tracked_about_its_middle_with_the_zero_of_its_sensor() {
        let result = compared("p885", &model(0.15, -131.0, [0.0, 120.0]));
        let (low, high) = piezoid_numerics::series::ends(result.references[0].r.iter().copied());
        assert!((0.5 * (low + high) + 122.0).abs() < 0.1 && (high - low - 15.84).abs() < 0.1, "{low} {high}");
        let notes = result.notes.join("\n");
        assert!(notes.contains("named references are centred on -122.0 um"), "{notes}");
        assert!(notes.contains("the zeros of their sensors differ. The zero of the plant is moved by -13"), "{notes}");
        assert!(percent(&result) < 20.0, "{}", percent(&result));
        // Without an offset, a unipolar actuator needs no other zero.
        let result = compared("p885", &model(0.15, 0.0, [0.0, 120.0]));
        assert!(result.notes.len() == 1 && result.notes[0].contains("centred on 9.000 um"), "{:?}", result.notes);
        assert!(percent(&result) < 20.0, "{}", percent(&result));
    }
}
