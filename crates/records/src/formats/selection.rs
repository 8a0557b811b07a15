//! What the user says about the columns of a data file: which is which, in which units, at which rate.

use super::roles::Role;
use super::units;
use crate::record::{Record, Units};
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::options::{OptionKind, OptionRow, Options, options};
use std::ops::Range;

options! {
    /// How to read the columns of a data file. Without an option, names and units decide.
    ///
    /// Time is `t_s`, the input is `u_V` or the only `u_*`, and the output is the only `y_*`; the rest of the name is
    /// the unit. Other names are understood too: `Zeit [s]`, `Drive voltage (V)`, `Displacement/µm`. A column that
    /// could be the input as well as another one is never chosen: an error names the options that choose it.
    pub struct ColumnSelection {
        /// Sampling period, for files without a time column.
        ts: Option<f64> = None, OptionRow::positive("s").group(GROUP);
        /// Sampling rate, in place of the sampling period.
        fs: Option<f64> = None, OptionRow::positive("Hz").group(GROUP);
        /// Unit of the time column: s, ms, us, ns, min or h.
        time_unit: Option<String> = None, OptionRow::new(UNIT).absent("the one in its name").group(GROUP);
        /// Name or number of the time column.
        time_col: Option<String> = None, OptionRow::new(NAME).absent("t_s, or the one named like a time").group(GROUP);
        /// Name or number of the input column.
        input_col: Option<String> = None, OptionRow::new(NAME).absent("u_V, or the one named like a voltage").group(GROUP);
        /// Name or number of the output column.
        output_col: Option<String> = None, OptionRow::new(NAME).absent("y_*, or the one named like a displacement").group(GROUP);
        /// Unit of the input.
        input_unit: Option<String> = None, OptionRow::new(UNIT).absent("the one in its name").group(GROUP);
        /// Unit of the output.
        output_unit: Option<String> = None, OptionRow::new(UNIT).absent("the one in its name").group(GROUP);
        /// Factor of the input, such as 20 for an amplifier of gain 20 whose input was recorded.
        input_scale: Option<String> = None, OptionRow::new(SCALE).absent("1").group(GROUP);
        /// Factor of the output, such as 5um/V for a sensor.
        output_scale: Option<String> = None, OptionRow::new(SCALE).absent("1").group(GROUP);
        /// Use the data from this time on, counted from the first row.
        from: Option<f64> = None, OptionRow::not_negative("s").group(GROUP);
        /// Use the data up to this time, counted from the first row.
        to: Option<f64> = None, OptionRow::not_negative("s").group(GROUP);
    }
}

const NAME: OptionKind = OptionKind::Text("NAME");
const UNIT: OptionKind = OptionKind::Text("UNIT");
const SCALE: OptionKind = OptionKind::Text("FACTOR");
const GROUP: &str = "Data files";

impl ColumnSelection {
    /// The selection in a profile of a rig, as [`to_toml`](ColumnSelection::to_toml) writes it.
    ///
    /// # Errors
    /// Returns an error if the text is not TOML, or has unknown names or invalid values.
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        let refused = |error: toml::de::Error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            let problem = format!("not TOML: {}; write one `name = value` a line", error.message());
            Error::line(1 + before.matches('\n').count() as u64, problem)
        };
        Self::from_json(toml::from_str(text).map_err(refused)?)
    }

    /// The selection as a profile of a rig: one `name = value` a line.
    ///
    /// ```
    /// use piezoid::formats::ColumnSelection;
    /// let rig = ColumnSelection { input_scale: Some("20".into()), fs: Some(2000.0), ..ColumnSelection::default() };
    /// assert_eq!(rig.to_toml(), "fs = 2000.0\ninput_scale = \"20\"\n");
    /// assert_eq!(ColumnSelection::from_toml(&rig.to_toml())?, rig);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub fn to_toml(&self) -> String {
        // Names and values of a flat table can always be written.
        toml::to_string(self).unwrap_or_default()
    }

    /// This selection; options that are missing here are those of `other`.
    pub fn or(self, other: ColumnSelection) -> Self {
        ColumnSelection {
            // A period and a rate say the same.
            ts: self.ts.or(other.ts.filter(|_| self.fs.is_none())),
            fs: self.fs.or(other.fs.filter(|_| self.ts.is_none())),
            time_unit: self.time_unit.or(other.time_unit),
            time_col: self.time_col.or(other.time_col),
            input_col: self.input_col.or(other.input_col),
            output_col: self.output_col.or(other.output_col),
            input_unit: self.input_unit.or(other.input_unit),
            output_unit: self.output_unit.or(other.output_unit),
            input_scale: self.input_scale.or(other.input_scale),
            output_scale: self.output_scale.or(other.output_scale),
            from: self.from.or(other.from),
            to: self.to.or(other.to),
        }
    }

    /// The unit that the user states for the numbers of the file in this role; a scale states that of its result.
    pub(super) fn stated_unit(&self, role: Role) -> Option<String> {
        let unit = match role {
            Role::Time => self.time_unit.as_ref(),
            Role::Input => self.input_unit.as_ref().filter(|_| self.input_scale.is_none()),
            Role::Output | Role::Reference => self.output_unit.as_ref().filter(|_| self.output_scale.is_none()),
        };
        unit.map(|unit| units::written(unit))
    }

    /// The selected range of `n` samples.
    pub fn part(&self, ts: f64, n: usize) -> Result<Range<usize>, Error> {
        match (self.from, self.to) {
            (None, None) => Ok(0..n),
            (from, to) => Record::span(from.unwrap_or(0.0), to.unwrap_or(f64::INFINITY), ts, n),
        }
    }

    /// The sampling period that the user states.
    pub fn period(&self) -> Result<Option<f64>, Error> {
        match (self.ts, self.fs) {
            (Some(_), Some(fs)) => Err(Error::parameter("fs", fs, "give either ts or fs")),
            (Some(ts), None) => positive("ts", ts, "seconds").map(Some),
            (None, Some(fs)) => positive("fs", fs, "Hz").map(|fs| Some(1.0 / fs)),
            (None, None) => Ok(None),
        }
    }

    /// The number of seconds of the time unit that the user states, with its power of ten if it is one.
    pub fn seconds(&self) -> Result<Option<f64>, Error> {
        let Some(unit) = &self.time_unit else { return Ok(None) };
        let unknown = || Error::parameter("time_unit", unit, "must be s, ms, us, ns, min or h");
        units::seconds(unit).ok_or_else(unknown).map(Some)
    }
}

impl Record {
    /// The record with its input and output multiplied by factors, such as `20`, or `5um/V` with the new unit; an empty
    /// text changes nothing. The options `input_scale` and `output_scale` do the same while a file is read.
    ///
    /// ```
    /// use piezoid::{Record, Units};
    /// let volts = Record::new(1.0, vec![1.0], vec![0.2])?.with_units(Units { u: "V".into(), y: "V".into() });
    /// let record = volts.scaled("", "5um/V")?;
    /// assert_eq!((record.y(), record.units().y.as_str()), (&[1.0][..], "um"));
    /// assert_eq!(record.history(), ["output scaled by 5um/V"]);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error for a text that is not a factor or is 0, and for samples that would not be finite.
    pub fn scaled(&self, input: &str, output: &str) -> Result<Self, Error> {
        let scale = |option, text: &str| Scale::read(option, if text.trim().is_empty() { "1" } else { text.trim() });
        let (u, y) = (scale("input_scale", input)?, scale("output_scale", output)?);
        let units = self.units().clone();
        let of_u = u.of("input_scale", Some(&units.u))?;
        let of_y = y.of("output_scale", Some(&units.y))?;
        let by = |x: &[f64], factor: f64| x.iter().map(|x| x * factor).collect();
        let record = self.with_samples(self.ts(), by(self.u(), of_u), by(self.y(), of_y))?;
        let record = record.with_units(Units { u: u.unit.unwrap_or(units.u), y: y.unit.unwrap_or(units.y) });
        let steps = [("input", input), ("output", output)].into_iter().filter(|(_, text)| !text.trim().is_empty());
        Ok(steps.fold(record, |record, (what, text)| record.with_step(format!("{what} scaled by {}", text.trim()))))
    }
}

/// A factor, with the unit after it: `5um/V` makes micrometres of volts.
#[derive(Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) factor: f64,
    pub(super) unit: Option<String>,
    /// The unit that it applies to: V of `5um/V`.
    pub(super) per: Option<String>,
}

impl Scale {
    /// The factor in a text such as `20`, `20V/V` or `5um/V`.
    pub(super) fn read(option: &str, text: &str) -> Result<Scale, Error> {
        let rule = "must be a factor other than 0, such as 20 or 5um/V";
        let refused = || Error::parameter(option, text, rule);
        let text = text.trim();
        // The longest number: the `e` of `5e3um` belongs to it, that of `5eV` does not.
        let ends = text.char_indices().map(|(at, c)| at + c.len_utf8());
        let end = ends.rev().find(|end| text[..*end].parse::<f64>().is_ok()).ok_or_else(refused)?;
        let factor = text[..end].parse::<f64>().ok().filter(|factor| factor.is_finite() && *factor != 0.0);
        let unit = text[end..].trim().trim_start_matches('*').trim();
        let (unit, per) = unit.split_once('/').unwrap_or((unit, ""));
        let written = |unit: &str| Some(units::written(unit)).filter(|unit| !unit.is_empty());
        Ok(Scale { factor: factor.ok_or_else(refused)?, unit: written(unit), per: written(per) })
    }

    /// The factor for a column in a unit.
    pub(super) fn of(&self, option: &str, unit: Option<&str>) -> Result<f64, Error> {
        let (Some(per), Some(unit)) = (&self.per, unit.map(units::written)) else { return Ok(self.factor) };
        let known = units::known(per).is_some() && units::known(&unit).is_some();
        match Units::factor(&unit, per) {
            Some(factor) => Ok(self.factor * factor),
            None if !known => Ok(self.factor),
            None => {
                let rule = format!("is a factor for {per}, but the column is in {unit}: correct one of them");
                let scale = format!("{}{}/{per}", self.factor, self.unit.as_deref().unwrap_or_default());
                Err(Error::parameter(option, scale, rule))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_is_a_factor_with_or_without_a_unit() {
        let read = |text| Scale::read("output_scale", text);
        let scale = |factor, unit: Option<&str>, per: Option<&str>| {
            let [unit, per] = [unit, per].map(|unit| unit.map(String::from));
            Scale { factor, unit, per }
        };
        for (text, expected) in [
            ("20", scale(20.0, None, None)),
            ("-5um/V", scale(-5.0, Some("um"), Some("V"))),
            ("5e-3 \u{b5}m/V", scale(5e-3, Some("um"), Some("V"))),
            ("0.1 mm/V", scale(0.1, Some("mm"), Some("V"))),
            ("2 nm", scale(2.0, Some("nm"), None)),
        ] {
            assert_eq!(read(text).unwrap(), expected, "{text}");
        }
        for text in ["", "um/V", "0", "inf", "nan", "0um/V"] {
            assert!(read(text).unwrap_err().to_string().contains("must be a factor"), "{text}");
        }
        let of = |text, unit| read(text).unwrap().of("output_scale", unit);
        assert_eq!((of("5um/V", Some("V")), of("5um/mV", Some("V"))), (Ok(5.0), Ok(5000.0)));
        assert_eq!((of("5um/V", Some("mV")), of("5um/V", None), of("2", Some("mV"))), (Ok(0.005), Ok(5.0), Ok(2.0)));
        let refused = of("5V/um", Some("V")).unwrap_err().to_string();
        assert!(refused.contains("is a factor for um, but the column is in V"), "{refused}");
    }
}
