//! The verbs by name: options as JSON and named bytes in, results as JSON and named bytes out.
//!
//! This is how the page calls the library, in the browser and through `piezoid serve`.
//!
//! ```
//! use piezoid::{File, progress::Stage};
//! use piezoid_calls::{Request, call};
//! use serde_json::json;
//!
//! let request = Request::of(json!({"call": "inspect", "files": {"data": ["log.csv"]}}))?;
//! let log = File::new("log.csv", "t_s,u_V,y_um\n0,0,0.1\n0.001,1,5.2\n0.002,0,0.3\n");
//! let answer = call(&request, &[log], &mut Stage::ignore)?;
//! assert_eq!(answer.result["record"]["units"]["y"], "um");
//! assert_eq!(answer.series[0], ("u".to_string(), vec![0.0, 1.0, 0.0]));
//! # Ok::<(), piezoid::Error>(())
//! ```

// A module of the page uses a part of what its verbs share.
#![cfg_attr(not(feature = "lists"), allow(dead_code))]

#[cfg(feature = "lists")]
mod lists;
mod packet;
mod request;
mod verbs;

#[cfg(feature = "lists")]
pub use lists::lists;
pub use packet::{answered, moves, refused};
pub use request::Request;
pub use verbs::{MODULES, Module};

use piezoid::progress::Progress;
use piezoid::{Error, File, OptionRow};
use serde_json::Value;

/// One verb: a row of a [`Module`].
#[derive(Debug, Clone, Copy)]
pub struct Call {
    /// Its name.
    pub name: &'static str,
    /// What it does.
    pub summary: &'static str,
    /// The files that it takes, by their roles.
    pub roles: &'static [Role],
    /// Its options.
    pub rows: fn() -> Vec<OptionRow>,
    run: fn(&Given, &mut Progress) -> Result<Answer, Error>,
}

/// What files a verb takes, and for what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Role {
    /// Its name, such as `model`.
    pub name: &'static str,
    /// Smallest number of files.
    pub least: usize,
    /// Largest number of files.
    pub most: usize,
}

/// What a verb answers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Answer {
    /// The result as a document.
    pub result: Value,
    /// Series for plots, by their names.
    pub series: Vec<(String, Vec<f64>)>,
    /// Files that were made.
    pub files: Vec<File>,
}

/// A request with its files.
struct Given<'a> {
    request: &'a Request,
    files: &'a [File],
}

/// Calls the verb that `request` names. The `files` are those that it names.
///
/// # Errors
/// Returns an error for an unknown verb, for missing or unknown files and options, and the errors of the verb.
pub fn call(request: &Request, files: &[File], progress: &mut Progress) -> Result<Answer, Error> {
    let calls = || MODULES.iter().flat_map(|module| module.calls);
    let known = || Error::unknown("call", &request.call, calls().map(|call| call.name));
    let call = calls().find(|call| call.name == request.call).ok_or_else(known)?;
    request.fit(call.roles)?;
    (call.run)(&Given { request, files }, progress)
}
