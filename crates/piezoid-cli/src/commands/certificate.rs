//! `piezoid certificate`: the expanded uncertainty of a predicted displacement, as a page and as XML.

use super::prelude::*;
use piezoid_numerics::number::short as number;
use piezoid_numerics::words::capitalised;
use piezoid_report::{dcc, report};
use piezoid_verbs::{Budget, CertificateOptions, CertifiedRecord, Contribution, Evaluation, Source, share};

const EXAMPLES: &str = "\
Examples:
  From validation records and the certificate of the sensor, as a page:
    piezoid certificate test5.csv test80.csv --model model.json --sensor-calibration 0.5% \\
        --sensor-linearity 20nm --date 2026-11-30 -o certificate.html
  As Digital Calibration Certificate, for others to read:
    piezoid certificate test5.csv test80.csv --model model.json --sensor-calibration 0.5% \\
        --date 2026-11-30 --country CZ --issuer \"Our institute\" -o certificate.xml

The records must not be those that the model was identified from. Each record, and each band of frequencies, has a budget; the certificate states the largest expanded uncertainty. The budget has the error of the model and the noise as measured, and what is stated here; it lists what is not stated. Lengths without a unit are in the unit of the records.

A certificate is a statement by its user, not by an accredited laboratory. docs/certificate.md has the equations.";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid certificate <FILE>... --model <FILE> [OPTIONS]")]
pub(crate) struct Certificate {
    /// The model file.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// The validation records.
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    options: Flags<CertificateOptions>,
    /// Write a page, or with the extension .xml a Digital Calibration Certificate; - is the page on stdout.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write a Digital Calibration Certificate (DCC 3.3.0, XML); - is stdout.
    #[arg(long, value_name = "FILE")]
    dcc: Option<PathBuf>,
    /// Write the results as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Certificate {
    fn run(self, console: &Console) -> Result<()> {
        let inputs: Vec<&PathBuf> = self.files.iter().chain([&self.model]).collect();
        let outputs = [self.output.as_deref(), self.dcc.as_deref(), self.json.as_deref()];
        let is_free = files::check(&outputs, &inputs)?;
        let (model, data) = (files::read(&self.model)?, files::all(&self.files, files::data)?);
        let data = Source::all(data, &self.columns.read()?);
        let found = self.options.0.run(&model, data).map_err(failed)?;
        let is_xml = |path: &&Path| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("xml"));
        let (xml, page) = match self.output.as_deref() {
            Some(path) if is_xml(&path) => (Some(path), None),
            path => (None, path),
        };
        let mut results = Results::default().file_with(page, || report::certificate(&found).html());
        if xml.or(self.dcc.as_deref()).is_some() {
            let text = dcc(&found).map_err(failed)?;
            results = results.file(xml, text.clone()).file(self.dcc.as_deref(), text);
        }
        if is_free {
            console.print(&(budget(&found, console) + "\n" + &records(&found, console)))?;
        }
        console.remarks(&found.remarks);
        if !found.not_stated.is_empty() {
            console.remark(&format!("not stated, not included: {}", found.not_stated.join(", ")));
        }
        results.json(self.json.as_deref(), &found.to_json()).write(console)?;
        let written = [self.output.as_deref(), self.dcc.as_deref()].into_iter().flatten();
        let wrote: String = written.map(|path| format!("; wrote {}", path.display())).collect();
        if is_free { console.sentence(&(capitalised(&found.summary()) + &wrote)) } else { Ok(()) }
    }
}

fn degrees(nu: Option<f64>) -> String {
    nu.map_or("inf".into(), number)
}

/// The budget of the worst record or band.
fn budget(found: &piezoid_verbs::Certificate, console: &Console) -> String {
    let (worst, budget) = found.worst();
    let row = |row: &Contribution| {
        let kind = if row.evaluation == Evaluation::A { "A" } else { "B" };
        vec![
            row.source.to_string(),
            format!("{} {}", number(row.value), row.unit),
            format!("{kind}, {}", row.distribution),
            number(row.divisor),
            number(row.sensitivity),
            number(row.contribution),
            degrees(row.degrees_of_freedom),
            format!("{:.1}", row.share_percent),
        ]
    };
    let Budget { standard, degrees_of_freedom, .. } = budget;
    let none = String::new;
    let combined = vec![
        "combined".into(),
        none(),
        none(),
        none(),
        none(),
        number(*standard),
        degrees(*degrees_of_freedom),
        none(),
    ];
    let contribution = format!("contribution [{}]", found.units.y);
    let header = [&*worst, "value", "type", "divisor", "coefficient", &contribution, "dof", "share %"];
    console.table(&header, budget.rows.iter().map(row).chain([combined]))
}

fn records(found: &piezoid_verbs::Certificate, console: &Console) -> String {
    let y = &found.units.y;
    let row = |record: &CertifiedRecord| {
        let Budget { standard, degrees_of_freedom, k, expanded, .. } = &record.budget;
        vec![
            record.compared.short().to_string(),
            record.n.to_string(),
            number(record.mean_error),
            number(*standard),
            degrees(*degrees_of_freedom),
            format!("{k:.2}"),
            number(*expanded),
            share(record.own_within_percent),
            share(record.within_percent),
        ]
    };
    let bands = found.bands.iter().map(|band| {
        let Budget { standard, degrees_of_freedom, k, expanded, .. } = &band.budget;
        let none = || "-".to_string();
        let [standard, nu, k, expanded] =
            [number(*standard), degrees(*degrees_of_freedom), format!("{k:.2}"), number(*expanded)];
        vec![band.name(), none(), none(), standard, nu, k, expanded, none(), none()]
    });
    let [mean, standard, expanded] = ["mean error", "u", "U"].map(|name| format!("{name} [{y}]"));
    let header = ["record", "n", &mean, &standard, "dof", "k", &expanded, "in its U %", "in U %"];
    console.table(&header, found.records.iter().map(row).chain(bands))
}
