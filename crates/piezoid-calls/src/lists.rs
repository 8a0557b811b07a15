//! The lists of the library as documents, for menus and forms.

use crate::MODULES;
use piezoid::OptionKind;
use piezoid::OptionRow;
use piezoid::Options;
use piezoid::control::{CONTROLLERS, FEED_FORWARDS, REFERENCES};
use piezoid::excitation::{ACTUATORS, DRIVERS, EXCITATIONS};
use piezoid::formats::ColumnSelection;
use piezoid::hysteresis::OPERATORS;
use piezoid::linear::ESTIMATORS;
use piezoid::plant::PLANTS;
use piezoid_export::TARGETS;
use serde_json::{Value, json};

/// All lists by name; each row has a name and a summary. `calls` also has the module, the options and the roles of
/// files of each verb, `excitations` the options of each signal, and `targets` what is exported of each operator, and
/// which options each takes of those that not all take.
///
/// ```
/// let lists = piezoid_calls::lists();
/// assert_eq!(lists["operators"].as_array().map(Vec::len), Some(16));
/// assert_eq!(lists["calls"][0]["name"], "inspect");
/// ```
pub fn lists() -> Value {
    let row = |name: &str, summary: &str| json!({"name": name, "summary": summary});
    let with = |mut row: Value, what: &str, more: Value| {
        row[what] = more;
        row
    };
    let calls = MODULES.iter().flat_map(|module| {
        module.calls.iter().map(move |call| {
            let roles: Vec<_> =
                call.roles.iter().map(|r| json!({"name": r.name, "least": r.least, "many": r.most > 1})).collect();
            json!({
                "name": call.name, "summary": call.summary, "module": module.name, "options": rows((call.rows)()),
                "roles": roles,
            })
        })
    });
    let excitations = EXCITATIONS.iter().map(|e| with(row(e.name, e.summary), "options", rows((e.rows)())));
    let targets = TARGETS.iter().map(|t| {
        let served: serde_json::Map<String, Value> =
            OPERATORS.iter().map(|o| (o.name.to_string(), json!(t.serves(o)))).collect();
        with(with(row(t.name, t.summary), "operators", json!(served)), "takes", json!(t.takes))
    });
    let feeds = FEED_FORWARDS.iter().map(|f| row(f.name, f.summary));
    json!({
        "calls": calls.collect::<Vec<_>>(),
        "columns": rows(ColumnSelection::rows()),
        "operators": OPERATORS.iter().map(|o| row(o.name, o.summary)).collect::<Vec<_>>(),
        "excitations": excitations.collect::<Vec<_>>(),
        "plants": PLANTS.iter().map(|p| row(p.name, p.summary)).collect::<Vec<_>>(),
        "drivers": DRIVERS.iter().map(|d| row(d.name, &d.description())).collect::<Vec<_>>(),
        "actuators": ACTUATORS.iter().map(|a| row(a.name, &a.description())).collect::<Vec<_>>(),
        "controllers": feeds.chain(CONTROLLERS.iter().map(|c| row(c.name, c.summary))).collect::<Vec<_>>(),
        "references": REFERENCES.iter().map(|r| row(r.name, r.summary)).collect::<Vec<_>>(),
        "targets": targets.collect::<Vec<_>>(),
        "estimators": ESTIMATORS.iter().map(|e| row(e.name, e.summary)).collect::<Vec<_>>(),
    })
}

/// Options as documents: what a form needs to know.
fn rows(rows: Vec<OptionRow>) -> Value {
    let row = |row: OptionRow| {
        let (kind, choices) = match row.values {
            OptionKind::Switch | OptionKind::Bit => ("switch", Value::Null),
            OptionKind::Integer(..) => ("integer", Value::Null),
            OptionKind::Number { .. } => ("number", Value::Null),
            OptionKind::Pair => ("pair", Value::Null),
            OptionKind::Numbers => ("numbers", Value::Null),
            OptionKind::Choice(known) => ("choice", json!(known)),
            OptionKind::Text(_) => ("text", Value::Null),
            OptionKind::Texts(_) => ("texts", Value::Null),
        };
        json!({
            "name": row.name, "kind": kind, "choices": choices, "unit": row.unit, "help": row.help, "group": row.group,
            "usual": row.usual(), "rule": row.rule(), "required": row.required,
        })
    };
    rows.into_iter().map(row).collect()
}
