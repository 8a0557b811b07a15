//! How good a model is, and where, in one sentence.

use super::{Compared, Validated};
use crate::hammerstein::{Domain, Identified, Model};
use crate::quality::{around, excites};
use crate::record::Record;
use crate::series::ends;
use crate::system::System;
use crate::validation::{inner_reversals, rough};
use serde::{Deserialize, Serialize};

/// Share of the whole range from which a record counts as a large signal.
const LARGE: f64 = 0.2;

/// Error from which a model is *only* good to so much [%].
const POOR: f64 = 5.0;

/// Ratio of two frequencies up to which they are one, and share of the Nyquist frequency up to which a band ends below
/// it.
const ONE: f64 = 1.3;
const WHOLE: f64 = 0.8;

/// Duration from which records show the creep that matters [s].
const LONG: f64 = 60.0;

/// How good a model is, on which inputs, and what no record has proven. It is stored in the model.
///
/// ```
/// use piezoid::{IdentifyOptions, Record, Records, progress::Stage};
/// use serde_json::Value;
/// let u: Vec<f64> = (0..2000).map(|t| 10.0 * (0.05 * f64::from(t)).sin()).collect();
/// let y = u.iter().map(|u| 30.0 * u + 5.0).collect();
/// let options = IdentifyOptions { operator: "proportional".into(), order: Some(0), ..IdentifyOptions::default() };
/// let records = [Record::new(1e-3, u, y)?];
/// let model = options.prove(Records::from(&records), &["sine"], "", Value::Null, &mut Stage::ignore)?.model;
/// let said = model.verdict().unwrap().to_string();
/// assert!(said.contains("+-10 V") && said.contains("unproven: "), "{said}");
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Rms error over peak-to-peak of the output [%].
    pub error_percent: f64,
    /// How it was measured, such as `free run on held-out parts`.
    pub measured: String,
    /// Noise in it, over the same peak-to-peak [%]; `None` if it is unknown.
    pub noise_percent: Option<f64>,
    /// Lowest and highest input [unit of the input].
    pub u: [f64; 2],
    /// Unit of the input.
    pub unit: String,
    /// Lowest and highest frequency of large signals [Hz]; `None` if all inputs are constant.
    pub hz: Option<[f64; 2]>,
    /// What no record has proven.
    pub unproven: Vec<String>,
}

impl Verdict {
    /// The verdict on a model after its identification, from its free runs on the `training` records (those of the
    /// `small` signals if there are no others).
    pub(super) fn of_identified(found: &Identified, training: &[Compared], small: &[Record]) -> Option<Self> {
        let all = Validated { files: training.to_vec() };
        let taken = found.trials.iter().find(|trial| trial.verdict == "taken");
        let (error_percent, measured) = match taken {
            Some(trial) => (trial.held_out_percent.max(trial.free_run_percent), "free run on held-out parts"),
            None => (all.total().rms_pp_percent, "free run on the training records only"),
        };
        let mut verdict = Verdict::of(&all, error_percent, measured.into())?;
        let records = || training.iter().map(|c| &c.record);
        let (model, unit) = (&found.model, &verdict.unit);
        let large: Vec<&Compared> = training.iter().filter(|c| is_large(&c.record, verdict.u)).collect();
        let mut unproven = Vec::new();
        let amplitudes = large.iter().flat_map(|c| &c.validation.by_amplitude).map(|bin| bin.low);
        let least = amplitudes.fold(f64::INFINITY, f64::min);
        if least.is_finite() && least > 0.5 * LARGE * (verdict.u[1] - verdict.u[0]) {
            unproven.push(format!("amplitudes below {} {unit}", rough(least)));
        }
        if let Some([low, high]) = verdict.hz {
            let of = if small.is_empty() { "" } else { "large signals " };
            if high < ONE * low {
                unproven.push(format!("{of}at other frequencies than {} Hz", rough(high)));
            } else if high < WHOLE * 0.5 / model.ts() {
                unproven.push(format!("{of}above {} Hz", rough(high)));
            }
        }
        if let Some(pole) = model.linear().resonance()
            && !records().chain(small).any(|record| excites(record.u(), record.ts(), around(pole.hz)))
        {
            unproven.push(format!("the resonance at {} Hz", rough(pole.hz)));
        }
        if !large.iter().any(|c| inner_reversals(c.record.u(), verdict.u[0], verdict.u[1]) > 0) {
            unproven.push("minor loops".into());
        }
        let longest = records().map(Record::duration).fold(0.0, f64::max);
        if longest < LONG {
            unproven.push(format!("creep beyond {} s", rough(longest)));
        }
        verdict.unproven = unproven;
        Some(verdict)
    }

    /// The verdict of a validation of `model`.
    fn of_validated(validated: &Validated, model: &Model) -> Option<Self> {
        let before = model.verdict().map(|before| format!("; {} % at identification", rough(before.error_percent)));
        let on = match &validated.files[..] {
            [one] => one.short().to_string(),
            several => format!("{} records", several.len()),
        };
        let measured = format!("free run on {on}{}", before.unwrap_or_default());
        let mut verdict = Verdict::of(validated, validated.total().rms_pp_percent, measured)?;
        let subject = |text: &String| text.split(':').next().unwrap_or_default().to_string();
        verdict.unproven = validated.not_covered().iter().map(subject).collect();
        if let Some(domain) = model.identified()
            && verdict.u[1] - verdict.u[0] < WHOLE * (domain.u[1] - domain.u[0])
        {
            verdict.unproven.push(format!("inputs outside {}", range(verdict.u, &verdict.unit)));
        }
        Some(verdict)
    }

    /// The figures of free runs; `None` if there are none, or the error is not finite.
    fn of(validated: &Validated, error_percent: f64, measured: String) -> Option<Self> {
        let records = || validated.files.iter().map(|c| &c.record);
        let whole = Domain::of(records())?;
        let large = records().filter(|record| is_large(record, whole.u));
        let unit = records().next()?.units().u.clone();
        let noise_percent = validated.floor().map(|floor| 100.0 * floor.rms / validated.total().peak_to_peak);
        let hz = Domain::of(large).and_then(|domain| domain.hz);
        let found = Verdict { error_percent, measured, noise_percent, u: whole.u, unit, hz, unproven: Vec::new() };
        error_percent.is_finite().then_some(found)
    }
}

/// True if the input of a record covers much of this range.
fn is_large(record: &Record, [low, high]: [f64; 2]) -> bool {
    let (lowest, highest) = ends(record.u().iter().copied());
    highest - lowest >= LARGE * (high - low)
}

/// A range as text: `+-25 V`, `-20 to 120 V`.
fn range([low, high]: [f64; 2], unit: &str) -> String {
    let [least, most] = [low, high].map(rough);
    if low < 0.0 && rough(-low) == most { format!("+-{most} {unit}") } else { format!("{least} to {most} {unit}") }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let only = if self.error_percent > POOR { "only " } else { "" };
        let noise = self.noise_percent.map(|noise| format!("; noise {} %", rough(noise))).unwrap_or_default();
        let (error, on) = (rough(self.error_percent), &self.measured);
        write!(f, "{only}good to {error} % of stroke ({on}{noise}), ")?;
        match self.hz {
            Some([low, high]) if high < ONE * low => write!(f, "{} Hz, ", rough(high))?,
            Some([low, high]) => write!(f, "{} to {} Hz, ", rough(low), rough(high))?,
            None => {}
        }
        f.write_str(&range(self.u, &self.unit))?;
        if !self.unproven.is_empty() {
            write!(f, "; unproven: {}", self.unproven.join(", "))?;
        }
        Ok(())
    }
}

impl Model {
    /// How good this model was at its identification; `None` if its file does not say so.
    pub fn verdict(&self) -> Option<Verdict> {
        Verdict::deserialize(&self.provenance()["verdict"]).ok()
    }

    /// The verdict in words, for what is made of this model.
    pub fn proven(&self) -> String {
        proven(self.verdict().as_ref())
    }
}

/// A verdict in words, or that there is none.
pub(super) fn proven(verdict: Option<&Verdict>) -> String {
    match verdict {
        Some(verdict) => format!("the model is {verdict}"),
        None => "no record has proven this model: validate it on a record that it was not identified on".into(),
    }
}

impl Validated {
    /// How good `model` is on these records; `None` without records, or if the error is not finite.
    pub fn verdict(&self, model: &Model) -> Option<Verdict> {
        Verdict::of_validated(self, model)
    }
}
