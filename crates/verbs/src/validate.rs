//! Validation of a model on records in files.

use super::{Source, merge, short};
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::round;
use piezoid_records::formats::{MAX_HELD_SAMPLES, Opened};
use piezoid_records::record::Record;
use piezoid_validation::{Bin, Floor, Metrics, Validate, ValidateOptions, Validation, summary};
use serde_json::{Value, json};

/// A record and the model's free run on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Name of the record: that of its file, if it is one. Pages show it without folders.
    pub name: String,
    /// The record; the first samples of one that is too long to be held.
    pub record: Record,
    /// Results of the free run.
    pub validation: Validation,
    /// The domain of its input.
    pub domain: Domain,
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

    /// The same with bounded memory: of long records, only sections are held. A file that cannot be read in pieces, or
    /// of which a part is selected, and a record for a model that interpolates its input are held.
    ///
    /// # Errors
    /// The errors of [`run`](ValidateRecords::run).
    fn in_pieces(&self, model: &Model, data: Vec<Source>) -> Result<Validated, Error>;

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

    fn in_pieces(&self, model: &Model, data: Vec<Source>) -> Result<Validated, Error> {
        let held = if model.interpolates() { usize::MAX } else { MAX_HELD_SAMPLES };
        held_up_to(held, self, model, data)
    }

    fn on(&self, model: &Model, records: &[(String, Record)]) -> Result<Validated, Error> {
        let unit = |first: &(String, Record)| first.1.units().y.clone();
        let unit = records.first().map(unit).unwrap_or_default();
        let compare = |(name, record): &(String, Record)| compare(self, model, name, record, &unit);
        Ok(Validated { files: records.iter().map(compare).collect::<Result<_, _>>()? })
    }
}

/// Compares a model with a record, in this unit.
fn compare(
    options: &ValidateOptions,
    model: &Model,
    name: &str,
    record: &Record,
    unit: &str,
) -> Result<Compared, Error> {
    let validated = || {
        let record = record.output_in(unit)?;
        skips(options, record.duration())?;
        let validation = model.validate_with(&record, options)?;
        Ok(Compared::new(name.into(), record, validation))
    };
    validated().map_err(|error: Error| error.of(name))
}

/// Returns an error if nothing of a record of this duration [s] is left.
fn skips(options: &ValidateOptions, duration: f64) -> Result<(), Error> {
    if options.skip < duration {
        return Ok(());
    }
    let rule = format!("must be less than the duration of this record, {} s", round(duration));
    Err(Error::parameter("skip", options.skip, rule))
}

/// [`ValidateRecords::in_pieces`] with records of up to so many samples held.
fn held_up_to(held: usize, options: &ValidateOptions, model: &Model, data: Vec<Source>) -> Result<Validated, Error> {
    let mut unit = None;
    let mut one = |source: Source| {
        let most = if source.preparation.is_empty() { held } else { usize::MAX };
        let name = source.file.name.clone();
        match source.file.opened(&source.columns, most)? {
            Opened::Held(table, _) => {
                let record = source.of(table)?;
                let unit = unit.get_or_insert_with(|| record.units().y.clone());
                compare(options, model, &name, &record, unit)
            }
            Opened::Long(record) => {
                let unit = unit.get_or_insert_with(|| record.units().y.clone());
                let validated = || {
                    let record = record.output_in(unit)?;
                    skips(options, record.duration())?;
                    let (validation, domain, record) = Validation::of_long(model, &record, options)?;
                    Ok(Compared { name: name.clone(), record, validation, domain })
                };
                validated().map_err(|error: Error| error.of(&name))
            }
        }
    };
    Ok(Validated { files: data.into_iter().map(&mut one).collect::<Result<_, _>>()? })
}

/// The records of sources, with the names of their files. Each file is dropped once it is read.
pub(super) fn records(data: Vec<Source>) -> Result<Vec<(String, Record)>, Error> {
    data.into_iter().map(|source| source.record().map(|record| (source.file.name, record))).collect()
}

impl Compared {
    /// A record and the free run on it.
    pub fn new(name: String, record: Record, validation: Validation) -> Self {
        let domain = Domain::of_input(record.u(), record.ts());
        Compared { name, record, validation, domain }
    }

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
        merge(&mut object, json!({"advice": v.advice, "remarks": v.remarks, "unproven": v.not_covered}));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DataFile, File};
    use piezoid_models::hysteresis::OPERATORS;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::Prbs;
    use piezoid_records::formats::{ColumnSelection, Table};
    use piezoid_testing::noise;
    use std::f64::consts::TAU;

    const TS: f64 = 5e-4;
    const N: usize = 6000;

    fn model() -> Model {
        let operator = OPERATORS.iter().find(|operator| operator.name == "prandtl-ishlinskii").unwrap();
        let beam = Arx::new(TS, vec![1.7424, -0.9453], vec![3.4, 3.3]).unwrap();
        let model = Model::new((operator.example)(TS).unwrap(), beam, 0.0).unwrap();
        let u = sine();
        model.with_identified(Domain::of_input(&u[..2000], TS))
    }

    /// A sine that rises from cycle to cycle.
    fn sine() -> Vec<f64> {
        (0..N).map(|t| (8.0 + 3e-3 * t as f64) * (TAU * 12.0 * t as f64 * TS).sin()).collect()
    }

    fn prbs() -> Vec<f64> {
        Prbs { order: 13, amplitude: 3.0, ..Prbs::default() }.samples(TS, N).unwrap()
    }

    /// The results on a file whose output is that of the model with another gain, noise and a drift; whole, and with at
    /// most 2600 samples held.
    fn both(u: &[f64]) -> [Validated; 2] {
        let (model, options) = (model(), ValidateOptions::default());
        let y = model.simulate(u).into_iter().zip(noise(4, N)).enumerate();
        let y: Vec<f64> = y.map(|(t, (y, e))| 1.03 * y + 0.5 * e + 4.0 + 3e-4 * t as f64).collect();
        let bytes = Table::write("r.csv", TS, &[("u_V", u), ("y_um", &y)]).unwrap();
        let file = DataFile::from(File::new("r.csv", bytes));
        let data = || Source::all(vec![file.clone()], &ColumnSelection::default());
        [options.run(&model, data()).unwrap(), held_up_to(2600, &options, &model, data()).unwrap()]
    }

    #[test]
    fn the_verdict_on_sections_is_that_on_the_whole() {
        for u in [sine(), prbs()] {
            let [whole, sections] = both(&u).each_ref().map(|validated| {
                let mut verdict = validated.verdict(&model()).unwrap();
                // The noise is within a tenth, and so is the band of a PRBS.
                (verdict.noise_percent, verdict.hz) = (None, None);
                let mut remarks = validated.files[0].validation.remarks.clone();
                remarks.retain(|remark| !remark.starts_with("the input has power"));
                (verdict.to_string(), remarks)
            });
            assert_eq!(whole, sections);
        }
    }
}
