//! `piezoid compare`: several models on the same records.

use super::prelude::*;
use piezoid_numerics::number::short as number;
use piezoid_numerics::words::capitalised;
use piezoid_report::report::comparison;
use piezoid_verbs::{CompareOptions, ModelComparison, Source};

const EXAMPLES: &str = "\
Examples:
  Three models on records that none of them has seen, as a page:
    piezoid compare pi.json dahl.json preisach.json --data test5.csv test80.csv \\
        -o compare.html
  The same figures as JSON, without the first half second of each record:
    piezoid compare pi.json dahl.json --data test5.csv --skip 0.5 --json -

All models run free on all records: they see only the input. The page shows errors by record, by frequency and by amplitude, and residuals and loops of all models on one record (--record).";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid compare <MODEL>... --data <FILE>... [OPTIONS]")]
pub(crate) struct Compare {
    /// The model files.
    #[arg(value_name = "MODEL", required = true)]
    models: Vec<PathBuf>,
    /// The records to compare with.
    #[arg(long, value_name = "FILE", num_args = 1.., required = true)]
    data: Vec<PathBuf>,
    #[command(flatten)]
    options: Flags<CompareOptions>,
    /// Write a page with figures; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the results as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Compare {
    fn run(self, console: &Console) -> Result<()> {
        let inputs: Vec<&PathBuf> = self.models.iter().chain(&self.data).collect();
        let is_free = files::check(&[self.output.as_deref(), self.json.as_deref()], &inputs)?;
        let (models, data) = (files::all(&self.models, files::read)?, files::all(&self.data, files::data)?);
        let data = Source::all(data, &self.columns.read()?);
        let compared = self.options.0.run(&models, data).map_err(failed)?;
        if is_free {
            console.print(&errors(&compared, console))?;
        }
        for one in &compared.models {
            for run in &one.validated.files {
                let remarks = &run.validation.remarks;
                console.remarks(remarks.iter().map(|remark| format!("{}, {}: {remark}", one.name, run.name)));
            }
        }
        let page = Results::default().file_with(self.output.as_deref(), || comparison(&compared).html());
        page.json(self.json.as_deref(), &compared.to_json()).write(console)?;
        let text = compared.summary().unwrap_or_else(|| "no error is defined: the outputs are constant".into());
        let wrote = self.output.map(|path| format!("; wrote {}", path.display())).unwrap_or_default();
        if is_free { console.sentence(&(capitalised(&text) + &wrote)) } else { Ok(()) }
    }
}

/// The errors of each model, by record and in total.
fn errors(compared: &ModelComparison, console: &Console) -> String {
    let records = compared.models.first().map_or(&[][..], |one| &one.validated.files);
    let mut header = vec!["rms/pp %", "operator"];
    header.extend(records.iter().map(|record| record.short()));
    header.extend((records.len() > 1).then_some("total"));
    let row = |one: &piezoid_verbs::ComparedModel| {
        let each = one.validated.files.iter().map(|run| number(run.validation.metrics.rms_pp_percent));
        let total = (records.len() > 1).then(|| number(one.validated.total().rms_pp_percent));
        let what = [one.name.clone(), one.model.hysteresis().operator().name.into()];
        what.into_iter().chain(each).chain(total).collect()
    };
    console.table(&header, compared.models.iter().map(row))
}
