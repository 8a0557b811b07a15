//! One column of a table: its samples, their unit and what that measures.

use super::quote::shortened;
use super::roles::Role;
use super::selection::{ColumnSelection, Scale};
use super::units::{self, Quantity};
use super::words::{OUTPUT, TIME};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{self, ascii_unit};

/// The unit of an input whose unit is not stated.
const VOLT: &str = "V";
/// The unit of an output whose unit is not stated: arbitrary units.
const ARBITRARY: &str = "a.u.";

/// One column of a [`Table`].
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Column {
    pub(super) name: String,
    /// Its unit, if the format states it separately from the name.
    pub(super) unit: Option<String>,
    /// Its sampling period [s], if the format states it for this column.
    pub(super) ts: Option<f64>,
    /// One number a row, not finite where there is none; empty if there is no number at all.
    pub(super) samples: Vec<f64>,
    /// The first cell that is not a finite number, as the error if its row is used.
    pub(super) flaw: Option<Error>,
    /// Why no number of it can be trusted, as the error if the column is used.
    pub(super) doubt: Option<Error>,
    /// The decimal separator, point or comma, and the line of its first use.
    pub(super) decimal: Option<(char, u64)>,
    /// True if a comma in it can only be a decimal one, and if there are whole numbers without a comma.
    pub(super) proven: bool,
    pub(super) whole: bool,
    /// If it holds times of day, the seconds of the days that have passed.
    pub(super) clock: Option<f64>,
}

impl Column {
    /// A column without samples.
    pub(super) fn new(name: String) -> Self {
        Column { name, ..Column::default() }
    }

    /// An error about it on a line.
    pub(super) fn error(&self, line: u64, problem: impl Into<String>) -> Error {
        Error::Line { line, column: Some(shortened(&self.name)), problem: problem.into() }
    }

    /// The unit that stands in the file: beside the name, or in it.
    pub(super) fn stated(&self) -> Option<&str> {
        self.unit.as_deref().or_else(|| units::split(&self.name).1).filter(|unit| !["", "-"].contains(unit))
    }

    /// True if its unit stands beside its name, or in brackets.
    pub(super) fn has_unit_apart(&self) -> bool {
        self.unit.is_some() || self.name.ends_with([']', ')'])
    }

    /// What its unit measures; `None` if there is no unit, or one that is not known.
    pub(super) fn quantity(&self) -> Option<Quantity> {
        let stated = self.stated().and_then(units::known).map(|(_, quantity)| quantity);
        stated.or_else(|| self.clock.map(|_| Quantity::Time(1.0))).or_else(|| self.since_1970())
    }

    /// The unit of points in time that count from 1970, for those from 2000 to 2100: seconds to nanoseconds.
    fn since_1970(&self) -> Option<Quantity> {
        let first = *self.samples.first()?;
        let unit = |power: i32| (9.4e8..4.1e9).contains(&(first / number::power(10.0, power)));
        let power = [0, 3, 6, 9].into_iter().find(|power| unit(*power))?;
        // A row without a time does not go back.
        let rising = self.samples.len() > 1 && !self.samples.windows(2).any(|pair| pair[1] < pair[0]);
        // Whole numbers near 1e9 are perhaps those of a counter.
        let counts = power == 0 && !self.has_word(TIME) && self.samples.iter().all(|t| t.is_nan() || t.fract() == 0.0);
        (rising && !counts && !self.has_word(OUTPUT)).then(|| Quantity::Time(number::power(10.0, -power)))
    }

    /// True if it holds the numbers of a converter.
    pub(super) fn is_raw(&self) -> bool {
        self.stated().and_then(units::known).is_some_and(|(unit, _)| unit == "counts")
    }

    /// The unit that its file states for this role.
    pub(super) fn own_unit(&self, role: Role) -> Option<String> {
        let own = || {
            self.name.strip_prefix(role.prefix()).map(|rest| ascii_unit(rest.trim())).filter(|unit| !unit.is_empty())
        };
        match (self.has_unit_apart(), self.stated()) {
            (true, Some(unit)) => Some(units::written(unit)),
            (_, unit) => own().or(unit.map(units::written)),
        }
    }

    /// The unit that a column has in this role, in its file.
    pub(super) fn unit(&self, role: Role) -> String {
        self.own_unit(role).unwrap_or_else(|| match role {
            Role::Input => VOLT.into(),
            _ => ARBITRARY.into(),
        })
    }

    /// The unit that a column has in this role, and the factor that brings it there.
    pub(super) fn unit_and_factor(&self, role: Role, selection: &ColumnSelection) -> Result<(String, f64), Error> {
        let (unit, scale, [option, name]) = match role {
            Role::Input => (&selection.input_unit, &selection.input_scale, ["input_scale", "input_unit"]),
            _ => (&selection.output_unit, &selection.output_scale, ["output_scale", "output_unit"]),
        };
        let scale = scale.as_ref().map(|text| Scale::read(option, text)).transpose()?;
        let arguments = unit.as_ref().map(|unit| units::written(unit));
        // The file may call its unit as it likes.
        if let Some(unit) = arguments.as_ref().filter(|unit| !units::is_word(unit) && **unit != self.unit(role)) {
            return Err(Error::parameter(name, unit, "must be a word of letters such as um, or %, or counts"));
        }
        let factor = scale.as_ref().map_or(Ok(1.0), |scale| scale.of(option, self.stated()))?;
        let unit = arguments.or(scale.and_then(|scale| scale.unit)).unwrap_or_else(|| self.unit(role));
        Ok((unit, factor))
    }
}
