//! `piezoid simulate`: a plant or a model on a drive signal.

use super::lists;
use crate::console::Console;
use crate::files::{self, Columns};
use crate::values::apart;
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use piezoid::hammerstein::InitialCondition;
use piezoid::plant::Plant;
use piezoid::{Record, System};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  What the paper's actuator answers to a drive signal:
    piezoid simulate --plant paper --input sine20.csv -o answer.csv
  What a model says it answers:
    piezoid simulate --model model.json --input sine20.csv -o predicted.csv
  An actuator of your own:
    piezoid plants --show pl140 > mine.json
    piezoid simulate --plant mine.json --input sine20.csv -o answer.csv";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(
    override_usage = "piezoid simulate (--plant <NAME|FILE> | --model <FILE>)\n           --input <FILE> [OPTIONS] -o <FILE>"
)]
#[group(id = "system", required = true, multiple = false, args = ["plant", "model"])]
pub(crate) struct Simulate {
    /// A plant by name (see `piezoid plants`), or a JSON file of its parameters.
    #[arg(long, value_name = "NAME|FILE")]
    plant: Option<String>,
    /// A model file.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// The drive signal.
    #[arg(long, value_name = "FILE")]
    input: PathBuf,
    /// The file to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// What came before: rest; the first input, which had stood for long; or the same as in the record.
    #[arg(long, value_enum, value_name = "HOW", default_value_t = Begin::Rest)]
    begin: Begin,
    /// The same as --begin settled.
    #[arg(long, conflicts_with = "begin")]
    settled: bool,
    /// Seed of the plant's noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    columns: Columns,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Begin {
    /// Rest, and a jump to the first input.
    Rest,
    /// The first input, which had stood for long.
    Settled,
    /// The same as in the record.
    Motion,
}

impl Simulate {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        apart(&[Some(&self.output)], &[&self.input])?;
        files::ready(&[Some(&self.output)])?;
        let input = self.columns.input(&self.input)?;
        let (u, ts) = (&input.samples, input.ts);
        let begin = if self.settled { Begin::Settled } else { self.begin };
        let (y, u_unit, y_unit) = match (&self.plant, &self.model) {
            (Some(plant), _) => {
                let plant = Plant::new(&lists::plant(plant)?, ts)?.with_seed(self.seed);
                let mut x = if begin == Begin::Rest { plant.initial() } else { plant.settled(u[0]) };
                if begin == Begin::Motion {
                    plant.resume(&mut x, u);
                }
                let y: Vec<f64> = plant.resume(&mut x, u).iter().map(|y| y * 1e6).collect();
                let saturation = plant.saturation(&x);
                if saturation.any() {
                    console.remark(&saturation.to_string());
                }
                (y, "V".to_string(), "um".to_string())
            }
            (_, Some(path)) => {
                let model = files::model(path)?;
                let units = model.units();
                if input.unit != units.u {
                    let (name, found) = (self.input.display(), &input.unit);
                    bail!("{name}: the input is in {found} but the model takes {}: convert it beforehand", units.u);
                }
                Record::same_sampling("the model", model.ts(), "the input", ts)
                    .with_context(|| self.input.display().to_string())?;
                let beginning = match begin {
                    Begin::Rest => InitialCondition::Rest,
                    Begin::Settled => InitialCondition::Settled,
                    Begin::Motion => InitialCondition::Motion,
                };
                let mut x = model.before(u, beginning);
                (model.resume(&mut x, u), units.u.clone(), units.y.clone())
            }
            _ => bail!("name a --plant or a --model"),
        };
        if let Some(k) = y.iter().position(|y| !y.is_finite()) {
            let time = k as f64 * ts;
            bail!("the answer grows beyond all numbers at {time} s: the model is unstable, or the input far too large");
        }
        let (u_name, y_name) = (format!("u_{u_unit}"), format!("y_{y_unit}"));
        files::write(&self.output, &piezoid::formats::Table::write(ts, &[(&u_name, u), (&y_name, &y)])?, console)
    }
}
