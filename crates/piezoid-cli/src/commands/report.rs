//! `piezoid report`: a self-contained page on a model and how well it predicts records.

use super::validate::ValidationFlags;
use crate::console::Console;
use crate::files;
use crate::values::apart;
use anyhow::Result;
use clap::Args;
use piezoid_report::report::report;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Example:
  piezoid report --model model.json --data test5.csv test20.csv -o report.html";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "piezoid report --model <FILE> --data <FILE>...\n           [OPTIONS] -o <FILE>")]
pub(crate) struct Report {
    #[command(flatten)]
    flags: ValidationFlags,
    /// The page to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl Report {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        apart(&[Some(&self.output)], &self.flags.inputs())?;
        files::ready(&[Some(&self.output)])?;
        let (model, validated) = self.flags.run()?;
        files::write(&self.output, &report(&model, &validated).html(), console)
    }
}
