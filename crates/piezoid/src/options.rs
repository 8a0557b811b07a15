//! The options of a verb: each stands once, as a field of a struct, with its range, unit, default and help.
//!
//! The command line makes a flag of every row, Python a keyword, a page a field of a form. What a value may be is checked
//! here, so that all of them refuse the same values in the same words. An [`Error`] names the option by its field:
//! whoever shows it writes `--input-col` or `input_col=` as its users do.

use crate::error::Error;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// What an option can be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Values {
    /// Yes or no.
    Switch,
    /// A whole number, from the first to the second.
    Whole(u64, u64),
    /// A number from `least` on, itself left out where `open`, and below `below`.
    Number {
        /// The least.
        least: f64,
        /// Whether that itself is too little.
        open: bool,
        /// What it must be below.
        below: f64,
    },
    /// One of these names, each with its meaning.
    Choice(&'static [(&'static str, &'static str)]),
    /// A name or text, as the help describes it; what its placeholder is called.
    Text(&'static str),
}

/// One option of a verb: a row of its table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OptionRow {
    /// Name of the field, in lower case with underscores.
    pub name: &'static str,
    /// What it can be.
    pub values: Values,
    /// Unit of a number; empty without one.
    pub unit: &'static str,
    /// What it means.
    pub help: &'static str,
    /// What holds where it is not given, of an option that has no value then; empty where nothing is to be said.
    pub absent: &'static str,
    /// The heading under which it stands; empty for the verb's own.
    pub group: &'static str,
    /// The option without which it means nothing; empty where there is none.
    pub requires: &'static str,
}

impl OptionRow {
    /// An option that takes `values`; a table adds its name and its help.
    pub(crate) const fn new(values: Values) -> Self {
        OptionRow { name: "", values, unit: "", help: "", absent: "", group: "", requires: "" }
    }

    /// A positive number in `unit`.
    pub(crate) const fn positive(unit: &'static str) -> Self {
        OptionRow { unit, ..OptionRow::new(Values::Number { least: 0.0, open: true, below: f64::INFINITY }) }
    }

    /// A number in `unit` that is 0 or more.
    pub(crate) const fn not_negative(unit: &'static str) -> Self {
        OptionRow { unit, ..OptionRow::new(Values::Number { least: 0.0, open: false, below: f64::INFINITY }) }
    }

    pub(crate) const fn absent(self, absent: &'static str) -> Self {
        OptionRow { absent, ..self }
    }

    pub(crate) const fn group(self, group: &'static str) -> Self {
        OptionRow { group, ..self }
    }

    pub(crate) const fn requires(self, requires: &'static str) -> Self {
        OptionRow { requires, ..self }
    }

    /// What a value must be, in words.
    pub fn rule(&self) -> String {
        match self.values {
            Values::Switch => "must be true or false".into(),
            Values::Whole(least, u64::MAX) => format!("must be a whole number, {least} or more"),
            Values::Whole(least, most) => format!("must be a whole number from {least} to {most}"),
            Values::Number { least, open, below } => {
                let number = match (least, open) {
                    _ if below.is_finite() => format!("a number from {least} to below {below}"),
                    (f64::NEG_INFINITY, _) => "a number".into(),
                    (0.0, true) => "a positive number".into(),
                    (least, true) => format!("a number above {least}"),
                    (least, false) => format!("a number, {least} or more"),
                };
                let unit = if self.unit.is_empty() { String::new() } else { format!(" [{}]", self.unit) };
                format!("must be {number}{unit}")
            }
            Values::Choice(known) => {
                let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
                format!("must be {}", names.join(" or "))
            }
            Values::Text(_) => "must be a text".into(),
        }
    }

    /// The value that `text` writes.
    ///
    /// # Errors
    /// [`Error::Parameter`] of a text that is no such value.
    pub fn parse(&self, text: &str) -> Result<Value, Error> {
        let value = match self.values {
            Values::Switch => text.parse::<bool>().map(Value::from).ok(),
            Values::Whole(..) => text.parse::<u64>().map(Value::from).ok(),
            Values::Number { .. } => text.parse::<f64>().map(Value::from).ok(),
            Values::Choice(_) | Values::Text(_) => Some(Value::from(text)),
        };
        let value = value.ok_or_else(|| Error::parameter(self.name, text, self.rule()))?;
        self.check(&value)?;
        Ok(value)
    }

    /// Refuses a value that this option cannot have.
    ///
    /// # Errors
    /// [`Error::Parameter`] with the name of the option, the value and what it must be.
    pub fn check(&self, value: &Value) -> Result<(), Error> {
        let fits = match self.values {
            Values::Switch => value.is_boolean(),
            Values::Whole(least, most) => value.as_u64().is_some_and(|n| (least..=most).contains(&n)),
            Values::Number { least, open, below } => {
                value.as_f64().is_some_and(|x| x.is_finite() && x < below && (x > least || x == least && !open))
            }
            Values::Choice(known) => value.as_str().is_some_and(|text| known.iter().any(|(name, _)| *name == text)),
            Values::Text(_) => value.is_string(),
        };
        let shown = || value.as_str().map_or_else(|| value.to_string(), str::to_string);
        if fits { Ok(()) } else { Err(Error::parameter(self.name, shown(), self.rule())) }
    }
}

/// The options of a verb.
pub trait Options: Default + Serialize + DeserializeOwned {
    /// Its table.
    fn rows() -> Vec<OptionRow>;

    /// The options that a JSON object gives by their names; those that it leaves out, or that are null, have their
    /// defaults.
    ///
    /// ```
    /// use piezoid::{IdentifyOptions, Options};
    /// let options = IdentifyOptions::from_json(serde_json::json!({"order": 3, "operator": "preisach"}))?;
    /// assert_eq!((options.order, options.seed), (Some(3), 1));
    /// let error = IdentifyOptions::from_json(serde_json::json!({"order": 13})).unwrap_err();
    /// assert_eq!(error.to_string(), "order = 13: must be a whole number from 0 to 12");
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unknown`] of an option that there is not, [`Error::Parameter`] of a value that it cannot have.
    fn from_json(given: Value) -> Result<Self, Error> {
        let Value::Object(mut given) = given else {
            return Err(Error::Content(format!("options must be an object of names and values, not {given}")));
        };
        given.retain(|_, value| !value.is_null());
        let rows = Self::rows();
        for (name, value) in &given {
            let row = rows.iter().find(|row| row.name == name);
            row.ok_or_else(|| Error::unknown("option", name, rows.iter().map(|row| row.name)))?.check(value)?;
        }
        serde_json::from_value(Value::Object(given)).map_err(|e| Error::Content(format!("options: {e}")))
    }

    /// What the option called `name` is where it is not given: its value, or what holds without one. Empty where nothing
    /// is to be said.
    fn default_of(name: &str) -> String {
        let defaults = serde_json::to_value(Self::default()).unwrap_or_default();
        let absent = || Self::rows().iter().find(|row| row.name == name).map_or("", |row| row.absent).to_string();
        match &defaults[name] {
            Value::Null => absent(),
            Value::String(text) => text.clone(),
            value => value.to_string(),
        }
    }
}

/// Defines the options of a verb: the struct, its defaults and its table. The comment of a field is its help.
macro_rules! options {
    (
        $(#[$about:meta])*
        pub struct $name:ident {
            $($(#[doc = $help:literal])+ $field:ident: $type:ty = $default:expr, $row:expr;)*
        } $(with $part:ident: $group:ty)*
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default)]
        pub struct $name {
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
                    help: concat!($($help),+).trim_ascii(),
                    ..$row
                }),*];
                own.into_iter()$(.chain(<$group as $crate::options::Options>::rows()))*.collect()
            }
        }
    };
}

pub(crate) use options;
