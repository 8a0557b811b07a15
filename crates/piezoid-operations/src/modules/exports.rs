//! Code and tables for other machines.

use super::{MODEL, NAME, optional};
use crate::{Inputs, Operation, Output};
use piezoid::Error;
use piezoid_export::ExportOptions;
use piezoid_numerics::options::{OptionRow, Options, options};
use piezoid_verbs::DataFile;

pub(super) const OPERATIONS: &[Operation] = &[Operation {
    name: "export",
    summary: "Export a model and its inverse as code or tables: C, FMU, Simulink, structured text, Rust, waveforms",
    module: "exports",
    roles: &[MODEL, optional("reference")],
    options: ExportCall::rows,
    run: |inputs, _| export(inputs),
}];

options! {
    /// Options of `export`.
    pub(crate) struct ExportCall {
        /// The target language or format.
        target: String = "c".into(), OptionRow::new(NAME).list("targets");
    } with export: ExportOptions
}

fn export(inputs: &Inputs) -> Result<Output, Error> {
    let (ExportCall { target, export }, columns) = (inputs.options()?, inputs.columns()?);
    let reference = inputs.some("reference")?.map(DataFile::from);
    let along = reference.as_ref().map(|file| (file, &columns));
    let outcome = export.run(&target, &inputs.one("model")?, along, None)?;
    Ok(Output { result: outcome.to_json(), series: Vec::new(), files: outcome.files })
}
