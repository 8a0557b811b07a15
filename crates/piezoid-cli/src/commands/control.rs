//! `piezoid control`: the closed loop on a simulated actuator, several schemes side by side.

use super::plant::RecordsOfModel;
use super::prelude::*;
use crate::values::{Ended::Misused, apart, record};
use piezoid::System;
use piezoid::control::{
    ClosedLoopRun, Comparison, ControllerInput, NamedReference, Reference, ReferenceResult, TunedScheme,
};
use piezoid_numerics::number::{round, short as number};
use piezoid_verbs::{ComparisonReport, ControlOptions};
use std::hint::black_box;
use std::time::{Duration, Instant};

const EXAMPLES: &str = "\
Examples:
  The usual schemes along sines, triangles, a staircase and a random path, on a stand-in for the actuator of the model:
    piezoid control --plant records --model model.json
  The same on a twin of the catalogue:
    piezoid control --plant pl140 --model model.json
  One scheme along your own reference, the run as a file:
    piezoid control --plant pl140 --model model.json \\
        --controller feed-forward+integral-notch --reference r.csv -o run.csv
  200 random actuators within +-20 % of the parameters of pl140, as a page with figures:
    piezoid control --plant pl140 --model model.json --controller pi predictive \\
        --reference triangle:20 --tolerance 20 --report control.html

A controller is a feed-forward (gain, feed-forward, learning), a feedback (see `piezoid controllers`), or both joined by +; a feedback alone is added to the feed-forward `gain`, the best constant gain. A reference is a file with a column r_* or \
y_*, or sine, triangle, staircase or random with a frequency in Hz, such as sine:5. Errors are the reference minus the measured displacement, in % of the peak-to-peak of the reference. For periodic references, the error leaves out the first whole periods, at least 0.25 s.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "piezoid control --plant <NAME|FILE|records> --model <FILE>\n           [OPTIONS]")]
pub(crate) struct Control {
    /// The actuator: records is a stand-in, a second model of the records of the model; a name (see `piezoid plants`)
    /// is a twin, a JSON file a twin or a stand-in.
    #[arg(long, value_name = "NAME|FILE|records")]
    plant: String,
    #[command(flatten)]
    of_model: RecordsOfModel,
    /// The model that controllers are tuned to.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    #[command(flatten)]
    options: Flags<ControlOptions>,
    /// Write the run as a record: CSV, or .npz or .mat by the extension (exactly one --controller and one --reference);
    /// - is stdout.
    #[arg(short, long, value_name = "FILE", value_parser = record())]
    output: Option<PathBuf>,
    /// Write a page with figures; - is stdout.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write all results as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Control {
    fn run(self, console: &Console) -> Result<()> {
        let options = &self.options.0;
        let results = [self.output.as_deref(), self.report.as_deref(), self.json.as_deref()];
        let paths: Vec<PathBuf> = options.files().map(PathBuf::from).collect();
        apart(&results, &paths.iter().chain([&self.model]).collect::<Vec<_>>())?;
        if self.output.is_some() && (options.controller.len() != 1 || options.reference.len() != 1) {
            bail!(Misused("-o holds one run: name one --controller and one --reference with it".into()));
        }
        files::ready(&results)?;
        let columns = self.columns.read()?;
        for path in &paths {
            let name = path.to_string_lossy();
            if let (false, Err(unknown)) = (path.exists(), Reference::find(name.split(':').next().unwrap_or(&name))) {
                bail!(Misused(format!("{name}: there is no such file, and {unknown}")));
            }
        }
        let (plant, actuator) = self.of_model.plant(&self.plant, &self.model, console)?;
        let (model, references) = (files::read(&self.model)?, files::all(&paths, files::data)?);
        let compared =
            console.work(|progress| options.run((&plant, &actuator), &model, &references, &columns, progress))?;
        if !results.contains(&Some(Path::new("-"))) {
            console.print(&tables(&compared, console))?;
        }
        console.remarks(compared.remarks().into_iter().chain(steps(&compared)));
        let record = Results::default().record(self.output.as_deref(), |name| compared.written(name))?;
        let page = piezoid_report::report::tracking(&compared).html();
        record.file(self.report.as_deref(), page).json(self.json.as_deref(), &compared.to_json()).write(console)
    }
}

/// Remarks on the computing time per step of each controller.
fn steps(compared: &Comparison) -> impl Iterator<Item = String> + '_ {
    compared.results.iter().filter(|d| d.tuned.scheme.law.is_some()).filter_map(|d| {
        let attempt = d.attempts.iter().find_map(|attempt| attempt.as_ref().ok())?;
        let [middle, most] = timed(&d.tuned, &attempt.run).map(|time| number(1e6 * time.as_secs_f64()));
        let (name, ts) = (d.name(), round(1e6 * d.tuned.model().ts()));
        Some(format!(
            "{name}: one step of the controller takes {middle} us on this computer (median; 99th percentile \
                      {most} us); the sampling period is {ts} us"
        ))
    })
}

/// Time of a controller step on the measurements of a run: median and 99th percentile.
fn timed(drive: &TunedScheme, run: &ClosedLoopRun) -> [Duration; 2] {
    let controller = drive.controller();
    let mut x = controller.initial();
    let mut took = |t: usize| {
        let now = ControllerInput { y: run.y[t - 1], r: run.r[t - 1], feed_forward: run.u[t], ahead: &run.r[t..] };
        let start = Instant::now();
        black_box(controller.step(&mut x, black_box(&now)));
        start.elapsed()
    };
    let mut times: Vec<Duration> = (1..run.u.len()).map(&mut took).collect();
    times.sort();
    [0.5, 0.99].map(|share| times.get((share * times.len() as f64) as usize).copied().unwrap_or_default())
}

fn tables(compared: &Comparison, console: &Console) -> String {
    let mut parts = vec![tracking(compared, console)];
    parts.extend(margins(compared, console));
    parts.extend(spreads(compared, console));
    parts.join("\n")
}

/// Table of tracking. One reference: all figures of each scheme. Several references: the rms errors.
fn tracking(compared: &Comparison, console: &Console) -> String {
    let unit = compared.unit();
    if let [only] = &compared.references[..] {
        let row = |d: &piezoid::control::SchemeResult| {
            let figures = match &d.attempts[0] {
                Err(_) => vec!["-".to_string(); 5],
                Ok(ReferenceResult { run, tracking: t, .. }) => {
                    [t.percent_of_stroke, t.rms, t.max, t.effort, run.max_abs_voltage()].map(number).to_vec()
                }
            };
            [vec![d.name()], figures].concat()
        };
        let (rms, max) = (format!("rms [{unit}]"), format!("max [{unit}]"));
        let header =
            [&*only.name, "rms [% of p-p of r]", &rms, &max, "rms change of u per sample [V]", "highest |u| [V]"];
        return console.table(&header, compared.results.iter().map(row));
    }
    let row = |(k, reference): (usize, &NamedReference)| {
        let figure =
            |a: &Result<ReferenceResult, _>| a.as_ref().map_or("-".into(), |a| number(a.tracking.percent_of_stroke));
        let cells = compared.results.iter().map(|d| figure(&d.attempts[k]));
        [reference.name.clone()].into_iter().chain(cells).collect()
    };
    let names: Vec<String> = compared.results.iter().map(|d| d.name()).collect();
    let header: Vec<&str> = ["rms error [% of p-p of r]"].into_iter().chain(names.iter().map(String::as_str)).collect();
    console.table(&header, compared.references.iter().enumerate().map(row))
}

fn margins(compared: &Comparison, console: &Console) -> Option<String> {
    let row = |d: &piezoid::control::SchemeResult| {
        let m = d.tuned.margins()?;
        let figures = [m.gain_db, m.phase_deg, m.peak, m.bandwidth_hz].map(number);
        Some([d.name()].into_iter().chain(figures).collect())
    };
    let rows: Vec<Vec<String>> = compared.results.iter().filter_map(row).collect();
    let header = ["loop", "gain margin [dB]", "phase margin [deg]", "peak of |S|", "bandwidth [Hz]"];
    (!rows.is_empty()).then(|| console.table(&header, rows))
}

fn spreads(compared: &Comparison, console: &Console) -> Option<String> {
    let row = |d: &piezoid::control::SchemeResult| {
        let spread = d.spread.as_ref()?;
        let shares = [0.5, 0.9, 1.0].map(|share| number(spread.percent_of_stroke(share)));
        let counted = |_| format!("{} of {}", spread.unstable(), spread.trials.len());
        let unstable = d.tuned.scheme.law.map_or("-".into(), counted);
        Some([d.name()].into_iter().chain(shares).chain([unstable]).collect())
    };
    let rows: Vec<Vec<String>> = compared.results.iter().filter_map(row).collect();
    let header = ["random plants, rms [% of p-p of r]", "median", "90th percentile", "worst", "unstable"];
    (!rows.is_empty()).then(|| console.table(&header, rows))
}
