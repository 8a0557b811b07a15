//! Selection of columns: by name, or by options of the user.
//!
//! Time is `t_s`. The input is `u_V`, or else the only `u_*`; the output is the only `y_*`; the rest of the name is the
//! unit. Other columns are ignored. No column is selected because its name is only similar: the error suggests it
//! instead.

use super::quote::{listed, shortened};
use super::table::{Column, Table};
use crate::Error;
use crate::options::{OptionKind, OptionRow, options};
use crate::record::{Record, plain};
use serde_json::Value;
use std::ops::Range;

options! {
    /// What the user says about the columns and the part of a data file; the names decide wherever it says nothing.
    ///
    /// A column chosen here may have any name. Its unit is what follows `u_` or `y_`; else what stands in brackets at
    /// the end, as in `Voltage [V]`; else what follows the last underscore, as in `sensor_um`, unless that holds a
    /// digit, as in `channel_2`; else none, the empty string.
    pub struct ColumnSelection {
        /// Sampling period, for files without a time column.
        ts: Option<f64> = None, OptionRow::positive("s").group(GROUP);
        /// Name of the input column.
        input_col: Option<String> = None, OptionRow::new(NAME).absent("u_V").group(GROUP);
        /// Name of the output column.
        output_col: Option<String> = None, OptionRow::new(NAME).absent("the one named y_*").group(GROUP);
        /// Name of the time column.
        time_col: Option<String> = None, OptionRow::new(NAME).absent("t_s").group(GROUP);
        /// Use the data from this time on, counted from the first row.
        from: Option<f64> = None, OptionRow::not_negative("s").group(GROUP);
        /// Use the data up to this time, counted from the first row.
        to: Option<f64> = None, OptionRow::not_negative("s").group(GROUP);
    }
}

const NAME: OptionKind = OptionKind::Text("NAME");
const GROUP: &str = "Data files";

impl ColumnSelection {
    /// The selected range of `n` samples.
    pub(super) fn part(&self, ts: f64, n: usize) -> Result<Range<usize>, Error> {
        match (self.from, self.to) {
            (None, None) => Ok(0..n),
            (from, to) => Record::span(from.unwrap_or(0.0), to.unwrap_or(f64::INFINITY), ts, n),
        }
    }

    /// True if the user gave this column a role.
    fn mentions(&self, name: &str) -> bool {
        [&self.input_col, &self.output_col, &self.time_col].into_iter().flatten().any(|asked| asked.trim() == name)
    }
}

/// The role of a column, and how the column is recognised.
pub(super) struct ColumnRole {
    what: &'static str,
    /// A column with this name is always selected.
    exact: Option<&'static str>,
    /// A column with this prefix is selected if it is the only one.
    prefix: Option<&'static str>,
    option: &'static str,
    /// The option that replaces the column.
    instead: Option<&'static str>,
    asked: fn(&ColumnSelection) -> Option<&String>,
    /// First words of names that probably have this role. Errors suggest them; they are never selected.
    hints: &'static [&'static str],
}

/// The time [s].
pub(super) static TIME: ColumnRole = ColumnRole {
    what: "time",
    exact: Some("t_s"),
    prefix: None,
    option: "time_col",
    instead: Some("ts"),
    asked: |selection| selection.time_col.as_ref(),
    hints: &["t", "ts", "time", "timestamp", "sec", "second", "seconds"],
};

/// The input u.
pub(super) static INPUT: ColumnRole = ColumnRole {
    what: "input",
    exact: Some("u_V"),
    prefix: Some("u_"),
    option: "input_col",
    instead: None,
    asked: |selection| selection.input_col.as_ref(),
    hints: &["u", "uv", "v", "volt", "volts", "voltage", "input", "in", "cmd", "command", "drive"],
};

/// The output y.
pub(super) static OUTPUT: ColumnRole = OUT;

const OUT: ColumnRole = ColumnRole {
    what: "output",
    exact: None,
    prefix: Some("y_"),
    option: "output_col",
    instead: None,
    asked: |selection| selection.output_col.as_ref(),
    hints: &["y", "yum", "disp", "displacement", "pos", "position", "output", "out", "sensor", "x", "z"],
};

/// The reference r, a requested output.
pub(super) static REFERENCE: ColumnRole = ColumnRole { what: "reference", prefix: Some("r_"), ..OUT };

impl ColumnRole {
    /// The only column of the table with this role.
    pub(super) fn find<'a>(&self, table: &'a Table, selection: &ColumnSelection) -> Result<&'a Column, Error> {
        if let Some(name) = (self.asked)(selection) {
            let column = table.columns.iter().find(|c| c.name == name.trim());
            return column.ok_or_else(|| unknown(name, table));
        }
        let free = || table.columns.iter().filter(|c| !selection.mentions(&c.name));
        if let Some(column) = free().find(|c| Some(c.name.as_str()) == self.exact) {
            return Ok(column);
        }
        let candidates: Vec<&Column> =
            free().filter(|c| self.prefix.is_some_and(|prefix| c.name.starts_with(prefix))).collect();
        match candidates[..] {
            [column] => Ok(column),
            [] => Err(self.missing(table, free().map(|c| c.name.as_str()))),
            _ => Err(Error::Line {
                line: table.header,
                column: None,
                problem: format!(
                    "{} could each be the {}; choose one: ",
                    listed(candidates.iter().map(|c| c.name.as_str())),
                    self.what,
                ),
            }
            .advised(vec![(self.option, Value::Null)])),
        }
    }

    /// The error that no column has this role: the name that is expected, and the column that may be meant.
    fn missing<'a>(&self, table: &Table, mut free: impl Iterator<Item = &'a str>) -> Error {
        let patterns = [self.exact.map(|name| format!("`{name}`")), self.prefix.map(|p| format!("exactly one `{p}*`"))];
        let patterns = patterns.into_iter().flatten().collect::<Vec<_>>().join(" or ");
        let wrong = format!("there is no {} column: expected {patterns}", self.what);
        if table.columns.len() == 1 && table.names().any(|name| name.contains(char::is_whitespace)) {
            let remedy = "; separate the columns with commas, semicolons or tabs: spaces belong to a name";
            return table.about_names(&wrong, remedy);
        }
        let hinted = free.find(|name| self.hints.contains(&first_word(name).as_str())).map(shortened);
        let remedy = hinted.as_ref().map_or("; ".into(), |name| format!("; it may be `{name}`: "));
        let instead = self.instead.map(|option| (option, Value::Null));
        let options = instead.into_iter().chain([(self.option, Value::from(hinted))]).collect();
        table.about_names(&wrong, &remedy).advised(options)
    }
}

/// The error for a requested column that the file does not have.
fn unknown(name: &str, table: &Table) -> Error {
    let known: Vec<String> = table.names().take(100).map(shortened).collect();
    Error::unknown("column", name, known.iter().map(String::as_str))
}

/// Returns an error for a time column that states another unit than seconds.
pub(super) fn in_seconds(column: &Column, header: u64) -> Result<&Column, Error> {
    match column.unit("t_") {
        other if ["ms", "us", "ns", "min", "h"].contains(&other.as_str()) => Err(Error::Line {
            line: header,
            column: Some(shortened(&column.name)),
            problem: format!("the time is in {other}, not in seconds: convert it, or "),
        }
        .advised(vec![("ts", Value::Null)])),
        _ => Ok(column),
    }
}

/// The letters and digits at the start of a name, in lower case.
fn first_word(name: &str) -> String {
    name.chars().take_while(|c| c.is_alphanumeric()).take(20).flat_map(char::to_lowercase).collect()
}

impl Column {
    /// Its unit: the one that the format states, else the one in its name after this prefix.
    pub(super) fn unit(&self, prefix: &str) -> String {
        self.unit.as_deref().map_or_else(|| unit(&self.name, prefix), |stated| plain(stated.trim()))
    }
}

/// The unit in a name (see [`ColumnSelection`]); the Greek letter of micro becomes `u`.
fn unit(name: &str, prefix: &str) -> String {
    let bracketed = |open, close| name.strip_suffix(close).and_then(|head: &str| head.rsplit_once(open));
    let unit = name
        .strip_prefix(prefix)
        .or_else(|| bracketed('[', ']').or_else(|| bracketed('(', ')')).map(|(_, unit)| unit))
        .or_else(|| name.rsplit_once('_').map(|(_, unit)| unit).filter(|unit| !unit.contains(char::is_numeric)))
        .unwrap_or_default();
    plain(unit.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(header: &str) -> Table {
        let zeros = header.replace(|c| c != ',', "0").replace("00", "0");
        let row = vec!["0"; zeros.matches(',').count() + 1].join(",");
        Table::parse(format!("{header}\n{row}\n").as_bytes()).unwrap()
    }

    fn found(role: &ColumnRole, header: &str, selection: &ColumnSelection) -> Result<String, String> {
        role.find(&table(header), selection).map(|c| c.name.clone()).map_err(|e| e.to_string())
    }

    fn default(role: &ColumnRole, header: &str) -> Result<String, String> {
        found(role, header, &ColumnSelection::default())
    }

    #[test]
    fn the_input_is_u_in_volts_or_the_only_u() {
        assert_eq!(default(&INPUT, "t_s,u_cmdV,u_V,y_um").unwrap(), "u_V");
        assert_eq!(default(&INPUT, "t_s,u_cmdV,y_um").unwrap(), "u_cmdV");
        assert_eq!(
            default(&INPUT, "t_s,u_cmdV,u_monV,y_um").unwrap_err(),
            "line 1: `u_cmdV`, `u_monV` could each be the input; choose one: give `input_col`"
        );
    }

    #[test]
    fn the_output_is_the_only_y_and_a_reference_is_none() {
        assert_eq!(default(&OUTPUT, "t_s,u_V,y_counts,yref_um").unwrap(), "y_counts");
        assert_eq!(
            default(&OUTPUT, "t_s,u_V,y_um,y_mm").unwrap_err(),
            "line 1: `y_um`, `y_mm` could each be the output; choose one: give `output_col`"
        );
        let chosen = ColumnSelection { output_col: Some("y_mm".into()), ..ColumnSelection::default() };
        assert_eq!(found(&OUTPUT, "t_s,u_V,y_um,y_mm", &chosen).unwrap(), "y_mm");
    }

    #[test]
    fn a_reference_is_the_only_r_or_else_the_only_y() {
        let reference =
            |file: &str| table(file).reference(&ColumnSelection { ts: Some(1.0), ..ColumnSelection::default() });
        assert_eq!(reference("r_mm,y_um").unwrap().unit, "mm");
        assert_eq!(reference("t_s,y_um").unwrap().unit, "um");
        assert!(reference("t_s,r_um,r_mm").unwrap_err().to_string().contains("could each be the reference"));
        assert!(
            reference("t_s,u_V")
                .unwrap_err()
                .to_string()
                .contains("there is no reference column: expected exactly one `r_*`")
        );
    }

    #[test]
    fn a_missing_column_is_answered_with_what_is_there_and_what_may_be_meant() {
        assert_eq!(
            default(&INPUT, "t_s,Voltage [V],y_um").unwrap_err(),
            "line 1: there is no input column: expected `u_V` or exactly one `u_*` among the columns `t_s`, `Voltage [V]`, `y_um`; it may be `Voltage [V]`: give `input_col` = \"Voltage [V]\""
        );
        assert_eq!(
            default(&INPUT, "t_s,a,b").unwrap_err(),
            "line 1: there is no input column: expected `u_V` or exactly one `u_*` among the columns `t_s`, `a`, `b`; \
             give `input_col`"
        );
        assert!(default(&INPUT, "t_s,u,y_um").unwrap_err().contains("it may be `u`: give"));
        assert!(default(&OUTPUT, "t_s,u_V,Position").unwrap_err().contains("`output_col` = \"Position\""));
        assert!(default(&OUTPUT, "t_s,u_V,yref_um").unwrap_err().ends_with("; give `output_col`"));
        assert_eq!(
            default(&TIME, "u_V,y_um").unwrap_err(),
            "line 1: there is no time column: expected `t_s` among the columns `u_V`, `y_um`; give `ts` or `time_col`"
        );
        assert!(
            default(&TIME, "time,u_V,y_um")
                .unwrap_err()
                .ends_with("it may be `time`: give `ts` or `time_col` = \"time\"")
        );
        assert!(default(&INPUT, "t_s u_V y_um").unwrap_err().contains("commas, semicolons or tabs"));
    }

    #[test]
    fn a_name_that_is_not_there_is_answered_with_the_nearest() {
        let asked = ColumnSelection { input_col: Some("u_cmd".into()), ..ColumnSelection::default() };
        assert_eq!(
            found(&INPUT, "t_s,u_cmdV,y_um", &asked).unwrap_err(),
            "there is no column called `u_cmd`: known are t_s, u_cmdV, y_um; did you mean `u_cmdV`?"
        );
    }

    #[test]
    fn a_column_given_to_one_role_is_not_taken_for_another() {
        let selection = ColumnSelection { input_col: Some("y_um".into()), ..ColumnSelection::default() };
        assert_eq!(found(&OUTPUT, "t_s,y_um,y_mm", &selection).unwrap(), "y_mm");
    }

    #[test]
    fn a_time_in_milliseconds_is_refused() {
        let asked = ColumnSelection { time_col: Some("t_ms".into()), ..ColumnSelection::default() };
        assert_eq!(
            table("t_ms,u_V,y_um").record(&asked).unwrap_err().to_string(),
            "line 1, column t_ms: the time is in ms, not in seconds: convert it, or give `ts`"
        );
    }

    #[test]
    fn the_unit_is_read_from_the_name() {
        let cases = [
            ("y_um", "um"),
            ("y_\u{b5}m", "um"),
            ("y_strain_ppm", "strain_ppm"),
            ("y_", ""),
            ("sensor_um", "um"),
            ("channel_2", ""),
            ("Position", ""),
            ("Position [nm]", "nm"),
            ("Position (mm)", "mm"),
        ];
        for (name, wanted) in cases {
            assert_eq!(unit(name, "y_"), wanted, "{name}");
        }
    }
}
