//! The options of a verb: each is defined once, as a field of a struct, with its range, unit, default and help.
//!
//! The command line makes a flag of every row, Python a keyword, the page a field. Values are checked here, so all
//! front ends reject the same values with the same message. Errors and helps name an option by its field; each front
//! end writes it in its own [`Words`].

use crate::error::Error;
use crate::words::{Words, parts};
use serde::de::DeserializeOwned;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

/// Kind of value of an option.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OptionKind {
    /// Yes or no.
    Switch,
    /// Yes or no, written 1 or 0.
    Bit,
    /// An integer, from the first to the second.
    Integer(u64, u64),
    /// A number of at least `least`, or above `least` if `open`, and below `below`.
    Number {
        /// The minimum.
        least: f64,
        /// True if the minimum itself is not allowed.
        open: bool,
        /// The upper bound, which itself is not allowed.
        below: f64,
    },
    /// Two numbers.
    Pair,
    /// One or several numbers.
    Numbers,
    /// One of these names, each with its meaning.
    Choice(&'static [(&'static str, &'static str)]),
    /// A name or text, with its placeholder in the help.
    Text(&'static str),
    /// One or several texts, with the placeholder in the help.
    Texts(&'static str),
}

/// Prefixes of units, with their powers of ten.
const PREFIXES: [(&str, i32); 8] = [("", 0), ("k", 3), ("M", 6), ("G", 9), ("m", -3), ("u", -6), ("n", -9), ("p", -12)];

/// One option of a verb: a row of its table.
#[derive(Debug, Clone, Copy)]
pub struct OptionRow {
    /// Name of the field, in lower case with underscores.
    pub name: &'static str,
    /// Kind of its value.
    pub values: OptionKind,
    /// Unit of a number; empty without one.
    pub unit: &'static str,
    /// Its description in the help: `{name}` is another option, `{list}` its list.
    pub help: &'static str,
    /// Its default; null if it has no value by default.
    pub default: fn() -> Value,
    /// Description of the default if that has no value; may be empty.
    pub absent: &'static str,
    /// True if it must be given.
    pub required: bool,
    /// Its heading in the help; empty for the verb's own options.
    pub group: &'static str,
    /// The option that it requires; empty if there is none.
    pub requires: &'static str,
    /// The list that its names are from, such as `drivers`; empty if there is none.
    pub list: &'static str,
}

impl OptionRow {
    /// An option with this kind of value; a table adds its name and its help.
    pub const fn new(values: OptionKind) -> Self {
        let default = || Value::Null;
        OptionRow {
            name: "",
            values,
            unit: "",
            help: "",
            default,
            absent: "",
            required: false,
            group: "",
            requires: "",
            list: "",
        }
    }

    /// Any number in `unit`.
    pub const fn number(unit: &'static str) -> Self {
        let any = OptionKind::Number { least: f64::NEG_INFINITY, open: true, below: f64::INFINITY };
        OptionRow { unit, ..OptionRow::new(any) }
    }

    /// A positive number in `unit`.
    pub const fn positive(unit: &'static str) -> Self {
        OptionRow { unit, ..OptionRow::new(OptionKind::Number { least: 0.0, open: true, below: f64::INFINITY }) }
    }

    /// A number in `unit` that is 0 or more.
    pub const fn not_negative(unit: &'static str) -> Self {
        OptionRow { unit, ..OptionRow::new(OptionKind::Number { least: 0.0, open: false, below: f64::INFINITY }) }
    }

    /// Sets the description of a default without a value.
    pub const fn absent(self, absent: &'static str) -> Self {
        OptionRow { absent, ..self }
    }

    /// Sets its heading.
    pub const fn group(self, group: &'static str) -> Self {
        OptionRow { group, ..self }
    }

    /// Sets the option that it requires.
    pub const fn requires(self, requires: &'static str) -> Self {
        OptionRow { requires, ..self }
    }

    /// Sets the list that its names are from.
    pub const fn list(self, list: &'static str) -> Self {
        OptionRow { list, ..self }
    }

    /// Makes it an option that must be given.
    pub const fn required(self) -> Self {
        OptionRow { required: true, ..self }
    }

    /// Its help in the words of a front end.
    pub fn help_in(&self, words: &dyn Words) -> String {
        let written = |(marked, part): (bool, &str)| match part {
            "list" if marked => words.list(self.list),
            option if marked => words.option(option),
            text => text.into(),
        };
        parts(self.help).map(written).collect()
    }

    /// The default as text: its value, or the description if it has none. May be empty.
    pub fn usual(&self) -> String {
        match (self.default)() {
            _ if self.required => String::new(),
            Value::Null => self.absent.into(),
            Value::Bool(on) if self.values == OptionKind::Bit => u8::from(on).to_string(),
            Value::Array(several) if several.is_empty() => self.absent.into(),
            Value::Array(several) => several.iter().map(shown).collect::<Vec<_>>().join(" "),
            Value::String(text) => text,
            value => shown(&value),
        }
    }

    /// The rule for its values, as text.
    pub fn rule(&self) -> String {
        match self.values {
            OptionKind::Switch => "must be true or false".into(),
            OptionKind::Bit => "must be 0 (no) or 1 (yes)".into(),
            OptionKind::Pair => "must be two numbers".into(),
            OptionKind::Numbers => "must be a list of numbers".into(),
            OptionKind::Integer(least, u64::MAX) => format!("must be a whole number, {least} or more"),
            OptionKind::Integer(least, most) => format!("must be a whole number from {least} to {most}"),
            OptionKind::Number { least, open, below } => {
                let number = match (least, open) {
                    (_, true) if below.is_finite() => format!("a number above {least} and below {below}"),
                    _ if below.is_finite() => format!("a number from {least} to below {below}"),
                    (f64::NEG_INFINITY, _) => "a number".into(),
                    (0.0, true) => "a positive number".into(),
                    (least, true) => format!("a number above {least}"),
                    (least, false) => format!("a number, {least} or more"),
                };
                let unit = if self.unit.is_empty() { String::new() } else { format!(" [{}]", self.unit) };
                format!("must be {number}{unit}")
            }
            OptionKind::Choice(known) => {
                let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
                format!("must be {}", names.join(" or "))
            }
            OptionKind::Text(_) => "must be a string".into(),
            OptionKind::Texts(_) => "must be a string or a list of strings".into(),
        }
    }

    /// The value in `text`; for an option with several values, one of them. A number may carry its unit: `30V`,
    /// `0.5ms`.
    ///
    /// # Errors
    /// [`Error::Parameter`] if the text is not a valid value.
    pub fn parse(&self, text: &str) -> Result<Value, Error> {
        let read = match self.values {
            OptionKind::Choice(_) | OptionKind::Text(_) | OptionKind::Texts(_) => Some(Value::from(text)),
            OptionKind::Switch => text.parse::<bool>().map(Value::from).ok(),
            OptionKind::Bit | OptionKind::Integer(..) => {
                text.parse::<u64>().map(Value::from).ok().or_else(|| number(text, ""))
            }
            OptionKind::Number { .. } | OptionKind::Pair | OptionKind::Numbers => number(text, self.unit),
        };
        let value = read.ok_or_else(|| Error::parameter(self.name, text, self.rule()))?;
        match self.values {
            OptionKind::Pair | OptionKind::Numbers | OptionKind::Texts(_) => Ok(value),
            _ => self.fit(value),
        }
    }

    /// The value in the type of the field.
    ///
    /// # Errors
    /// [`Error::Parameter`] if the option cannot have this value: its name, the value and the rule.
    pub fn fit(&self, value: Value) -> Result<Value, Error> {
        let whole = |value: &Value| value.as_u64().or_else(|| value.as_f64().and_then(exactly));
        let is_number = |value: &Value| value.as_f64().is_some_and(f64::is_finite);
        let if_it_fits = |fits: bool| fits.then(|| value.clone());
        let fitted = match (self.values, &value) {
            (OptionKind::Switch | OptionKind::Bit, Value::Bool(_)) => Some(value.clone()),
            (OptionKind::Bit, _) => whole(&value).filter(|n| *n < 2).map(|n| Value::Bool(n == 1)),
            (OptionKind::Integer(least, most), _) => {
                whole(&value).filter(|n| (least..=most).contains(n)).map(Value::from)
            }
            (OptionKind::Number { .. }, Value::String(text)) => return self.parse(text),
            (OptionKind::Number { least, open, below }, _) => {
                let fits = |x: f64| x.is_finite() && x < below && (x > least || x == least && !open);
                if_it_fits(value.as_f64().is_some_and(fits))
            }
            (OptionKind::Pair, Value::Array(two)) => if_it_fits(two.len() == 2 && two.iter().all(is_number)),
            (OptionKind::Numbers, Value::Array(several)) => if_it_fits(several.iter().all(is_number)),
            (OptionKind::Choice(known), Value::String(text)) => if_it_fits(known.iter().any(|(name, _)| name == text)),
            (OptionKind::Text(_), Value::String(_)) => Some(value.clone()),
            (OptionKind::Text(_), Value::Number(number)) => Some(number.to_string().into()),
            (OptionKind::Texts(_), Value::String(_)) => Some(Value::Array(vec![value.clone()])),
            (OptionKind::Texts(_), Value::Array(several)) => if_it_fits(several.iter().all(Value::is_string)),
            _ => None,
        };
        let shown = || value.as_str().map_or_else(|| value.to_string(), str::to_string);
        fitted.ok_or_else(|| Error::parameter(self.name, shown(), self.rule()))
    }
}

/// All that a form, a flag or a keyword needs to know. `usual` is the default as text, `rule` the one for its values.
impl Serialize for OptionRow {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let (kind, choices) = match self.values {
            OptionKind::Switch | OptionKind::Bit => ("switch", Value::Null),
            OptionKind::Integer(..) => ("integer", Value::Null),
            OptionKind::Number { .. } => ("number", Value::Null),
            OptionKind::Pair => ("pair", Value::Null),
            OptionKind::Numbers => ("numbers", Value::Null),
            OptionKind::Choice(known) => ("choice", json!(known)),
            OptionKind::Text(_) => ("text", Value::Null),
            OptionKind::Texts(_) => ("texts", Value::Null),
        };
        let default = match (self.default)() {
            Value::Bool(on) if self.values == OptionKind::Bit => u8::from(on).into(),
            default => default,
        };
        let row = json!({
            "name": self.name, "kind": kind, "choices": choices, "unit": self.unit, "help": self.help,
            "group": self.group, "list": self.list, "requires": self.requires, "default": default,
            "usual": self.usual(), "rule": self.rule(), "required": self.required,
        });
        row.serialize(to)
    }
}

/// The rows of a table, as members of documents.
#[doc(hidden)]
pub fn rows_of<S: Serializer>(rows: &fn() -> Vec<OptionRow>, to: S) -> Result<S::Ok, S::Error> {
    rows().serialize(to)
}

/// A number as it is written in help.
fn shown(value: &Value) -> String {
    match value.as_f64() {
        Some(small) if small != 0.0 && small.abs() < 1e-3 => format!("{small:e}"),
        _ => value.to_string().trim_end_matches(".0").into(),
    }
}

/// The finite number in `text`, converted to `unit` if it has this unit with a prefix: `30V`, `0.5 ms`, `2min`.
fn number(text: &str, unit: &str) -> Option<Value> {
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit() && c != '.');
    let written = crate::number::ascii_unit(text[digits.len()..].trim());
    let number = match (&*written, unit) {
        ("", _) => digits.parse::<f64>().ok()?,
        ("min", "s") => 60.0 * digits.parse::<f64>().ok()?,
        ("h", "s") => 3600.0 * digits.parse::<f64>().ok()?,
        ("deg", "degrees") => digits.parse::<f64>().ok()?,
        (_, "") => return None,
        _ => {
            let (_, power) = PREFIXES.iter().find(|(prefix, _)| written.strip_prefix(prefix) == Some(unit))?;
            let (mantissa, exponent) = digits.split_once(['e', 'E']).unwrap_or((digits, "0"));
            // As a decimal, because 0.3 * 1e-3 is not 3e-4.
            format!("{mantissa}e{}", exponent.parse::<i32>().ok()?.checked_add(*power)?).parse::<f64>().ok()?
        }
    };
    number.is_finite().then(|| Value::from(number))
}

/// The integer, if the number is an integer and not negative.
fn exactly(x: f64) -> Option<u64> {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    (x.fract() == 0.0 && (0.0..=EXACT).contains(&x)).then_some(x as u64)
}

/// The options of a verb.
pub trait Options: Default + Serialize + DeserializeOwned {
    /// The rows of its table.
    fn rows() -> Vec<OptionRow>;

    /// The options from a JSON object by name. Those that are missing or null have their defaults.
    ///
    /// ```
    /// use piezoid::IdentifyOptions;
    /// use piezoid_numerics::options::Options;
    /// let options = IdentifyOptions::from_json(serde_json::json!({"order": 3, "operator": "preisach"}))?;
    /// assert_eq!((options.order, options.seed), (Some(3), 1));
    /// let error = IdentifyOptions::from_json(serde_json::json!({"order": 13})).unwrap_err();
    /// assert_eq!(error.to_string(), "order = 13: must be a whole number from 0 to 12");
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unknown`] for an unknown option, [`Error::Parameter`] for an invalid value.
    fn from_json(values: Value) -> Result<Self, Error> {
        let Value::Object(values) = values else {
            return Err(Error::Content(format!("options must be an object of names and values, not {values}")));
        };
        let (rows, mut fitted) = (Self::rows(), serde_json::Map::new());
        for (name, value) in values.into_iter().filter(|(_, value)| !value.is_null()) {
            let row = rows.iter().find(|row| row.name == name);
            let row = row.ok_or_else(|| Error::unknown("option", &name, rows.iter().map(|row| row.name)))?;
            fitted.insert(name, row.fit(value)?);
        }
        if let Some(row) = rows.iter().find(|row| row.required && !fitted.contains_key(row.name)) {
            return Err(Error::parameter(row.name, "(not given)", row.rule()));
        }
        serde_json::from_value(Value::Object(fitted)).map_err(|e| Error::Content(format!("options: {e}")))
    }

    /// The options that differ from their defaults, by name: what [`Options::from_json`] needs to repeat them.
    fn to_json(&self) -> Value {
        let mut values = serde_json::to_value(self).unwrap_or_default();
        let value = |row: OptionRow| (row.name.to_string(), values[row.name].take(), (row.default)());
        let changed = Self::rows().into_iter().map(value).filter(|(_, value, default)| value != default);
        Value::Object(changed.map(|(name, value, _)| (name, value)).collect())
    }

    /// The options that differ from their defaults, with their values as text.
    fn changed(&self) -> Vec<(OptionRow, String)> {
        let values = self.to_json();
        let changed = Self::rows().into_iter().filter(|row| values.get(row.name).is_some());
        changed.map(|row| (row, values[row.name].to_string().trim_matches('"').to_string())).collect()
    }
}

/// Options as members of documents: those that differ from their defaults, checked when they are read.
pub mod by_name {
    use super::Options;
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
    use serde_json::Value;

    /// Writes what differs from the defaults.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<O: Options, S: Serializer>(options: &O, to: S) -> Result<S::Ok, S::Error> {
        options.to_json().serialize(to)
    }

    /// Reads and checks what [`serialize`] writes.
    ///
    /// # Errors
    /// Those of [`Options::from_json`] and of the deserializer.
    pub fn deserialize<'d, O: Options, D: Deserializer<'d>>(from: D) -> Result<O, D::Error> {
        O::from_json(Value::deserialize(from)?).map_err(D::Error::custom)
    }
}

/// Defines the options of a verb: the struct, its defaults and its table. The comment of a field is its help.
#[doc(hidden)]
#[macro_export]
macro_rules! options {
    (
        $(#[$about:meta])*
        $public:vis struct $name:ident {
            $($(#[doc = $help:literal])+ $field:ident: $type:ty = $default:expr, $row:expr;)*
        } $(with $part:ident: $group:ty)*
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default)]
        $public struct $name {
            $($(#[doc = $help])+ pub $field: $type,)*
            $(
                #[doc = concat!("See [`", stringify!($group), "`].")]
                #[serde(flatten)]
                pub $part: $group,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                $name { $($field: $default,)* $($part: <$group>::default(),)* }
            }
        }

        impl $crate::options::Options for $name {
            fn rows() -> Vec<$crate::options::OptionRow> {
                let own = [$($crate::options::OptionRow {
                    name: stringify!($field),
                    help: concat!($($help),+).trim_ascii().trim_end_matches('.'),
                    default: || serde_json::to_value::<$type>($default).unwrap_or_default(),
                    ..$row
                }),*];
                own.into_iter()$(.chain(<$group as $crate::options::Options>::rows()))*.collect()
            }
        }
    };
}

pub use crate::options;

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    options! {
        /// One of each kind.
        struct Each {
            /// A count.
            count: u32 = 3, OptionRow::new(OptionKind::Integer(1, 9));
            /// A bit.
            bit: bool = false, OptionRow::new(OptionKind::Bit);
            /// A small number.
            small: f64 = 5e-5, OptionRow::positive("s");
            /// Two numbers.
            pair: Option<(f64, f64)> = None, OptionRow::new(OptionKind::Pair);
            /// Names.
            names: Vec<String> = Vec::new(), OptionRow::new(OptionKind::Texts("NAME")).absent("all");
            /// Numbers.
            several: Vec<f64> = vec![1.0, 0.5], OptionRow::new(OptionKind::Numbers);
        }
    }

    #[test]
    fn values_become_what_their_fields_hold() {
        let values = json!({"count": 4.0, "bit": 1, "small": 2, "pair": [0, 1.5], "names": "a", "several": [1]});
        let each = Each::from_json(values).unwrap();
        assert_eq!((each.count, each.bit, each.small, each.pair), (4, true, 2.0, Some((0.0, 1.5))));
        assert_eq!(each.several, [1.0]);
        assert_eq!(
            (each.names, Each::from_json(json!({"pair": null})).unwrap()),
            (vec!["a".to_string()], Each::default())
        );
        assert!(Each::default().changed().is_empty());
        let changed = Each { bit: true, ..Each::default() }.changed();
        assert_eq!(changed.iter().map(|(row, value)| (row.name, &**value)).collect::<Vec<_>>(), [("bit", "true")]);
    }

    #[test]
    fn a_number_may_carry_its_unit() {
        let small = |text: &str| Each::rows()[2].parse(text).ok().and_then(|value| value.as_f64());
        let read =
            [("0.3ms", 3e-4), ("5e-1 ms", 5e-4), ("2s", 2.0), ("7 \u{b5}s", 7e-6), ("2min", 120.0), ("1.5h", 5400.0)];
        for (text, seconds) in read {
            assert_eq!(small(text), Some(seconds), "{text}");
        }
        for text in ["3V", "ms", "3 mss", "-1ms", "1e999ms", "1e99999999999s", "inf", "nan s", "0x1s", ""] {
            assert_eq!(small(text), None, "{text}");
        }
        assert_eq!(Each::from_json(json!({"small": "3 ms"})).unwrap().small, 3e-3);
    }

    #[test]
    fn values_that_an_option_cannot_have_are_refused_with_its_name() {
        for (name, value, rule) in [
            ("count", json!(10), "count = 10: must be a whole number from 1 to 9"),
            ("count", json!(2.5), "count = 2.5: must be a whole number from 1 to 9"),
            ("bit", json!(2), "bit = 2: must be 0 (no) or 1 (yes)"),
            ("small", json!(0), "small = 0: must be a positive number [s]"),
            ("pair", json!([1]), "pair = [1]: must be two numbers"),
            ("several", json!([1, "a"]), "several = [1,\"a\"]: must be a list of numbers"),
            ("names", json!([1]), "names = [1]: must be a string or a list of strings"),
        ] {
            assert_eq!(Each::from_json(json!({ name: value })).unwrap_err().to_string(), rule);
        }
    }

    #[test]
    fn defaults_are_told_as_they_are_written() {
        let message: Vec<String> = Each::rows().iter().map(OptionRow::usual).collect();
        assert_eq!(message, ["3", "0", "5e-5", "", "all", "1 0.5"]);
    }
}
