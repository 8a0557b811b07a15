//! Records and signals as files. Reading them gives bit-identical numbers.

use super::{FORMATS, Format, Table, Write, csv};
use crate::record::Record;
use piezoid_numerics::error::{Error, finite, positive};
use std::io;

impl Table {
    /// A file with the time column `t_s`, multiples of `ts` [s] from 0, then these columns, named with their units. The
    /// extension of `name` selects the format: `.npz`, `.mat`, or CSV for all others.
    ///
    /// ```
    /// use piezoid::formats::Table;
    /// let columns: &[(&str, &[f64])] = &[("u_V", &[0.0, 1.0, 2.5]), ("y_um", &[0.1, -0.2, 1e-9])];
    /// let text = Table::write("r.csv", 5e-4, columns)?;
    /// assert_eq!(text, b"t_s,u_V,y_um\n0.0000,0,0.1\n0.0005,1,-0.2\n0.0010,2.5,1e-9\n");
    /// assert!(Table::write("r.npz", 5e-4, columns)?.starts_with(b"PK"));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// `ts` must be positive, the columns equally long and finite, and their names different and without line ends;
    /// those in a `.mat` file must be names of variables. Returns an error for an extension of a format that is only
    /// read, and for more than 2 GiB in a binary format.
    pub fn write(name: &str, ts: f64, columns: &[(&str, &[f64])]) -> Result<Vec<u8>, Error> {
        Table::write_with(name, ts, columns, &[])
    }

    /// The same with a history.
    fn write_with(name: &str, ts: f64, columns: &[(&str, &[f64])], history: &[String]) -> Result<Vec<u8>, Error> {
        let format = written(name)?;
        let rows = columns.first().map_or(0, |(_, samples)| samples.len());
        let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        named(&names, ts)?;
        positive("time of the last row", rows.max(1) as f64 * ts, "seconds")?;
        for (name, samples) in columns {
            if samples.len() != rows {
                let (left, left_len) = (columns[0].0.into(), rows);
                return Err(Error::Lengths { left, left_len, right: (*name).into(), right_len: samples.len() });
            }
            finite(name, samples)?;
        }
        format(ts, columns, history)
    }

    /// Returns an error if [`write`](Table::write) refuses the extension of this name.
    ///
    /// ```
    /// use piezoid::formats::Table;
    /// assert!(["u.NPZ", "u.mat", "u.txt", "u", "-"].iter().all(|name| Table::writable(name).is_ok()));
    /// assert_eq!(
    ///     Table::writable("u.h5").unwrap_err().to_string(),
    ///     ".h5 files are read, but not written: name the file .csv or .npz or .mat"
    /// );
    /// ```
    ///
    /// # Errors
    /// Returns an error if files with this extension are only read.
    pub fn writable(name: &str) -> Result<(), Error> {
        written(name).map(drop)
    }
}

impl Table {
    /// True if [`write`](Table::write) writes CSV to a file of this name, which [`TextWriter`] does piece by piece.
    pub fn is_text(name: &str) -> bool {
        Format::meant(name).0.is_none_or(|format| format.in_pieces)
    }
}

impl Record {
    /// This record as a file with the columns `t_s`, `u_*` and `y_*` in its units, and its history; see
    /// [`Table::write`].
    ///
    /// ```
    /// use piezoid::{Record, formats::{ColumnSelection, Table}};
    /// let record = Record::new(5e-4, vec![0.0, 1.0], vec![0.1, 20.3])?;
    /// let table = Table::read("r.mat", &record.written("r.mat")?)?;
    /// assert_eq!(table.record(&ColumnSelection::default())?, record);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Table::write`], which depend on the units.
    pub fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        let (u, y) = (format!("u_{}", self.units().u), format!("y_{}", self.units().y));
        Table::write_with(name, self.ts(), &[(&u, self.u()), (&y, self.y())], self.history())
    }
}

/// Returns an error for names of columns that cannot be read again, and for an invalid sampling period.
fn named(names: &[&str], ts: f64) -> Result<(), Error> {
    positive("ts", ts, "seconds")?;
    for (i, name) in names.iter().enumerate() {
        let twice = *name == "t_s" || names[..i].contains(name);
        if twice || name.trim() != *name || name.is_empty() || name.contains(char::is_control) {
            let rule = "must be on one line, and there only once";
            return Err(Error::parameter("column name", format!("{name:?}"), rule));
        }
    }
    Ok(())
}

/// A CSV file that is written piece by piece.
pub struct TextWriter<W> {
    names: Vec<String>,
    to: csv::Writer<W>,
}

impl<W: io::Write> TextWriter<W> {
    /// A file of columns with these names, sampled every `ts` [s].
    ///
    /// ```
    /// use piezoid_records::formats::TextWriter;
    /// let mut file = Vec::new();
    /// let mut writer = TextWriter::new(&mut file, 0.5, &["u_V"])?;
    /// writer.rows(&[&[1.0, 2.0]])?;
    /// writer.rows(&[&[3.0]])?;
    /// assert_eq!(file, b"t_s,u_V\n0.0,1\n0.5,2\n1.0,3\n");
    /// # Ok::<(), piezoid_numerics::error::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Table::write`], and an error if the file cannot be written.
    pub fn new(to: W, ts: f64, names: &[&str]) -> Result<Self, Error> {
        named(names, ts)?;
        let to = csv::Writer::new(to, ts, names, &[])?;
        Ok(TextWriter { names: names.iter().map(ToString::to_string).collect(), to })
    }

    /// Adds rows of these columns, in the order of their names.
    ///
    /// # Errors
    /// Returns an error for samples that are not finite, and if the file cannot be written.
    pub fn rows(&mut self, columns: &[&[f64]]) -> Result<(), Error> {
        self.names.iter().zip(columns).try_for_each(|(name, samples)| finite(name, samples))?;
        self.to.rows(columns)
    }
}

/// What writes a file of this name: the format with this as its first extension; CSV if no format has the extension.
fn written(name: &str) -> Result<Write, Error> {
    let (meant, extension) = Format::meant(name);
    let row = meant.unwrap_or(&csv::ROW);
    let own = |_: &Write| row.name == csv::ROW.name || extension.eq_ignore_ascii_case(row.extensions[0]);
    row.write.filter(own).ok_or_else(|| {
        let written = FORMATS.iter().filter(|row| row.write.is_some());
        let names: Vec<String> = written.map(|row| format!(".{}", row.extensions[0])).collect();
        let names = names.join(" or ");
        Error::Content(format!(".{extension} files are read, but not written: name the file {names}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::ColumnSelection;
    use crate::record::Units;

    const NAMES: [&str; 3] = ["r.csv", "r.npz", "r.mat"];

    fn back(name: &str, bytes: &[u8]) -> Record {
        Table::read("any", bytes).and_then(|table| table.record(&ColumnSelection::default())).expect(name)
    }

    #[test]
    fn what_could_not_be_read_back_is_refused() {
        for name in NAMES {
            let refusal = |ts, columns: &[(&str, &[f64])]| Table::write(name, ts, columns).unwrap_err().to_string();
            assert!(refusal(0.0, &[]).starts_with("ts = 0"));
            assert!(refusal(1e308, &[("u_V", &[0.0; 20])]).starts_with("time of the last row = inf"));
            assert!(refusal(1.0, &[("u_V", &[f64::NAN])]).starts_with("u_V[0] is NaN"));
            assert!(refusal(1.0, &[("u_V", &[0.0]), ("y_um", &[])]).starts_with("u_V has 1 samples but y_um has 0"));
            assert!(refusal(1.0, &[("u_V", &[0.0]), ("u_V", &[0.0])]).contains("only once"));
            assert!(refusal(1.0, &[("u\n", &[0.0])]).starts_with("column name = \"u\\n\""));
        }
    }

    #[test]
    fn the_extension_selects_the_format() {
        for (name, format) in
            [("r.csv", "csv"), ("R.NPZ", "numpy"), ("a.b/r.mat", "matlab"), ("r.dat", "csv"), ("-", "csv")]
        {
            let bytes = Table::write(name, 1.0, &[("u_V", &[1.0, 2.0])]).unwrap();
            assert_eq!(Format::of(&bytes).name, format, "{name}");
        }
        for name in ["r.npy", "r.h5", "r.TDMS", "r.wav", "r.gcs"] {
            let error = Table::write(name, 1.0, &[("u_V", &[1.0])]).unwrap_err().to_string();
            assert!(error.ends_with("read, but not written: name the file .csv or .npz or .mat"), "{error}");
        }
    }

    #[test]
    fn a_record_keeps_its_units_however_odd() {
        let units = Units { u: "mV".into(), y: "a;\"b\", c/d".into() };
        let record = Record::new(0.3, vec![-0.0, 1e-300], vec![f64::MAX, f64::MIN_POSITIVE]).unwrap().with_units(units);
        for name in ["r.csv", "r.npz"] {
            assert_eq!(back(name, &record.written(name).unwrap()), record);
        }
        let error = record.written("r.mat").unwrap_err().to_string();
        assert!(error.contains("y_a;") && error.contains("no name of a variable of MATLAB"), "{error}");
        let long = format!("u_{}", "x".repeat(61));
        assert!(Table::write("r.mat", 1.0, &[(&long, &[1.0])]).is_ok());
        assert!(Table::write("r.mat", 1.0, &[(&format!("{long}x"), &[1.0])]).is_err());
    }

    #[test]
    fn the_history_of_a_record_travels_with_it() {
        let plain = Record::new(5e-4, vec![0.0, 1.0], vec![0.1, 20.3]).unwrap();
        let steps = ["cut from 1 s to 2 s", "sample rate: 7, \"x\"\nof \u{b5}m", "3, 4 = 5"];
        let record = steps.iter().fold(plain.clone(), |record, step| record.with_step((*step).into()));
        for name in NAMES {
            let back = back(name, &record.written(name).unwrap());
            assert_eq!((&back, back.history().len()), (&plain, 3), "{name}");
            let expected = ["cut from 1 s to 2 s", "sample rate: 7, \"x\" of \u{b5}m", "3, 4 = 5"];
            assert_eq!(back.history(), expected, "{name}");
            let (plain, columns) = (plain.written(name).unwrap(), [("u_V", plain.u()), ("y_um", plain.y())]);
            assert_eq!(plain, Table::write(name, 5e-4, &columns).unwrap(), "{name}");
        }
        let text = String::from_utf8(record.written("r.csv").unwrap()).unwrap();
        assert!(text.starts_with("# piezoid: cut from 1 s to 2 s\n# piezoid: sample rate"), "{text}");
        for text in [text.replace('\n', "\r\n"), text.replace('\n', "\r")] {
            assert_eq!(back("r.csv", text.as_bytes()).history().len(), 3, "{text:?}");
        }
        let error = Table::parse(text.replace("20.3", "x").as_bytes()).unwrap().record(&ColumnSelection::default());
        assert!(error.unwrap_err().to_string().starts_with("line 6, column y_um"), "lines are counted from the first");
        let error = Table::parse(b"# piezoid: cut").unwrap_err().to_string();
        assert!(error.contains("holds only comments"), "{error}");
    }

    #[test]
    fn a_long_record_keeps_an_odd_sampling_period() {
        let u: Vec<f64> = (0..100_000).map(|k| f64::from(k).sin()).collect();
        for ts in [1.0 / 3e4, 5e-4, 1.0 / 44_100.0, 1.0 / 3.0] {
            let record = Record::new(ts, u.clone(), u.clone()).unwrap();
            for name in NAMES {
                let back = back(name, &record.written(name).unwrap());
                assert_eq!((back.ts().to_bits(), &back), (ts.to_bits(), &record), "{name}");
            }
        }
    }
}
