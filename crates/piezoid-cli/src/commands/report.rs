//! `piezoid report`: a self-contained page on a model and how well it predicts records.

use super::Run;
use super::validate::ValidationFlags;
use crate::console::Console;
use crate::files::{self, Results};
use crate::layout::capitalised;
use crate::tables::verdict;
use crate::values::apart;
use anyhow::Result;
use clap::Args;
use piezoid_report::report::report;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Example:
  piezoid report test5.csv test20.csv --model model.json -o report.html";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "piezoid report <FILE>... --model <FILE> [OPTIONS] -o <FILE>")]
pub(crate) struct Report {
    #[command(flatten)]
    flags: ValidationFlags,
    /// The page to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl Run for Report {
    fn run(self, console: &Console) -> Result<()> {
        apart(&[Some(&self.output)], &self.flags.inputs())?;
        files::ready(&[Some(&self.output)])?;
        let (model, validated) = self.flags.run()?;
        Results::default().file(Some(&self.output), report(&model, &validated).html()).write(console)?;
        if self.output == Path::new("-") {
            return Ok(());
        }
        let text = capitalised(&verdict(validated.verdict(&model).as_ref()));
        console.print(&console.paragraph(&format!("{text}; wrote {}.", self.output.display()), ""))
    }
}
