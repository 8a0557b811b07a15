//! Validation of a model on records in files.

use super::{Source, merge, short};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::round;
use piezoid_records::record::Record;
use piezoid_validation::{Bin, Floor, Metrics, Validate, ValidateOptions, Validation, summary};
use serde_json::{Value, json};

/// A record and the model's free run on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Name of the record: that of its file, if it is one. Pages show it without folders.
    pub name: String,
    /// The record.
    pub record: Record,
    /// Results of the free run.
    pub validation: Validation,
}

/// Free runs of a model on several records, all in one unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Validated {
    /// The results, one per record.
    pub files: Vec<Compared>,
}

/// Validation of a model with several records.
pub trait ValidateRecords {
    /// Compares a model with the records in files, in the unit of the first record.
    ///
    /// # Errors
    /// Returns an error for files without records. The errors of [`ValidateOptions::on`].
    fn run(&self, model: &Model, data: Vec<Source>) -> Result<Validated, Error>;

    /// Compares a model with named records, in the unit of the first.
    ///
    /// # Errors
    /// Returns an error for `skip` beyond the end of a record. The errors of [`Model::validate_with`].
    fn on(&self, model: &Model, records: &[(String, Record)]) -> Result<Validated, Error>;
}

impl ValidateRecords for ValidateOptions {
    fn run(&self, model: &Model, data: Vec<Source>) -> Result<Validated, Error> {
        self.on(model, &records(data)?)
    }

    fn on(&self, model: &Model, records: &[(String, Record)]) -> Result<Validated, Error> {
        let compare = |(name, record): &(String, Record)| {
            let record = record.clone().output_in(&records[0].1.units().y)?;
            if self.skip >= record.duration() {
                let duration = round(record.duration());
                let rule = format!("must be less than the duration of this record, {duration} s");
                return Err(Error::parameter("skip", self.skip, rule));
            }
            let validation = model.validate_with(&record, self)?;
            Ok(Compared { name: name.clone(), record, validation })
        };
        let named = |one: &(String, Record)| compare(one).map_err(|e| e.of(&one.0));
        Ok(Validated { files: records.iter().map(named).collect::<Result<_, _>>()? })
    }
}

/// The records of sources, with the names of their files. Each file is dropped once it is read.
pub(super) fn records(data: Vec<Source>) -> Result<Vec<(String, Record)>, Error> {
    data.into_iter().map(|source| source.record().map(|record| (source.file.name, record))).collect()
}

impl Compared {
    /// The name of its file without folders.
    pub fn short(&self) -> &str {
        short(&self.name)
    }

    /// All its results as a document.
    pub fn to_json(&self) -> Value {
        let v = &self.validation;
        let mut object =
            json!({"file": self.name, "unit": self.record.units().y, "initial_condition": v.initial_condition});
        merge(&mut object, json!(v.metrics));
        let without = v.nrmse_without_drift_percent;
        merge(&mut object, json!({"summary": v.summary, "offset": v.offset, "offset_removed": v.offset_removed}));
        merge(&mut object, json!({"drift_per_s": v.drift_per_s, "nrmse_without_drift_percent": without}));
        merge(&mut object, json!({"remarks": v.remarks, "unproven": v.not_covered}));
        merge(&mut object, json!({"by_frequency": v.by_frequency, "by_amplitude": v.by_amplitude}));
        merge(&mut object, json!({"loops": v.loops, "whiteness": v.whiteness, "floor": v.floor}));
        object
    }
}

impl Validated {
    /// The figures of all records together.
    pub fn total(&self) -> Metrics {
        Metrics::total(&self.files.iter().map(|c| c.validation.metrics).collect::<Vec<_>>())
    }

    /// The noise floor of all records together; `None` if that of one is unknown.
    pub fn floor(&self) -> Option<Floor> {
        let records: Vec<_> = self.files.iter().map(|c| (c.validation.metrics, c.validation.floor)).collect();
        Floor::total(&records, &self.total())
    }

    /// The error of all records together in one sentence; `None` if relative errors are undefined.
    pub fn summary(&self) -> Option<String> {
        match self.files.as_slice() {
            [one] => one.validation.summary.clone(),
            _ => summary(&self.total(), self.floor().as_ref(), None),
        }
    }

    /// The bins of all records by frequency and by amplitude.
    pub fn bins(&self) -> [Vec<Bin>; 2] {
        [
            Bin::merged(self.files.iter().flat_map(|c| &c.validation.by_frequency)),
            Bin::merged(self.files.iter().flat_map(|c| &c.validation.by_amplitude)),
        ]
    }

    /// Properties of the model that none of the records tests.
    pub fn not_covered(&self) -> Vec<String> {
        let Some((first, others)) = self.files.split_first() else { return Vec::new() };
        let subject = |text: &str| text.split(':').next().unwrap_or_default().to_string();
        let by_all = |text: &&String| {
            others.iter().all(|c| c.validation.not_covered.iter().any(|other| subject(other) == subject(text)))
        };
        first.validation.not_covered.iter().filter(by_all).cloned().collect()
    }

    /// All results as a document.
    pub fn to_json(&self) -> Value {
        let mut total = json!(self.total());
        let [by_frequency, by_amplitude] = self.bins();
        merge(&mut total, json!({"by_frequency": by_frequency, "by_amplitude": by_amplitude}));
        merge(&mut total, json!({"floor": self.floor(), "summary": self.summary(), "unproven": self.not_covered()}));
        json!({"files": self.files.iter().map(Compared::to_json).collect::<Vec<_>>(), "total": total})
    }
}
