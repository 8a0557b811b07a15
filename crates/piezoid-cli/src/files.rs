//! Files: records in, results out. What is written is whole or not there: it is written beside and renamed.

use crate::values::{period, seconds};
use anyhow::{Context, Error, Result, anyhow, bail};
use clap::Args;
use piezoid::Units;
use piezoid::formats::{Selection, Signal, Table};
use piezoid::{Model, Record, System};
use piezoid_host::files;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Which columns and which part of a data file are meant.
#[derive(Args, Clone)]
pub(crate) struct Columns {
    /// Sampling period, for files without a time column.
    #[arg(long, value_name = "SECONDS", value_parser = period, allow_negative_numbers = true)]
    #[arg(help_heading = "Data files")]
    ts: Option<f64>,
    /// Name of the input column [default: u_V].
    #[arg(long, value_name = "NAME", help_heading = "Data files")]
    input_col: Option<String>,
    /// Name of the output column [default: the one named y_*].
    #[arg(long, value_name = "NAME", help_heading = "Data files")]
    output_col: Option<String>,
    /// Name of the time column [default: t_s].
    #[arg(long, value_name = "NAME", help_heading = "Data files")]
    time_col: Option<String>,
    /// Use the data from this time on, counted from the first row.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    #[arg(help_heading = "Data files")]
    from: Option<f64>,
    /// Use the data up to this time, counted from the first row.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    #[arg(help_heading = "Data files")]
    to: Option<f64>,
}

/// A record and the file it comes from.
pub(crate) struct Measured {
    pub(crate) record: Record,
    /// Name and hash, as results tell where they come from.
    pub(crate) origin: Value,
}

impl Columns {
    fn selection(&self) -> Selection {
        Selection {
            ts: self.ts,
            input: self.input_col.clone(),
            output: self.output_col.clone(),
            time: self.time_col.clone(),
        }
    }

    /// Whether anything is said of columns or parts.
    pub(crate) fn any(&self) -> bool {
        let names = [&self.input_col, &self.output_col, &self.time_col];
        names.iter().any(|name| name.is_some()) || [self.ts, self.from, self.to].iter().any(Option::is_some)
    }

    fn part(&self) -> (f64, f64) {
        (self.from.unwrap_or(0.0), self.to.unwrap_or(f64::INFINITY))
    }

    /// The record in a file, which is read once: it may be a pipe.
    pub(crate) fn record(&self, path: &Path) -> Result<Measured> {
        let (from, to) = self.part();
        let (table, bytes) = parse(path)?;
        let record = table.record(&self.selection()).and_then(|r| r.part(from, to)).with_context(|| named(path))?;
        let hex: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Measured { record, origin: json!({"file": short(&named(path)), "sha256": hex}) })
    }

    /// The input in a file that may hold nothing else.
    pub(crate) fn input(&self, path: &Path) -> Result<Signal> {
        self.signal(path, Table::input)
    }

    /// The reference in a file that may hold nothing else, in the unit of the model's output.
    pub(crate) fn reference(&self, path: &Path, model: &Model) -> Result<Vec<f64>> {
        let Signal { ts, samples, unit } = self.signal(path, Table::reference)?;
        Record::same_sampling("the model", model.ts(), "the reference", ts).with_context(|| named(path))?;
        let Some(factor) = Units::factor(&unit, &model.units().y) else {
            let (name, wanted) = (named(path), &model.units().y);
            bail!("{name}: the reference is in {unit} but the model gives {wanted}: convert it beforehand");
        };
        Ok(samples.iter().map(|r| r * factor).collect())
    }

    fn signal(&self, path: &Path, of: fn(&Table, &Selection) -> Result<Signal, piezoid::Error>) -> Result<Signal> {
        let (from, to) = self.part();
        let (table, _) = parse(path)?;
        let signal = || {
            let Signal { ts, samples, unit } = of(&table, &self.selection())?;
            let range = Record::span(from, to, ts, samples.len())?;
            Ok::<_, piezoid::Error>(Signal { ts, samples: samples[range].to_vec(), unit })
        };
        signal().with_context(|| named(path))
    }
}

fn named(path: &Path) -> String {
    path.display().to_string()
}

fn parse(path: &Path) -> Result<(Table, Vec<u8>)> {
    let bytes = read(path)?;
    Ok((Table::read(&named(path), &bytes).with_context(|| named(path))?, bytes))
}

/// The bytes of a file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => anyhow!("{}: there is no such file: check its name and folder", named(path)),
        ErrorKind::PermissionDenied => anyhow!("{}: this file may not be read: check its permissions", named(path)),
        _ if path.is_dir() => anyhow!("{}: this is a folder: name a file in it", named(path)),
        _ => Error::new(error).context(format!("cannot read {}", named(path))),
    })
}

/// The text of a file.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?).map_err(|_| anyhow!("{}: this is not a text file (it is not UTF-8)", named(path)))
}

/// The model in a file.
pub(crate) fn model(path: &Path) -> Result<Model> {
    let text = read_text(path)?;
    Model::from_json(&text).map_err(|e| anyhow!("{}: {e}; a model is what `piezoid identify` writes", named(path)))
}

/// Writes a file beside its place and renames it there; `-` is stdout.
pub(crate) fn write(path: &Path, text: &str, console: &crate::console::Console) -> Result<()> {
    if path == Path::new("-") {
        return console.print(text);
    }
    match std::fs::metadata(path) {
        // A pipe or a device stays what it is.
        Ok(what) if !what.is_file() && !what.is_dir() => {
            let mut open = std::fs::OpenOptions::new();
            return open.write(true).open(path).and_then(|mut file| file.write_all(text.as_bytes())).or_else(|error| {
                match error.kind() {
                    ErrorKind::BrokenPipe => Ok(()),
                    _ => Err(Error::new(error).context(format!("cannot write {}", named(path)))),
                }
            });
        }
        _ => {}
    }
    Ok(files::write(path, text.as_bytes())?)
}

/// Refuses results that could not be written when the work is done: before it is begun.
pub(crate) fn ready(paths: &[Option<&Path>]) -> Result<()> {
    let named = paths.iter().copied().flatten().filter(|path| *path != Path::new("-"));
    let plain = |path: &&Path| std::fs::metadata(path).map_or(true, |what| what.is_file() || what.is_dir());
    Ok(named.filter(plain).try_for_each(files::ready)?)
}

/// Writes a machine-readable result where `--json` says.
pub(crate) fn write_json(path: Option<&Path>, value: &Value, console: &crate::console::Console) -> Result<()> {
    match path {
        Some(path) => write(path, &format!("{value:#}\n"), console),
        None => Ok(()),
    }
}

/// Where a result comes from: the command, its files with their hashes, the version. Folders are left out, so that
/// the same work gives the same bytes wherever it is done.
pub(crate) fn provenance(origins: Vec<Value>) -> Value {
    let word = |argument: std::ffi::OsString| {
        let argument = argument.to_string_lossy();
        let word = match argument.split_once('=') {
            Some((flag, value)) if flag.starts_with("--") => format!("{flag}={}", short(value)),
            _ => short(&argument),
        };
        if word.is_empty() || word.contains([' ', '\'', '"']) {
            format!("'{}'", word.replace('\'', "'\\''"))
        } else {
            word
        }
    };
    let command: Vec<String> = std::env::args_os().skip(1).map(word).collect();
    json!({
        "command": format!("piezoid {}", command.join(" ")),
        "version": env!("CARGO_PKG_VERSION"),
        "files": origins,
    })
}

/// The name of a file without its folder.
fn short(text: &str) -> String {
    match Path::new(text).file_name() {
        Some(name) if text.contains(['/', '\\']) => name.to_string_lossy().into_owned(),
        _ => text.to_string(),
    }
}
