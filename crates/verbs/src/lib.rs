//! Verbs: from options and named bytes to a result, and from the result to bytes. Front ends only read files, call a
//! verb, and write files.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

mod certificate;
mod compare;
mod compensate;
mod contribute;
mod control;
mod data;
mod excite;
mod identification;
mod identify;
mod inspect;
mod methods;
mod named;
mod on_plant;
mod online;
mod origin;
mod plan;
mod prepare;
mod same_actuator;
mod simulate;
mod smoothing;
mod split;
mod stand_in;
mod timing;
mod validate;
mod verdict;

pub use certificate::{
    Budget, Certificate, CertificateOptions, CertifiedBand, CertifiedRecord, Contribution, Digit, Evaluation,
    MeanError, NoiseOrigin, sha256, share,
};
pub use compare::{CompareOptions, ComparedModel, Contest, Failed, ModelComparison, Other, Times};
pub use compensate::{CompensateOptions, Compensation};
pub use contribute::{ContributeOptions, Contributed, ContributedFile, Licence};
pub use control::{ComparisonReport, ControlOptions, PATHS, SCHEMES, TuneOptions};
pub use data::DataFile;
pub use excite::{ExciteOptions, Excited};
pub use identification::{IdentifyOptions, Method, Records, identify};
pub use identify::Identification;
pub use inspect::{Measured, inspect, propose};
pub use methods::MethodOptions;
pub use on_plant::OnPlant;
pub use online::{EstimatorOptions, OnlineOptions, OnlineRow, OnlineRun, Replayed};
pub use origin::{Origin, files_of, identify_again};
pub use plan::{Plan, PlanOptions, PlannedDrive, Rehearsal, RehearsedDrive, UncertainParameter, Uncertainty};
pub use prepare::{Source, Step};
pub use simulate::{SimulateOptions, Simulated, Subject};
pub use smoothing::{Faster, Smoothing};
pub use split::{Split, Test};
pub use stand_in::{stand_in, stand_in_from};
pub use timing::{
    FastestMove, Landing, MoveOptions, PlannedMoves, Players, RunTiming, ScanLag, Start, StepTiming, Timing,
    TimingOptions,
};
pub use validate::{Compared, ValidateRecords, Validated};
pub use verdict::{StatedVerdict, Verdict};

use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_records::formats::archive;
use serde_json::Value;

/// A file that a verb reads or writes: bytes with a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Its name, with `/` between folders; errors about the file begin with it.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

impl File {
    /// A file of this name.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        File { name: name.into(), bytes: bytes.into() }
    }

    /// Its name without folders: the same work gives the same bytes in every folder.
    pub fn short(&self) -> &str {
        short(&self.name)
    }

    /// A zip archive of these files, stored, without dates: the same files give the same bytes.
    ///
    /// ```
    /// let archive = piezoid_verbs::File::archive(&[piezoid_verbs::File::new("a/b.txt", "c")])?;
    /// assert!(archive.starts_with(b"PK"));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error for more than 65535 files, or more than 4 GB.
    pub fn archive(files: &[File]) -> Result<Vec<u8>, Error> {
        archive(files.iter().map(|file| (file.name.clone(), file.bytes.clone())))
    }

    /// Its text.
    ///
    /// # Errors
    /// Returns an error if it is not text.
    pub fn text(&self) -> Result<&str, Error> {
        let none = |_| Error::Content("this is not a text file (it is not UTF-8)".into()).of(&self.name);
        std::str::from_utf8(&self.bytes).map_err(none)
    }

    /// The model in it.
    ///
    /// # Errors
    /// Returns an error if it contains no model.
    pub fn model(&self) -> Result<Model, Error> {
        let known = |e| Error::Content(format!("{e}; give a file that `identify` wrote")).of(&self.name);
        Model::from_json(self.text()?).map_err(known)
    }
}

/// Adds the name of `file` to an error about a request that its model does not support.
fn blamed(error: Error, file: &File) -> Error {
    let inner = if let Error::File { error, .. } = &error { error } else { &error };
    match inner {
        Error::Unsuited { .. } | Error::NoInverse { .. } => error.of(&file.name),
        _ => error,
    }
}

/// A name without folders.
fn short(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// Adds the members of one object to another.
fn merge(object: &mut Value, more: Value) {
    if let (Value::Object(object), Value::Object(more)) = (object, more) {
        object.extend(more);
    }
}
