//! The lists of operators, plants, drive signals and other members, each row with its one-line summary.

use super::prelude::*;
use crate::values::Ended::Misused;
use anyhow::anyhow;
use piezoid::control::SimulatedActuator;
use piezoid::plant::{self, Spec};
use piezoid_export::{FEED_FORWARD, MODEL};
use piezoid_operations::catalogue;
use serde_json::{Value, json};

/// The rows of a list: `name`, `summary` and, of most, `reference`; figures where there are some.
fn rows(list: &str) -> Vec<Value> {
    json!(catalogue())[list].as_array().cloned().unwrap_or_default()
}

fn text<'a>(row: &'a Value, key: &str) -> &'a str {
    row[key].as_str().unwrap_or_default()
}

#[derive(Args)]
pub(crate) struct List {
    /// Write the list with references as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl List {
    /// Prints the list of this name.
    pub(crate) fn run(self, list: &str, console: &Console) -> Result<()> {
        self.print(rows(list), console)
    }

    fn print(self, rows: Vec<Value>, console: &Console) -> Result<()> {
        if self.json.as_deref() != Some(Path::new("-")) {
            let width = rows.iter().map(|row| text(row, "name").len()).max().unwrap_or(0);
            let indent = " ".repeat(width + 2);
            for row in &rows {
                let (name, summary) = (text(row, "name"), text(row, "summary"));
                console.print(&console.paragraph(&format!("{name:width$}  {summary}"), &indent))?;
            }
        }
        Results::default().json(self.json.as_deref(), &rows.into()).write(console)
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

impl Run for Plants {
    fn run(self, console: &Console) -> Result<()> {
        match self.show {
            Some(name) => console.print(&(twin(&name)?.to_json()? + "\n")),
            None => self.list.run("plants", console),
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

impl Run for Targets {
    fn run(self, console: &Console) -> Result<()> {
        let mut rows = rows("targets");
        if self.operators {
            for row in &mut rows {
                row["summary"] = served(&row["operators"]).into();
            }
        }
        self.list.print(rows, console)
    }
}

/// What a target serves, in words; `operators` has what it makes for each operator.
fn served(operators: &Value) -> String {
    let of = |what: &str| {
        let all = operators.as_object().into_iter().flatten();
        let makes =
            |(_, result): &(&String, &Value)| result.as_array().is_some_and(|result| result.iter().any(|m| m == what));
        let (with, without): (Vec<_>, Vec<_>) = all.partition(makes);
        let names = |rows: &[(&String, &Value)]| rows.iter().map(|(name, _)| &***name).collect::<Vec<_>>().join(", ");
        match (with.len(), without.len()) {
            (0, _) => "no operator".into(),
            (_, 0) => format!("all {} operators", with.len()),
            (few, many) if few < many => names(&with),
            _ => format!("all but {}", names(&without)),
        }
    };
    match (of(MODEL), of(FEED_FORWARD)) {
        (model, feed_forward) if model == feed_forward => format!("{MODEL} and {FEED_FORWARD}: {model}"),
        (model, feed_forward) => format!("{MODEL}: {model}; {FEED_FORWARD}: {feed_forward}"),
    }
}

/// The twin called `name`, or the twin or stand-in in the JSON file of this name.
pub(crate) fn plant(name: &str) -> Result<SimulatedActuator> {
    if name.ends_with(".json") {
        let file = files::read(Path::new(name))?;
        let text = file.text().map_err(failed)?;
        let advice = if text.contains("\"stand_in\"") { "" } else { ", which `piezoid plants --show pl140` prints" };
        let found = SimulatedActuator::from_json(text).map_err(|error| failed(error.of(name)));
        return found.map_err(|error| anyhow!("{error}{advice}"));
    }
    let own = "a plant of your own goes into a .json file: see `piezoid plants --show`";
    let unknown = |e| Misused(format!("{e} ({own})"));
    Ok(plant::Preset::find(name).map_err(unknown)?.spec().into())
}

/// The same for a plant that must be a twin.
fn twin(name: &str) -> Result<Spec> {
    match plant(name)? {
        SimulatedActuator::Twin(spec) => Ok(*spec),
        SimulatedActuator::StandIn(_) => {
            bail!(Misused(format!("{name} is a stand-in, which has no parameters of an actuator: name a plant")))
        }
    }
}
