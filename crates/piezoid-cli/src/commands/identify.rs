//! `piezoid identify`: from measured records to a model.

use super::Proven;
use super::driver::driver_limits;
use super::identified::{result, summary};
use crate::console::Console;
use crate::files::{self, Columns, Measured};
use crate::values::{Misused, apart, argument, count, farads, seconds};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use piezoid::Record;
use piezoid::driver::Driver;
use piezoid::hammerstein::{Identified, Joint, Paper, identify_joint, identify_paper};
use piezoid::hysteresis::{Reading, Split};
use piezoid::optimize::swarm::{self, GlobalBest};
use piezoid::validation::{Linearity, Settings, small_signal, validate};
use serde_json::json;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  A small PRBS for the linear block, rising sines for the hysteresis; operator and order are chosen:
    piezoid identify --linear prbs.csv --rich rise1.csv rise20.csv rise80.csv \\
        -o model.json
  What records there are, without their start-up, and one operator:
    piezoid identify --data run1.csv run2.csv --from 1.5 \\
        --operator preisach -o model.json
  The paper's way: two branches a frequency, ARX by swarm:
    piezoid identify --method paper --linear prbs.csv --rich sine5.csv sine20.csv \\
        -o model.json
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
    /// Records that exercise the hysteresis: rising sines, at some frequencies.
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present_any = ["linear", "data"])]
    rich: Vec<PathBuf>,
    /// Records for everything, where no small-signal one was taken.
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["linear", "rich"])]
    data: Vec<PathBuf>,
    /// The way to identify.
    #[arg(long, value_name = "WAY", value_enum, default_value_t = Method::Joint)]
    method: Method,
    /// The hysteresis operator, by name (see `piezoid operators`), or several, separated by commas; auto tries all. The
    /// simplest is taken that foretells held-out parts as well as the best. The paper's way takes its branches.
    #[arg(long, value_name = "NAME", default_value = "auto")]
    operator: String,
    /// Order of the linear block [default: chosen; 2 the paper's way].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=12), allow_negative_numbers = true)]
    order: Option<u8>,
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
    joint: OfJoint,
    #[command(flatten)]
    paper: OfPaper,
    #[command(flatten)]
    columns: Columns,
}

/// What only the joint way knows.
#[derive(Args)]
#[command(next_help_heading = "The joint way")]
struct OfJoint {
    /// Thresholds, levels or knots of the operator [default: its own number].
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    elements: Option<usize>,
    /// Leave creep out.
    #[arg(long)]
    no_creep: bool,
    /// The driver the records were taken with, where its limits matter (see `piezoid drivers`).
    #[arg(long, value_name = "NAME")]
    driver: Option<String>,
    /// Capacitance of the load, for the driver's current limit.
    #[arg(long, value_name = "FARAD", requires = "driver", value_parser = farads)]
    capacitance: Option<f64>,
    /// Time constant of the driver, where it is known.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    driver_lag: Option<f64>,
}

/// What only the paper's way knows.
#[derive(Args)]
#[command(next_help_heading = "The paper's way")]
struct OfPaper {
    /// The estimator of the linear block (see `piezoid estimators`) [default: swarm].
    #[arg(long, value_name = "NAME")]
    estimator: Option<String>,
    /// How the points of a loop are told apart [default: line].
    #[arg(long, value_name = "WAY", value_enum)]
    split: Option<SplitBy>,
    /// Averages on each branch, between the turning points [default: 16].
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    bins: Option<usize>,
    /// Which branch is read while the input is held [default: held].
    #[arg(long, value_name = "RULE", value_enum)]
    reading: Option<Read>,
    /// Particles of the swarm [default: 50].
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    particles: Option<usize>,
    /// Iterations of the swarm [default: 500].
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    iterations: Option<usize>,
    /// The position that draws all particles, g_best of equation (2) [default: ever].
    #[arg(long, value_name = "WHICH", value_enum)]
    global_best: Option<Best>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Method {
    /// All parts together, by the free-run error.
    Joint,
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
    /// The descending one, by the "otherwise" of the paper's rule.
    Printed,
}

#[derive(Clone, Copy, ValueEnum)]
enum Best {
    /// The best that any particle has ever had.
    Ever,
    /// The best of the current positions: equation (4) as printed.
    Current,
}

impl Identify {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let rich_files: Vec<&PathBuf> = self.rich.iter().chain(&self.data).collect();
        let files: Vec<&PathBuf> = self.linear.iter().chain(rich_files.iter().copied()).collect();
        apart(&[Some(&self.output), self.json.as_deref()], &files)?;
        files::ready(&[Some(&self.output), self.json.as_deref()])?;
        if self.operator != "auto" {
            argument(piezoid::hysteresis::operators(&self.operator))?;
        }
        let way = self.way()?;
        let mut origins = Vec::new();
        let mut read = |path: &&PathBuf| {
            let Measured { record, origin } = self.columns.record(path)?;
            origins.push(origin);
            Ok(record)
        };
        let linear: Vec<Record> = self.linear.iter().map(|path| read(&path)).collect::<Result<_>>()?;
        let rich: Vec<Record> = rich_files.iter().map(read).collect::<Result<_>>()?;
        let mut progress = console.progress();
        let found = console.done(match &way {
            Way::Joint(how) => identify_joint(&linear, &rich, how, &mut progress),
            Way::Paper(how) => identify_paper(&linear, &rich, how, &mut progress),
        })?;
        drop(progress);

        let mut made = files::provenance(origins);
        made["seed"] = json!(self.seed);
        // For the report: the model alone does not tell them.
        for (name, known) in [("trials", json!(found.trials)), ("parameters", json!(found.parameters))] {
            if known != json!([]) {
                made[name] = known;
            }
        }
        // The joint way gives each record an offset of its own.
        let settings = Settings { free_offset: self.method == Method::Joint, ..Settings::default() };
        let trained = trained(&found, &rich_files, &rich, settings)?;
        let model = found.model.clone().with_provenance(made);
        if ![Some(self.output.as_path()), self.json.as_deref()].contains(&Some(Path::new("-"))) {
            console.print(&summary(&found, &trained, console))?;
        }
        for note in &found.notes {
            console.remark(note);
        }
        let linearity: Vec<Option<Linearity>> = linear.iter().map(|record| small_signal(record).ok()).collect();
        for (path, seen) in self.linear.iter().zip(&linearity) {
            if let Some(seen) = seen.as_ref().filter(|seen| seen.is_linear != Some(true)) {
                console.remark(&format!("{}: {}", path.display(), seen.verdict));
            }
        }
        let mut result = result(&found, &trained);
        result["linearity"] = json!(linearity);
        files::write_json(self.json.as_deref(), &result, console)?;
        files::write(&self.output, &model.to_json(), console)
    }

    /// The method with its settings; those of the other one are refused.
    fn way(&self) -> Result<Way> {
        let (joint, paper) = (&self.joint, &self.paper);
        let misplaced = |way: &str, given: &[(&str, bool)]| match given.iter().find(|(_, given)| *given) {
            Some((name, _)) => {
                bail!(Misused(format!("{name} belongs to --method {way}: leave it out, or ask for that method")))
            }
            None => Ok(()),
        };
        match self.method {
            Method::Joint => {
                misplaced(
                    "paper",
                    &[
                        ("--estimator", paper.estimator.is_some()),
                        ("--split", paper.split.is_some()),
                        ("--bins", paper.bins.is_some()),
                        ("--reading", paper.reading.is_some()),
                        ("--particles", paper.particles.is_some()),
                        ("--iterations", paper.iterations.is_some()),
                        ("--global-best", paper.global_best.is_some()),
                    ],
                )?;
                Ok(Way::Joint(Joint {
                    operator: self.operator.clone(),
                    order: self.order.map(usize::from),
                    elements: joint.elements,
                    creep: !joint.no_creep,
                    driver: joint.driver()?,
                    seed: self.seed,
                }))
            }
            Method::Paper => {
                misplaced(
                    "joint",
                    &[
                        ("--elements", joint.elements.is_some()),
                        ("--no-creep", joint.no_creep),
                        ("--driver", joint.driver.is_some()),
                        ("--driver-lag", joint.driver_lag.is_some()),
                    ],
                )?;
                let usual = Paper::default();
                let order = self.order.map_or(usual.order, usize::from);
                if order == 0 {
                    bail!(Misused("--order 0: the paper's way needs at least order 1".into()));
                }
                argument(piezoid::linear::estimator(paper.estimator.as_deref().unwrap_or(&usual.estimator)))?;
                Ok(Way::Paper(Paper {
                    order,
                    operator: self.operator.clone(),
                    estimator: paper.estimator.clone().unwrap_or(usual.estimator),
                    split: match paper.split {
                        Some(SplitBy::Direction) => Split::Direction,
                        _ => Split::Line,
                    },
                    bins: paper.bins.unwrap_or(usual.bins),
                    reading: match paper.reading {
                        Some(Read::Printed) => Reading::Printed,
                        _ => Reading::Held,
                    },
                    swarm: swarm::Settings {
                        particles: paper.particles.unwrap_or(usual.swarm.particles),
                        iterations: paper.iterations.unwrap_or(usual.swarm.iterations),
                        global_best: match paper.global_best {
                            Some(Best::Current) => GlobalBest::Current,
                            _ => GlobalBest::Ever,
                        },
                        seed: self.seed,
                        ..usual.swarm
                    },
                }))
            }
        }
    }
}

/// A method with its settings.
enum Way {
    Joint(Joint),
    Paper(Paper),
}

impl OfJoint {
    /// The driver as a block; none where nothing is known of it.
    fn driver(&self) -> Result<Option<Driver>> {
        let Some(name) = &self.driver else {
            return self.driver_lag.map(|lag| argument(Driver::new(lag, None))).transpose();
        };
        let limits = driver_limits(name, self.capacitance)?;
        let by_current = limits.current.zip(limits.capacitance).map(|(current, farads)| current / farads);
        let slew = limits.slew.into_iter().chain(by_current).reduce(f64::min);
        argument(Driver::new(self.driver_lag.unwrap_or(0.0), slew)).map(Some)
    }
}

/// The model's free run over the rich records it was made from.
fn trained(found: &Identified, files: &[&PathBuf], rich: &[Record], settings: Settings) -> Result<Vec<Proven>> {
    let prove = |(path, record): (&&PathBuf, &Record)| {
        let record = record.output_in(&found.model.units().y)?;
        let validation = validate(&found.model, &record, settings)?;
        Ok(Proven { file: path.display().to_string(), record, validation })
    };
    files.iter().zip(rich).map(prove).collect()
}
