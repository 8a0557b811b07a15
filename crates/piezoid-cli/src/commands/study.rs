//! `piezoid study`: the paper's experiment from end to end.

use super::prelude::*;
use piezoid_host::files::FileSet;
use piezoid_numerics::number::{round, short as number};
use piezoid_report::study::{self, METHODS, Study as Outcome, StudyOptions};

const EXAMPLES: &str = "\
Examples:
  Both simulated actuators, into the folder study:
    piezoid study
  Only the simulated actuator of the paper, with its tables as JSON:
    piezoid study --plant paper --out paper --json paper/tables.json";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Study {
    /// The folder to write the report and the figures to.
    #[arg(long, value_name = "DIR", default_value = "study")]
    out: PathBuf,
    #[command(flatten)]
    options: Flags<StudyOptions>,
    /// Write the tables as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Run for Study {
    fn run(self, console: &Console) -> Result<()> {
        if self.out.exists() && !self.out.is_dir() {
            bail!("{}: this is a file, not a folder: name a folder with --out", self.out.display());
        }
        self.options.0.plants().map_err(failed)?;
        // The folder is made when there is something to write.
        let above = self.out.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new(""));
        if above.is_file() {
            let (out, above) = (self.out.display(), above.display());
            bail!("cannot create the folder {out}: {above} is a file: choose another with --out");
        }
        files::ready(&[Some(&above.join("report.html")), self.json.as_deref()])?;
        let studies = console.work(|progress| self.options.0.run(progress))?;
        let files = FileSet::in_folder(&self.out, &Outcome::files(&studies))?;
        Results::of(files).json(self.json.as_deref(), &Outcome::to_json(&studies)).write(console)?;
        if self.json.as_deref() != Some(Path::new("-")) {
            for study in &studies {
                console.print(&summary(study, console))?;
            }
            console.print(&format!("Report: {}\n", self.out.join("report.html").display()))?;
        }
        Ok(())
    }
}

fn summary(study: &Outcome, console: &Console) -> String {
    let mut text = console.paragraph(&format!("PLANT {}: {}", study.plant.name, study.plant.summary), "  ");
    let of_frequencies = |title: &str, figure: &dyn Fn(&study::StudyRow) -> f64, printed: bool| {
        let row = |f: &study::Frequency| {
            let mse =
                Outcome::PRINTED_MSE.iter().find(|(hz, _)| *hz == f.hz).map_or("-".into(), |(_, mse)| number(*mse));
            let cells = METHODS.iter().map(|m| f.row(m.name).map_or("-".into(), |r| number(figure(r))));
            let amplitude = (!printed).then(|| round(f.amplitude));
            [round(f.hz)].into_iter().chain(amplitude).chain(cells).chain(printed.then_some(mse)).collect()
        };
        let mut header = vec!["f [Hz]"];
        header.extend((!printed).then_some("u [V]"));
        header.extend(METHODS.iter().map(|m| m.name));
        header.extend(printed.then_some("paper"));
        format!("\n{}\n{}", title, console.table(&header, study.frequencies.iter().map(row)))
    };
    text += &of_frequencies(
        &format!("Table 1: mean squared error on the stepped sine of {} steps [mm^2]", Outcome::STEPS_USED),
        &|r| r.metrics.mse,
        true,
    );
    for method in METHODS {
        text += &console.paragraph(&format!("{}: {}", method.name, method.summary), "  ");
    }
    text += &of_frequencies("The same as rms error [% of peak-to-peak]", &|r| r.metrics.rms_pp_percent, false);

    let coefficients = |b: &study::StudyBlock| [b.name.to_string()].into_iter().chain(b.printed()).collect();
    let table = console.table(&["linear block", "a1", "a2", "b0", "b1", "b2"], study.blocks.iter().map(coefficients));
    text += &format!("\nTable 2: the linear block [b in mm/V]\n{table}");

    let dynamics = |b: &study::StudyBlock| {
        let pole = b.arx.poles().pop();
        let zeros: Vec<String> = b.arx.zeros().iter().map(|z| format!("{:.3}", z.modulus())).collect();
        let inverse = if b.arx.inverse().is_ok() { "stable" } else { "unstable" };
        let part = |what: &dyn Fn(piezoid::linear::Pole) -> f64| pole.map_or("-".into(), |p| number(what(p)));
        vec![b.name.into(), part(&|p| p.hz), part(&|p| p.damping), zeros.join("  "), inverse.into()]
    };
    let header = ["linear block", "pole [Hz]", "damping", "moduli of zeros", "inverse (equation 8)"];
    let table = console.table(&header, study.blocks.iter().map(dynamics));
    text += &format!("\nPoles, zeros and inverse of the linear block\n{table}\n");
    let paragraphs: Vec<String> = study.verdict().split("\n\n").map(|p| console.paragraph(p, "")).collect();
    text += &paragraphs.join("\n");
    for note in &study.notes {
        text += &format!("\n{}", console.paragraph(&format!("* {note}"), "  "));
    }
    text + "\n"
}
