//! The options of a verb as flags, made from the library's table.

use crate::values::Misused;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use piezoid::{Error, OptionRow, Options, Values};
use serde_json::{Map, Value};

/// The options `O`, read from flags. A switch that is on unless told otherwise is the flag `--no-NAME`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Flags<O>(pub(crate) O);

impl<O: Options> Args for Flags<O> {
    fn augment_args(command: Command) -> Command {
        O::rows().into_iter().fold(command, |command, row| command.arg(argument::<O>(&row)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<O: Options> FromArgMatches for Flags<O> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut given = Map::new();
        for row in O::rows() {
            if let Some(value) = value::<O>(&row, matches) {
                given.insert(row.name.into(), value);
            }
        }
        let options = O::from_json(Value::Object(given));
        options.map(Flags).map_err(|error| clap::Error::raw(ErrorKind::ValueValidation, format!("{error}\n")))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The flag of an option: hyphens, and `no-` before a switch that is on.
fn flag<O: Options>(row: &OptionRow) -> String {
    let off = row.values == Values::Switch && O::default_of(row.name) == "true";
    format!("{}{}", if off { "no-" } else { "" }, row.name.replace('_', "-"))
}

fn argument<O: Options>(row: &OptionRow) -> Arg {
    let default = O::default_of(row.name);
    let told = match row.values {
        Values::Switch => String::new(),
        _ if default.is_empty() => String::new(),
        _ => format!(" [default: {default}]"),
    };
    let help = row.help.trim_end_matches('.');
    let help = match (flag::<O>(row).starts_with("no-"), help.split_at_checked(1)) {
        (true, Some((first, rest))) => format!("Do not {}{rest}", first.to_lowercase()),
        _ => format!("{help}{told}"),
    };
    let argument = Arg::new(row.name).long(flag::<O>(row)).help(help);
    let argument = if row.group.is_empty() { argument } else { argument.help_heading(row.group) };
    let argument = if row.requires.is_empty() { argument } else { argument.requires(row.requires) };
    let row = *row;
    let parsed = move |text: &str| {
        row.parse(text).map_err(|error| match error {
            Error::Parameter { rule, .. } => rule,
            other => other.to_string(),
        })
    };
    match row.values {
        Values::Switch => argument.action(ArgAction::SetTrue),
        Values::Choice(known) => {
            let known = known.iter().map(|(name, meaning)| PossibleValue::new(*name).help(*meaning));
            argument.value_name(placeholder(&row)).value_parser(PossibleValuesParser::new(known).map(Value::from))
        }
        _ => argument.value_name(placeholder(&row)).value_parser(ValueParser::new(parsed)).allow_negative_numbers(true),
    }
}

/// What stands for a value in the help.
fn placeholder(row: &OptionRow) -> &'static str {
    match (row.values, row.unit) {
        (Values::Text(placeholder), _) => placeholder,
        (Values::Whole(..), _) => "N",
        (Values::Choice(_), _) => "NAME",
        (_, "") => "NUMBER",
        (_, "s") => "SECONDS",
        (_, "F") => "FARAD",
        (_, unit) => unit,
    }
}

/// What a flag was set to, if it was.
fn value<O: Options>(row: &OptionRow, matches: &ArgMatches) -> Option<Value> {
    match row.values {
        Values::Switch => matches.get_flag(row.name).then(|| Value::Bool(!flag::<O>(row).starts_with("no-"))),
        _ => matches.get_one::<Value>(row.name).cloned(),
    }
}

/// What the library says of an option, with its flag.
pub(crate) fn misused(error: Error) -> anyhow::Error {
    match error {
        Error::Parameter { name, value, rule } => {
            let name = name.replace('_', "-");
            let flag = if value == "false" { format!("--no-{name}") } else { format!("--{name} {value}") };
            Misused(format!("{flag}: {rule}")).into()
        }
        other => Misused(other.to_string()).into(),
    }
}
