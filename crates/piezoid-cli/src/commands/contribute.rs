//! `piezoid contribute`: records of a real actuator, checked and packed as evidence for all.

use super::prelude::*;
use crate::values::Ended::Misused;
use crate::words::CommandLine;
use piezoid::formats::ColumnSelection;
use piezoid_numerics::number::round;
use piezoid_numerics::words::capitalised;
use piezoid_verbs::{ContributeOptions, Contributed, ContributedFile, Source};

const EXAMPLES: &str = "\
Examples:
  Check records, and pack them:
    piezoid contribute slow.csv fast.csv prbs.csv path.csv --licence CC-BY-4.0 \\
        --actuator \"P-885.91 stack, no load\" --driver \"E-610, gain 10\" --sensor \"D-510 capacitive\" \\
        --who \"A. Name, Our institute\" --conditions \"22 degC\" -o contribution.zip
  Check an archive that was received:
    piezoid contribute --check contribution.zip

The archive has the files as they are, and what is stated of them. Nothing is sent anywhere. Without -o the records are only checked. docs/contributing-records.md says which records are useful, what they are used for, and how the archive is handed in.";

const USAGE: &str = "piezoid contribute <FILE>... --licence <NAME> [OPTIONS]
       piezoid contribute --check <FILE>";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = USAGE)]
pub(crate) struct Contribute {
    /// The records, as they were measured.
    #[arg(value_name = "FILE", required_unless_present = "check")]
    data: Vec<PathBuf>,
    #[command(flatten)]
    options: Flags<ContributeOptions>,
    /// Check an archive: its checksums, and its records as it states them.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["data", "output"])]
    check: Option<PathBuf>,
    /// Write the archive; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write what is stated and what was found as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Contribute {
    fn run(self, console: &Console) -> Result<()> {
        let inputs: Vec<&PathBuf> = self.data.iter().chain(&self.check).collect();
        let is_free = files::check(&[self.output.as_deref(), self.json.as_deref()], &inputs)?;
        let columns = self.columns.read()?;
        let found = match &self.check {
            Some(archive) => {
                if self.options.0 != ContributeOptions::default() || columns != ColumnSelection::default() {
                    let what = "--check reads all of it as the archive states";
                    bail!(Misused(format!("{what}: leave out all other options but --json")));
                }
                Contributed::check(&files::read(archive)?).map_err(failed)?
            }
            None => {
                self.options.0.stated().map_err(|error| Misused(error.message(&CommandLine)))?;
                let data = files::all(&self.data, files::data)?;
                self.options.0.run(Source::all(data, &columns)).map_err(failed)?
            }
        };
        if is_free {
            console.print(&table(&found, console))?;
        }
        for file in found.files() {
            console.remarks(file.findings.iter().map(|finding| format!("{}: {finding}", file.file)));
        }
        console.remarks(found.findings());
        let mut results = Results::default();
        if self.output.is_some() {
            results = results.file(self.output.as_deref(), found.archive().map_err(failed)?);
        }
        results.json(self.json.as_deref(), &found.to_json()).write(console)?;
        let end = match (&self.check, &self.output) {
            (Some(_), _) => format!("the files are as piezoid {} packed them", found.version()),
            (None, Some(path)) => {
                let where_to = "docs/contributing-records.md says how it is handed in";
                format!("wrote {}, sent nothing: {where_to}", path.display())
            }
            (None, None) => "give -o to pack them".into(),
        };
        if is_free { console.sentence(&format!("{}; {end}", capitalised(&found.summary()))) } else { Ok(()) }
    }
}

/// The files, a row each.
fn table(found: &Contributed, console: &Console) -> String {
    let row = |file: &ContributedFile| {
        let ContributedFile { samples, ts, duration, units, .. } = file;
        let proposed = file.proposed["use"].as_str().unwrap_or("-").to_string();
        let [every, duration] = [*ts, *duration].map(round);
        vec![file.file.clone(), proposed, samples.to_string(), every, duration, units.u.clone(), units.y.clone()]
    };
    let header = ["record", "proposed for", "samples", "every [s]", "duration [s]", "u in", "y in"];
    console.table(&header, found.files().iter().map(row)) + "\n"
}
