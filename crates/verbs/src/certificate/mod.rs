//! The certificate of a model: the expanded uncertainty of the displacement that it predicts, after the GUM.
//!
//! The measurand is the displacement that a voltage causes, as the free run of the model predicts it, within the ranges
//! of voltage, frequency and stroke of the records. No record may be one that the model was identified from. Each
//! record, and each band of frequencies of several cycles, has a budget of its own; the expanded uncertainty of the
//! certificate is the largest of all, so that an error at one frequency is not averaged away. What is not stated is
//! listed, and is in no budget.
//!
//! A certificate is a statement of its user. It does not read a clock: the same input gives the same bytes.
//!
//! Reference: JCGM 100:2008, Guide to the expression of uncertainty in measurement. The mean error: 3.2.4 and F.2.4.5;
//! Phillips, Eberhardt & Parry 1997, doi:10.6028/jres.102.039.

mod budget;
mod evidence;
mod options;
mod part;

pub use budget::{Budget, Contribution, Digit, Evaluation};
pub use options::{CertificateOptions, MeanError, NoiseOrigin};
pub use part::{CertifiedBand, CertifiedRecord};

use super::origin::{Training, training};
use super::{Compared, File, Origin, Source, ValidateRecords, Validated};
use part::{Reach, Rules};
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{join, short};
use piezoid_numerics::options::Options;
use piezoid_records::record::{Record, Units};
use piezoid_validation::Offset;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

/// Smallest number of samples of a record.
const MIN_SAMPLES: usize = 100;

/// The certificate of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    /// What is stated.
    pub options: CertificateOptions,
    /// The model in one line.
    pub model: String,
    /// SHA-256 of its file.
    pub model_sha256: String,
    /// The verdict of the validation in words, if there is one.
    pub verdict: Option<String>,
    /// Units of voltage and displacement.
    pub units: Units,
    /// The records.
    pub records: Vec<CertifiedRecord>,
    /// The bands of frequencies, if there are several.
    pub bands: Vec<CertifiedBand>,
    /// The expanded uncertainty, rounded up to two digits [output unit].
    pub expanded: f64,
    /// Its last digit.
    pub digit: Digit,
    /// What the user adds to every prediction; `None` if the mean error is a part of the uncertainty [output unit].
    pub correction: Option<f64>,
    /// Sources of uncertainty that are not stated and in no budget.
    pub not_stated: Vec<&'static str>,
    /// Remarks.
    pub remarks: Vec<String>,
}

impl CertificateOptions {
    /// Certifies the model in a file with the records in others.
    ///
    /// # Errors
    /// The errors of [`on`](CertificateOptions::on), and those of reading.
    pub fn run(&self, model: &File, data: Vec<Source>) -> Result<Certificate, Error> {
        let of_source = |source: Source| source.read().map(|(record, origin)| (source.file.name, record, origin));
        let records = data.into_iter().map(of_source).collect::<Result<Vec<_>, _>>()?;
        self.on(&model.model()?, &sha256(&model.bytes), records)
    }

    /// Certifies a model with records, each with its name and its origin.
    ///
    /// # Errors
    /// Returns an error if a record is one that the model was identified from, if the output is no length, if there is
    /// no record, and for statements that are invalid. The errors of [`ValidateRecords::on`].
    pub fn on(
        &self,
        model: &Model,
        model_sha256: &str,
        records: Vec<(String, Record, Origin)>,
    ) -> Result<Certificate, Error> {
        let mut remarks = Vec::new();
        unseen(model, &records, &mut remarks)?;
        let (named, origins): (Vec<(String, Record)>, Vec<Origin>) =
            records.into_iter().map(|(name, record, origin)| ((name, record), origin)).unzip();
        let validated = self.validation.on(model, &named)?;
        let Some(first) = validated.files.first() else {
            return Err(Error::Content("a certificate needs one or more records: give them".into()));
        };
        let units = first.record.units().clone();
        if Units::factor(&units.y, "um").is_none() {
            let why = "a certificate states a displacement";
            return Err(Error::units(&format!("{why}; the output"), &units.y, "a unit of length (um, nm, mm, m)"));
        }
        for compared in &validated.files {
            let have = compared.record.len() - compared.validation.start;
            if have < MIN_SAMPLES {
                let (what, remedy) = ("the record".into(), "give a longer one".into());
                return Err(Error::TooShort { what, have, need: MIN_SAMPLES, remedy }.of(&compared.name));
            }
        }
        let stated = self.stated(&units.y)?;
        let verdict = validated.verdict(model);
        let rules = Rules { options: self, stated: &stated, units: &units };
        let reaches = validated.files.iter().map(|c| Reach::of(c, model, self)).collect::<Result<Vec<_>, _>>()?;
        let correction = rules.correction(&validated.files);
        let parts = validated.files.iter().cloned().zip(origins).zip(&reaches);
        let mut records: Vec<CertifiedRecord> =
            parts.map(|((compared, origin), reach)| rules.record(compared, origin, reach, correction)).collect();
        let corrected = match correction {
            None => None,
            Some((value, _)) => Some(self.corrected(model, &validated, value)?),
        };
        let [bins, _] = corrected.as_ref().unwrap_or(&validated).bins();
        let bands = rules.bands(&bins, &records, &Reach::largest(&reaches));
        let all = records.iter().map(|r| r.budget.expanded).chain(bands.iter().map(|b| b.budget.expanded));
        let all: Vec<f64> = all.collect();
        if all.iter().any(|expanded| !expanded.is_finite()) {
            let why = "the squares of the errors are not finite: check the scale of the records, and what is stated";
            return Err(Error::Content(why.into()));
        }
        let (expanded, digit) = Digit::of(all.into_iter().fold(0.0, f64::max));
        let offset = correction.map_or(0.0, |(value, _)| value);
        records.iter_mut().for_each(|record| record.count_within(offset, expanded));
        let not_stated = rules.not_stated();
        let mut certificate = Certificate {
            options: self.clone(),
            model: model.to_string(),
            model_sha256: model_sha256.into(),
            verdict: verdict.as_ref().map(ToString::to_string),
            units,
            records,
            bands,
            expanded,
            digit,
            correction: correction.map(|(value, _)| value),
            not_stated,
            remarks,
        };
        certificate.remark(&validated);
        Ok(certificate)
    }

    /// The validation with records less the correction: the errors of bands contain their mean.
    fn corrected(&self, model: &Model, validated: &Validated, correction: f64) -> Result<Validated, Error> {
        let shifted = |compared: &Compared| {
            let record = &compared.record;
            let y = record.y().iter().map(|y| y - correction).collect();
            Ok((compared.name.clone(), record.with_samples(record.ts(), record.u().to_vec(), y)?))
        };
        self.validation.on(model, &validated.files.iter().map(shifted).collect::<Result<Vec<_>, Error>>()?)
    }
}

/// The SHA-256 of these bytes.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns an error if one of the records, or a part of it, is one that the model was identified from. What cannot be
/// known becomes a remark.
fn unseen(model: &Model, records: &[(String, Record, Origin)], remarks: &mut Vec<String>) -> Result<(), Error> {
    let Some(known) = training(model) else {
        let text = "the model does not state the records that it was identified from: that the records of this \
                    certificate are others is a statement of its issuer";
        remarks.push(text.into());
        return Ok(());
    };
    if known.iter().any(|one| one.origin().sha256.is_empty()) || known.is_empty() {
        remarks.push(
            "the model was identified from records that were in no file: that those of this certificate are others is \
             a statement of its issuer"
                .into(),
        );
    }
    for (name, _, origin) in records.iter().filter(|(_, _, origin)| !origin.sha256.is_empty()) {
        let same = |one: &&Training| one.origin().sha256 == origin.sha256;
        for one in known.iter().filter(same) {
            let ([a, b], [c, d]) = (origin.times(), one.origin().times());
            if a < d && c < b {
                let why = "the model was identified from this record, which therefore does not show the error of other \
                           drives: give records that it was not identified from";
                return Err(Error::Content(why.into()).of(name));
            }
            remarks.push(format!("{name} is another part of a file that the model was identified from"));
        }
    }
    Ok(())
}

impl Certificate {
    /// The record or the band whose expanded uncertainty is the largest, with its budget.
    pub fn worst(&self) -> (String, &Budget) {
        let records = self.records.iter().map(|r| (r.compared.short().to_string(), &r.budget));
        let bands = self.bands.iter().map(|b| (b.name(), &b.budget));
        let all: Vec<(String, &Budget)> = records.chain(bands).collect();
        // Of equal ones the first, which is a record.
        let largest = all.iter().map(|(_, budget)| budget.expanded).fold(0.0, f64::max);
        let first = all.iter().position(|(_, budget)| budget.expanded >= largest).unwrap_or(0);
        all.into_iter().nth(first).unwrap_or_else(|| (String::new(), &self.records[0].budget))
    }

    /// The range of the inputs, and of their frequencies.
    pub fn domain(&self) -> Option<Domain> {
        Domain::together(self.records.iter().map(|record| record.compared.domain))
    }

    /// Lowest and highest displacement of the records [output unit].
    pub fn stroke(&self) -> [f64; 2] {
        let y = self.records.iter().flat_map(|record| record.compared.record.y().iter().copied());
        let (low, high) = piezoid_numerics::series::ends(y);
        [low, high]
    }

    /// Share of all samples within the expanded uncertainty [%].
    pub fn within_percent(&self) -> f64 {
        let n: usize = self.records.iter().map(|record| record.n).sum();
        let within: f64 = self.records.iter().map(|record| record.n as f64 * record.within_percent).sum();
        within / n as f64
    }

    /// Its number: as stated, or made of the hashes of all that it depends on.
    pub fn number(&self) -> String {
        self.options.number.clone().unwrap_or_else(|| {
            let hashes = self.records.iter().map(|record| &*record.origin.sha256);
            let all: Vec<&str> = [&*self.model_sha256].into_iter().chain(hashes).collect();
            let text = format!("{} {}", all.join(" "), self.options.to_json());
            format!("piezoid-{}", &sha256(text.as_bytes())[..16])
        })
    }

    /// What is certified, in words.
    pub fn measurand(&self) -> &'static str {
        match self.options.validation.offset {
            Offset::Kept => "displacement of the actuator, as the free run of the model predicts it from the voltage",
            Offset::Free => {
                "displacement of the actuator about its mean over a record, as the free run of the model predicts it \
                 from the voltage; a constant offset is not a part of it"
            }
            Offset::Drift => {
                "displacement of the actuator about a straight line over a record, as the free run of the model \
                 predicts it from the voltage; a constant offset and a linear drift are not a part of it"
            }
        }
    }

    /// The result in one sentence.
    pub fn summary(&self) -> String {
        let (worst, budget) = self.worst();
        let (expanded, y) = (self.digit.text(self.expanded), &self.units.y);
        let probability = self.options.coverage;
        let correction = self.correction.map(|value| {
            let sign = if value < 0.0 { "less" } else { "plus" };
            format!(" {sign} {} {y}", self.digit.text(value.abs()))
        });
        let correction = correction.unwrap_or_default();
        format!(
            "displacement = prediction{correction} +- {expanded} {y} (k = {:.2}, {probability} %; largest of {}, \
             {worst}); {} % of the samples are within",
            budget.k,
            self.scope(),
            share(self.within_percent()),
        )
    }

    fn scope(&self) -> String {
        let count = |n: usize, one: &str| if n == 1 { format!("1 {one}") } else { format!("{n} {one}s") };
        let parts = [(self.records.len(), "record"), (self.bands.len(), "band")];
        join(&parts.into_iter().filter(|(n, _)| *n > 0).map(|(n, one)| count(n, one)).collect::<Vec<_>>())
    }

    fn remark(&mut self, validated: &Validated) {
        let y = self.units.y.clone();
        let several = validated.files.len();
        self.remarks.push(match several {
            1 => "one record does not show how the error differs from drive to drive".into(),
            n => {
                let spread = self.records.iter().map(|record| record.budget.standard);
                let (low, high) = piezoid_numerics::series::ends(spread);
                format!(
                    "from record to record, the standard uncertainty lies between {} and {} {y}; if a further drive is \
                     like these, its error is larger than that of all {n} records with a probability of 1/{}",
                    short(low),
                    short(high),
                    n + 1
                )
            }
        });
        for record in &self.records {
            let name = record.compared.short();
            let offset = self.correction.unwrap_or(0.0);
            if self.options.validation.offset == Offset::Kept
                && (record.mean_error - offset).abs() > 2.0 * record.mean_uncertainty
            {
                let [mean, left] = [record.mean_error, record.mean_error - offset].map(short);
                self.remarks.push(match self.correction {
                    Some(_) => format!("{name}: of the mean error of {mean} {y}, the correction leaves {left} {y}"),
                    None => format!("{name}: the mean error of {mean} {y} is in the uncertainty"),
                });
            }
            if record.noise.is_none() {
                let text = "the noise of the record is not known: the error of the model contains it";
                self.remarks.push(format!("{name}: {text}"));
            }
            let Budget { k, student_k, .. } = record.budget;
            if k > student_k {
                self.remarks.push(format!(
                    "{name}: its errors are not normal, so that k is {k:.2}, within which {} % of them lie, and not \
                     {student_k:.2}",
                    self.options.coverage
                ));
            }
            let texts = record.compared.validation.remarks.iter();
            self.remarks.extend(texts.map(|remark| format!("{name}: {remark}")));
        }
        if self.within_percent() < self.options.coverage {
            let percent = share(self.within_percent());
            self.remarks.push(format!("only {percent} % of all samples are within: its errors are not normal"));
        }
    }

    /// All results as a document.
    pub fn to_json(&self) -> Value {
        let (worst, budget) = self.worst();
        let domain = self.domain();
        json!({
            "number": self.number(), "version": env!("CARGO_PKG_VERSION"), "options": self.options.to_json(),
            "measurand": self.measurand(), "unit": self.units.y, "model": self.model, "model_sha256": self.model_sha256,
            "verdict": self.verdict, "summary": self.summary(),
            "coverage_percent": self.options.coverage, "expanded": self.expanded, "correction": self.correction,
            "worst": worst, "budget": budget, "within_percent": self.within_percent(),
            "range": {
                "u": domain.map(|d| d.u), "u_unit": self.units.u, "hz": domain.and_then(|d| d.hz), "y": self.stroke(),
            },
            "records": self.records.iter().map(CertifiedRecord::to_json).collect::<Vec<_>>(),
            "bands": self.bands, "not_stated": self.not_stated, "remarks": self.remarks,
        })
    }
}

/// A percentage with so many digits that less than all is never shown as all.
pub fn share(percent: f64) -> String {
    let text = format!("{percent:.2}");
    if text == "100.00" && percent < 100.0 {
        "99.99".into()
    } else {
        text.trim_end_matches('0').trim_end_matches('.').into()
    }
}

#[cfg(test)]
mod tests;
