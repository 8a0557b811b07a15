//! The tables of options in docs/reference.md.

use crate::words::REFERENCE;
use piezoid::excitation::LimitOptions;
use piezoid::formats::ColumnSelection;
use piezoid_instruments::Simulation;
use piezoid_numerics::options::{OptionKind, OptionRow, Options};
use piezoid_operations::catalogue;

/// Tables that several verbs share: title, and rows.
type Shared = [(&'static str, Vec<OptionRow>); 2];

/// The tables: what verbs share first.
pub(crate) fn options() -> String {
    let shared: Shared =
        [("Columns of data files", ColumnSelection::rows()), ("Limits of a voltage", LimitOptions::rows())];
    let mut text = String::new();
    for (title, rows) in &shared {
        text += &table(title, rows, "");
    }
    let operations = catalogue().operations.into_iter().map(|operation| (operation.name, (operation.options)()));
    // A server, which is no operation.
    let all = operations.chain([("instrument", Simulation::rows())]).filter(|(_, rows)| !rows.is_empty());
    let all: Vec<(&str, Vec<OptionRow>)> = all.collect();
    for (k, (verb, rows)) in all.iter().enumerate() {
        let texts = |rows: &[OptionRow]| rows.iter().map(|row| (row.name, row.help)).collect::<Vec<_>>();
        if let Some((other, _)) = all[..k].iter().find(|(_, others)| texts(others) == texts(rows)) {
            text += &format!("### Options of `{verb}`\n\n[Those of `{other}`](#options-of-{other}).\n\n");
            continue;
        }
        let is_of =
            |row: &OptionRow, others: &[OptionRow]| others.iter().any(|o| (o.name, o.help) == (row.name, row.help));
        let (limits, own): (Vec<OptionRow>, Vec<OptionRow>) = rows.iter().partition(|row| is_of(row, &shared[1].1));
        let also = if limits.is_empty() { "" } else { "And the [limits of a voltage](#limits-of-a-voltage).\n\n" };
        text += &table(&format!("Options of `{verb}`"), &own, also);
    }
    text
}

fn table(title: &str, rows: &[OptionRow], below: &str) -> String {
    let lines: String = rows.iter().map(line).collect();
    format!("### {title}\n\n| option | value | default | meaning |\n|---|---|---|---|\n{lines}\n{below}")
}

fn line(row: &OptionRow) -> String {
    let rule = row.rule();
    let value = rule.trim_start_matches("must be ");
    let value = value.strip_prefix("a ").or(value.strip_prefix("an ")).unwrap_or(value);
    let (value, meanings) = match row.values {
        OptionKind::Switch => ("switch".into(), String::new()),
        OptionKind::Choice(known) => {
            let names: Vec<String> = known.iter().map(|(name, _)| format!("`{name}`")).collect();
            let all: Vec<String> = known.iter().map(|(name, meaning)| format!("`{name}`, {meaning}")).collect();
            (names.join(", "), format!(": {}", all.join("; ")))
        }
        _ => (value.to_string(), String::new()),
    };
    let default = match row.usual() {
        _ if row.required => "required".into(),
        // A switch that is off.
        usual if usual == "false" => String::new(),
        usual => usual,
    };
    let cell = |text: String| text.replace('|', "\\|");
    let cells = [format!("`{}`", row.name), cell(value), cell(default), cell(row.help_in(&REFERENCE) + &meanings)];
    format!("| {} |\n", cells.join(" | ")).replace("|  |", "| |")
}
