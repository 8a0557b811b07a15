//! Reading and preparing records, of all formats of files.

use super::{named, role};
use crate::{Answer, Call, Given};
use piezoid::formats::{ColumnSelection, Format, Table};
use piezoid::{Error, File, Options, PrepareOptions};

pub(super) const CALLS: &[Call] = &[
    Call {
        name: "inspect",
        summary: "what a file holds, how it is read, and what seems wrong with it",
        roles: &[role("data", 1, 1)],
        rows: Vec::new,
        run: |given, _| inspect(given),
    },
    Call {
        name: "prepare",
        summary: "a record as it is to be identified, from one as it was measured",
        roles: &[role("data", 1, 1)],
        rows: PrepareOptions::rows,
        run: |given, _| prepare(given),
    },
];

fn inspect(given: &Given) -> Result<Answer, Error> {
    let (file, columns) = (given.one("data")?, given.columns()?);
    let table = Table::read(&file.name, &file.bytes).map_err(|error| error.of(&file.name))?;
    let (result, record) = table.inspect(&file.name, Format::of(&file.bytes).name, &columns);
    let Ok(record) = record else { return Ok(Answer { result, ..Answer::default() }) };
    let profile = File::new("profile.toml", table.profile(&columns).to_toml());
    Ok(Answer { result, series: named([("u", record.u()), ("y", record.y())]), files: vec![profile] })
}

fn prepare(given: &Given) -> Result<Answer, Error> {
    let file = given.one("data")?;
    let made =
        given.options::<PrepareOptions>()?.run(&file.record(&given.columns()?)?).map_err(|e| e.of(&file.name))?;
    let name = "record.csv";
    let written = File::new(name, made.written(name)?);
    let (result, _) = Table::read(name, &written.bytes)?.inspect(name, "csv", &ColumnSelection::default());
    Ok(Answer { result, series: named([("u", made.u()), ("y", made.y())]), files: vec![written] })
}
