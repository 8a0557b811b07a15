//! The parameters of the controller, by the numbers of PI's manuals.
//!
//! `SPA` changes some of them at command level 1 (`CCL 1 advanced`) until the controller ends; `SEP` keeps a value that
//! `SEP?` answers, and that nothing uses.

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
    set: Option<fn(&mut Axis) -> &mut f64>,
}

const fn row(number: u32, kind: &'static str, what: &'static str, get: fn(&Device, &Axis) -> String) -> Row {
    Row { number, kind, what, get, set: None }
}

/// A number that `SPA` changes.
const fn float(
    number: u32,
    what: &'static str,
    get: fn(&Device, &Axis) -> String,
    set: fn(&mut Axis) -> &mut f64,
) -> Row {
    Row { number, kind: "FLOAT", what, get, set: Some(set) }
}

/// Those of a servo have numbers in this range.
const SERVO_FIRST: u32 = 0x0600_0000;
const SERVO_END: u32 = 0x0900_0000;

#[rustfmt::skip]
const ROWS: [Row; 31] = [
    row(0x0700_0000, "FLOAT", "Range Limit min", |_, axis| axis.travel.0.to_string()),
    row(0x0700_0001, "FLOAT", "Range Limit max", |_, axis| axis.travel.1.to_string()),
    float(0x0700_0200, "Servo Loop Slew-Rate", |_, axis| axis.velocity.to_string(), |axis| &mut axis.velocity),
    float(0x0700_0201, "Open Loop Slew-Rate", |_, axis| axis.slew.to_string(), |axis| &mut axis.slew),
    row(0x0700_0300, "FLOAT", "Servo Loop P-Term", |_, _| "0".into()),
    float(0x0700_0301, "Servo Loop I-Term", |_, axis| axis.bandwidth.to_string(), |axis| &mut axis.bandwidth),
    row(0x0700_0302, "FLOAT", "Servo Loop D-Term", |_, _| "0".into()),
    row(0x0703_0600, "FLOAT", "Servo Loop Feed-Forward", |_, _| "1".into()),
    row(0x0600_0500, "INT", "ADC Channel for Target", |_, _| "0".into()),
    row(0x0800_0100, "FLOAT", "Notch Frequency 1", |_, _| "0".into()),
    row(0x0800_0101, "FLOAT", "Notch Frequency 2", |_, _| "0".into()),
    row(0x0800_0200, "FLOAT", "Notch Rejection 1", |_, _| "1".into()),
    row(0x0800_0201, "FLOAT", "Notch Rejection 2", |_, _| "1".into()),
    row(0x0800_0300, "FLOAT", "Notch Bandwidth 1", |_, _| "0".into()),
    row(0x0800_0301, "FLOAT", "Notch Bandwidth 2", |_, _| "0".into()),
    row(0x0700_0600, "CHAR", "Axis Name", |_, axis| axis.name.clone()),
    row(0x0700_0601, "CHAR", "Axis Unit", |_, _| "um".into()),
    float(0x0700_0900, "ON Target Tolerance", |_, axis| axis.tolerance.to_string(), |axis| &mut axis.tolerance),
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
    row(0x1600_0200, "INT", "Data Recorder Max Points", |_, _| (RECORDED * TABLES).to_string()),
    row(0x1600_0300, "INT", "Data Recorder Channel Number", |_, _| TABLES.to_string()),
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
            format!("0x{number:X}=\t{}\t1\t{kind}\tsystem\t{what}", u8::from(row.set.is_some()))
        };
        self.rows().map(line).collect()
    }

    /// Parameters, each of an axis; all without arguments. `is_saved` asks for those that `SEP` keeps.
    pub(super) fn parameters(&self, arguments: &[&str], is_saved: bool) -> Result<Vec<String>, i32> {
        let line = |k: usize, row: &Row| {
            let (name, number) = (&self.axes[k].name, row.number);
            let saved = self.saved.get(&(k, number)).filter(|_| is_saved).map(f64::to_string);
            format!("{name} 0x{number:X}={}", saved.unwrap_or_else(|| (row.get)(self, &self.axes[k])))
        };
        if arguments.is_empty() {
            return Ok((0..self.axes.len()).flat_map(|k| self.rows().map(move |row| line(k, row))).collect());
        }
        refused(&[(arguments.len() % 2 == 1, COUNT)])?;
        arguments.chunks(2).map(|pair| Ok(line(self.axis(pair[0])?, self.row(pair[1])?))).collect()
    }

    /// Sets parameters: axis, number, value, and so on. `is_saved` keeps them for `SEP?` only.
    pub(super) fn set_parameters(&mut self, arguments: &[&str], is_saved: bool) -> Result<(), i32> {
        let mut changes = Vec::new();
        for triple in triples(arguments)? {
            let (k, row) = (self.axis(triple[0])?, self.row(triple[1])?);
            refused(&[(self.level == 0, PROTECTED)])?;
            let (set, value) = (row.set.ok_or(READ_ONLY)?, real(triple[2])?);
            // From a standstill to a full move in one servo cycle.
            refused(&[(!(1e-9..=1e9).contains(&value), RANGE)])?;
            changes.push((k, row.number, set, value));
        }
        for (k, number, set, value) in changes {
            if is_saved {
                self.saved.insert((k, number), value);
            } else {
                *set(&mut self.axes[k]) = value;
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
