//! The record of a file: how its columns are read, and the steps of its preparation.

use super::{DataFile, Origin};
use piezoid_numerics::error::Error;
use piezoid_numerics::options::by_name;
use piezoid_records::formats::{ColumnSelection, Table};
use piezoid_records::preparation::PrepareOptions;
use piezoid_records::record::{Record, Units};
use serde::{Deserialize, Serialize};

/// A file, and how its record is read and prepared.
#[derive(Debug, Clone)]
pub struct Source {
    /// The file.
    pub file: DataFile,
    /// How its columns are read.
    pub columns: ColumnSelection,
    /// What is done to the record, in this order.
    pub preparation: Vec<Step>,
    /// Origin of the record, if the file was derived from another one.
    pub origin: Option<Origin>,
}

/// A step of the preparation of a record; as JSON such as `{"prepare": {"decimate": 4}}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Step {
    /// [`Record::part`] from the first time to the second [s]; to the end without a second.
    Part(f64, Option<f64>),
    /// [`Record::scaled`] by these factors of input and output.
    Scaled(String, String),
    /// [`Record::output_in`] this unit.
    OutputIn(String),
    /// [`Record::with_units`].
    Units(Units),
    /// [`PrepareOptions::run`].
    #[serde(with = "by_name")]
    Prepare(PrepareOptions),
}

impl Source {
    /// Files whose columns are read in the same way, and whose records are used as they are.
    pub fn all<F: Into<DataFile>>(files: Vec<F>, columns: &ColumnSelection) -> Vec<Source> {
        files.into_iter().map(|file| Source::new(file, columns.clone(), Vec::new())).collect()
    }

    /// A file with the selection of its columns and the preparation of its record.
    pub fn new(file: impl Into<DataFile>, columns: ColumnSelection, preparation: Vec<Step>) -> Self {
        Source {
            file: file.into(),
            columns,
            preparation: preparation.into_iter().filter(|step| !step.is_empty()).collect(),
            origin: None,
        }
    }

    /// The record. If the first step resamples it, its times may be uneven: the samples are interpolated first, and the
    /// record's history says so.
    ///
    /// # Errors
    /// The errors of [`DataFile::record`] and of the steps.
    pub fn record(&self) -> Result<Record, Error> {
        self.of(self.file.table()?.0)
    }

    /// The record, and where it comes from.
    ///
    /// # Errors
    /// The errors of [`record`](Source::record).
    pub fn read(&self) -> Result<(Record, Origin), Error> {
        // A file may change between two readings: what is hashed is what was read.
        let (table, _, sha256) = self.file.hashed()?;
        let (columns, preparation) = (self.columns.clone(), self.preparation.clone());
        let own = || Origin { columns, preparation, ..Origin::of(&self.file.name, sha256) };
        Ok((self.of(table)?, self.origin.clone().unwrap_or_else(own)))
    }

    /// The record in the table of its file.
    pub(super) fn of(&self, table: Table) -> Result<Record, Error> {
        let resample = match self.preparation.first() {
            Some(Step::Prepare(options)) => options.resample,
            _ => None,
        };
        let record = table.resampled(&self.columns, resample).map_err(|error| error.of(&self.file.name))?;
        drop(table);
        let prepared = self.preparation.iter().try_fold(record, |record, step| step.run(record));
        prepared.map_err(|error| error.about(&self.file.name))
    }
}

impl Step {
    /// True if it leaves every record as it is.
    pub fn is_empty(&self) -> bool {
        match self {
            Step::Part(from, to) => *from == 0.0 && to.is_none(),
            Step::Scaled(input, output) => [input, output].iter().all(|factor| factor.trim().is_empty()),
            Step::Prepare(options) => *options == PrepareOptions::default(),
            Step::OutputIn(_) | Step::Units(_) => false,
        }
    }

    /// The record after this step.
    ///
    /// # Errors
    /// The errors of the method that the step names.
    pub fn run(&self, record: Record) -> Result<Record, Error> {
        match self {
            Step::Part(from, to) => record.part(*from, to.unwrap_or(f64::INFINITY)),
            Step::Scaled(input, output) => record.scaled(input, output),
            Step::OutputIn(unit) => record.output_in(unit),
            Step::Units(units) => Ok(record.with_units(units.clone())),
            Step::Prepare(options) => options.run(&record),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::File;

    /// A record with a period of 1 ms whose stamps are off by up to `jitter` [ms].
    fn file(jitter: f64) -> File {
        let mut text = String::from("t_s,u_V,y_um\n");
        for k in 0..400 {
            let t = 1e-3 * (f64::from(k) + jitter * f64::from(k * 7919 % 13 - 6) / 6.0);
            text += &format!("{t:.7},{:.6},{:.6}\n", (30.0 * t).sin(), 20.0 * (30.0 * t).cos());
        }
        File::new("jitter.csv", text)
    }

    fn prepared(file: &File, columns: ColumnSelection, options: PrepareOptions) -> Result<Record, Error> {
        Source::new(file.clone(), columns, vec![Step::Prepare(options)]).record()
    }

    fn resampled(file: &File, ts: f64) -> Result<Record, Error> {
        prepared(file, ColumnSelection::default(), PrepareOptions { resample: Some(ts), ..PrepareOptions::default() })
    }

    #[test]
    fn uneven_times_are_refused_unless_the_record_is_resampled() {
        let file = file(0.2);
        let refused = prepared(&file, ColumnSelection::default(), PrepareOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("use `prepare` with the option resample = 0.001;"), "{refused}");
        for (ts, count) in [(1e-3, 400), (4e-3, 100), (5e-4, 799)] {
            let record = resampled(&file, ts).unwrap();
            assert_eq!((record.ts(), record.len().abs_diff(count) <= 1), (ts, true), "{}", record.len());
            // The first stamp is 0.2 ms early.
            let at = |k: usize| 30.0 * (k as f64 * ts - 2e-4);
            let inner = record.len() / 10..record.len() * 9 / 10;
            let worst = inner.map(|k| (record.u()[k] - at(k).sin()).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-3, "{worst} at {ts} s");
            let message = &record.history()[0];
            assert!(message.starts_with("uneven times (steps of 6.333e-4 s to 0.001067 s"), "{message}");
        }
    }

    #[test]
    fn even_times_are_resampled_as_ever() {
        let record = resampled(&file(0.0), 2e-3).unwrap();
        assert!(record.history().iter().all(|step| !step.contains("uneven")), "{:?}", record.history());
    }

    #[test]
    fn a_long_gap_is_not_bridged() {
        let whole = String::from_utf8(file(0.2).bytes).unwrap();
        let lines: Vec<&str> =
            whole.lines().enumerate().filter(|(k, _)| !(101..=150).contains(k)).map(|(_, l)| l).collect();
        let gap = File::new("gap.csv", lines.join("\n"));
        let refused = resampled(&gap, 1e-3).unwrap_err().to_string();
        assert!(refused.contains("there is no sample from 0.09"), "{refused}");
        let (_, from) = refused.rsplit_once("give `from` = ").unwrap();
        let columns = ColumnSelection { from: from.parse().ok(), ..ColumnSelection::default() };
        let options = PrepareOptions { resample: Some(1e-3), ..PrepareOptions::default() };
        assert_eq!(prepared(&gap, columns, options).unwrap().len(), 250);
    }

    #[test]
    fn times_that_stand_still_are_not_resampled() {
        let still = File::new("still.csv", "t_s,u_V,y_um\n0,1,2\n0.1,1,2\n0.1,1,2\n0.3,1,2\n");
        assert!(resampled(&still, 0.1).unwrap_err().to_string().contains("two rows have the time 0.1 s"));
    }

    #[test]
    fn steps_are_repeated_from_their_document() {
        let document = serde_json::json!([
            {"prepare": {"detrend": "mean", "resample": 2e-3}}, {"part": [0.1, null]}, {"scaled": ["20", "5um/um"]},
            {"output_in": "nm"}, {"units": {"u": "V", "y": "pm"}},
        ]);
        let steps: Vec<Step> = serde_json::from_value(document.clone()).unwrap();
        assert_eq!(serde_json::to_value(&steps).unwrap(), document);
        let source = Source::new(file(0.2), ColumnSelection::default(), steps);
        let record = source.record().unwrap();
        let alone = Source { preparation: source.preparation[..1].to_vec(), ..source }.record().unwrap();
        assert_eq!((record.len(), record.units().y.as_str()), (alone.len() - 50, "pm"));
        assert_eq!((record.u()[0], record.y()[0]), (20.0 * alone.u()[50], alone.y()[50] * 5.0 * 1e3));
        let wrong = serde_json::json!({"prepare": {"decimate": -1}});
        let refused = serde_json::from_value::<Step>(wrong).unwrap_err().to_string();
        assert!(refused.contains("decimate = -1"), "{refused}");
    }
}
