//! `piezoid simulate`: the response of a plant or a model to a drive signal.

use super::lists;
use super::prelude::*;
use crate::values::record;
use piezoid::formats::Table;
use piezoid::hammerstein::InitialCondition;
use piezoid_host::files::write_in_pieces;
use piezoid_verbs::{SimulateOptions, Subject};
use std::io::Write;

const EXAMPLES: &str = "\
Examples:
  Response of the paper's actuator to a drive signal:
    piezoid simulate sine20.csv --plant paper -o answer.csv
  Free run of a model on the same signal:
    piezoid simulate sine20.csv --model model.json -o simulated.csv
  An actuator of your own:
    piezoid plants --show pl140 > mine.json
    piezoid simulate sine20.csv --plant mine.json -o answer.csv";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(
    override_usage = "piezoid simulate <FILE> (--plant <NAME|FILE> | --model <FILE>)\n           [OPTIONS] -o <FILE>"
)]
#[group(id = "system", required = true, multiple = false, args = ["plant", "model"])]
pub(crate) struct Simulate {
    /// A plant by name (see `piezoid plants`), or a JSON file: the parameters of a twin, or what `piezoid stand-in`
    /// wrote.
    #[arg(long, value_name = "NAME|FILE")]
    plant: Option<String>,
    /// A model file.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// The drive signal.
    #[arg(value_name = "FILE", required_unless_present = "input")]
    file: Option<PathBuf>,
    /// The same as <FILE>.
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    input: Option<PathBuf>,
    /// The file to write: CSV, or .npz or .mat by the extension; - is stdout.
    #[arg(short, long, value_name = "FILE", value_parser = record())]
    output: PathBuf,
    #[command(flatten)]
    options: Flags<SimulateOptions>,
    /// The same as --begin settled.
    #[arg(long, conflicts_with = "begin")]
    settled: bool,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Simulate {
    fn run(self, console: &Console) -> Result<()> {
        let Some(input) = self.file.or(self.input) else { bail!("name the file of the drive signal") };
        files::check(&[Some(&self.output)], &[&input])?;
        let (mut options, columns) = (self.options.0, &self.columns.read()?);
        if self.settled {
            options.begin = InitialCondition::Settled;
        }
        let input = files::data(&input)?;
        let subject = match (&self.plant, &self.model) {
            (Some(plant), _) => Subject::Plant(lists::plant(plant)?),
            (_, Some(model)) => Subject::Model(Box::new(files::read(model)?.model().map_err(failed)?)),
            _ => bail!("name a --plant or a --model"),
        };
        let name = self.output.display().to_string();
        let reached = if files::is_stream(&self.output) || !Table::is_text(&name) {
            let result = options.run(&subject, &input, columns).map_err(failed)?;
            Results::default().record(Some(&self.output), |name| result.written(name))?.write(console)?;
            result.reached
        } else {
            let write = |to: &mut dyn Write| options.write(&subject, (&input, columns), (&name, to));
            write_in_pieces(&self.output, write).map_err(failed)?
        };
        console.remarks(Some(&reached).filter(|text| !text.is_empty()));
        Ok(())
    }
}
