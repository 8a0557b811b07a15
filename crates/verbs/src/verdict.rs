//! How good a model is, and where, in one sentence.

use super::{Compared, Validated};
use libm::{log10, pow};
use piezoid_identification::{Identified, MIN_SAMPLES_PER_PARAMETER};
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::number::round;
use piezoid_numerics::system::System;
use piezoid_records::quality::{around, excites};
use piezoid_records::record::Record;
use piezoid_validation::{Validation, inner_reversals, rough};
use serde::{Deserialize, Serialize};

/// Share of the whole range from which a record counts as a large signal.
const LARGE: f64 = 0.2;

/// Error from which a model is *only* good to so much [%].
const POOR: f64 = 5.0;

/// Error, without noise and offset, over that at identification from which a model is worse, not good.
const WORSE: f64 = 3.0;

/// Share of the whole range that an input must go up and down for its hysteresis to show.
const BACK: f64 = 0.2;

/// Ratio of two frequencies up to which they are one, and share of the Nyquist frequency up to which a band ends below
/// it.
const ONE: f64 = 1.3;
const WHOLE: f64 = 0.8;

/// Duration from which records show the creep that matters [s].
const LONG: f64 = 60.0;

/// The error of a model, the range of the inputs, and the properties that no record tests. It is stored in the model.
///
/// ```
/// use piezoid::{IdentifyOptions, Record, Records, StatedVerdict, progress::Stage};
/// use serde_json::Value;
/// let u: Vec<f64> = (0..2000).map(|t| 10.0 * (0.05 * f64::from(t)).sin()).collect();
/// let y = u.iter().map(|u| 30.0 * u + 5.0).collect();
/// let options = IdentifyOptions { operator: "proportional".into(), order: Some(0), ..IdentifyOptions::default() };
/// let records = [Record::new(1e-3, u, y)?];
/// let records = Records::from(&records);
/// let result = options.identify_and_validate(records, &["sine"], ("", &[]), &mut Stage::ignore)?;
/// let verdict = result.found.model.verdict().unwrap().to_string();
/// assert!(verdict.contains("+-10 V") && verdict.contains("unproven: "), "{verdict}");
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
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
    /// Properties of the model that no record tests.
    pub unproven: Vec<String>,
    /// Of several validation records, the one with the largest error over its own peak-to-peak; `None` for one record,
    /// and after an identification.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_record: Option<String>,
    /// Its error [%].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_percent: Option<f64>,
    /// The error of a validation (of its worst record) over that at identification, if it is more than three times as
    /// large and neither noise nor a constant offset explain it [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times_worse: Option<f64>,
    /// Predicted decrease of the sum of squared errors by another step of the search [%]; `None` if the fit is at its
    /// minimum, or if that is not known. With a number, the verdict says *only* good to its error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_percent: Option<f64>,
    /// The stage in which the search was cancelled: the model is the best until then. `None` if it was not; else the
    /// verdict says *only* too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cancelled_in: Option<String>,
}

impl Verdict {
    /// The verdict on a model after its identification, from its free runs on the `training` records (those of the
    /// `small` signals if there are no others).
    pub(super) fn of_identified(found: &Identified, training: &[Compared], small: &[Record]) -> Option<Self> {
        let all = Validated { files: training.to_vec() };
        let taken = found.trials.iter().find(|trial| trial.verdict == "taken");
        let (error_percent, measured) = match taken {
            Some(trial) => (trial.error_percent, "free run on held-out parts"),
            None => (all.total().rms_pp_percent, "free run on the training records only"),
        };
        let mut verdict = Verdict::of(&all, error_percent, measured.into())?;
        let records = || training.iter().map(|c| &c.record);
        let (model, unit) = (&found.model, &verdict.unit);
        let large: Vec<&Compared> = training.iter().filter(|c| c.is_large(verdict.u)).collect();
        let mut unproven = Vec::new();
        let samples: usize = records().map(Record::len).sum();
        if let Some(trial) = taken.filter(|trial| samples < MIN_SAMPLES_PER_PARAMETER * trial.parameters) {
            let few = format!("the hysteresis ({samples} samples are few for its {} parameters)", trial.parameters);
            unproven.push(few);
        }
        // Hysteresis is the difference of the two branches: one of them alone does not show it.
        let swings = |of: fn(f64, f64) -> f64| records().map(|r| swing(r.u(), of)).fold(0.0, f64::max);
        let back = BACK * (verdict.u[1] - verdict.u[0]);
        for (most, never) in [(swings(|a, b| a - b), "falls"), (swings(|a, b| b - a), "rises")] {
            if most < back {
                unproven.push(format!("the hysteresis (the input never {never})"));
            }
        }
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
        (verdict.unproven, verdict.left_percent) = (unproven, found.left_percent);
        verdict.cancelled_in = found.cancelled_in().map(str::to_string);
        Some(verdict)
    }

    /// The verdict of a validation of `model`.
    fn of_validated(validated: &Validated, model: &Model) -> Option<Self> {
        let identified = model.verdict().map(|verdict| verdict.error_percent);
        let before = identified.map(|before| format!("; {} % at identification", rough(before)));
        let on = match &validated.files[..] {
            [one] => one.short().to_string(),
            several => format!("{} records", several.len()),
        };
        let measured = format!("free run on {on}{}", before.unwrap_or_default());
        let mut verdict = Verdict::of(validated, validated.total().rms_pp_percent, measured)?;
        if let Some(identified) = model.verdict() {
            (verdict.left_percent, verdict.cancelled_in) = (identified.left_percent, identified.cancelled_in);
        }
        // A small signal has a large error over its own peak-to-peak, most of it noise.
        let whole = verdict.u;
        let large = validated.files.iter().filter(|c| validated.files.len() == 1 || c.is_large(whole));
        let finite = large.filter(|c| c.percent().is_finite());
        if let Some(worst) = finite.max_by(|a, b| a.percent().total_cmp(&b.percent())) {
            if validated.files.len() > 1 {
                (verdict.worst_record, verdict.worst_percent) = (Some(worst.short().into()), Some(worst.percent()));
            }
            verdict.times_worse = identified.and_then(|before| worst.times_worse(before));
        }
        let subject = |text: &String| text.split(':').next().unwrap_or_default().to_string();
        verdict.unproven = validated.not_covered().iter().map(subject).collect();
        if let Some(domain) = model.identified()
            && verdict.u[1] - verdict.u[0] < WHOLE * (domain.u[1] - domain.u[0])
        {
            verdict.unproven.push(format!("inputs outside {}", range(verdict.u, &verdict.unit)));
        }
        Some(verdict)
    }

    /// True if a longer search would have found a better fit.
    fn is_unfinished(&self) -> bool {
        self.left_percent.is_some() || self.cancelled_in.is_some()
    }

    /// The figures of free runs; `None` if there are none, or the error is not finite.
    fn of(validated: &Validated, error_percent: f64, measured: String) -> Option<Self> {
        let whole = Domain::together(validated.files.iter().map(|c| c.domain))?;
        let large = validated.files.iter().filter(|c| c.is_large(whole.u)).map(|c| c.domain);
        let unit = validated.files.first()?.record.units().u.clone();
        let noise_percent = validated.floor().map(|floor| 100.0 * floor.rms / validated.total().peak_to_peak);
        let hz = Domain::together(large).and_then(|domain| domain.hz);
        let found = Verdict { error_percent, measured, noise_percent, u: whole.u, unit, hz, ..Verdict::default() };
        error_percent.is_finite().then_some(found)
    }
}

impl Compared {
    /// True if its input covers much of this range.
    fn is_large(&self, [low, high]: [f64; 2]) -> bool {
        let [lowest, highest] = self.domain.u;
        highest - lowest >= LARGE * (high - low)
    }

    /// Rms error over peak-to-peak of this record [%].
    fn percent(&self) -> f64 {
        self.validation.metrics.rms_pp_percent
    }

    /// The error over that at identification `before` [%]; `None` if it is not much larger, or if noise or a constant
    /// offset explain it: identification estimates an offset for each record.
    fn times_worse(&self, before: f64) -> Option<f64> {
        let Validation { metrics, mean_error: constant, floor, .. } = self.validation;
        let noise = floor.map_or(0.0, |floor| floor.rms);
        let rest = (metrics.mse - constant * constant - noise * noise).max(0.0).sqrt();
        let is_worse = 100.0 * rest / metrics.peak_to_peak > WORSE * before;
        is_worse.then(|| self.percent() / before).filter(|times| times.is_finite())
    }
}

/// The largest difference, by `of`, of a sample from an earlier one: with `b - a` the largest rise.
fn swing(u: &[f64], of: fn(f64, f64) -> f64) -> f64 {
    let mut base = u[0];
    u.iter().fold(0.0, |most: f64, &u| {
        if of(base, u) < 0.0 {
            base = u;
        }
        most.max(of(base, u))
    })
}

/// A range as text: `+-25 V`, `-20 to 120 V`, both ends rounded to a hundredth of the decade of its width.
fn range([low, high]: [f64; 2], unit: &str) -> String {
    let decade = log10(high - low).floor();
    let step = pow(10.0, decade - 2.0);
    let rounded =
        |x: f64| if step > 0.0 && step.is_finite() { round((x / step).round() * step + 0.0) } else { round(x) };
    let [least, most] = [low, high].map(rounded);
    if low < 0.0 && rounded(-low) == most { format!("+-{most} {unit}") } else { format!("{least} to {most} {unit}") }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let noise = self.noise_percent.map(|noise| format!("; noise {} %", rough(noise))).unwrap_or_default();
        let (error, measured) = (rough(self.error_percent), &self.measured);
        match self.times_worse {
            Some(times) => write!(f, "{} times worse than at identification: ", rough(times))?,
            None if self.worst_percent.unwrap_or(self.error_percent) > POOR || self.is_unfinished() => {
                f.write_str("only good to ")?;
            }
            None => f.write_str("good to ")?,
        }
        match self.worst_percent.zip(self.worst_record.as_ref()) {
            Some((worst, record)) => {
                let worst = rough(worst);
                write!(f, "{worst} % of stroke at worst ({record}; {error} % in the {measured}{noise}), ")?;
            }
            None => write!(f, "{error} % of stroke ({measured}{noise}), ")?,
        }
        match self.hz {
            Some([low, high]) if high < ONE * low => write!(f, "{} Hz, ", rough(high))?,
            Some([low, high]) => write!(f, "{} to {} Hz, ", rough(low), rough(high))?,
            None => {}
        }
        f.write_str(&range(self.u, &self.unit))?;
        if let Some(stage) = &self.cancelled_in {
            write!(f, "; the search was cancelled in the stage \"{stage}\": the model is the best until then")?;
        }
        if let Some(left) = self.left_percent {
            let left = rough(left);
            write!(
                f,
                "; the fit is not at its minimum: another step would lower its sum of squared errors by {left} %"
            )?;
        }
        if !self.unproven.is_empty() {
            write!(f, "; unproven: {}", self.unproven.join(", "))?;
        }
        Ok(())
    }
}

/// The verdict of the identification of a model, as its file states it.
pub trait StatedVerdict {
    /// How good this model was at its identification; `None` if its file does not say so.
    fn verdict(&self) -> Option<Verdict>;

    /// The verdict in words, for files and pages about this model; or a sentence that there is none.
    fn proven(&self) -> String;
}

impl StatedVerdict for Model {
    fn verdict(&self) -> Option<Verdict> {
        Verdict::deserialize(&self.provenance()["verdict"]).ok()
    }

    fn proven(&self) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ValidateRecords;
    use crate::identification::{IdentifyOptions, Records};
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::progress::Stage;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::noise;
    use piezoid_validation::ValidateOptions;
    use serde_json::json;
    use std::sync::Arc;

    const TS: f64 = 1e-3;

    /// A gain of 1 um/V whose verdict says 0.1 %.
    fn model() -> Model {
        let model =
            Model::new(Arc::new(Proportional::new(TS, 1.0).unwrap()), Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap();
        let before = json!({"error_percent": 0.1, "measured": "free run on held-out parts", "noise_percent": null,
            "u": [-10.0, 10.0], "unit": "V", "hz": [8.0, 8.0], "unproven": []});
        model.with_provenance(json!({"verdict": before}))
    }

    /// A sine of +-10 V, with an output of another gain, an offset and noise [um].
    fn record(name: &str, gain: f64, offset: f64, rms: f64) -> (String, Record) {
        let u: Vec<f64> = (0..4000).map(|t| 10.0 * (0.05 * f64::from(t)).sin()).collect();
        let y = u.iter().zip(noise(3, 4000)).map(|(u, e)| gain * u + offset + rms * e).collect();
        (name.into(), Record::new(TS, u, y).unwrap())
    }

    fn verdict_on(records: &[(String, Record)]) -> Verdict {
        let model = model();
        ValidateOptions::default().on(&model, records).unwrap().verdict(&model).unwrap()
    }

    #[test]
    fn of_several_records_the_worst_is_named_with_its_error() {
        let records = [record("a/2Hz.csv", 1.0, 0.0, 0.02), record("a/80Hz.csv", 1.002, 0.0, 0.05)];
        let verdict = verdict_on(&records);
        let (worst, all) = (verdict.worst_percent.unwrap(), verdict.error_percent);
        assert!(worst > 1.2 * all && all > 0.1, "{worst} {all}");
        let (worst, all) = (rough(worst), rough(all));
        let sentence = format!(
            "good to {worst} % of stroke at worst (80Hz.csv; {all} % in the free run on 2 records; 0.1 % at \
             identification; noise "
        );
        assert!(verdict.to_string().starts_with(&sentence), "{verdict}");
        let alone = verdict_on(&records[1..]).to_string();
        assert!(alone.starts_with(&format!("good to {worst} % of stroke (free run on 80Hz.csv; 0.1 % at")), "{alone}");
    }

    #[test]
    fn an_error_far_above_that_at_identification_is_not_called_good() {
        let verdict = verdict_on(&[record("r.csv", 1.1, 0.0, 0.02)]);
        assert!((verdict.times_worse.unwrap() - 32.0).abs() < 0.1, "{verdict:?}");
        assert!(verdict.to_string().starts_with("32 times worse than at identification: 3.2 % of stroke (free run"));
        assert_eq!(serde_json::from_value::<Verdict>(json!(verdict)).unwrap(), verdict);
        // Noise, or a constant offset, does not make the model worse.
        for same in [record("r.csv", 1.0, 0.0, 0.2), record("r.csv", 1.0, 0.5, 0.02)] {
            let verdict = verdict_on(&[same]);
            assert!(verdict.error_percent > 0.7 && verdict.to_string().starts_with("good to "), "{verdict}");
        }
    }

    #[test]
    fn the_ends_of_a_range_have_the_digits_of_its_width() {
        for (ends, text) in [
            ([0.31, 119.7], "0 to 120 V"),
            ([-25.03, 24.98], "+-25 V"),
            ([-20.2, 120.1], "-20 to 120 V"),
            ([29.94, 31.02], "29.94 to 31.02 V"),
            ([-0.0004, 9.996], "0 to 10 V"),
            ([5.0, 5.0], "5 to 5 V"),
        ] {
            assert_eq!(range(ends, "V"), text);
        }
    }

    #[test]
    fn a_fit_that_is_not_at_its_minimum_is_not_called_good() {
        let mut verdict = model().verdict().unwrap();
        assert!(verdict.to_string().starts_with("good to 0.1 %"), "{verdict}");
        verdict.left_percent = Some(8.2);
        let sentence = verdict.to_string();
        assert!(
            sentence.starts_with("only good to 0.1 %") && sentence.contains("squared errors by 8.2 %"),
            "{sentence}"
        );
        // What is made of the model, and its validation, say so too.
        let model = model().with_provenance(json!({"verdict": verdict}));
        assert!(model.proven().contains("not at its minimum"));
        let again = ValidateOptions::default().on(&model, &[record("r.csv", 1.0, 0.0, 0.001)]).unwrap();
        assert_eq!(again.verdict(&model).unwrap().left_percent, Some(8.2));
    }

    #[test]
    fn an_input_that_never_falls_or_a_short_record_leaves_the_hysteresis_unproven() {
        let sentence = |operator: &str, u: Vec<f64>| {
            let y = u.iter().zip(noise(5, u.len())).map(|(u, e)| 0.1 * u + 0.001 * e).collect();
            let records = [Record::new(0.02, u, y).unwrap()];
            let options = IdentifyOptions { operator: operator.into(), order: Some(0), ..IdentifyOptions::default() };
            let result =
                options.identify_and_validate(Records::from(&records), &["r"], ("", &[]), &mut Stage::ignore).unwrap();
            result.found.model.verdict().unwrap().unproven
        };
        let step = |from: f64, to: f64| (0..1500).map(|t| if t < 100 { from } else { to }).collect::<Vec<f64>>();
        for (u, expected) in [
            (step(0.0, 80.0), Some("the hysteresis (the input never falls)")),
            (step(80.0, 0.0), Some("the hysteresis (the input never rises)")),
            ((0..1500).map(|t| 40.0 * (0.05 * f64::from(t)).sin()).collect(), None),
        ] {
            let unproven = sentence("proportional", u);
            let found = unproven.iter().find(|text| text.starts_with("the hysteresis"));
            assert_eq!(found.map(String::as_str), expected, "{unproven:?}");
        }
        let short = sentence("prandtl-ishlinskii", (0..24).map(|t| 50.0 - 50.0 * (0.3 * f64::from(t)).cos()).collect());
        assert!(short[0].starts_with("the hysteresis (24 samples are few for its "), "{short:?}");
    }

    #[test]
    fn a_resonance_that_only_the_small_signal_excites_is_proven() {
        let mode = Arx::new(TS, vec![1.5714, -0.9391], vec![0.0, 0.2, 0.1677]).unwrap();
        let of = |u: Vec<f64>, seed: u64| {
            let y = mode.simulate(&u).into_iter().zip(noise(seed, u.len())).map(|(y, e)| y + 1e-3 * e).collect();
            Record::new(TS, u, y).unwrap()
        };
        let sine = of((0..4000).map(|t| 10.0 * (0.05 * f64::from(t)).sin()).collect(), 1);
        let small = of(Prbs::default().samples(TS, 2047).unwrap(), 2);
        let unproven = |small_signal: &[Record]| {
            let options =
                IdentifyOptions { operator: "proportional".into(), order: Some(2), ..IdentifyOptions::default() };
            let records = Records { small_signal, large_signal: std::slice::from_ref(&sine) };
            let names = &["small", "sine"][1 - small_signal.len()..];
            let result = options.identify_and_validate(records, names, ("", &[]), &mut Stage::ignore).unwrap();
            result.found.model.verdict().unwrap().unproven.join(", ")
        };
        let with = unproven(&[small]);
        assert!(!with.contains("resonance") && with.contains("large signals at other frequencies"), "{with}");
        let without = unproven(&[]);
        assert!(without.contains("at other frequencies") && !without.contains("large signals"), "{without}");
    }
}
