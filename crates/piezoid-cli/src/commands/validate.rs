//! `piezoid validate`: a model against records it has not seen, in free run.

use crate::console::Console;
use crate::files::{self, Columns};
use crate::flags::Flags;
use crate::tables;
use crate::values::apart;
use anyhow::{Context, Result, bail};
use clap::Args;
use piezoid::number::round;
use piezoid::validation::{Metrics, ValidateOptions, Validation};
use piezoid::{Model, Record};
use serde_json::{Value, json};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  Records the model has not seen, without their first half second:
    piezoid validate --model model.json --data test5.csv test20.csv --skip 0.5
  The second half of a record whose sensor drifts, as JSON:
    piezoid validate --model model.json --data record.csv --from 20 --offset free \\
        --json -

The model runs free: it sees the input alone, and starts as if the first input had stood for long. \
nrmse % is 100 rmse / standard deviation of y, rms/pp % is 100 rmse / peak-to-peak of y, fit % is 100 - nrmse %.

Errors by frequency and amplitude are those of the cycles of the input, over all files; where it does not go to and fro, \
of the spectra, in third-octave bands. The floor is the scatter of y between repetitions of the same input. What is left is \
white when a Ljung-Box test cannot tell it from noise; it goes with the input when the model lacks something.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "piezoid validate --model <FILE>\n           --data <FILE>... [OPTIONS]")]
pub(crate) struct Validate {
    #[command(flatten)]
    proof: Proof,
    /// Show all bands, all loops, and what the tests of the residuals mean.
    #[arg(long)]
    full: bool,
    /// Write the figures as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// A model, records, and how to compare them.
#[derive(Args)]
pub(crate) struct Proof {
    /// The model file.
    #[arg(long, value_name = "FILE")]
    pub(crate) model: PathBuf,
    /// The records to compare with.
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) data: Vec<PathBuf>,
    #[command(flatten)]
    options: Flags<ValidateOptions>,
    #[command(flatten)]
    columns: Columns,
}

/// A record, its file's name as given, and the model's run beside it.
pub(crate) struct Proven {
    pub(crate) file: String,
    pub(crate) record: Record,
    pub(crate) validation: Validation,
}

impl Proof {
    /// The files that are read.
    pub(crate) fn inputs(&self) -> Vec<&PathBuf> {
        self.data.iter().chain([&self.model]).collect()
    }

    pub(crate) fn run(&self) -> Result<(Model, Vec<Proven>)> {
        let model = files::model(&self.model)?;
        let options = &self.options.0;
        let mut unit = None;
        let mut prove = |path: &PathBuf| {
            let file = path.display().to_string();
            let record = self.columns.record(path)?.record;
            // The total of all files needs one unit: that of the first.
            let unit = unit.get_or_insert_with(|| record.units().y.clone());
            let record = record.output_in(unit).with_context(|| file.clone())?;
            if options.skip >= record.duration() {
                let (skip, duration) = (options.skip, round(record.duration()));
                bail!("{file}: --skip {skip} leaves nothing of this record, which lasts {duration} s: skip less");
            }
            let validation = model.validate_with(&record, options).with_context(|| file.clone())?;
            Ok(Proven { file, record, validation })
        };
        let proven = self.data.iter().map(&mut prove).collect::<Result<Vec<_>>>()?;
        Ok((model, proven))
    }
}

impl Validate {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        apart(&[self.json.as_deref()], &self.proof.inputs())?;
        files::ready(&[self.json.as_deref()])?;
        let (_, proven) = self.proof.run()?;
        let each: Vec<Metrics> = proven.iter().map(|p| p.validation.metrics).collect();
        let total = Metrics::total(&each);
        if self.json.as_deref() != Some(std::path::Path::new("-")) {
            console.print(&tables::all(&proven, &total, self.full, console))?;
        }
        for p in &proven {
            for remark in &p.validation.remarks {
                console.remark(&format!("{}: {remark}", p.file));
            }
        }
        let mut total = json!(total);
        let [by_frequency, by_amplitude] = tables::merged_bins(&proven);
        merge(&mut total, json!({"by_frequency": by_frequency, "by_amplitude": by_amplitude}));
        merge(&mut total, json!({"unproven": tables::unproven(&proven)}));
        let result = json!({"files": proven.iter().map(figures).collect::<Vec<_>>(), "total": total});
        files::write_json(self.json.as_deref(), &result, console)
    }
}

/// All about one record, for scripts.
pub(crate) fn figures(p: &Proven) -> Value {
    let v = &p.validation;
    let mut object = json!({"file": p.file, "unit": p.record.units().y, "beginning": v.beginning});
    merge(&mut object, json!(v.metrics));
    merge(&mut object, json!({"remarks": v.remarks, "unproven": v.unproven}));
    merge(&mut object, json!({"by_frequency": v.by_frequency, "by_amplitude": v.by_amplitude}));
    merge(&mut object, json!({"loops": v.loops, "whiteness": v.whiteness, "floor": v.floor}));
    object
}

/// Adds the members of one object to another.
fn merge(object: &mut Value, more: Value) {
    if let (Value::Object(object), Value::Object(more)) = (object, more) {
        object.extend(more);
    }
}
