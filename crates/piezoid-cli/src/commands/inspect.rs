//! `piezoid inspect`: what files hold, how they are read, and what seems wrong with them.

use super::prelude::*;
use crate::sketch::{Sketch, sketch};
use crate::words::CommandLine;
use piezoid::{Error, Units};
use piezoid_numerics::number::round;
use piezoid_verbs::{Measured, propose};
use serde_json::{Value, json};

const EXAMPLES: &str = "\
Examples:
  What a file holds, and how it would be read:
    piezoid inspect log.csv
  A scope recorded the input of an amplifier of gain 20 and a sensor of 5 um/V; the profile says so from now on:
    piezoid inspect scope.csv --input-col CH1 --input-scale 20 --output-col CH2 --output-scale 5um/V -o rig.toml
    piezoid identify scope.csv --profile rig.toml -o model.json";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid inspect <FILE>... [OPTIONS]")]
pub(crate) struct Inspect {
    /// The files.
    #[arg(value_name = "FILE", required = true)]
    data: Vec<PathBuf>,
    /// Write a profile: how the first file is read. Other verbs take it by --profile.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write what was found as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Inspect {
    fn run(self, console: &Console) -> Result<()> {
        let inputs: Vec<&PathBuf> = self.data.iter().collect();
        let is_free = files::check(&[self.output.as_deref(), self.json.as_deref()], &inputs)?;
        let (columns, data) = (self.columns.read()?, files::all(&self.data, files::data)?);
        let (mut all, mut drives, mut profile) = (Vec::new(), Vec::new(), None);
        for file in &data {
            let (mut inspection, record) = file.inspect(&columns).map_err(failed)?;
            match &record {
                Ok(record) => drives.push(Some(record.drive().map_err(failed)?)),
                Err(error) => {
                    inspection["problems"] = json!([error.message(&CommandLine)]);
                    drives.push(None);
                }
            }
            if is_free {
                console.print(&summary(&inspection, record.as_ref(), console)?)?;
            }
            if let (Ok(Measured::Long(record)), true) = (&record, all.is_empty()) {
                profile = Some(record.profile().clone());
            }
            all.push(inspection);
        }
        propose(&mut all, &drives);
        if is_free && self.output.is_none() && !self.columns.has_profile() {
            console.print(&alike(&all, console))?;
        }
        if is_free {
            console.print(&proposed(&all, console))?;
        }
        let mut results = Results::default();
        if let (Some(path), Some(first)) = (&self.output, data.first()) {
            let profile = profile.map_or_else(|| first.profile(&columns), Ok).map_err(failed)?.to_toml();
            let about = "# How records of this rig are read: piezoid VERB ... --profile FILE\n";
            results = results.file(Some(path), format!("{about}{profile}"));
        }
        results.json(self.json.as_deref(), &Value::Array(all)).write(console)
    }
}

/// The proposed uses, a line each.
fn proposed(all: &[Value], console: &Console) -> String {
    let line = |inspection: &Value| {
        let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
        let (file, proposal) = (text(&inspection["file"]), &inspection["use"]);
        let option = match proposal["use"].as_str()? {
            "small-signal" => "identify --small-signal",
            "validation" => "validate",
            _ => "identify",
        };
        Some(console.paragraph(&format!("{file}: proposed for {option}: {}", text(&proposal["because"])), "  "))
    };
    all.iter().filter_map(line).collect()
}

/// For each layout that several files have, one line: a profile reads them all.
fn alike(all: &[Value], console: &Console) -> String {
    let mut layouts: Vec<&Value> = Vec::new();
    let mut sentences = String::new();
    for inspection in all {
        let layout = &inspection["layout"];
        if layouts.contains(&layout) {
            continue;
        }
        layouts.push(layout);
        let names = || all.iter().filter(|other| other["layout"] == *layout).filter_map(|other| other["file"].as_str());
        let (count, first) = (names().count(), names().next().unwrap_or_default());
        if count > 1 {
            let which = if count == all.len() {
                String::new()
            } else {
                format!(" ({})", names().collect::<Vec<_>>().join(", "))
            };
            let flags = if inspection["record"].is_null() { " FLAGS" } else { "" };
            let profile = format!("one profile reads them: piezoid inspect {first}{flags} -o rig.toml");
            sentences += &console.paragraph(&format!("{count} files{which} look alike: {profile}"), "");
        }
    }
    sentences
}

/// What a file holds, as text for the terminal.
fn summary(inspection: &Value, record: Result<&Measured, &Error>, console: &Console) -> Result<String> {
    let text = |value: &Value| value.as_str().map_or_else(|| "-".to_string(), String::from);
    let number = |value: &Value| value.as_f64().map_or_else(|| "-".into(), round);
    let channels = inspection["channels"].as_array().map_or(&[][..], Vec::as_slice);
    let row = |channel: &Value| {
        let (name, unit, role) = (text(&channel["name"]), text(&channel["unit"]), text(&channel["role"]));
        vec![name, role, unit, channel["samples"].to_string(), number(&channel["low"]), number(&channel["high"])]
    };
    let table = console.table(&["channel", "role", "unit", "samples", "from", "to"], channels.iter().map(row));
    let mut sentence = format!("{}: {}\n{table}", text(&inspection["file"]), text(&inspection["format"]));
    if let Ok(record) = record {
        let (n, ts, Units { u, y }) = match record {
            Measured::Held(record) => (record.len(), record.ts(), record.units()),
            Measured::Long(record) => (record.len(), record.ts(), record.units()),
        };
        let [ts, hz, duration] = [ts, 1.0 / ts, n as f64 * ts].map(round);
        let rate = format!("{n} samples every {ts} s ({hz} Hz), {duration} s; u in {u}, y in {y}");
        sentence += &console.paragraph(&rate, "  ");
    }
    let list = |name: &str| inspection[name].as_array().into_iter().flatten().map(&text).collect::<Vec<_>>();
    for step in list("history") {
        sentence += &console.paragraph(&step, "  ");
    }
    match record {
        Ok(record) => {
            let width = console.room().unwrap_or(80).min(100);
            match record {
                Measured::Held(record) => {
                    sentence += &sketch("u", record.u(), width);
                    sentence += &sketch("y", record.y(), width);
                }
                Measured::Long(record) => {
                    let ([u, y], n) = (record.ends(), record.len());
                    let [mut u, mut y] = [("u", u), ("y", y)].map(|(name, ends)| Sketch::new(name, ends, n, width));
                    let read = record.read(&mut |inputs, outputs| {
                        u.add(inputs);
                        y.add(outputs);
                        Ok(())
                    });
                    read.map_err(failed)?;
                    sentence += &(u.text() + &y.text());
                }
            }
            for problem in list("problems") {
                sentence += &console.paragraph(&format!("problem: {problem}"), "  ");
            }
        }
        Err(error) => sentence += &console.paragraph(&format!("no record: {}", error.message(&CommandLine)), "  "),
    }
    Ok(sentence + "\n")
}
