//! What a file holds, how it is read, and what seems wrong with it.

use super::DataFile;
use piezoid_numerics::error::Error;
use piezoid_records::formats::{ColumnSelection, LongRecord, MAX_HELD_SAMPLES, Opened, Table};
use piezoid_records::quality::{self, Finding, InSections};
use piezoid_records::quality::{Drive, Proposal, uses};
use piezoid_records::record::Record;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::ops::Range;

/// Samples of a long record that show its waveform.
const SHOWN_SAMPLES: usize = 1_000_000;

impl DataFile {
    /// What this file holds as a document: `format`; `layout`, the same text for files that look alike (see
    /// [`Table::layout`]); `channels`, each with `name`, `unit`, `samples`, `low`, `high` and
    /// its `role` (`time`, `input`, `output` or null); `record` with sampling period, duration and units, or null;
    /// `history`, the steps from the channels to the record; `problems`, which are reasons why there is no record, and
    /// suspected defects of the record; `defects`, these with the spans of time [s] that they concern, the first
    /// hundred of each; `use`, which [`propose`] sets. The second result is the record, or the error that prevents it.
    /// A long record in a text is read in pieces, and its defects are looked for in each of its sections.
    ///
    /// ```
    /// use piezoid::formats::ColumnSelection;
    /// use piezoid_verbs::{DataFile, File, Measured};
    /// let log = File::new("log.csv", "Time (ms),Drive (V),Position (um)\n0,0,0.1\n1,1,5.2\n2,0,0.3\n");
    /// let file = DataFile::from(log);
    /// let (seen, record) = file.inspect(&ColumnSelection::default())?;
    /// assert_eq!(seen["channels"][2]["role"], "output");
    /// assert!(matches!(record?, Measured::Held(record) if record.ts() == 0.001));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if the file has no format that is read, or is damaged.
    pub fn inspect(&self, columns: &ColumnSelection) -> Result<(Value, Result<Measured<'_>, Error>), Error> {
        self.inspect_held(columns, MAX_HELD_SAMPLES)
    }

    /// The same with records of up to so many samples held.
    fn inspect_held(
        &self,
        columns: &ColumnSelection,
        held: usize,
    ) -> Result<(Value, Result<Measured<'_>, Error>), Error> {
        match self.opened(columns, held)? {
            Opened::Held(table, format) => {
                let (channels, read, layout) =
                    (table.described(columns), table.record(columns), table.layout(format.name));
                drop(table);
                let document = inspection(channels, &read, &self.name, (format.name, &layout));
                Ok((document, read.map(Measured::Held)))
            }
            Opened::Long(record) => {
                let mut found = InSections::default();
                let read = record.sections(&mut |start, section| found.add(section, start));
                read.map_err(|error| error.of(&self.name))?;
                let (ts, samples, duration) = (record.ts(), record.len(), record.duration());
                let described = json!({"ts": ts, "samples": samples, "duration": duration, "units": record.units()});
                let contents = Ok((described, ts, record.history().to_vec(), found.findings()));
                let alike = (record.format(), record.layout());
                let document = document(record.channels().to_vec(), contents, &self.name, alike);
                Ok((document, Ok(Measured::Long(record))))
            }
        }
    }
}

/// The record of a file.
pub enum Measured<'a> {
    /// All its samples.
    Held(Record),
    /// One that is too long to be held.
    Long(Box<LongRecord<'a>>),
}

impl Measured<'_> {
    /// Its drive, by which a use is proposed; of a long record, the waveform is that of its first million samples.
    ///
    /// # Errors
    /// Returns an error if a long record is damaged before.
    pub fn drive(&self) -> Result<Drive, Error> {
        let drive = Drive::of(&*self.shown()?);
        Ok(match self {
            Measured::Held(_) => drive,
            Measured::Long(record) => drive.between(record.ends()[0]),
        })
    }

    /// The record; of a long one, its first million samples.
    pub(super) fn shown(&self) -> Result<Cow<'_, Record>, Error> {
        let record = match self {
            Measured::Held(record) => return Ok(Cow::Borrowed(record)),
            Measured::Long(record) => record,
        };
        let (mut u, mut y) = (Vec::new(), Vec::new());
        let enough = || Error::Cancelled { what: "reading".into(), done: SHOWN_SAMPLES, total: record.len() };
        let read = record.read(&mut |inputs, outputs| {
            u.extend_from_slice(inputs);
            y.extend_from_slice(outputs);
            if u.len() < SHOWN_SAMPLES { Ok(()) } else { Err(enough()) }
        });
        // An error after these samples is that of ending the reading.
        if u.len() < SHOWN_SAMPLES {
            read?;
        }
        Ok(Cow::Owned(Record::new(record.ts(), u, y)?.with_units(record.units().clone())))
    }
}

/// Sets in the documents of the files of a rig, in this order, for which `use` each file is proposed: `training` (a
/// large-signal record), `small-signal` or `validation`, and `because`, the reason in one sentence. It stays null for a
/// file without a record, which has no drive here, and if there is only one record.
pub fn propose(documents: &mut [Value], drives: &[Option<Drive>]) {
    let known: Vec<&Drive> = drives.iter().flatten().collect();
    if known.len() < 2 {
        return;
    }
    let with_record = documents.iter_mut().zip(drives).filter(|(_, drive)| drive.is_some());
    for ((document, _), Proposal { of, because }) in with_record.zip(uses(&known)) {
        document["use"] = json!({"use": of.name(), "because": because});
    }
}

/// What a table with this name and format holds, as [`File::inspect`] gives it.
pub fn inspect(table: &Table, name: &str, format: &str, columns: &ColumnSelection) -> (Value, Result<Record, Error>) {
    let read = table.record(columns);
    let alike = (format, &*table.layout(format));
    (inspection(table.described(columns), &read, name, alike), read)
}

/// The document of a file with these channels, and the record that was read from it.
fn inspection(channels: Vec<Value>, read: &Result<Record, Error>, name: &str, alike: (&str, &str)) -> Value {
    let contents = read.as_ref().map(|record| {
        let found = quality::inspect(record).findings;
        (described(record), record.ts(), record.history().to_vec(), found)
    });
    document(channels, contents, name, alike)
}

/// A record as a document, its sampling period, history and defects.
type Contents = (Value, f64, Vec<String>, Vec<Finding>);

/// The document of a file with these channels, its format and layout, and this record or the error that prevents it.
fn document(channels: Vec<Value>, contents: Result<Contents, &Error>, name: &str, alike: (&str, &str)) -> Value {
    let (format, layout) = alike;
    let (record, history, problems, defects) = match contents {
        Ok((record, ts, history, found)) => {
            let defects = found.iter().map(|finding| placed(finding, ts)).collect();
            (record, history, found.into_iter().map(|finding| finding.text).collect(), defects)
        }
        Err(error) => (Value::Null, Vec::new(), vec![error.to_string()], Vec::new()),
    };
    json!({
        "file": name, "format": format, "channels": channels, "record": record, "history": history,
        "problems": problems, "defects": defects, "layout": layout,
        "use": null,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::File;
    use piezoid_numerics::series;
    use std::f64::consts::TAU;

    #[test]
    fn an_inspection_in_sections_is_that_of_the_whole_but_for_the_place_of_a_defect() {
        let u: Vec<f64> = (0..6000).map(|t| 20.0 * (TAU * f64::from(t) / 211.0).sin()).collect();
        let mut y: Vec<f64> = u.iter().map(|u| 2e-3 * u - 0.1).collect();
        let inspected = |y: &[f64], held: usize| {
            let bytes = Table::write("r.csv", 5e-4, &[("Drive (V)", &u), ("Position (mm)", y)]).unwrap();
            let file = DataFile::from(File::new("r.csv", bytes));
            let columns = ColumnSelection { input_scale: Some("-2".into()), ..ColumnSelection::default() };
            let (document, record) = file.inspect_held(&columns, held).unwrap();
            let ends = match record.unwrap() {
                Measured::Held(record) => [record.u(), record.y()].map(|x| series::ends(x.iter().copied())),
                Measured::Long(record) => {
                    assert_eq!(record.profile(), &file.profile(&columns).unwrap());
                    record.ends()
                }
            };
            (document, ends)
        };
        assert_eq!(inspected(&y, 6000), inspected(&y, 2600));
        y[3000] += 0.05;
        let (whole, sections) = (inspected(&y, 6000).0, inspected(&y, 2600).0);
        assert_eq!(whole["defects"][0]["spans"], sections["defects"][0]["spans"]);
        assert!(sections["problems"][0].as_str().unwrap().contains("in the section from 1.2 s to 1.8 s"), "{sections}");
    }
}
