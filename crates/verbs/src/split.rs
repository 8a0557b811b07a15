//! The split of `compare`: what methods are fitted to, and the samples on which all are compared.
//!
//! With other records for the comparison, methods are fitted to the whole training records. Otherwise the end of each
//! training record is held out: a method simulates the whole record from its input, and only the end counts. What the
//! input did before is then known, and the initial condition is that of the first samples, which are training data.
//! Small-signal records are training data alone.

use super::{Compared, Validated};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::round;
use piezoid_records::record::Record;
use piezoid_validation::{Validate, ValidateOptions, Validation, output_factor, require_finite};
use serde_json::{Value, json};

/// Least number of samples of the training part, and of the end that is held out.
const LEAST: usize = 10;

/// A record on which methods are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    /// Its name: that of its file, if it is one.
    pub name: String,
    /// The whole record.
    pub record: Record,
    /// The first sample that counts: those before are training data.
    pub from: usize,
}

/// Training data, and the records on which methods are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Split {
    /// What methods are fitted to, with their names: the training records, without the ends that are held out.
    pub training: Vec<(String, Record)>,
    /// The records that count, all in the unit of the first.
    pub tests: Vec<Test>,
    /// The share that is held out; `None` if other records are compared.
    pub held_out: Option<f64>,
}

impl Split {
    /// The split of `training` records; `data` are other records for the comparison, or none.
    ///
    /// # Errors
    /// Returns an error if there is no record, for a record that is too short to be split, and for units that cannot be
    /// converted.
    pub fn of(training: Vec<(String, Record)>, data: Vec<(String, Record)>, held_out: f64) -> Result<Self, Error> {
        let held_out = data.is_empty().then_some(held_out);
        let Some((_, first)) = data.first().or(training.first()) else {
            let remedy = "give training records, records to compare on, or both".into();
            return Err(Error::TooShort { what: "the list of records".into(), have: 0, need: 1, remedy });
        };
        let unit = first.units().y.clone();
        let test = |(name, record): &(String, Record), from: usize| {
            let record = record.output_in(&unit).map_err(|error| error.of(name))?;
            Ok(Test { name: name.clone(), record, from })
        };
        let Some(share) = held_out else {
            let tests = data.iter().map(|one| test(one, 0)).collect::<Result<_, Error>>()?;
            return Ok(Split { training, tests, held_out });
        };
        let mut split = Split { training: Vec::new(), tests: Vec::new(), held_out };
        for named in training {
            let (name, record) = &named;
            let have = record.len();
            let from = ((1.0 - share) * have as f64).round() as usize;
            if from < LEAST || have - from.min(have) < LEAST {
                let what = format!("{name}, of which {} % are held out,", round(100.0 * share));
                let remedy = "give a longer record, hold out another share, or give other records to compare on".into();
                return Err(Error::TooShort { what, have, need: 2 * LEAST, remedy });
            }
            split.tests.push(test(&named, from)?);
            split.training.push((name.clone(), record.slice(0..from).map_err(|error| error.of(name))?));
        }
        Ok(split)
    }

    /// An error if a test is shorter than the time that is skipped, or cannot be simulated by models of the training
    /// records.
    pub(super) fn check(&self, options: &ValidateOptions) -> Result<(), Error> {
        for Test { name, record, from } in &self.tests {
            let duration = record.duration() - *from as f64 * record.ts();
            if options.skip >= duration {
                let rule = format!("must be less than the duration that counts, {} s", round(duration));
                return Err(Error::parameter("skip", options.skip, rule).of(name));
            }
            let Some((first, own)) = self.training.first() else { continue };
            Record::same_sampling(first, own.ts(), name, record.ts())?;
            output_factor(own.units(), record.units()).map_err(|error| error.of(name))?;
        }
        Ok(())
    }

    /// Free runs of a model on all tests.
    ///
    /// # Errors
    /// The errors of [`Validate::validate_with`].
    pub(super) fn validated(&self, model: &Model, options: &ValidateOptions) -> Result<Validated, Error> {
        self.each(options, |k, record, options| {
            let known = Some(self.tests[k].from).filter(|from| *from > 0).unwrap_or(record.len());
            let found = model.validate_end(record, known, options)?;
            require_finite(&found.simulated)?;
            Ok(found)
        })
    }

    /// Free runs that another simulator computed, one per test.
    ///
    /// # Errors
    /// Returns an error for another number of runs, and the errors of [`Validation::of_run`].
    pub(super) fn compared(&self, runs: Vec<Vec<f64>>, options: &ValidateOptions) -> Result<Validated, Error> {
        let (found, expected) = (runs.len(), self.tests.len());
        if found != expected {
            return Err(Error::Content(format!("there are {found} free runs, but {expected} records")));
        }
        self.each(options, |k, record, options| Validation::of_run(record, runs[k].clone(), options))
    }

    fn each(
        &self,
        options: &ValidateOptions,
        validate: impl Fn(usize, &Record, &ValidateOptions) -> Result<Validation, Error>,
    ) -> Result<Validated, Error> {
        let one = |(k, Test { name, record, from }): (usize, &Test)| {
            let start = *from as f64 * record.ts();
            let options = ValidateOptions { skip: start + options.skip, ..*options };
            let validation = validate(k, record, &options).map_err(|error| error.of(name))?;
            Ok(Compared::new(name.clone(), record.clone(), validation))
        };
        Ok(Validated { files: self.tests.iter().enumerate().map(one).collect::<Result<_, _>>()? })
    }

    /// True if a record that is compared is one of the training records.
    pub fn tests_are_training(&self) -> bool {
        let same = |a: &Record, b: &Record| a.u() == b.u() && a.y() == b.y();
        self.tests.iter().any(|test| self.training.iter().any(|(_, record)| same(record, &test.record)))
    }

    /// The split as a document.
    pub(super) fn to_json(&self) -> Value {
        let training = |(name, record): &(String, Record)| json!({"file": name, "n": record.len()});
        let test = |test: &Test| json!({"file": test.name, "n": test.record.len(), "from": test.from});
        json!({
            "held_out": self.held_out,
            "training": self.training.iter().map(training).collect::<Vec<_>>(),
            "compared": self.tests.iter().map(test).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use std::sync::Arc;

    fn record(n: u32) -> (String, Record) {
        let u: Vec<f64> = (0..n).map(|t| (0.1 * f64::from(t)).sin()).collect();
        (format!("{n}"), Record::new(1e-3, u.clone(), u).unwrap())
    }

    #[test]
    fn the_end_of_each_record_is_held_out_and_only_it_counts() {
        let split = Split::of(vec![record(400), record(1000)], Vec::new(), 0.25).unwrap();
        let lengths: Vec<usize> = split.training.iter().map(|(_, record)| record.len()).collect();
        assert_eq!(lengths, [300, 750]);
        let run = |test: &Test| {
            let wrong = |(t, y): (usize, &f64)| if t < test.from { y + 100.0 } else { y + 0.5 };
            test.record.y().iter().enumerate().map(wrong).collect()
        };
        let runs = split.tests.iter().map(run).collect();
        let validated = split.compared(runs, &ValidateOptions::default()).unwrap();
        let total = validated.total();
        assert_eq!(total.n, 350);
        assert!((total.max_abs - 0.5).abs() < 1e-12, "the training part does not count: {}", total.max_abs);
    }

    #[test]
    fn with_other_records_the_whole_training_records_are_fitted() {
        let split = Split::of(vec![record(400)], vec![record(500)], 0.25).unwrap();
        assert_eq!((split.training[0].1.len(), split.tests[0].from, split.held_out), (400, 0, None));
    }

    #[test]
    fn the_output_of_the_held_out_part_does_not_change_the_free_run() {
        let (name, whole) = record(1000);
        let y = whole.y().iter().enumerate().map(|(t, y)| if t < 750 { *y } else { 9.0 }).collect();
        let other = (name.clone(), Record::new(1e-3, whole.u().to_vec(), y).unwrap());
        let gain = Arc::new(Proportional::new(1e-3, 1.0).unwrap());
        let model = Model::new(gain, Arx::new(1e-3, vec![0.9], vec![0.1]).unwrap(), 0.0).unwrap();
        let run = |record: (String, Record)| {
            let split = Split::of(vec![record], Vec::new(), 0.25).unwrap();
            let validated = split.validated(&model, &ValidateOptions::default()).unwrap();
            (validated.files[0].validation.simulated.clone(), split.training)
        };
        assert_eq!(run((name, whole)), run(other));
    }

    #[test]
    fn no_output_that_is_held_out_chooses_the_initial_condition() {
        // Before the held-out end the settled run is nearer, in it that from rest.
        let u: Vec<f64> =
            (0..1000).map(|t| if t < 60 { 1.0 } else { 1.0 + (0.05 * f64::from(t - 60)).sin() }).collect();
        let gain = Arc::new(Proportional::new(1e-3, 1.0).unwrap());
        let model = Model::new(gain, Arx::new(1e-3, vec![0.999], vec![0.001]).unwrap(), 0.0).unwrap();
        let run = |after: f64| {
            let y: Vec<f64> = (0..1000).map(|t| if t < 60 { 0.6 } else { after }).collect();
            let record = ("a".to_string(), Record::new(1e-3, u.clone(), y).unwrap());
            let split = Split::of(vec![record], Vec::new(), 0.94).unwrap();
            let found = split.validated(&model, &ValidateOptions::default()).unwrap();
            (found.files[0].validation.initial_condition, found.files[0].validation.simulated.clone())
        };
        let (one, other) = (run(1.0), run(0.08));
        assert_eq!(one.0, other.0);
        assert!(one.1 == other.1, "the free runs differ");
    }

    #[test]
    fn a_record_that_is_too_short_is_refused_with_its_name() {
        let error = Split::of(vec![record(25)], Vec::new(), 0.25).unwrap_err().to_string();
        assert!(error.contains("25, of which 25 % are held out"), "{error}");
    }
}
