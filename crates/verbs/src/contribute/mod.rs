//! Records that a stranger contributes as evidence: checked, described and packed in one archive, or such an archive
//! checked by the one who receives it.
//!
//! The archive has the files as they are, `contribution.json` and, for people, `SOURCE.md`:
//!
//! ```json
//! {
//!   "piezoid_contribution": 1,
//!   "version": "0.1.0",
//!   "statement": {"licence": "CC-BY-4.0", "actuator": "...", "driver": "...", "sensor": "...", "who": "..."},
//!   "files": [
//!     {"file": "rise5.csv", "sha256": "9f86...", "bytes": 81234, "format": "csv", "samples": 4000, "ts": 0.0005,
//!      "duration": 2.0, "units": {"u": "V", "y": "um"}, "columns": {"input_col": "u_V", "output_col": "y_um"},
//!      "use": {"use": "training", "because": "..."}, "findings": []}
//!   ],
//!   "findings": ["no record is of another kind than the others ..."]
//! }
//! ```
//! What makes records unusable is an error; what makes them less useful is a finding. `columns` reads a file again as
//! it was read. It does not do: sending the archive, or preparing records, which are contributed as they were measured.

mod findings;
mod options;
mod received;
mod source;
#[cfg(test)]
mod tests;

pub use options::{ContributeOptions, Licence};

use super::certificate::sha256;
use super::{DataFile, File, Measured, Source, inspect::propose};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::round;
use piezoid_numerics::options::by_name;
use piezoid_records::formats::{self, ColumnSelection, is_displacement, is_voltage};
use piezoid_records::quality::Drive;
use piezoid_records::record::Units;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Names of the files that describe the others.
const DOCUMENT: &str = "contribution.json";
const SOURCE: &str = "SOURCE.md";

/// The schema of the document.
const SCHEMA: u64 = 1;

/// Records that were checked for a contribution, with what is stated of them.
#[derive(Debug, Clone)]
pub struct Contributed {
    document: Document,
    files: Vec<File>,
}

/// `contribution.json`.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Document {
    piezoid_contribution: u64,
    version: String,
    #[serde(with = "by_name")]
    statement: ContributeOptions,
    files: Vec<ContributedFile>,
    findings: Vec<String>,
}

/// A file of a contribution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ContributedFile {
    /// Its name, without folders.
    pub file: String,
    /// Hash of its bytes.
    pub sha256: String,
    /// Number of its bytes.
    pub bytes: usize,
    /// Its format.
    pub format: String,
    /// Number of samples of its record.
    pub samples: usize,
    /// Sampling period [s].
    pub ts: f64,
    /// Duration [s].
    pub duration: f64,
    /// Units of the record.
    pub units: Units,
    /// How its columns are read.
    #[serde(with = "by_name")]
    pub columns: ColumnSelection,
    /// The proposed use, `use` and `because` (see [`propose`]); null if there is only one record.
    #[serde(rename = "use")]
    pub proposed: Value,
    /// What makes it less useful, a sentence each.
    pub findings: Vec<String>,
}

impl ContributeOptions {
    /// Checks records for a contribution. Their files must not be prepared.
    ///
    /// # Errors
    /// The errors of [`stated`](ContributeOptions::stated). Returns an error for a file without a record of voltage and
    /// displacement, and for files that cannot stand in one archive.
    pub fn run(&self, sources: Vec<Source>) -> Result<Contributed, Error> {
        self.stated()?;
        if sources.is_empty() {
            return Err(Error::Content("there is no record: give the files of the contribution".into()));
        }
        let (mut files, mut described, mut documents, mut drives) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut rates = Vec::new();
        for source in sources {
            let file = contributed(&source, &files)?;
            let Read { document, columns, units, own, drive, rate } = read(&file, &source.columns)?;
            let number = |name: &str| document["record"][name].as_f64().unwrap_or_default();
            described.push(ContributedFile {
                file: file.name.clone(),
                sha256: sha256(&file.bytes),
                bytes: file.bytes.len(),
                format: document["format"].as_str().unwrap_or_default().into(),
                samples: number("samples") as usize,
                ts: number("ts"),
                duration: number("duration"),
                units,
                columns,
                proposed: Value::Null,
                findings: own,
            });
            files.push(file);
            documents.push(document);
            drives.push(Some(drive));
            rates.push(rate);
        }
        propose(&mut documents, &drives);
        for (file, document) in described.iter_mut().zip(&mut documents) {
            file.proposed = document["use"].take();
        }
        let findings = findings::of_all(&described, &rates);
        let version = env!("CARGO_PKG_VERSION").into();
        let document =
            Document { piezoid_contribution: SCHEMA, version, statement: self.clone(), files: described, findings };
        Ok(Contributed { document, files })
    }
}

/// The file of a source under its name in the archive, which these files have already.
fn contributed(source: &Source, others: &[File]) -> Result<File, Error> {
    let name = source.file.short();
    let wrong = |what: String| Err(Error::Content(what).of(&source.file.name));
    if !source.preparation.is_empty() || source.origin.is_some() {
        return wrong(
            "was prepared here, and records are contributed as they were measured: give the file itself".into(),
        );
    }
    let same = |other: &str| other.to_lowercase() == name.to_lowercase();
    if [DOCUMENT, SOURCE].into_iter().any(same) {
        return wrong(format!("the archive has a file {name} of its own: rename this one"));
    }
    if others.iter().any(|other| same(&other.name)) {
        return wrong(format!("two files are called {name}, and the archive has one folder: rename one of them"));
    }
    if name.is_empty() || name.chars().any(char::is_control) {
        return wrong(format!("{name:?} is no name of a file in an archive: rename it"));
    }
    let bytes = source.file.content()?;
    let twin = others.iter().find(|other| other.bytes == bytes);
    if let Some(File { name: twin, .. }) = twin {
        return wrong(format!("has the same bytes as {twin}: leave one of them out"));
    }
    Ok(File::new(name, bytes))
}

/// A file as it was read.
struct Read {
    document: Value,
    columns: ColumnSelection,
    units: Units,
    own: Vec<String>,
    drive: Drive,
    rate: Option<f64>,
}

/// Reads a file. What `inspect` finds is a finding, unless there is no record.
fn read(file: &File, columns: &ColumnSelection) -> Result<Read, Error> {
    let (data, named) = (DataFile::from(file.clone()), |error: Error| error.of(&file.name));
    let (document, record) = data.inspect(columns)?;
    let record = record.map_err(named)?;
    let shown = record.shown().map_err(named)?;
    let units = shown.units().clone();
    let other = |what: &str, unit: &str, quantity: &str, option, example: &str| {
        let wrong = format!("{what} is in {unit}, which is no {quantity}: state its unit or its scale, and for that ");
        named(Error::Content(wrong).advised(vec![(option, example.into())]))
    };
    if !is_displacement(&units.y) {
        return Err(other("the output", &units.y, "displacement", "output_scale", "5um/V"));
    }
    if !is_voltage(&units.u) {
        return Err(other("the input", &units.u, "voltage", "input_scale", "20V/V"));
    }
    let own = findings::of_one(&document, shown.u());
    let rate = piezoid_records::waveform::cycle_rate(shown.u(), shown.ts());
    let columns = match &record {
        Measured::Held(_) => data.profile(columns)?,
        Measured::Long(record) => record.profile().clone(),
    };
    let drive = record.drive().map_err(named)?;
    Ok(Read { document, columns, units, own, drive, rate })
}

impl Contributed {
    /// Checks an archive that [`archive`](Contributed::archive) has made, and its records like those of a new one.
    ///
    /// # Errors
    /// Returns an error for another archive, and for a file that is missing, was added, was changed, or is not read as
    /// the archive states it.
    pub fn check(archive: &File) -> Result<Self, Error> {
        received::read(&archive.bytes).map_err(|error| error.of(&archive.name))
    }

    /// All of it as a document, which is `contribution.json`.
    pub fn to_json(&self) -> Value {
        // Names, texts and finite numbers can always be written.
        serde_json::to_value(&self.document).unwrap_or_default()
    }

    /// Its files, with what is known of each.
    pub fn files(&self) -> &[ContributedFile] {
        &self.document.files
    }

    /// What makes the records as a set less useful, a sentence each.
    pub fn findings(&self) -> &[String] {
        &self.document.findings
    }

    /// The version that packed it, or would.
    pub fn version(&self) -> &str {
        &self.document.version
    }

    /// The summary in one sentence.
    pub fn summary(&self) -> String {
        let (n, statement) = (self.files.len(), &self.document.statement);
        let bytes: usize = self.files.iter().map(|file| file.bytes.len()).sum();
        let size = if bytes < 1_000_000 { format!("{} kB", bytes.div_ceil(1000)) } else { megabytes(bytes) };
        let licence = statement.licence.map(|licence| licence.words()[0]).unwrap_or_default();
        let records = if n == 1 { "1 record".into() } else { format!("{n} records") };
        let of = statement.actuator.as_deref().unwrap_or_default().trim();
        format!("{records} of {of}, {size}, {licence}")
    }

    /// The archive: the files as they are, and what is stated of them. The same files give the same bytes.
    ///
    /// # Errors
    /// Returns an error for more than 65533 files, or more than 4 GB.
    pub fn archive(&self) -> Result<Vec<u8>, Error> {
        let document = format!("{:#}\n", self.to_json());
        let own = [(DOCUMENT.to_string(), document.into_bytes()), (SOURCE.into(), source::text(&self.document).into())];
        let files = self.files.iter().map(|file| (file.name.clone(), file.bytes.clone()));
        formats::archive(own.into_iter().chain(files))
    }
}

fn megabytes(bytes: usize) -> String {
    format!("{} MB", round((bytes as f64 / 1e5).round() / 10.0))
}
