//! `piezoid report`: a self-contained page on a model and how well it predicts records.

use super::prelude::*;
use super::validate::ValidationFlags;
use crate::tables::verdict;
use piezoid_report::page::Address;
use piezoid_report::report::report;

const EXAMPLES: &str = "\
Example:
  piezoid report test5.csv test20.csv --model model.json -o report.html";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid report <FILE>... --model <FILE> [OPTIONS] -o <FILE>")]
pub(crate) struct Report {
    #[command(flatten)]
    flags: ValidationFlags,
    /// The page to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Address of the page that has the project open, for a link to it.
    #[arg(long, value_name = "ADDRESS")]
    project: Option<Address>,
}

impl Run for Report {
    fn run(self, console: &Console) -> Result<()> {
        let is_free = files::check(&[Some(&self.output)], &self.flags.inputs())?;
        let (model, validated) = self.flags.run()?;
        let page = report(&model, &validated).of_project(self.project);
        Results::default().file(Some(&self.output), page.html()).write(console)?;
        let verdict = verdict(validated.verdict(&model).as_ref());
        if is_free { console.sentence(&format!("{verdict}; wrote {}", self.output.display())) } else { Ok(()) }
    }
}
