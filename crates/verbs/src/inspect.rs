//! What a file holds, how it is read, and what seems wrong with it.

use super::DataFile;
use piezoid_numerics::error::Error;
use piezoid_records::formats::{ColumnSelection, Table};
use piezoid_records::quality::{self, Finding};
use piezoid_records::record::Record;
use serde_json::{Value, json};
use std::ops::Range;

impl DataFile {
    /// What this file holds as a document: `format`; `channels`, each with `name`, `unit`, `samples`, `low`, `high` and
    /// its `role` (`time`, `input`, `output` or null); `record` with sampling period, duration and units, or null;
    /// `history`, the steps from the channels to the record; `problems`, which are reasons why there is no record, and
    /// suspected defects of the record; `defects`, these with the spans of time [s] that they concern, the first
    /// hundred of each. The second result is the record, or the error that prevents it.
    ///
    /// ```
    /// use piezoid::formats::ColumnSelection;
    /// use piezoid_verbs::{DataFile, File};
    /// let log = File::new("log.csv", "Time (ms),Drive (V),Position (um)\n0,0,0.1\n1,1,5.2\n2,0,0.3\n");
    /// let file = DataFile::from(log);
    /// let (seen, record) = file.inspect(&ColumnSelection::default())?;
    /// assert_eq!(seen["channels"][2]["role"], "output");
    /// assert_eq!(record?.ts(), 0.001);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if the file has no format that is read, or is damaged.
    pub fn inspect(&self, columns: &ColumnSelection) -> Result<(Value, Result<Record, Error>), Error> {
        let (table, format) = self.table()?;
        let (channels, read) = (table.described(columns), table.record(columns));
        drop(table);
        Ok((inspection(channels, &read, &self.name, format.name), read))
    }
}

/// What a table with this name and format holds, as [`File::inspect`] gives it.
pub fn inspect(table: &Table, name: &str, format: &str, columns: &ColumnSelection) -> (Value, Result<Record, Error>) {
    let read = table.record(columns);
    (inspection(table.described(columns), &read, name, format), read)
}

/// The document of a file with these channels, and the record that was read from it.
fn inspection(channels: Vec<Value>, read: &Result<Record, Error>, name: &str, format: &str) -> Value {
    let (record, history, problems, defects) = match read {
        Ok(record) => {
            let found = quality::inspect(record).findings;
            let defects = found.iter().map(|finding| placed(finding, record.ts())).collect();
            let texts = found.into_iter().map(|finding| finding.text).collect();
            (described(record), record.history().to_vec(), texts, defects)
        }
        Err(error) => (Value::Null, Vec::new(), vec![error.to_string()], Vec::new()),
    };
    json!({
        "file": name, "format": format, "channels": channels, "record": record, "history": history,
        "problems": problems, "defects": defects,
    })
}

fn described(record: &Record) -> Value {
    let (ts, samples, duration) = (record.ts(), record.len(), record.duration());
    json!({"ts": ts, "samples": samples, "duration": duration, "units": record.units()})
}

/// Most spans that are listed for a defect.
const SPANS: usize = 100;

/// A defect, with the spans of time that it concerns.
fn placed(finding: &Finding, ts: f64) -> Value {
    let span = |samples: &Range<usize>| [samples.start as f64 * ts, samples.end as f64 * ts];
    let spans: Vec<_> = finding.samples.iter().take(SPANS).map(span).collect();
    json!({"defect": finding.detector.name, "text": finding.text, "spans": spans})
}
