//! `piezoid compare`: several models on the same records, and methods that are identified from one split of them.

use super::prelude::*;
use crate::values::Ended;
use piezoid_numerics::number::short as number;
use piezoid_numerics::words::capitalised;
use piezoid_report::report::{comparison, leaderboard};
use piezoid_verbs::{CompareOptions, ComparedModel, ModelComparison, Source};
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  Three models on records that none of them has seen, as a page:
    piezoid compare pi.json dahl.json preisach.json --data test5.csv test80.csv \\
        -o compare.html
  The same figures as JSON, without the first half second of each record:
    piezoid compare pi.json dahl.json --data test5.csv --skip 0.5 --json -
  All operators and other structures, identified from three quarters of each record and compared on the rest:
    piezoid compare run1.csv run2.csv --operators all --structures hammerstein,no-creep,linear \\
        --figure compare.svg
  The same for two operators and a model file, on a record of another day:
    piezoid compare run1.csv old.json --operators bouc-wen,auto --data friday.csv

All models run free on all records: they see only the input. The page shows errors by record, by frequency and by amplitude, and residuals and loops of all models on one record (--record).

With --operators or --structures, files that do not end in .json are training records, of which the end is held out (--held-out), unless --data names others. Times are printed in the table alone: all written files are the same each time.";

#[derive(Args)]
#[command(
    after_help = EXAMPLES,
    override_usage = "piezoid compare <MODEL>... --data <FILE>... [OPTIONS]\n       \
                      piezoid compare <FILE>... --operators <NAMES> [--data <FILE>...]"
)]
pub(crate) struct Compare {
    /// The model files; with --operators or --structures also training records.
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// The records to compare with.
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present_any = ["operators", "structures"])]
    data: Vec<PathBuf>,
    /// Small-signal records for the linear block: a PRBS of about 1 V.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    small_signal: Vec<PathBuf>,
    #[command(flatten)]
    options: Flags<CompareOptions>,
    /// Write a page with figures; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the error against the number of parameters as SVG; - is stdout.
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
    /// Write the results as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Compare {
    fn run(self, console: &Console) -> Result<()> {
        let inputs: Vec<&PathBuf> = self.files.iter().chain(&self.data).chain(&self.small_signal).collect();
        let outputs = [self.output.as_deref(), self.figure.as_deref(), self.json.as_deref()];
        let is_free = files::check(&outputs, &inputs)?;
        let options = &self.options.0;
        options.methods.check().map_err(failed)?;
        let is_model = |path: &PathBuf| {
            !options.methods.is_any() || path.extension().is_some_and(|end| end.eq_ignore_ascii_case("json"))
        };
        let (models, training): (Vec<PathBuf>, Vec<PathBuf>) = self.files.iter().cloned().partition(is_model);
        let models = files::all(&models, files::read)?;
        let columns = self.columns.read()?;
        let records = |paths: &[PathBuf]| -> Result<_> { Ok(Source::all(files::all(paths, files::data)?, &columns)) };
        let [training, small_signal, data] = [&training, &self.small_signal, &self.data].map(|paths| records(paths));
        let records = [training?, small_signal?, data?];
        let start = Instant::now();
        let clock = || start.elapsed().as_secs_f64();
        let (compared, _) =
            console.work_until_cancelled(|progress| options.run_all((models, records), Some(&clock), progress))?;
        if is_free {
            let table = if compared.split.is_some() { ranking } else { errors };
            console.print(&table(&compared, console))?;
        }
        for one in &compared.failed {
            console.remark(&format!("{}: {}", one.name, one.reason));
        }
        // Of many methods, the remarks on the best are of use.
        let remarked = if compared.split.is_some() { 1 } else { compared.models.len() };
        for one in compared.models.iter().take(remarked) {
            for run in &one.validated.files {
                let remarks = &run.validation.remarks;
                console.remarks(remarks.iter().map(|remark| format!("{}, {}: {remark}", one.name, run.name)));
            }
        }
        if compared.cancelled.is_some() {
            let text = "cancelled: the table has what was compared until then; nothing was written";
            bail!(Ended::Cancelled(text.into()));
        }
        let page = Results::default().file_with(self.output.as_deref(), || comparison(&compared).html());
        let figure = || leaderboard(&compared).map(|figure| figure.svg()).unwrap_or_default();
        let results = page.file_with(self.figure.as_deref(), figure);
        results.json(self.json.as_deref(), &compared.to_json()).write(console)?;
        let text = compared.summary().unwrap_or_else(|| "no error is defined: the outputs are constant".into());
        let wrote = self.output.map(|path| format!("; wrote {}", path.display())).unwrap_or_default();
        match compared.models.is_empty() {
            true => bail!("no method could be compared"),
            false if is_free => console.sentence(&(capitalised(&text) + &wrote)),
            false => Ok(()),
        }
    }
}

/// The methods by rising error, with the noise floor, their size and their times; then those that failed.
fn ranking(compared: &ModelComparison, console: &Console) -> String {
    let header = ["method", "rms/pp %", "noise %", "operator", "parameters", "fit s", "step ns"];
    let none = || "-".to_string();
    let row = |one: &ComparedModel| {
        let noise = one.validated.floor().map_or_else(none, |floor| number(floor.rms_pp_percent));
        let operator = one.operator().map_or_else(none, Into::into);
        let size = one.all_parameters.map_or_else(none, |n| n.to_string());
        let [fit, step] =
            [one.times.fit_s, one.times.step_ns].map(|time| time.map_or_else(none, |t| format!("{t:.1}")));
        vec![one.name.clone(), number(one.error()), noise, operator, size, fit, step]
    };
    let failed = compared.failed.iter().map(|one| {
        [one.name.clone(), "failed".into()].into_iter().chain(std::iter::repeat_with(none).take(5)).collect()
    });
    console.table(&header, compared.models.iter().map(row).chain(failed))
}

/// The errors of each model, by record and in total.
fn errors(compared: &ModelComparison, console: &Console) -> String {
    let records = compared.models.first().map_or(&[][..], |one| &one.validated.files);
    let mut header = vec!["rms/pp %", "operator"];
    header.extend(records.iter().map(|record| record.short()));
    header.extend((records.len() > 1).then_some("total"));
    let row = |one: &ComparedModel| {
        let each = one.validated.files.iter().map(|run| number(run.validation.metrics.rms_pp_percent));
        let total = (records.len() > 1).then(|| number(one.validated.total().rms_pp_percent));
        let what = [one.name.clone(), one.operator().unwrap_or_default().into()];
        what.into_iter().chain(each).chain(total).collect()
    };
    console.table(&header, compared.models.iter().map(row))
}
