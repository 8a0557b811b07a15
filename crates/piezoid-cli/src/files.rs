//! Files: records in, results out. What is written is whole or not there: it is written beside and renamed.

use anyhow::{Context, Result, bail};
use clap::Args;
use piezoid::formats::{Selection, Signal, Table};
use piezoid::{Model, Record};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Which columns and which part of a data file are meant.
#[derive(Args, Clone)]
pub(crate) struct Columns {
    /// Sampling period, for files without a time column.
    #[arg(long, value_name = "SECONDS", help_heading = "Data files")]
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
    #[arg(long, value_name = "SECONDS", help_heading = "Data files")]
    from: Option<f64>,
    /// Use the data up to this time.
    #[arg(long, value_name = "SECONDS", help_heading = "Data files")]
    to: Option<f64>,
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

    fn part(&self) -> (f64, f64) {
        (self.from.unwrap_or(0.0), self.to.unwrap_or(f64::INFINITY))
    }

    /// The record in a file.
    pub(crate) fn record(&self, path: &Path) -> Result<Record> {
        let (from, to) = self.part();
        let table = parse(path)?;
        table.record(&self.selection()).and_then(|r| r.part(from, to)).with_context(|| path.display().to_string())
    }

    /// The records in files, in their order.
    pub(crate) fn records(&self, paths: &[PathBuf]) -> Result<Vec<Record>> {
        paths.iter().map(|p| self.record(p)).collect()
    }

    /// The input in a file that may hold nothing else.
    pub(crate) fn input(&self, path: &Path) -> Result<Signal> {
        parse(path)?.input(&self.selection()).with_context(|| path.display().to_string())
    }
}

fn parse(path: &Path) -> Result<Table> {
    let name = || path.display().to_string();
    match path.extension().and_then(|e| e.to_str()) {
        Some("mat" | "npz" | "dat") => bail!("{}: this version reads CSV files; export the record as CSV", name()),
        _ => Table::parse(&read(path)?).with_context(name),
    }
}

/// The bytes of a file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

/// The text of a file.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?).map_err(|_| anyhow::anyhow!("{}: not a text file (it is not UTF-8)", path.display()))
}

/// The model in a file.
pub(crate) fn model(path: &Path) -> Result<Model> {
    Model::from_json(&read_text(path)?).with_context(|| path.display().to_string())
}

/// Writes a file beside its place and renames it there; `-` is stdout.
pub(crate) fn write(path: &Path, text: &str, console: &crate::console::Console) -> Result<()> {
    if path == Path::new("-") {
        return console.print(text);
    }
    let name = || format!("cannot write {}", path.display());
    if path.is_dir() {
        bail!("{}: it is a folder; name a file in it", name());
    }
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut beside = builder.prefix(".piezoid-").tempfile_in(folder).with_context(name)?;
    beside.write_all(text.as_bytes()).with_context(name)?;
    beside.persist(path).with_context(name)?;
    Ok(())
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
pub(crate) fn provenance(files: &[&PathBuf]) -> Result<Value> {
    let short = |text: &str| match Path::new(text).file_name() {
        Some(name) if text.contains(['/', '\\']) => name.to_string_lossy().into_owned(),
        _ => text.to_string(),
    };
    let command: Vec<String> = std::env::args().skip(1).map(|a| short(&a)).collect();
    let hashes = files.iter().map(|path| {
        let digest = Sha256::digest(read(path)?);
        let hex: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(json!({"file": short(&path.display().to_string()), "sha256": hex}))
    });
    Ok(json!({
        "command": format!("piezoid {}", command.join(" ")),
        "version": env!("CARGO_PKG_VERSION"),
        "files": hashes.collect::<Result<Vec<_>>>()?,
    }))
}
