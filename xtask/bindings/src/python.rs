//! Keywords of Python: a TypedDict for each verb, whose docstring lists the options, and the defaults.

use crate::verbs::KEYWORDS;
use crate::words;
use piezoid_numerics::options::{OptionKind, OptionRow};
use piezoid_numerics::words::wrapped;
use serde_json::Value;
use std::fmt::Write;

const HEAD: &str = r#""""The options of the library as keywords of functions. Written by `cargo xtask generate bindings`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict

if TYPE_CHECKING:
    from typing_extensions import Required
"#;

const WIDTH: usize = 120;

/// The content of `_options.py`.
pub(crate) fn options() -> String {
    let mut text = HEAD.to_string();
    for (class, functions, rows) in KEYWORDS {
        let rows = rows();
        let lines = documented(&rows);
        let types: String = rows.iter().map(|row| format!("    {}: {}\n", row.name, typed(row))).collect();
        let _ = write!(
            text,
            "\n\nclass {class}(TypedDict, total=False):\n    \"\"\"Keywords of {functions}.\n\n{lines}    \"\"\"\n\n{types}"
        );
    }
    text += "\n\nDEFAULTS: dict[str, dict[str, Any]] = {\n";
    for (class, _, rows) in KEYWORDS {
        let defaults: Vec<String> =
            rows().iter().map(|row| format!("        \"{}\": {},\n", row.name, literal(&(row.default)()))).collect();
        let _ = write!(text, "    \"{class}\": {{\n{}    }},\n", defaults.concat());
    }
    text + "}\n\"\"\"The defaults by class and name; None if an option has no value by default.\"\"\"\n"
}

/// The lines of all options: first those without a group, then those of each group under its heading, if there are
/// several groups.
fn documented(rows: &[OptionRow]) -> String {
    let mut groups = vec![""];
    for row in rows {
        if !groups.contains(&row.group) {
            groups.push(row.group);
        }
    }
    let lines = |group: &&str| rows.iter().filter(|row| row.group == *group).map(line).collect::<String>();
    let own = lines(&groups[0]);
    let others = groups.iter().skip(1).map(|group| match own.is_empty() && groups.len() == 2 {
        true => lines(group),
        false => format!("\n    {group}:\n\n{}", lines(group)),
    });
    own.clone() + &others.collect::<String>()
}

/// The line of an option in a docstring, wrapped.
fn line(row: &OptionRow) -> String {
    let known = match row.values {
        OptionKind::Choice(known) => quoted(known).join(" or "),
        _ => row.unit.to_string(),
    };
    let known = if known.is_empty() { known } else { format!(" [{known}]") };
    let usual = row.usual();
    let default = if usual.is_empty() || usual == "false" { String::new() } else { format!("; default: {usual}") };
    let help = row.help_in(&words::KEYWORDS);
    let text = format!("    {}: {help}{known}{default}", row.name);
    wrapped(&text, WIDTH, "        ") + "\n"
}

/// The type of a keyword. A number with a unit may be a text such as "0.5 ms".
fn typed(row: &OptionRow) -> String {
    let own = match row.values {
        OptionKind::Switch | OptionKind::Bit => "bool".into(),
        OptionKind::Integer(..) => "int".into(),
        OptionKind::Number { .. } if row.unit.is_empty() => "float".into(),
        OptionKind::Number { .. } | OptionKind::Text("FACTOR") => "float | str".into(),
        OptionKind::Pair | OptionKind::Numbers => "Sequence[float]".into(),
        OptionKind::Choice(known) => format!("Literal[{}]", quoted(known).join(", ")),
        // Columns have names or numbers.
        OptionKind::Text(_) if row.name.ends_with("_col") => "str | int".into(),
        OptionKind::Text(_) => "str".into(),
        OptionKind::Texts(_) => "str | Sequence[str]".into(),
    };
    match (row.default)() {
        _ if row.required => format!("Required[{own}]"),
        Value::Null => format!("{own} | None"),
        _ => own,
    }
}

/// The names of choices in quotes.
fn quoted(known: &[(&str, &str)]) -> Vec<String> {
    known.iter().map(|(name, _)| format!("\"{name}\"")).collect()
}

/// A value as Python writes it.
fn literal(value: &Value) -> String {
    match value {
        Value::Null => "None".into(),
        Value::Bool(true) => "True".into(),
        Value::Bool(false) => "False".into(),
        other => other.to_string(),
    }
}
