//! The words of the command line: options of the library as flags, its lists as commands.

use crate::flags::placeholder;
use piezoid::PrepareOptions;
use piezoid::formats::ColumnSelection;
use piezoid_numerics::options::{OptionRow, Options};
use piezoid_numerics::words::Words;
use piezoid_operations::catalogue;
use serde_json::Value;

/// The words of the command line.
pub(crate) struct CommandLine;

impl Words for CommandLine {
    fn option(&self, name: &str) -> String {
        format!("--{}", flag(name))
    }

    fn remedy(&self, name: &str, value: &Value) -> String {
        match value {
            Value::Null => self.option(name) + &unknown(name),
            Value::Bool(_) => self.option(name),
            value => format!("{} {value}", self.option(name)),
        }
    }

    fn setting(&self, name: &str, value: &str) -> String {
        match value {
            _ if !is_option(name) => format!("{name} = {value}"),
            "true" => self.option(name),
            "false" => format!("--no-{}", flag(name)),
            value => format!("{} {value}", self.option(name)),
        }
    }

    fn list(&self, name: &str) -> String {
        format!("`piezoid {name}`")
    }
}

/// The name of an option as a flag, without its dashes.
pub(crate) fn flag(name: &str) -> String {
    name.replace('_', "-")
}

/// The placeholder for a value that only the user knows: of columns and of the steps that repair a record.
fn unknown(name: &str) -> String {
    let mut rows = ColumnSelection::rows().into_iter().chain(PrepareOptions::rows());
    let row = rows.find(|row| row.name == name);
    row.map(|row| format!(" {}", placeholder(&row))).unwrap_or_default()
}

/// True if some operation has an option of this name.
pub(crate) fn is_option(name: &str) -> bool {
    let catalogue = catalogue();
    let has = |rows: &[OptionRow]| rows.iter().any(|row| row.name == name);
    has(&catalogue.columns)
        || catalogue.operations.iter().any(|operation| has(&(operation.options)()))
        || catalogue.excitations.iter().any(|excitation| has(&(excitation.rows)()))
}
