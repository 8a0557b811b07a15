//! Channels: the named contents of a file. Those that belong together form a table.

use super::column::Column;
use super::quote::shortened;
use super::table::Table;
use std::collections::HashMap;

/// Maximum number of omitted channels that a message names.
const MAX_LISTED_CHANNELS: usize = 12;

/// One named content of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its unit, if the file states it separately from the name.
    pub unit: Option<String>,
    /// Its sampling period [s], if the file states it for this channel.
    pub ts: Option<f64>,
    /// Its samples, or a description if it is not a vector of real numbers: `of shape 2 x 3`.
    pub samples: Result<Vec<f64>, String>,
}

impl Channel {
    /// A channel of samples; its name may contain a unit.
    pub fn new(name: impl Into<String>, samples: Vec<f64>) -> Self {
        Channel { name: name.into(), unit: None, ts: None, samples: Ok(samples) }
    }

    /// A channel that is not a vector, with a description.
    pub fn other(name: impl Into<String>, what: impl Into<String>) -> Self {
        Channel { name: name.into(), unit: None, ts: None, samples: Err(what.into()) }
    }
}

impl Table {
    /// A table of the channels with the most frequent length. The others are left out, and are named in errors about
    /// missing columns. Single numbers are not samples if there are longer channels. Errors count samples from 0;
    /// errors about text count lines.
    ///
    /// ```
    /// use piezoid::formats::{Channel, ColumnSelection, Table};
    /// let (t, u, y) = (vec![0.0, 5e-4], vec![0.0, 1.0], vec![0.1, 0.2]);
    /// let channels = [("t_s", t), ("u_V", u), ("y_mm", y), ("gain", vec![10.0])];
    /// let table = Table::of(channels.map(|(name, samples)| Channel::new(name, samples)));
    /// assert_eq!(table.record(&ColumnSelection::default())?.units().y, "mm");
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// Two channels of one name, and samples that are not finite, are an error only if they are used.
    pub fn of(channels: impl IntoIterator<Item = Channel>) -> Self {
        let mut left = Vec::new();
        let mut columns = Vec::new();
        for Channel { name, unit, ts, samples } in channels {
            match samples {
                Ok(samples) => {
                    let flaw = piezoid_numerics::error::finite(&name, &samples).err();
                    columns.push(Column { unit, ts, samples, flaw, ..Column::new(name) });
                }
                Err(what) => left.push(format!("{} ({what})", shortened(&name))),
            }
        }
        let longest = columns.iter().map(|column| column.samples.len()).max().unwrap_or(0);
        columns.retain(|column| column.samples.len() > 1 || longest == column.samples.len());
        let usual = usual(columns.iter().map(|column| column.samples.len()));
        let mut table = Table { count: usual, ..Table::default() };
        for column in columns {
            if column.samples.len() == usual {
                table.columns.push(column);
            } else {
                let length = column.samples.len();
                left.push(format!("{} (of {length} samples, not {usual})", shortened(&column.name)));
                table.others.push(column);
            }
        }
        let more = left.len().saturating_sub(MAX_LISTED_CHANNELS);
        left.truncate(MAX_LISTED_CHANNELS);
        table.left = left.join(", ");
        if more > 0 {
            table.left += &format!(" and {more} more");
        }
        table
    }
}

/// The most frequent length; of equally frequent lengths, the longest.
fn usual(lengths: impl Iterator<Item = usize>) -> usize {
    let mut counts = HashMap::new();
    lengths.for_each(|length| *counts.entry(length).or_insert(0) += 1);
    counts.into_iter().max_by_key(|(length, count)| (*count, *length)).map_or(0, |(length, _)| length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::ColumnSelection;

    fn channels(lengths: &[(&str, usize)]) -> Vec<Channel> {
        lengths.iter().map(|(name, n)| Channel::new(*name, (0..*n).map(|k| k as f64).collect())).collect()
    }

    #[test]
    fn what_is_as_long_as_most_is_a_table_and_the_rest_is_told() {
        let mut arguments = channels(&[("t_s", 4), ("u_V", 4), ("y_um", 3), ("a", 1), ("b", 1), ("a", 1), ("c", 1)]);
        arguments.push(Channel::other("map", "of shape 2 x 2"));
        let table = Table::of(arguments);
        assert_eq!(table.names().collect::<Vec<_>>(), ["t_s", "u_V"]);
        assert_eq!(
            table.record(&ColumnSelection::default()).unwrap_err().to_string(),
            "there is no output column: expected exactly one `y_*` among the columns `t_s`, `u_V`; left out: map (of shape 2 x 2), y_um (of 3 samples, not 4); give `output_col`"
        );
        let requested = ColumnSelection { output_col: Some("map".into()), ..ColumnSelection::default() };
        assert!(table.record(&requested).unwrap_err().to_string().contains("left out: map (of shape 2 x 2)"));
        let many: Vec<(String, usize)> = (0..20).map(|k| (format!("c{k}"), 2 + k)).collect();
        let many: Vec<(&str, usize)> = many.iter().map(|(name, n)| (name.as_str(), *n)).collect();
        assert!(Table::of(channels(&many)).left.ends_with("(of 13 samples, not 21) and 7 more"));
    }

    #[test]
    fn a_record_of_one_sample_is_one() {
        let table = Table::of(channels(&[("u_V", 1), ("y_um", 1)]));
        assert_eq!(table.record(&ColumnSelection { ts: Some(1.0), ..ColumnSelection::default() }).unwrap().len(), 1);
    }

    #[test]
    fn two_channels_of_one_name_harm_who_needs_them() {
        let table = Table::of(channels(&[("t_s", 4), ("u_V", 4), ("u_V", 4), ("y_um", 4)]));
        let requested = ColumnSelection { input_col: Some("u_V".into()), ..ColumnSelection::default() };
        for selection in [&requested, &ColumnSelection::default()] {
            let error = table.record(selection).unwrap_err().to_string();
            assert!(error.contains("`u_V` is also the name of column 2"), "{error}");
        }
        let by_number = ColumnSelection { input_col: Some("3".into()), ..ColumnSelection::default() };
        assert!(table.record(&by_number).is_ok());
    }

    #[test]
    fn channels_of_another_length_can_be_chosen_together() {
        let table = Table::of(channels(&[("a/u", 4), ("a/y", 4), ("b/u", 3), ("b/y", 3), ("t", 4)]));
        let ask = |u: &str, y: &str| ColumnSelection {
            ts: Some(1.0),
            input_col: Some(u.into()),
            output_col: Some(y.into()),
            ..ColumnSelection::default()
        };
        assert_eq!(table.record(&ask("b/u", "b/y")).unwrap().len(), 3);
        let error = table.record(&ask("b/u", "a/y")).unwrap_err().to_string();
        assert!(error.starts_with("b/u has 3 samples but a/y has 4"), "{error}");
        let error = table.record(&ColumnSelection::default()).unwrap_err().to_string();
        assert!(error.contains("input_col") && error.contains("output_col"), "{error}");
    }

    #[test]
    fn a_unit_and_a_period_that_the_file_states_are_the_tables() {
        let stated =
            |name: &str, unit: &str| Channel { unit: Some(unit.into()), ..Channel::new(name, vec![0.0, 1.0, 2.0]) };
        let table = Table { ts: Some(0.5), ..Table::of([stated("u_drive", "V"), stated("y_probe", "\u{b5}m")]) };
        let record = table.record(&ColumnSelection::default()).unwrap();
        assert_eq!((record.ts(), &*record.units().u, &*record.units().y), (0.5, "V", "um"));
        let text = ColumnSelection { ts: Some(0.25), ..ColumnSelection::default() };
        assert_eq!(table.record(&text).unwrap().ts(), 0.25, "who says a period knows better");
        let timed = Table::of([stated("t", "ms"), stated("u_drive", "V"), stated("y_probe", "nm")]);
        assert_eq!(timed.record(&ColumnSelection::default()).unwrap().ts(), 1e-3);
    }
}
