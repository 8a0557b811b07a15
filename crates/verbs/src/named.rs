//! Errors and notes about the records of an identification, with the names of their files.

use crate::identification::Records;
use piezoid_identification::called;
use piezoid_numerics::error::Error;
use piezoid_records::record::{Record, Units};
use serde_json::Value;

/// The records of an identification with the names of their files, small-signal records first.
#[derive(Clone, Copy)]
pub(super) struct Named<'a> {
    pub(super) records: Records<'a>,
    pub(super) names: &'a [&'a str],
}

impl<'a> Named<'a> {
    fn all(self) -> impl Iterator<Item = (&'a Record, &'a str)> {
        self.records.small_signal.iter().chain(self.records.large_signal).zip(self.names.iter().copied())
    }

    /// The name of the file of the record that begins this text, if there are several records.
    fn begins(self, text: &str) -> Option<&'a str> {
        let Records { small_signal, large_signal } = self.records;
        let kinds = [("small-signal record", small_signal.len()), ("large-signal record", large_signal.len())];
        let labels = kinds.into_iter().flat_map(|(kind, of)| (0..of).map(move |k| called(kind, k, of) + ":"));
        let mut found = labels.zip(self.names).filter(|(label, _)| self.names.len() > 1 && text.starts_with(label));
        found.next().map(|(_, name)| *name)
    }

    /// The same note, with the name of the file if it is about one record.
    pub(super) fn note(self, note: String) -> String {
        self.begins(&note).map(|name| format!("{name}: {note}")).unwrap_or(note)
    }

    /// The same error, with the names of the files if it is about sampling periods or units, or about one record.
    pub(super) fn error(self, error: Error) -> Error {
        match error {
            Error::Sampling { left, left_ts, right, right_ts } => {
                let name = |ts: f64, other: String| {
                    self.all().find(|(record, _)| record.ts() == ts).map_or(other, |(_, name)| name.into())
                };
                Error::Sampling { left: name(left_ts, left), left_ts, right: name(right_ts, right), right_ts }
            }
            Error::Units { .. } => self.units().unwrap_or(error),
            Error::Unidentifiable { ref because, .. } => match self.begins(because) {
                Some(name) => error.of(name),
                None => error,
            },
            other => other,
        }
    }

    /// An error about the first record whose units do not fit to those of the first one.
    fn units(self) -> Option<Error> {
        let (first, first_name) = self.all().next()?;
        let (expected, other) = (first.units(), self.all().find(|(record, _)| !fits(record.units(), first.units()))?);
        let (own, name) = (other.0.units(), other.1);
        let (signal, option, own, expected) = if own.u == expected.u {
            ("output", "output_scale", &own.y, &expected.y)
        } else {
            ("input", "input_scale", &own.u, &expected.u)
        };
        let problem = format!(
            "its {signal} is in {own}, but that of {first_name} is in {expected}: if a unit is wrong, state the right one; \
             else convert this file by `prepare` first; "
        );
        let factor = Units::factor(own, expected).map_or(Value::Null, |k| format!("{k}{expected}/{own}").into());
        Some(Error::Content(problem).of(name).advised(vec![(option, factor)]))
    }
}

/// True if records with these units can be fitted together.
fn fits(own: &Units, first: &Units) -> bool {
    own.u == first.u && Units::factor(&own.y, &first.y).is_some()
}

#[cfg(test)]
mod tests {
    use crate::{File, IdentifyOptions, Source};
    use piezoid_numerics::progress::Stage;
    use piezoid_records::formats::ColumnSelection;

    /// The error of an identification from a file of 400 rows every 0.5 ms and another.
    fn error(ts: f64, names: &str, row: impl Fn(f64) -> (f64, f64)) -> String {
        let file = |name: &str, ts: f64, names: &str, row: &dyn Fn(f64) -> (f64, f64)| {
            let row = |k: u32| {
                let (u, y) = row(f64::from(k));
                format!("{},{u},{y}\n", f64::from(k) * ts)
            };
            File::new(name, format!("t_s,{names}\n") + &(0..400).map(row).collect::<String>())
        };
        let wave = |k: f64| ((0.1 * k).sin(), k % 7.0);
        let files = [file("a.csv", 5e-4, "u_V,y_um", &wave), file("b.csv", ts, names, &row)];
        let large = Source::all(files.into(), &ColumnSelection::default());
        IdentifyOptions::default().run((Vec::new(), large), "", &mut Stage::ignore).unwrap_err().to_string()
    }

    #[test]
    fn records_of_two_rates_are_named_by_their_files() {
        assert_eq!(
            error(7e-4, "u_V,y_um", |k| ((0.1 * k).sin(), k % 7.0)),
            "a.csv is sampled every 0.0005 s but b.csv every 0.0007 s: resample one of them; `prepare` does, with the \
             option resample = 0.0007"
        );
    }

    #[test]
    fn records_of_two_units_are_named_by_their_files_with_the_factor() {
        let of = |names: &str| error(5e-4, names, |k| ((0.1 * k).sin(), k % 7.0));
        let what = "if a unit is wrong, state the right one; else convert this file by `prepare` first; give";
        let expected = |problem: &str, option: &str| format!("b.csv: {problem}: {what} {option}");
        assert_eq!(
            of("u_mV,y_um"),
            expected("its input is in mV, but that of a.csv is in V", "`input_scale` = \"0.001V/mV\"")
        );
        assert_eq!(
            of("u_V,y_counts"),
            expected("its output is in counts, but that of a.csv is in um", "`output_scale`")
        );
    }

    #[test]
    fn a_defect_of_one_of_several_records_names_its_file() {
        let constant = error(5e-4, "u_V,y_um", |k| (3.0, k % 7.0));
        assert!(
            constant.starts_with("b.csv: a model cannot be identified: large-signal record 2: the input is"),
            "{constant}"
        );
    }
}
