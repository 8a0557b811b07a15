//! `piezoid identify`: from measured records to a model.

use crate::console::Console;
use crate::files::{self, Columns, Measured};
use crate::layout::table;
use crate::values::{apart, argument, count};
use anyhow::Result;
use clap::{Args, ValueEnum};
use piezoid::hammerstein::{Identified, Paper, identify_paper};
use piezoid::hysteresis::{Reading, Split};
use piezoid::linear::{Residuals, Root};
use piezoid::number::{round, short as number};
use piezoid::optimize::swarm;
use piezoid::validation::{self, Linearity, Metrics, small_signal};
use piezoid::{Record, System};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  The paper's way: a small PRBS for the linear block, a sine a frequency for the hysteresis:
    piezoid identify --linear prbs.csv --rich sine5.csv sine20.csv -o model.json
  One record and nothing else, without its start-up:
    piezoid identify --data record.csv --from 1.5 --to 20 -o model.json
  Columns of other names, and no time column:
    piezoid identify --data log.csv --ts 0.005 --input-col cmd_V \\
        --output-col pos_um -o model.json";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "\
piezoid identify --linear <FILE>... --rich <FILE>...
           [OPTIONS] -o <FILE>
       piezoid identify --data <FILE>... [OPTIONS] -o <FILE>")]
pub(crate) struct Identify {
    /// Small-signal records for the linear block: a PRBS of about 1 V.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    linear: Vec<PathBuf>,
    /// Records that exercise the hysteresis, one a frequency.
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present_any = ["linear", "data"])]
    rich: Vec<PathBuf>,
    /// Records for everything, where no small-signal one was taken.
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["linear", "rich"])]
    data: Vec<PathBuf>,
    /// The way to identify.
    #[arg(long, value_name = "WAY", value_enum, default_value_t = Method::Paper)]
    method: Method,
    /// The hysteresis operator, by name (see `piezoid operators`); auto is two-branch for one frequency and
    /// rate-scheduled for more.
    #[arg(long, value_name = "NAME", default_value = "auto")]
    operator: String,
    /// Order of the linear block.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=12), allow_negative_numbers = true)]
    order: u8,
    /// The estimator of the linear block (see `piezoid estimators`).
    #[arg(long, value_name = "NAME", default_value = "swarm")]
    estimator: String,
    /// How the points of a loop are told apart.
    #[arg(long, value_name = "WAY", value_enum, default_value_t = SplitBy::Line)]
    split: SplitBy,
    /// Averages on each branch, between the turning points.
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true, default_value_t = Paper::default().bins)]
    bins: usize,
    /// Which branch is read while the input is held.
    #[arg(long, value_name = "RULE", value_enum, default_value_t = Read::Held)]
    reading: Read,
    /// Particles of the swarm.
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true, default_value_t = swarm::Settings::default().particles)]
    particles: usize,
    /// Iterations of the swarm.
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true, default_value_t = swarm::Settings::default().iterations)]
    iterations: usize,
    /// Seed of the swarm.
    #[arg(long, value_name = "N", default_value_t = swarm::Settings::default().seed)]
    seed: u64,
    /// The model file to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write what was found as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

#[derive(Clone, Copy, ValueEnum)]
enum Method {
    /// The paper's six steps.
    Paper,
}

#[derive(Clone, Copy, ValueEnum)]
enum SplitBy {
    /// By the side of the line through the turning points, as in the paper.
    Line,
    /// By the direction of the input.
    Direction,
}

#[derive(Clone, Copy, ValueEnum)]
enum Read {
    /// That of the last movement.
    Held,
    /// The descending one: the paper's rule to the letter.
    Printed,
}

impl Identify {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let Method::Paper = self.method;
        let rich_files: Vec<&PathBuf> = self.rich.iter().chain(&self.data).collect();
        let files: Vec<&PathBuf> = self.linear.iter().chain(rich_files.iter().copied()).collect();
        apart(&[Some(&self.output), self.json.as_deref()], &files)?;
        files::ready(&[Some(&self.output), self.json.as_deref()])?;
        argument(piezoid::linear::estimator(&self.estimator))?;
        if self.operator != "auto" {
            argument(piezoid::hysteresis::operator(&self.operator))?;
        }
        let mut origins = Vec::new();
        let mut read = |path: &&PathBuf| {
            let Measured { record, origin } = self.columns.record(path)?;
            origins.push(origin);
            Ok(record)
        };
        let linear: Vec<Record> = self.linear.iter().map(|path| read(&path)).collect::<Result<_>>()?;
        let rich: Vec<Record> = rich_files.iter().map(read).collect::<Result<_>>()?;
        let how = Paper {
            order: self.order.into(),
            estimator: self.estimator.clone(),
            operator: self.operator.clone(),
            split: match self.split {
                SplitBy::Line => Split::Line,
                SplitBy::Direction => Split::Direction,
            },
            bins: self.bins,
            reading: match self.reading {
                Read::Held => Reading::Held,
                Read::Printed => Reading::Printed,
            },
            swarm: swarm::Settings {
                particles: self.particles,
                iterations: self.iterations,
                seed: self.seed,
                ..swarm::Settings::default()
            },
        };
        let found = console.done(identify_paper(&linear, &rich, &how, &mut console.progress()))?;

        let mut made = files::provenance(origins);
        made["seed"] = json!(self.seed);
        let on_itself = rich
            .iter()
            .map(|record| {
                let record = record.output_in(&found.model.units().y)?;
                Ok(validation::validate(&found.model, &record, validation::Settings::default())?.metrics)
            })
            .collect::<Result<Vec<Metrics>>>()?;
        let model = found.model.clone().with_provenance(made);

        if ![Some(self.output.as_path()), self.json.as_deref()].contains(&Some(Path::new("-"))) {
            console.print(&summary(&found, &rich_files, &on_itself, console))?;
        }
        for note in &found.notes {
            console.remark(note);
        }
        let linearity: Vec<Option<Linearity>> = linear.iter().map(|record| small_signal(record).ok()).collect();
        for (path, seen) in self.linear.iter().zip(&linearity) {
            if let Some(seen) = seen.as_ref().filter(|seen| !seen.is_linear) {
                console.remark(&format!("{}: {}", path.display(), seen.verdict));
            }
        }
        let mut result = result(&found, &on_itself);
        result["linearity"] = json!(linearity);
        files::write_json(self.json.as_deref(), &result, console)?;
        files::write(&self.output, &model.to_json(), console)
    }
}

fn summary(found: &Identified, rich: &[&PathBuf], on_itself: &[Metrics], console: &Console) -> String {
    let (arx, units) = (found.model.linear(), found.model.units());
    let listed = |name: &str, values: Vec<String>| {
        console.paragraph(&format!("  {name:<9} {}", values.join("  ")), "            ")
    };
    let each = |values: &[f64]| values.iter().map(|v| format!("{v:.6}")).collect::<Vec<_>>();
    let form = match arx.a() {
        [] => "a gain without dynamics",
        _ => "y = a1 y1 + ... + b0 u + b1 u1 + ...",
    };
    let mut text = console.paragraph(&format!("Linear block: {form}, every {} s", arx.ts()), "  ");
    if !arx.a().is_empty() {
        text += &listed("a", each(arx.a()));
        text += &listed("b", each(arx.b()));
        text += &listed(
            "poles",
            arx.poles().iter().map(|p| format!("{} Hz (damping {})", number(p.hz), round(p.damping))).collect(),
        );
        text += &listed("zeros", arx.zeros().iter().map(Root::to_string).collect());
    }
    if let Some(fit) = &found.linear.fit {
        let Residuals { rms, max_abs, .. } = fit.residuals;
        let white = if fit.residuals.are_white() { "white" } else { "not white" };
        text += &format!(
            "  errors    {} {} rms, {} at most, one step ahead; {white}\n",
            number(rms),
            units.y,
            number(max_abs)
        );
    }
    text += &format!("  gain      {} {}/{}\n", number(arx.dc_gain()), units.y, units.u);
    text += &format!("  offset    {} {}\n", number(found.model.offset()), units.y);
    if let Some(gain) = arx.noise_gain() {
        text += &format!("  inverse   makes {} {} of 1 {} of noise\n", number(gain), units.u, units.y);
    }
    text += &format!("\nHysteresis block: {}\n", found.model.hysteresis().operator().name);
    if !found.loops.is_empty() {
        let row = |l: &piezoid::hammerstein::HiddenLoop| {
            let (low, high) = l.found.branches.range();
            let side = if l.found.ascending_below { "below" } else { "above" };
            let width = number(100.0 * l.found.branches.width());
            vec![
                l.frequency_hz.map_or("-".into(), round),
                round(low),
                round(high),
                width,
                side.into(),
                round(100.0 * l.found.agreement),
            ]
        };
        let (from, to) = (format!("from [{}]", units.u), format!("to [{}]", units.u));
        let header = ["f [Hz]", &from, &to, "width %", "ascending", "agreement %"];
        text += &table(&header, &found.loops.iter().map(row).collect::<Vec<_>>(), console.room());
    }
    if !on_itself.is_empty() {
        let row = |(path, m): (&&PathBuf, &Metrics)| {
            vec![path.display().to_string(), number(m.rmse), number(m.nrmse_percent), number(m.rms_pp_percent)]
        };
        let rmse = format!("rmse [{}]", units.y);
        let rows: Vec<_> = rich.iter().zip(on_itself).map(row).collect();
        let header = ["its own data", &rmse, "nrmse %", "rms/pp %"];
        text += &format!("\nFree run\n{}", table(&header, &rows, console.room()));
    }
    text
}

fn result(found: &Identified, on_itself: &[Metrics]) -> Value {
    let arx = found.model.linear();
    let each = |l: &piezoid::hammerstein::HiddenLoop| {
        json!({
            "frequency_hz": l.frequency_hz,
            "loop_width_percent": 100.0 * l.found.branches.width(),
            "ascending_below": l.found.ascending_below,
            "agreement": l.found.agreement,
        })
    };
    json!({
        "linear": {
            "a": arx.a(),
            "b": arx.b(),
            "poles": arx.poles(),
            "zeros": arx.zeros(),
            "noise_gain": arx.noise_gain(),
            "reason": found.linear.reason,
            "residuals": found.linear.fit.as_ref().map(|f| f.residuals),
            "offsets": found.linear.fit.as_ref().map(|f| &f.offsets),
            "convergence": found.linear.fit.as_ref().map(|f| &f.history),
        },
        "operator": found.model.hysteresis().operator().name,
        "loops": found.loops.iter().map(each).collect::<Vec<_>>(),
        "training": on_itself,
        "notes": found.notes,
    })
}
