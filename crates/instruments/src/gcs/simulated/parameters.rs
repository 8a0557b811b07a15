//! The parameters of the controller, by the numbers of PI's manuals.
//!
//! `SPA` changes some of them at command level 1 (`CCL 1 advanced`) until the controller ends, the number of recorder
//! tables at any level. P-term, notch filters and the like change without effect; so does all that `SEP` keeps and
//! `SEP?` answers.

use super::errors::{COUNT, PARAMETER, PASSWORD, PROTECTED, RANGE, READ_ONLY, refused};
use super::generators::{POINTS, WAVES};
use super::recorder::{RECORDED, TABLES};
use super::words::{code, real, triples};
use super::{CYCLE, Device};
use crate::simulated::Model;
use crate::simulated::axis::Axis;

/// Password of `SEP`, and that of command level 1.
const SEP_PASSWORD: &str = "100";
const ADVANCED: &str = "advanced";

/// A parameter.
struct Row {
    number: u32,
    kind: &'static str,
    what: &'static str,
    get: fn(&Device, &Axis) -> String,
    set: Set,
}

/// How `SPA` changes a parameter.
enum Set {
    Never,
    /// In an axis.
    Axis(fn(&mut Axis) -> &mut f64),
    /// It is answered again, and nothing else.
    Kept,
    /// The number of tables of the recorder, of the controller as a whole, at any level. It changes no table.
    Tables,
}

impl Row {
    /// Where the value of an axis is kept.
    fn place(&self, k: usize) -> (usize, u32) {
        (if matches!(self.set, Set::Tables) { 0 } else { k }, self.number)
    }
}

const fn row(number: u32, kind: &'static str, what: &'static str, get: fn(&Device, &Axis) -> String) -> Row {
    Row { number, kind, what, get, set: Set::Never }
}

/// A number of an axis that `SPA` changes.
const fn float(
    number: u32,
    what: &'static str,
    get: fn(&Device, &Axis) -> String,
    set: fn(&mut Axis) -> &mut f64,
) -> Row {
    Row { number, kind: "FLOAT", what, get, set: Set::Axis(set) }
}

/// A number that `SPA` changes without effect.
const fn kept(number: u32, kind: &'static str, what: &'static str, get: fn(&Device, &Axis) -> String) -> Row {
    Row { number, kind, what, get, set: Set::Kept }
}

/// The number of tables of the recorder.
const RECORDER_TABLES: u32 = 0x1600_0300;

/// A number without the rounding of its computation.
fn text(value: f64) -> String {
    format!("{value:.8e}").parse().unwrap_or(value).to_string()
}

/// Those of a servo have numbers in this range.
const SERVO_FIRST: u32 = 0x0600_0000;
const SERVO_END: u32 = 0x0900_0000;

#[rustfmt::skip]
const ROWS: [Row; 31] = [
    row(0x0700_0000, "FLOAT", "Range Limit min", |_, axis| text(axis.travel.0)),
    row(0x0700_0001, "FLOAT", "Range Limit max", |_, axis| text(axis.travel.1)),
    float(0x0700_0200, "Servo Loop Slew-Rate", |_, axis| text(axis.velocity), |axis| &mut axis.velocity),
    float(0x0700_0201, "Open Loop Slew-Rate", |_, axis| text(axis.slew), |axis| &mut axis.slew),
    kept(0x0700_0300, "FLOAT", "Servo Loop P-Term", |_, _| "0".into()),
    float(0x0700_0301, "Servo Loop I-Term", |_, axis| axis.bandwidth.to_string(), |axis| &mut axis.bandwidth),
    kept(0x0700_0302, "FLOAT", "Servo Loop D-Term", |_, _| "0".into()),
    kept(0x0703_0600, "FLOAT", "Servo Loop Feed-Forward", |_, _| "1".into()),
    kept(0x0600_0500, "INT", "ADC Channel for Target", |_, _| "0".into()),
    kept(0x0800_0100, "FLOAT", "Notch Frequency 1", |_, _| "0".into()),
    kept(0x0800_0101, "FLOAT", "Notch Frequency 2", |_, _| "0".into()),
    kept(0x0800_0200, "FLOAT", "Notch Rejection 1", |_, _| "1".into()),
    kept(0x0800_0201, "FLOAT", "Notch Rejection 2", |_, _| "1".into()),
    kept(0x0800_0300, "FLOAT", "Notch Bandwidth 1", |_, _| "0".into()),
    kept(0x0800_0301, "FLOAT", "Notch Bandwidth 2", |_, _| "0".into()),
    row(0x0700_0600, "CHAR", "Axis Name", |_, axis| axis.name.clone()),
    row(0x0700_0601, "CHAR", "Axis Unit", |_, _| "um".into()),
    float(0x0700_0900, "ON Target Tolerance", |_, axis| text(axis.tolerance), |axis| &mut axis.tolerance),
    float(0x0700_0901, "Settling Time", |_, axis| axis.settling.to_string(), |axis| &mut axis.settling),
    row(0x0700_0A00, "FLOAT", "AutoZero Low Voltage", |_, axis| axis.range.0.to_string()),
    row(0x0700_0A01, "FLOAT", "AutoZero High Voltage", |_, axis| axis.range.1.to_string()),
    row(0x0200_0200, "FLOAT", "Sensor Offset", |_, _| "0".into()),
    row(0x0200_0300, "FLOAT", "Sensor Gain", |_, _| "1".into()),
    row(0x0C00_0000, "FLOAT", "Lower Voltage Limit", |_, axis| axis.range.0.to_string()),
    row(0x0C00_0001, "FLOAT", "Upper Voltage Limit", |_, axis| axis.range.1.to_string()),
    row(0x0E00_0200, "FLOAT", "Servo Update Time", |_, _| CYCLE.to_string()),
    row(0x0E00_0B02, "INT", "Number Of Output Channels", |device, _| device.axes.len().to_string()),
    row(0x1300_0004, "INT", "Max Wave Points", |_, _| POINTS.to_string()),
    row(0x1300_010A, "INT", "Number Of Waves", |_, _| WAVES.to_string()),
    row(0x1600_0200, "INT", "Data Recorder Max Points", |device, _| (RECORDED * device.recorder_tables()).to_string()),
    Row { set: Set::Tables, ..row(RECORDER_TABLES, "INT", "Data Recorder Channel Number", |_, _| TABLES.to_string()) },
];

impl Device {
    /// The parameters of this model.
    fn rows(&self) -> impl Iterator<Item = &'static Row> {
        let has_servo = self.model != Model::OpenLoop;
        ROWS.iter().filter(move |row| has_servo || !(SERVO_FIRST..SERVO_END).contains(&row.number))
    }

    fn row(&self, number: &str) -> Result<&'static Row, i32> {
        let number = code(number)?;
        self.rows().find(|row| row.number == number).ok_or(PARAMETER)
    }

    /// What `HPA?` lists.
    pub(super) fn parameter_list(&self) -> Vec<String> {
        let line = |row: &Row| {
            let (number, kind, what) = (row.number, row.kind, row.what);
            format!(
                "0x{number:X}=\t{}\t1\t{kind}\tsystem\t{what}",
                u8::from(!matches!(row.set, Set::Never | Set::Tables))
            )
        };
        self.rows().map(line).collect()
    }

    /// Parameters, each of an axis; all without arguments. `is_saved` asks for those that `SEP` keeps.
    pub(super) fn parameters(&self, arguments: &[&str], is_saved: bool) -> Result<Vec<String>, i32> {
        let line = |k: usize, row: &Row, number: String| {
            let (name, place) = (&self.axes[k].name, row.place(k));
            let saved = if is_saved { self.saved.get(&place) } else { self.kept.get(&place) }.map(f64::to_string);
            format!("{name} 0x{number}={}", saved.unwrap_or_else(|| (row.get)(self, &self.axes[k])))
        };
        let short = |row: &Row| format!("{:X}", row.number);
        if arguments.is_empty() {
            return Ok((0..self.axes.len())
                .flat_map(|k| self.rows().map(move |row| line(k, row, short(row))))
                .collect());
        }
        refused(&[(arguments.len() % 2 == 1, COUNT)])?;
        let of_pair = |pair: &[&str]| {
            let (k, row) = (self.axis(pair[0])?, self.row(pair[1])?);
            // An E-754 repeats the digits that it was given.
            let digits = pair[1].strip_prefix("0x").or(pair[1].strip_prefix("0X"));
            let digits = digits.filter(|_| self.model == Model::E754).map(String::from);
            Ok(line(k, row, digits.unwrap_or_else(|| short(row))))
        };
        arguments.chunks(2).map(of_pair).collect()
    }

    fn recorder_tables(&self) -> usize {
        self.kept.get(&(0, RECORDER_TABLES)).map_or(TABLES, |tables| *tables as usize)
    }

    /// Sets parameters: axis, number, value, and so on. `is_saved` keeps them for `SEP?` only.
    pub(super) fn set_parameters(&mut self, arguments: &[&str], is_saved: bool) -> Result<(), i32> {
        let mut changes = Vec::new();
        for triple in triples(arguments)? {
            let (k, row) = (self.axis(triple[0])?, self.row(triple[1])?);
            refused(&[(self.level == 0 && !matches!(row.set, Set::Tables), PROTECTED)])?;
            let value = real(triple[2])?;
            let is_possible = match row.set {
                Set::Never => return Err(READ_ONLY),
                // From a standstill to a full move in one servo cycle.
                Set::Axis(_) => (1e-9..=1e9).contains(&value),
                Set::Tables => (1..=TABLES).any(|tables| tables as f64 == value),
                Set::Kept => value.abs() <= 1e9 && (row.kind != "INT" || value.fract() == 0.0),
            };
            refused(&[(!is_possible, RANGE)])?;
            changes.push((k, row, value));
        }
        for (k, row, value) in changes {
            match row.set {
                Set::Axis(set) if !is_saved => *set(&mut self.axes[k]) = value,
                _ => drop(if is_saved { &mut self.saved } else { &mut self.kept }.insert(row.place(k), value)),
            }
        }
        Ok(())
    }

    /// The same with the password of `SEP`.
    pub(super) fn save_parameters(&mut self, arguments: &[&str]) -> Result<(), i32> {
        let (password, rest) = arguments.split_first().ok_or(COUNT)?;
        refused(&[(*password != SEP_PASSWORD, PASSWORD)])?;
        self.set_parameters(rest, true)
    }

    /// Changes the command level.
    pub(super) fn set_level(&mut self, arguments: &[&str]) -> Result<(), i32> {
        self.level = match arguments {
            ["0"] => 0,
            ["1", password] if *password == ADVANCED => 1,
            ["1" | "2" | "3", ..] => return Err(PASSWORD),
            [] => return Err(COUNT),
            _ => return Err(RANGE),
        };
        Ok(())
    }
}
