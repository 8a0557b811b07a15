//! Errors for invalid input.
//!
//! Every message says what is wrong, the value, where, and what to do. The outcome of a search is data, not an error
//! (see [`crate::optimize`]).

use crate::number::{exact, tamed};
use crate::words::Words;
use serde_json::Value;
use thiserror::Error;

/// Invalid input, with its numbers.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting outside its domain.
    #[error("{name} = {value}: {rule}")]
    Parameter {
        /// The setting, as the user writes it.
        name: String,
        /// Its value.
        value: String,
        /// The rule it breaks.
        rule: String,
    },
    /// A sample that is NaN or infinite.
    #[error("{what}[{index}] is {value}: every sample must be a finite number; leave the sample out or repair it")]
    NotFinite {
        /// The series.
        what: String,
        /// Position, from 0.
        index: usize,
        /// The sample.
        value: f64,
    },
    /// Two series of different lengths that must be equally long.
    #[error("{left} has {left_len} samples but {right} has {right_len}: they must be equally long")]
    Lengths {
        /// First series.
        left: String,
        /// Its length.
        left_len: usize,
        /// Second series.
        right: String,
        /// Its length.
        right_len: usize,
    },
    /// Too few samples.
    #[error("{what} has {have} samples, but at least {need} are needed: {remedy}")]
    TooShort {
        /// The series.
        what: String,
        /// Samples given.
        have: usize,
        /// Samples needed.
        need: usize,
        /// What to do.
        remedy: String,
    },
    /// A line of a file that cannot be read. Lines count from 1.
    #[error("line {line}{}: {problem}", column.as_ref().map(|c| format!(", column {c}")).unwrap_or_default())]
    Line {
        /// Line of the file, the header being line 1.
        line: u64,
        /// Column name, or its number when it has no name.
        column: Option<String>,
        /// What is wrong, the value and what to do.
        problem: String,
    },
    /// A sample that cannot be read, in a format without lines. Rows count from 0.
    #[error("{}{problem}", place(*row, column.as_deref()))]
    Row {
        /// Number of the sample, if the error is about one sample.
        row: Option<u64>,
        /// Name of the column.
        column: Option<String>,
        /// What is wrong, the value and what to do.
        problem: String,
    },
    /// A file or document that cannot be read as a whole.
    #[error("{0}")]
    Content(String),
    /// An error that options can resolve.
    #[error("{error}give {}", plain(options, *all))]
    Advised {
        /// The error; its message ends such that the options can follow.
        error: Box<Error>,
        /// Options that resolve the error: name and value (null if only the user knows the value).
        options: Vec<(&'static str, Value)>,
        /// True if all of them are needed; false if each resolves the error.
        all: bool,
    },
    /// An error in a file.
    #[error("{name}: {error}")]
    File {
        /// Its name.
        name: String,
        /// The error.
        error: Box<Error>,
    },
    /// A name that is not in a list.
    #[error("there is no {kind} called `{name}`: known are {}{}", known.join(", "), nearest(name, known))]
    Unknown {
        /// The kind: operator, plant, excitation...
        kind: &'static str,
        /// The name given.
        name: String,
        /// The known names.
        known: Vec<String>,
    },
    /// Two different sampling periods that must agree.
    #[error("{left} is sampled every {} s but {right} every {} s: {}", exact(*left_ts), exact(*right_ts), other_rate((left, *left_ts), (right, *right_ts)))]
    Sampling {
        /// First object.
        left: String,
        /// Its sampling period [s].
        left_ts: f64,
        /// Second object.
        right: String,
        /// Its sampling period [s].
        right_ts: f64,
    },
    /// Units that cannot be converted into each other.
    #[error("{what} is in {found}, but {expected} is needed and the conversion is unknown: convert it first")]
    Units {
        /// The object with this unit.
        what: String,
        /// Its unit.
        found: String,
        /// The unit needed.
        expected: String,
    },
    /// A part of the model that the data do not determine.
    #[error("{what} cannot be identified: {because}")]
    Unidentifiable {
        /// The part of the model.
        what: String,
        /// Why, with the numbers, and what would help.
        because: String,
    },
    /// A linear block that does not have the requested inverse.
    #[error("the linear block has no {kind} inverse: {because}")]
    NoInverse {
        /// Causal, or stable.
        kind: &'static str,
        /// The zeros that prevent it, and what to use instead.
        because: String,
    },
    /// A request that this model does not support.
    #[error("no {what} is possible with this model: {because}")]
    Unsuited {
        /// The request.
        what: String,
        /// Why, with the numbers, and what would help.
        because: String,
    },
    /// A requested displacement that no allowed input gives.
    #[error("the reference cannot be reached: {0}")]
    Unreachable(String),
    /// A drive that exceeds the driver's limits.
    #[error("the drive exceeds its limits: {0}")]
    Limits(String),
    /// The caller asked to stop.
    #[error("cancelled: {what} stopped after {done} of {total} steps")]
    Cancelled {
        /// The work.
        what: String,
        /// Steps done.
        done: usize,
        /// Steps in total.
        total: usize,
    },
}

impl Error {
    /// A setting outside its domain.
    pub fn parameter(name: impl Into<String>, value: impl ToString, rule: impl Into<String>) -> Self {
        let (value, rule) = (tamed(&value.to_string()), tamed(&rule.into()));
        Error::Parameter { name: name.into(), value, rule }
    }

    /// An unknown name, with all known names.
    pub fn unknown<'a>(kind: &'static str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        Error::Unknown { kind, name: name.into(), known: known.into_iter().map(String::from).collect() }
    }

    /// Units that cannot be converted into each other.
    pub fn units(what: &str, found: &str, expected: &str) -> Self {
        Error::Units { what: what.into(), found: found.into(), expected: expected.into() }
    }

    /// A line of a file that cannot be read.
    pub fn line(line: u64, problem: impl Into<String>) -> Self {
        Error::Line { line, column: None, problem: problem.into() }
    }

    /// The message in the words of a front end.
    pub fn message(&self, words: &dyn Words) -> String {
        match self {
            Error::Parameter { name, value, rule } => format!("{}: {rule}", words.setting(name, value)),
            Error::Advised { error, options, all } => {
                let options: Vec<String> = options.iter().map(|(name, value)| words.remedy(name, value)).collect();
                format!("{}give {}", error.message(words), options.join(if *all { " " } else { " or " }))
            }
            Error::Limits(_) | Error::Unreachable(_) => format!("{self} ({})", words.remedy("clip", &true.into())),
            Error::File { name, error } => format!("{name}: {}", error.message(words)),
            other => other.to_string(),
        }
    }

    /// The same error with options, each of which resolves it; its message must end such that they can follow.
    pub fn advised(self, options: Vec<(&'static str, Value)>) -> Self {
        Error::Advised { error: Box::new(self), options, all: false }
    }

    /// The same error with options that resolve it together.
    pub fn needing(self, options: Vec<(&'static str, Value)>) -> Self {
        Error::Advised { error: Box::new(self), options, all: true }
    }

    /// The options that resolve it, with their values.
    pub fn advice(&self) -> &[(&'static str, Value)] {
        match self {
            Error::Advised { options, .. } => options,
            Error::File { error, .. } => error.advice(),
            _ => &[],
        }
    }

    /// The same error, about the file of this name.
    pub fn of(self, name: &str) -> Self {
        Error::File { name: name.into(), error: Box::new(self) }
    }

    /// The same error about the file of this name, unless it concerns an option or another file.
    pub fn about(self, name: &str) -> Self {
        match self {
            Error::Parameter { .. } | Error::Unknown { .. } | Error::Advised { .. } | Error::File { .. } => self,
            other => other.of(name),
        }
    }
}

/// Options as text, such as "`ts` = 0.1 or `time_col`".
fn plain(options: &[(&'static str, Value)], all: bool) -> String {
    let one = |(name, value): &(&str, Value)| match value {
        Value::Null => format!("`{name}`"),
        value => format!("`{name}` = {value}"),
    };
    options.iter().map(one).collect::<Vec<_>>().join(if all { ", " } else { " or " })
}

/// The row called `name` of a list of rows of this `kind`.
///
/// # Errors
/// [`Error::Unknown`] with all names.
pub fn row<T>(
    kind: &'static str,
    mut rows: impl Iterator<Item = &'static T> + Clone,
    name_of: fn(&T) -> &'static str,
    name: &str,
) -> Result<&'static T, Error> {
    let known = rows.clone().map(name_of);
    rows.find(|row| alike(name_of(row), name)).ok_or_else(|| Error::unknown(kind, name, known))
}

/// True if two names differ only in case and in what joins their words: `Bouc_Wen` is `bouc-wen`.
pub fn alike(a: &str, b: &str) -> bool {
    let letter = |c: char| if c == '_' || c == ' ' { '-' } else { c.to_ascii_lowercase() };
    a.chars().map(letter).eq(b.trim().chars().map(letter))
}

/// Returns an error if a setting is not a positive finite number.
#[doc(hidden)]
pub fn positive(name: &str, value: f64, unit: &str) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Error::parameter(name, value, format!("must be a positive number of {unit}")))
    }
}

/// Returns an error if a sample is not finite.
#[doc(hidden)]
pub fn finite(what: &str, samples: &[f64]) -> Result<(), Error> {
    match samples.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Error::NotFinite { what: what.into(), index, value: samples[index] }),
    }
}

/// A place as text, such as "row 3, t_s: ".
fn place(row: Option<u64>, column: Option<&str>) -> String {
    match (row, column) {
        (Some(row), Some(column)) => format!("row {row}, {column}: "),
        (Some(row), None) => format!("row {row}: "),
        (None, Some(column)) => format!("{column}: "),
        (None, None) => String::new(),
    }
}

/// The text "; did you mean `x`?" if a known name is at most two edits away.
fn nearest(name: &str, known: &[String]) -> String {
    known
        .iter()
        .map(|k| (edits(name, k), k))
        .min()
        .filter(|(distance, _)| *distance <= 2)
        .map(|(_, k)| format!("; did you mean `{k}`?"))
        .unwrap_or_default()
}

/// Levenshtein distance.
fn edits(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.chars().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.chars().count()]
}

/// Objects of messages about sampling that `prepare` does not resample.
const NO_RECORDS: [&str; 8] =
    ["the controller", "the linear block", "creep", "another", "the next", "the plan", "the reference", "the input"];

/// What to do about two sampling periods [s] that differ.
fn other_rate((left, left_ts): (&str, f64), (right, right_ts): (&str, f64)) -> String {
    let both = [left_ts, right_ts].into_iter();
    match both.clone().find(|rate| (left_ts * right_ts - 1.0).abs() < 0.01 && *rate > 1.0) {
        Some(rate) => format!("if {} is the sampling rate in Hz, state it as such", exact(rate)),
        None if NO_RECORDS.contains(&right) => "resample one of them".into(),
        // A model keeps its period; of two records, the slower one has no samples for the faster one.
        None => {
            let ts = if left == "the model" { left_ts } else { both.fold(0.0, f64::max) };
            format!("resample one of them; `prepare` does, with the option resample = {}", exact(ts))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_about_an_unknown_name_suggests_the_nearest_one() {
        let error = Error::unknown("plant", "pl14O", ["paper", "pl140"]);
        assert_eq!(
            error.to_string(),
            "there is no plant called `pl14O`: known are paper, pl140; did you mean `pl140`?"
        );
        assert!(!Error::unknown("plant", "xyz", ["paper", "pl140"]).to_string().contains("did you mean"));
    }

    #[test]
    fn a_period_that_is_the_rate_of_another_is_named() {
        let message = |left_ts, right_ts| {
            Error::Sampling { left: "one".into(), left_ts, right: "other".into(), right_ts }.to_string()
        };
        assert!(message(5e-4, 2000.0).ends_with("if 2000 is the sampling rate in Hz, state it as such"));
        assert!(
            message(5e-4, 1e-3).ends_with("resample one of them; `prepare` does, with the option resample = 0.001")
        );
        let message =
            Error::Sampling { left: "the model".into(), left_ts: 5e-4, right: "the record".into(), right_ts: 1e-3 };
        assert!(message.to_string().ends_with("resample = 0.0005"), "{message}");
    }

    #[test]
    fn a_huge_value_has_an_exponent_and_not_hundreds_of_digits() {
        let message = |value: &dyn ToString| Error::parameter("from", value.to_string(), "must be less").to_string();
        assert_eq!(message(&1e300), "from = 1e300: must be less");
        assert_eq!(message(&format!("{} s", -1.5e200)), "from = -1.5e200 s: must be less");
        assert_eq!(message(&0.000_012_5), "from = 0.0000125: must be less");
        assert_eq!(message(&12_345_678_901_234_567_890_u64), "from = 12345678901234567890: must be less");
        let samples = Error::parameter("ts", "1e-9 s", format!("gives {:.0} samples, at {} s.", 1e30, 1e200));
        assert_eq!(samples.to_string(), "ts = 1e-9 s: gives 1e30 samples, at 1e200 s.");
        assert_eq!(message(&"a name"), "from = a name: must be less");
    }

    #[test]
    fn the_error_about_a_sample_that_is_not_finite_has_its_index() {
        let error = finite("y", &[1.0, f64::NAN]).unwrap_err();
        assert!(error.to_string().starts_with("y[1] is NaN"), "{error}");
    }
}
