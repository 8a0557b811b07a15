//! `piezoid identify`: from measured records to a model.

use super::Proven;
use super::identified::{result, summary};
use crate::console::Console;
use crate::files::{self, Columns, Measured};
use crate::flags::{Flags, misused};
use crate::values::apart;
use anyhow::Result;
use clap::Args;
use piezoid::hammerstein::Identified;
use piezoid::validation::{Linearity, Offset, ValidateOptions};
use piezoid::{IdentifyOptions, Method, Record, Records, identify_watched};
use serde_json::json;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  A small PRBS for the linear block, rising sines for the hysteresis; operator and order are chosen:
    piezoid identify --small-signal prbs.csv --large-signal rise1.csv rise20.csv rise80.csv \\
        -o model.json
  What records there are, without their start-up, and one operator:
    piezoid identify --data run1.csv run2.csv --from 1.5 \\
        --operator preisach -o model.json
  The paper's way: two branches a frequency, ARX by swarm:
    piezoid identify --method paper --small-signal prbs.csv --large-signal sine5.csv sine20.csv \\
        -o model.json
  Columns of other names, and no time column:
    piezoid identify --data log.csv --ts 0.005 --input-col cmd_V \\
        --output-col pos_um -o model.json";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "\
piezoid identify --small-signal <FILE>... --large-signal <FILE>...
           [OPTIONS] -o <FILE>
       piezoid identify --data <FILE>... [OPTIONS] -o <FILE>")]
pub(crate) struct Identify {
    /// Small-signal records for the linear block: a PRBS of about 1 V.
    #[arg(long, alias = "linear", value_name = "FILE", num_args = 1..)]
    small_signal: Vec<PathBuf>,
    /// Large-signal records, which exercise the hysteresis: rising sines at some frequencies.
    #[arg(long, alias = "rich", value_name = "FILE", num_args = 1.., required_unless_present_any = ["small_signal", "data"])]
    large_signal: Vec<PathBuf>,
    /// Records for everything, where no small-signal one was taken.
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["small_signal", "large_signal"])]
    data: Vec<PathBuf>,
    #[command(flatten)]
    options: Flags<IdentifyOptions>,
    /// The model file to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write what was found as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Identify {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let large_files: Vec<&PathBuf> = self.large_signal.iter().chain(&self.data).collect();
        let files: Vec<&PathBuf> = self.small_signal.iter().chain(large_files.iter().copied()).collect();
        apart(&[Some(&self.output), self.json.as_deref()], &files)?;
        files::ready(&[Some(&self.output), self.json.as_deref()])?;
        let options = self.options.0;
        options.check().map_err(misused)?;
        let mut origins = Vec::new();
        let mut read = |path: &&PathBuf| {
            let Measured { record, origin } = self.columns.record(path)?;
            origins.push(origin);
            Ok(record)
        };
        let small: Vec<Record> = self.small_signal.iter().map(|path| read(&path)).collect::<Result<_>>()?;
        let large: Vec<Record> = large_files.iter().map(read).collect::<Result<_>>()?;
        let mut progress = console.progress();
        let records = Records { small_signal: &small, large_signal: &large };
        let found = console.done(identify_watched(records, &options, &mut progress))?;
        drop(progress);

        let mut made = files::provenance(origins);
        made["seed"] = json!(options.seed);
        // For the report: the model alone does not tell them.
        for (name, known) in [("trials", json!(found.trials)), ("parameters", json!(found.parameters))] {
            if known != json!([]) {
                made[name] = known;
            }
        }
        // The joint method gives each record an offset of its own.
        let offset = if options.method == Method::Joint { Offset::Free } else { Offset::Kept };
        let trained = trained(&found, &large_files, &large, &ValidateOptions { offset, ..ValidateOptions::default() })?;
        let model = found.model.clone().with_provenance(made);
        if ![Some(self.output.as_path()), self.json.as_deref()].contains(&Some(Path::new("-"))) {
            console.print(&summary(&found, &trained, console))?;
        }
        for note in &found.notes {
            console.remark(note);
        }
        let linearity: Vec<Option<Linearity>> = small.iter().map(|record| Linearity::of(record).ok()).collect();
        for (path, seen) in self.small_signal.iter().zip(&linearity) {
            if let Some(seen) = seen.as_ref().filter(|seen| seen.is_linear != Some(true)) {
                console.remark(&format!("{}: {}", path.display(), seen.verdict));
            }
        }
        let mut result = result(&found, &trained);
        result["linearity"] = json!(linearity);
        files::write_json(self.json.as_deref(), &result, console)?;
        files::write(&self.output, &model.to_json(), console)
    }
}

/// The model's free run over its training data.
fn trained(
    found: &Identified,
    files: &[&PathBuf],
    records: &[Record],
    options: &ValidateOptions,
) -> Result<Vec<Proven>> {
    let prove = |(path, record): (&&PathBuf, &Record)| {
        let record = record.output_in(&found.model.units().y)?;
        let validation = found.model.validate_with(&record, options)?;
        Ok(Proven { file: path.display().to_string(), record, validation })
    };
    files.iter().zip(records).map(prove).collect()
}
