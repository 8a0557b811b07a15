//! The lists of operators, plants, drive signals and other members, each row with its one-line summary.

use crate::console::Console;
use crate::files::{self, Results};
use crate::flags::failed;
use crate::values::Ended::Misused;
use anyhow::Result;
use clap::Args;
use piezoid::control::{CONTROLLERS, FEED_FORWARDS};
use piezoid::excitation::{ACTUATORS, DRIVERS, EXCITATIONS};
use piezoid::hysteresis::{OPERATORS, Operator};
use piezoid::linear::ESTIMATORS;
use piezoid::plant::{self, PLANTS, Spec};
use piezoid_export::{FEED_FORWARD, MODEL, TARGETS};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A row of a list as JSON: `name`, `summary` and `reference`, and figures where there are some.
type Row = Value;

fn row(name: &str, summary: &str, reference: &str) -> Row {
    json!({"name": name, "summary": summary, "reference": reference})
}

/// The row with another summary.
fn told(mut row: Row, summary: String) -> Row {
    row["summary"] = summary.into();
    row
}

fn text<'a>(row: &'a Row, key: &str) -> &'a str {
    row[key].as_str().unwrap_or_default()
}

pub(crate) fn operators() -> Vec<Row> {
    let operator = |o: &&Operator| {
        let also = if o.aliases.is_empty() { String::new() } else { format!(" (or {})", o.aliases.join(", ")) };
        let mut row = row(o.name, &format!("{}{also}", o.summary), o.reference);
        row["aliases"] = json!(o.aliases);
        row
    };
    OPERATORS.iter().map(operator).collect()
}

pub(crate) fn excitations() -> Vec<Row> {
    EXCITATIONS.iter().map(|e| row(e.name, e.summary, e.reference)).collect()
}

pub(crate) fn estimators() -> Vec<Row> {
    ESTIMATORS.iter().map(|e| row(e.name, e.summary, e.reference)).collect()
}

pub(crate) fn drivers() -> Vec<Row> {
    DRIVERS.iter().map(|d| told(json!(d), d.description())).collect()
}

pub(crate) fn actuators() -> Vec<Row> {
    ACTUATORS.iter().map(|a| told(json!(a), a.description())).collect()
}

pub(crate) fn controllers() -> Vec<Row> {
    let feeds = FEED_FORWARDS.iter().map(|f| row(f.name, f.summary, f.reference));
    feeds.chain(CONTROLLERS.iter().map(|c| row(c.name, c.summary, c.reference))).collect()
}

fn targets() -> Vec<Row> {
    TARGETS.iter().map(|t| row(t.name, t.summary, t.reference)).collect()
}

fn plants() -> Vec<Row> {
    PLANTS.iter().map(|p| row(p.name, p.summary, p.reference)).collect()
}

#[derive(Args)]
pub(crate) struct List {
    /// Write the list with references as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl List {
    pub(crate) fn run(self, rows: &[Row], console: &Console) -> Result<()> {
        if self.json.as_deref() != Some(Path::new("-")) {
            let width = rows.iter().map(|row| text(row, "name").len()).max().unwrap_or(0);
            let indent = " ".repeat(width + 2);
            for row in rows {
                let (name, summary) = (text(row, "name"), text(row, "summary"));
                console.print(&console.paragraph(&format!("{name:width$}  {summary}"), &indent))?;
            }
        }
        Results::default().json(self.json.as_deref(), &rows.to_vec().into()).write(console)
    }
}

#[derive(Args)]
pub(crate) struct Plants {
    /// Print the parameters of a plant as JSON, for a plant of your own (`piezoid simulate --plant FILE`).
    #[arg(long, value_name = "NAME", conflicts_with = "json")]
    show: Option<String>,
    #[command(flatten)]
    list: List,
}

impl Plants {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        match self.show {
            Some(name) => console.print(&(plant(&name)?.to_json()? + "\n")),
            None => self.list.run(&plants(), console),
        }
    }
}

#[derive(Args)]
pub(crate) struct Targets {
    /// Show which operators each target serves, and with what: the model, its feed-forward.
    #[arg(long)]
    operators: bool,
    #[command(flatten)]
    list: List,
}

impl Targets {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let mut rows = targets();
        if self.operators {
            for (row, target) in rows.iter_mut().zip(TARGETS) {
                let served: Vec<_> = OPERATORS.iter().map(|o| (o.name, target.serves(o))).collect();
                row["summary"] = told_served(&served).into();
                row["operators"] = served.into_iter().map(|(name, what)| (name.to_string(), json!(what))).collect();
            }
        }
        self.list.run(&rows, console)
    }
}

/// What a target serves, in words.
fn told_served(served: &[(&str, &[&str])]) -> String {
    let of = |what: &str| {
        let (with, without): (Vec<_>, Vec<_>) = served.iter().partition(|(_, all)| all.contains(&what));
        let names = |rows: &[&(&str, &[&str])]| rows.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        match (with.len(), without.len()) {
            (0, _) => "no operator".into(),
            (_, 0) => format!("all {} operators", served.len()),
            (few, many) if few < many => names(&with),
            _ => format!("all but {}", names(&without)),
        }
    };
    match (of(MODEL), of(FEED_FORWARD)) {
        (model, feed) if model == feed => format!("{MODEL} and {FEED_FORWARD}: {model}"),
        (model, feed) => format!("{MODEL}: {model}; {FEED_FORWARD}: {feed}"),
    }
}

/// The plant called `name`, or the plant in the JSON file of this name.
pub(crate) fn plant(name: &str) -> Result<Spec> {
    if name.ends_with(".json") {
        let file = files::read(Path::new(name))?;
        return file.text().and_then(|text| Spec::from_json(text).map_err(|e| e.of(name))).map_err(failed);
    }
    let own = "a plant of your own goes into a .json file: see `piezoid plants --show`";
    let unknown = |e| Misused(format!("{e} ({own})"));
    Ok((plant::Preset::find(name).map_err(unknown)?.spec)())
}
