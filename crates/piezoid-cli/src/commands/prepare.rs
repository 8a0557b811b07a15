//! `piezoid prepare`: a record as it is to be identified, from one as it was measured.

use super::prelude::*;
use crate::values::record;
use piezoid::PrepareOptions;
use piezoid_verbs::{Source, Step};

const EXAMPLES: &str = "\
Examples:
  From 20 kHz to 2 kHz, without single spikes of the sensor:
    piezoid prepare log.csv --outliers --decimate 10 -o record.csv
  One period out of many, with less noise:
    piezoid prepare multisine.csv --from 2 --detrend line --average -o period.csv
  A scope record with a sensor delay of 0.35 ms and an amplifier of gain 20:
    piezoid prepare scope.csv --input-scale 20 --output-scale 5um/V --delay 0.35ms -o record.npz
  A second record at the sampling period of the first:
    piezoid prepare other.tdms --resample 0.5ms -o other.csv

The steps happen in this order: cut (--from, --to), scale, offset, outliers, detrend, average, delay, and decimate or \
resample. Filters have no phase and are the same for input and output. Each step is printed, written into the file, and \
stored in the model that is identified from it.

Signals are kept up to 0.8 of the new Nyquist frequency, and nothing is aliased. Near the ends of a record a filter \
depends on samples outside the record: cut the ends off, or average periods.";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid prepare <FILE> [OPTIONS] -o <FILE>")]
pub(crate) struct Prepare {
    /// The record.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    options: Flags<PrepareOptions>,
    /// The file to write: CSV, or .npz or .mat by the extension; - is stdout.
    #[arg(short, long, value_name = "FILE", value_parser = record())]
    output: PathBuf,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Prepare {
    fn run(self, console: &Console) -> Result<()> {
        files::check(&[Some(&self.output)], &[&self.file])?;
        let (columns, file) = (self.columns.read()?, files::data(&self.file)?);
        let result = Source::new(file, columns, vec![Step::Prepare(self.options.0)]).record().map_err(failed)?;
        console.remarks(result.history());
        Results::default().record(Some(&self.output), |name| result.written(name))?.write(console)
    }
}
