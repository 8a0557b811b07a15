//! Records from files of all formats, and drive signals.

use super::shape::{shape, spectra};
use super::{DATA, NAME, named, one};
use crate::packet::Marks;
use crate::{Inputs, Operation, Output};
use piezoid::excitation::Excitation;
use piezoid::formats::{ColumnSelection, Table};
use piezoid::{Error, PrepareOptions, Record};
use piezoid_numerics::options::{OptionRow, Options, options};
use piezoid_records::quality::Drive;
use piezoid_records::waveform::spectrum;
use piezoid_verbs::{ExciteOptions, File, Source, Step, propose};
use serde_json::{Value, json};

pub(super) const OPERATIONS: &[Operation] = &[
    Operation {
        name: "inspect",
        summary: "Show what data files hold, how they are read and what seems wrong; write a profile of a rig",
        module: "files",
        roles: &[DATA],
        options: Vec::new,
        run: |inputs, _| inspect(inputs),
    },
    Operation {
        name: "prepare",
        summary: "Prepare a record: cut, filter, decimate, resample, average periods, align, repair, calibrate",
        module: "files",
        roles: &[one("data")],
        options: PrepareOptions::rows,
        run: |inputs, _| prepare(inputs),
    },
    Operation {
        name: "excite",
        summary: "Make a drive signal: PRBS, sines, chirps, steps",
        module: "files",
        roles: &[],
        options: ExciteCall::rows,
        run: |inputs, _| excite(inputs),
    },
];

/// One file, with its samples; or several files of a rig, with the use that is proposed for each.
fn inspect(inputs: &Inputs) -> Result<Output, Error> {
    let sources = inputs.sources("data")?;
    let [Source { file, columns, .. }] = &sources[..] else { return Ok(rig(&sources)) };
    let (table, format) = file.table()?;
    let (mut result, record) = piezoid_verbs::inspect(&table, &file.name, format.name, columns);
    let record = match record {
        Ok(record) => record,
        Err(error) => {
            result["problems"] = json!([error.message(&Marks)]);
            return Ok(Output { result, ..Output::default() });
        }
    };
    result["shape"] = shape(&record);
    let profile = File::new("profile.toml", table.profile(columns).to_toml());
    Ok(Output { result, series: drawn(&record), files: vec![profile] })
}

/// The files of a rig. One that cannot be read has its name and the reason alone.
fn rig(sources: &[Source]) -> Output {
    let (mut files, mut drives) = (Vec::new(), Vec::new());
    for source in sources {
        let Source { file, columns, preparation, .. } = source;
        let wrong = |error: Error| json!([error.message(&Marks)]);
        let prepared = || source.record().map(|record| Drive::of(&record));
        let (document, drive) = match file.inspect(columns) {
            Ok((document, Ok(_))) if !preparation.is_empty() => (document, prepared().ok()),
            Ok((document, Ok(record))) => (document, record.drive().ok()),
            Ok((mut document, Err(error))) => {
                document["problems"] = wrong(error);
                (document, None)
            }
            Err(error) => (json!({"file": file.name, "problems": wrong(error), "use": null}), None),
        };
        files.push(document);
        drives.push(drive);
    }
    propose(&mut files, &drives);
    Output { result: json!({"files": files}), ..Output::default() }
}

fn prepare(inputs: &Inputs) -> Result<Output, Error> {
    let steps = vec![Step::Prepare(inputs.options()?)];
    let source = Source::new(inputs.one("data")?, inputs.columns()?, steps);
    let ((outcome, origin), name) = (source.read()?, "record.csv");
    let written = File::new(name, outcome.written(name)?);
    let table = Table::read(name, &written.bytes)?;
    let (mut result, _) = piezoid_verbs::inspect(&table, name, "csv", &ColumnSelection::default());
    result["origin"] = json!(origin);
    result["shape"] = shape(&outcome);
    Ok(Output { result, series: drawn(&outcome), files: vec![written] })
}

/// The samples of a record and its spectra.
fn drawn(record: &Record) -> Vec<(String, Vec<f64>)> {
    let spectra = spectra(record, None).into_iter().map(|(name, values)| (name.to_string(), values));
    named([("u", record.u()), ("y", record.y())]).into_iter().chain(spectra).collect()
}

options! {
    /// Options of `excite`, besides those of the signal.
    pub(crate) struct ExciteCall {
        /// The kind of signal.
        kind: String = "sine".into(), OptionRow::new(NAME).list("excitations");
    } with common: ExciteOptions
}

fn excite(inputs: &Inputs) -> Result<Output, Error> {
    let known = |name: &str| ExciteCall::rows().iter().any(|row| row.name == name);
    let all = inputs.request.options.iter().map(|(name, value)| (name.clone(), value.clone()));
    let (common, own): (serde_json::Map<_, _>, serde_json::Map<_, _>) = all.partition(|(name, _)| known(name));
    let ExciteCall { kind, common } = ExciteCall::from_json(Value::Object(common))?;
    let outcome = common.run(Excitation::find(&kind)?, Value::Object(own))?;
    let result = json!({"ts": outcome.ts, "unit": outcome.unit, "usage": outcome.usage, "clipped": outcome.clipped});
    let file = File::new("signal.csv", outcome.written("signal.csv")?);
    let (hz, amplitude) = spectrum(&outcome.u, outcome.ts);
    let series = named([("u", &outcome.u), ("u/hz", &hz), ("u/amplitude", &amplitude)]);
    Ok(Output { result, series, files: vec![file] })
}
