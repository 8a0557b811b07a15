//! The operations of piezoid: one row a verb, with its files, its options and what it does. The front ends are derived
//! from these rows, and from the families of the [`catalogue`].
//!
//! The page calls them by name, in the browser and through `piezoid serve`: options as JSON and named bytes in, results
//! as JSON and named bytes out.
//!
//! ```
//! use piezoid::progress::Stage;
//! use piezoid_verbs::File;
//! use piezoid_operations::{Request, run};
//! use serde_json::json;
//!
//! let request = Request::of(json!({"call": "inspect", "files": {"data": ["log.csv"]}}))?;
//! let log = File::new("log.csv", "t_s,u_V,y_um\n0,0,0.1\n0.001,1,5.2\n0.002,0,0.3\n");
//! let output = run(&request, &[log], &mut Stage::ignore)?;
//! assert_eq!(output.result["record"]["units"]["y"], "um");
//! assert_eq!(output.series[0], ("u".to_string(), vec![0.0, 1.0, 0.0]));
//! # Ok::<(), piezoid::Error>(())
//! ```

// A module of the page uses a part of what its operations share.
#![cfg_attr(not(feature = "catalogue"), allow(dead_code))]

#[cfg(feature = "catalogue")]
mod catalogue;
mod modules;
mod packet;
#[cfg(feature = "catalogue")]
mod picture;
mod request;

#[cfg(feature = "catalogue")]
pub use catalogue::{Catalogue, ControlRow, OperatorRow, catalogue};
pub use packet::{answered, moves, refused};
pub use request::{Inputs, Request};

use piezoid::Error;
use piezoid::progress::Progress;
use piezoid_numerics::options::OptionRow;
use piezoid_verbs::File;
use serde::{Serialize, Serializer};
use serde_json::Value;

/// One operation.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Operation {
    /// Its name: the verb.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// The module of the page that has it, which is a feature of this crate.
    pub module: &'static str,
    /// The files that it takes.
    pub roles: &'static [Role],
    /// Its options.
    #[serde(serialize_with = "piezoid_numerics::options::rows_of")]
    pub options: fn() -> Vec<OptionRow>,
    /// Runs the operation.
    ///
    /// # Errors
    /// Returns an error for missing or unknown files and options, and for what the operation cannot do.
    #[serde(skip)]
    pub run: fn(&Inputs, &mut Progress) -> Result<Output, Error>,
}

impl Operation {
    /// All operations that are built in.
    pub fn all() -> impl Iterator<Item = &'static Operation> {
        modules::MODULES.iter().copied().flatten()
    }

    /// The operation of this name.
    ///
    /// # Errors
    /// Returns an error for an unknown name.
    pub fn find(name: &str) -> Result<&'static Operation, Error> {
        let known = || Error::unknown("call", name, Operation::all().map(|operation| operation.name));
        Operation::all().find(|operation| operation.name == name).ok_or_else(known)
    }
}

/// The files that an operation takes for one purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Role {
    /// Its name, such as `model`.
    pub name: &'static str,
    /// Smallest number of files.
    pub least: usize,
    /// True if there may be several files.
    pub many: bool,
}

/// Result of an operation. As a document it has the names and lengths of series and files, not their contents.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Output {
    /// The result as a document.
    pub result: Value,
    /// Series for plots, by their names.
    #[serde(serialize_with = "series_lengths")]
    pub series: Vec<(String, Vec<f64>)>,
    /// Files to write.
    #[serde(rename = "bytes", serialize_with = "file_lengths")]
    pub files: Vec<File>,
}

/// Names and numbers of samples.
fn series_lengths<S: Serializer>(series: &[(String, Vec<f64>)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(series.iter().map(|(name, samples)| (name, samples.len())))
}

/// Names and numbers of bytes.
fn file_lengths<S: Serializer>(files: &[File], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(files.iter().map(|file| (&file.name, file.bytes.len())))
}

/// Runs the operation that `request` names. The `files` are those that it names.
///
/// # Errors
/// Returns an error for an unknown operation, and the errors of [`Operation::run`].
pub fn run(request: &Request, files: &[File], progress: &mut Progress) -> Result<Output, Error> {
    let operation = Operation::find(&request.call)?;
    request.fit(operation.roles)?;
    (operation.run)(&Inputs { request, files }, progress)
}
