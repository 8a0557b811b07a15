//! The options of a verb as flags, created from the library's table, and their values.

use crate::values::Ended::Misused;
use crate::words::{CommandLine, flag, is_option};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use piezoid::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, Options};
use serde_json::{Map, Value};

/// The options `O`, read from flags. A switch that is on by default becomes the flag `--no-NAME`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Flags<O>(pub(crate) O);

impl<O: Options> Args for Flags<O> {
    fn augment_args(command: Command) -> Command {
        command.args(O::rows().iter().map(argument))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<O: Options> FromArgMatches for Flags<O> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let options = O::from_json(values(&O::rows(), matches));
        let wrong = |error: Error| format!("{}\n", error.message(&CommandLine));
        options.map(Flags).map_err(|error| clap::Error::raw(ErrorKind::ValueValidation, wrong(error)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// True if the flag turns off a switch that is on by default.
fn turns_off(row: &OptionRow) -> bool {
    row.values == OptionKind::Switch && (row.default)() == Value::Bool(true)
}

/// The flag of an option.
pub(crate) fn argument(row: &OptionRow) -> Arg {
    let (default, off, name, help) = (row.usual(), turns_off(row), flag(row.name), row.help_in(&CommandLine));
    let help = match (row.values, help.split_at_checked(1)) {
        (OptionKind::Switch, Some((first, rest))) if off => format!("Do not {}{rest}", first.to_lowercase()),
        (OptionKind::Switch, _) => help,
        _ if default.is_empty() => help,
        _ => format!("{help} [default: {default}]"),
    };
    let argument = Arg::new(row.name).long(if off { format!("no-{name}") } else { name }).help(help);
    let argument = if row.group.is_empty() { argument } else { argument.help_heading(row.group) };
    let argument = if row.requires.is_empty() { argument } else { argument.requires(row.requires) };
    let argument = argument.required(row.required).value_name(placeholder(row));
    let own = *row;
    let parsed = move |text: &str| {
        own.parse(text).map_err(|error| match error {
            Error::Parameter { rule, .. } => rule,
            other => other.to_string(),
        })
    };
    let several =
        |count: clap::builder::ValueRange| argument.clone().num_args(count).value_parser(ValueParser::new(parsed));
    match row.values {
        OptionKind::Switch => argument.action(ArgAction::SetTrue),
        OptionKind::Choice(known) => {
            let known = known.iter().map(|(name, meaning)| PossibleValue::new(*name).help(*meaning));
            argument.value_parser(PossibleValuesParser::new(known).map(Value::from))
        }
        OptionKind::Texts(_) => several((1..).into()),
        OptionKind::Numbers => several((1..).into()).allow_negative_numbers(true),
        OptionKind::Pair => several(2.into()).value_names(["LOW", "HIGH"]).allow_hyphen_values(true),
        // Negative numbers with a unit too.
        OptionKind::Number { .. } => several(1.into()).allow_hyphen_values(true),
        _ => several(1.into()).allow_negative_numbers(true),
    }
}

/// Placeholder of the value in the help.
pub(crate) fn placeholder(row: &OptionRow) -> &'static str {
    match (row.values, row.unit) {
        (OptionKind::Text(placeholder) | OptionKind::Texts(placeholder), _) => placeholder,
        (OptionKind::Integer(..), _) => "N",
        (OptionKind::Choice(_), _) => "NAME",
        (_, "") => "NUMBER",
        (_, "s") => "SECONDS",
        (_, "F") => "FARAD",
        (_, "%") => "PERCENT",
        (_, "dB") => "DB",
        (_, "degrees") => "DEGREES",
        (_, unit) => unit,
    }
}

/// The values of the flags that were given.
pub(crate) fn values(rows: &[OptionRow], matches: &ArgMatches) -> Value {
    let value = |row: &OptionRow| match row.values {
        OptionKind::Switch => matches.get_flag(row.name).then(|| Value::Bool(!turns_off(row))),
        OptionKind::Pair | OptionKind::Numbers | OptionKind::Texts(_) => {
            Some(matches.get_many::<Value>(row.name)?.cloned().collect())
        }
        _ => matches.get_one::<Value>(row.name).cloned(),
    };
    Value::Object(rows.iter().filter_map(|row| Some((row.name.into(), value(row)?))).collect::<Map<_, _>>())
}

/// The error as the failure of a verb: a [`Misused`] if the command line itself is wrong.
pub(crate) fn failed(error: Error) -> anyhow::Error {
    let text = error.message(&CommandLine);
    match if let Error::Advised { error, .. } = &error { error } else { &error } {
        Error::Unknown { .. } => Misused(text).into(),
        Error::Parameter { name, .. } if is_option(name) => Misused(text).into(),
        _ => anyhow::Error::msg(text),
    }
}
