//! Code and tables for other machines.

use super::{MODEL, NAME, role};
use crate::{Answer, Call, Given};
use piezoid::{Error, OptionRow, Options, options};
use piezoid_export::ExportOptions;

pub(super) const CALLS: &[Call] = &[Call {
    name: "export",
    summary: "the model, its inverse and its controller for another machine",
    roles: &[MODEL, role("reference", 0, 1)],
    rows: ExportCall::rows,
    run: |given, _| export(given),
}];

options! {
    /// Options of `export`.
    pub(crate) struct ExportCall {
        /// The target language or format.
        target: String = "c".into(), OptionRow::new(NAME);
    } with export: ExportOptions
}

fn export(given: &Given) -> Result<Answer, Error> {
    let (ExportCall { target, export }, columns) = (given.options()?, given.columns()?);
    let reference = given.some("reference")?;
    let along = reference.as_ref().map(|file| (file, &columns));
    let made = export.run(&target, &given.one("model")?, along, None)?;
    Ok(Answer { result: made.to_json(), series: Vec::new(), files: made.files })
}
