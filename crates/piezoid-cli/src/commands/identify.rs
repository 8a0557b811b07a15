//! `piezoid identify`: from measured records to a model.

use super::identified::summary;
use super::prelude::*;
use crate::tables::verdict;
use crate::values::Ended;
use piezoid::formats::ColumnSelection;
use piezoid::{IdentifyOptions, Model, StatedVerdict};
use piezoid_export::ExportTarget;
use piezoid_numerics::number::join;
use piezoid_numerics::options::Options;
use piezoid_report::report;
use piezoid_verbs::{Source, identify_again};

const EXAMPLES: &str = "\
Examples:
  A small PRBS for the linear block, rising sines for the hysteresis; operator and order are chosen:
    piezoid identify rise1.csv rise20.csv rise80.csv --small-signal prbs.csv -o model.json
  All available records, without their first 1.5 s, and one operator:
    piezoid identify run1.csv run2.csv --from 1.5 --operator preisach -o model.json
  One operator, and a page on the model:
    piezoid identify run1.csv run2.csv --operator pi -o model.json --report report.html
  The paper's method: two branches per frequency, ARX by particle swarm:
    piezoid identify sine5.csv sine20.csv --small-signal prbs.csv --method paper -o model.json
  Identify a model again from its files, to check that the result is the same:
    piezoid identify --again model.json rise1.csv rise20.csv rise80.csv prbs.csv
  Columns of other names, and no time column:
    piezoid identify log.csv --ts 5ms --input-col cmd_V --output-col pos_um -o model.json";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(
    override_usage = "piezoid identify <FILE>... [--small-signal <FILE>...]\n           [OPTIONS] -o <FILE>\n       \
                             piezoid identify --again <MODEL> <FILE>..."
)]
pub(crate) struct Identify {
    /// Large-signal records, which exercise the hysteresis: rising sines at some frequencies. Without a small-signal
    /// record, they are for the linear block too.
    #[arg(value_name = "FILE", required_unless_present = "small_signal")]
    files: Vec<PathBuf>,
    /// Small-signal records for the linear block: a PRBS of about 1 V.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    small_signal: Vec<PathBuf>,
    /// Repeat the identification of this model: with its options, roles and columns, from its files in any order.
    #[arg(long, value_name = "MODEL", conflicts_with_all = fixed_by_a_model())]
    again: Option<PathBuf>,
    #[command(flatten)]
    options: Flags<IdentifyOptions>,
    /// The export target that the model is for: only operators that it serves are tried (see `piezoid targets
    /// --operators`).
    #[arg(long = "for", value_name = "TARGET")]
    target: Option<String>,
    /// Show the tables: linear block, modes, operators tried, parameters, errors on the training records.
    #[arg(short, long)]
    verbose: bool,
    /// The model file to write; - is stdout. With --again it may be left out.
    #[arg(short, long, value_name = "FILE", required_unless_present = "again")]
    output: Option<PathBuf>,
    /// Write a page on the model and its errors on the training records; - is stdout.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write what was found as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

/// The arguments that a model answers itself.
fn fixed_by_a_model() -> Vec<&'static str> {
    let rows = IdentifyOptions::rows().into_iter().chain(ColumnSelection::rows());
    rows.map(|row| row.name).chain(["small_signal", "target", "profile"]).collect()
}

impl Run for Identify {
    fn run(mut self, console: &Console) -> Result<()> {
        let paths: Vec<&PathBuf> = self.small_signal.iter().chain(&self.files).collect();
        let results = [self.output.as_deref(), self.report.as_deref(), self.json.as_deref()];
        let is_free = files::check(&results, &paths)?;
        self.options.0.check().map_err(failed)?;
        if let Some(target) = &self.target {
            let options = &mut self.options.0;
            options.operator =
                ExportTarget::find(target).and_then(|t| t.operators(&options.operator)).map_err(failed)?;
        }
        let columns = self.columns.read()?;
        let before = self.again.as_ref().map(|path| files::read(path)?.model().map_err(failed)).transpose()?;
        let (small, large) = (files::all(&self.small_signal, files::data)?, files::all(&self.files, files::data)?);
        let small_names: Vec<String> = small.iter().map(|file| file.name.clone()).collect();
        let (result, is_cancelled) = console.work_until_cancelled(|progress| match &before {
            Some(before) => identify_again(before, &large, progress),
            None => {
                let [small, large] = [small, large].map(|files| Source::all(files, &columns));
                self.options.0.run((small, large), "piezoid identify", progress)
            }
        })?;
        if is_cancelled {
            return self.keep_best(&result.found.model, console);
        }
        if is_free && self.verbose {
            console.print(&(summary(&result, console) + "\n"))?;
        }
        let reasons = result.found.reasons.iter().filter(|_| self.verbose);
        console.remarks(reasons.chain(&result.found.notes));
        for (name, linearity) in small_names.iter().zip(&result.linearity) {
            if let Some(linearity) = linearity.as_ref().filter(|linearity| linearity.is_linear != Some(true)) {
                console.remark(&format!("{name}: {}", linearity.verdict));
            }
        }
        let written = Results::default().json(self.json.as_deref(), &result.to_json());
        let written = written.file(self.output.as_deref(), result.found.model.to_json());
        written.file_with(self.report.as_deref(), || report::identification(&result).html()).write(console)?;
        let files = [self.output.as_deref(), self.report.as_deref()].into_iter().flatten();
        let named = files.filter(|path| *path != Path::new("-")).map(|path| path.display().to_string());
        let named: Vec<String> = named.collect();
        let wrote = if named.is_empty() { String::new() } else { format!("; wrote {}", join(&named)) };
        let same = before.filter(|before| *before == result.found.model);
        let same = same.and(self.again).map(|path| format!("Equal to {} to the bit", path.display()));
        let text = [result.found.model.to_string(), verdict(result.found.model.verdict().as_ref()) + &wrote];
        for line in text.into_iter().chain(same) {
            match is_free {
                true => console.sentence(&line)?,
                false => console.remark(&line),
            }
        }
        Ok(())
    }
}

impl Identify {
    /// Writes the best model of a search that was cancelled, and returns this as the error. It takes the place of no
    /// older file.
    fn keep_best(&self, model: &Model, console: &Console) -> Result<()> {
        let is_file = |path: &&Path| self.again.is_none() && (path.is_file() || **path != *"-" && !path.exists());
        let Some(path) = self.output.as_deref().filter(is_file) else {
            bail!(Ended::Cancelled("cancelled: nothing was written".into()));
        };
        let place = if path.exists() { path.with_extension("unfinished.json") } else { path.into() };
        Results::default().file(Some(&place), model.to_json()).write(console)?;
        let verdict = model.verdict().map(|verdict| format!(", {verdict}")).unwrap_or_default();
        bail!(Ended::Cancelled(format!("cancelled: wrote the best model until then to {}{verdict}", place.display())))
    }
}
