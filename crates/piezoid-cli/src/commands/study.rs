//! `piezoid study`: the paper's experiment from end to end.

use crate::console::{Console, number, table};
use crate::files;
use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use piezoid::plant;
use piezoid::study::{self, METHODS, PRINTED_MSE, Study as Outcome};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(crate) struct Study {
    /// The folder to write the report and the figures to.
    #[arg(long, value_name = "DIR", default_value = "study")]
    out: PathBuf,
    /// The plant to study [default: both].
    #[arg(long, value_enum)]
    plant: Option<Twin>,
    /// Seed of the swarm and of the plant's noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the tables as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Twin {
    /// The paper's: one mode, no noise.
    Paper,
    /// The catalogue's PL140 with noise, creep and a driver.
    Pl140,
}

impl Study {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let names: &[&str] = match self.plant {
            None => &["paper", "pl140"],
            Some(Twin::Paper) => &["paper"],
            Some(Twin::Pl140) => &["pl140"],
        };
        let studies = names
            .iter()
            .map(|name| study::run(plant::find(name)?, self.seed, &mut console.progress()))
            .collect::<Result<Vec<Outcome>, _>>();
        console.done();
        let studies = studies?;

        std::fs::create_dir_all(&self.out).with_context(|| format!("cannot make the folder {}", self.out.display()))?;
        for (name, figure) in studies.iter().flat_map(study::figures) {
            files::write(&self.out.join(format!("{name}.svg")), &figure.svg(), console)?;
        }
        let page = self.out.join("report.html");
        files::write(&page, &study::page(&studies).html(), console)?;
        if self.json.as_deref() != Some(Path::new("-")) {
            for study in &studies {
                console.print(&summary(study))?;
            }
            console.print(&format!("report: {}\n", page.display()))?;
        }
        files::write_json(self.json.as_deref(), &study::to_json(&studies), console)
    }
}

fn summary(study: &Outcome) -> String {
    let mut text = format!("PLANT {}: {}\n\n", study.plant.name, study.plant.summary);
    let by_method = |title: &str, figure: &dyn Fn(&study::Row) -> f64, printed: bool| {
        let row = |f: &study::Frequency| {
            let mse = PRINTED_MSE.iter().find(|(hz, _)| *hz == f.hz).map_or("-".into(), |(_, mse)| number(*mse));
            let cells = METHODS.iter().map(|m| f.row(m.name).map_or("-".into(), |r| number(figure(r))));
            let last = if printed { Some(mse) } else { None };
            [number(f.hz), number(f.amplitude)].into_iter().chain(cells).chain(last).collect()
        };
        let mut header = vec!["f [Hz]", "u [V]"];
        header.extend(METHODS.iter().map(|m| m.name));
        header.extend(printed.then_some("paper"));
        format!("{title}\n{}\n", table(&header, &study.frequencies.iter().map(row).collect::<Vec<_>>()))
    };
    text += &by_method("Table 1: mean squared error on the staircase [mm^2]", &|r| r.mse, true);
    text += &by_method("the same as rms error, % of peak-to-peak", &|r| r.metrics.rms_pp_percent, false);
    let fit = |f: &study::Block| {
        let c = f.coefficients();
        let pole = f.arx.poles().last().map_or("-".into(), |p| format!("{} / {}", number(p.hz), number(p.damping)));
        let zeros: Vec<String> = f.arx.zeros().iter().map(|z| format!("{:.3}", z.modulus())).collect();
        let inverse = if f.arx.inverse().is_ok() { "stable" } else { "unstable" };
        let mut cells = vec![f.name.to_string()];
        cells.extend(c.iter().map(|c| format!("{c:.4}")));
        cells.extend([pole, zeros.join(" "), inverse.into()]);
        cells
    };
    let header = ["Table 2", "a1", "a2", "b0", "b1", "b2", "pole Hz / damping", "|zeros|", "(8)"];
    text += &table(&header, &study.blocks.iter().map(fit).collect::<Vec<_>>());
    for note in &study.notes {
        text += &format!("\n* {note}\n");
    }
    text + "\n"
}
