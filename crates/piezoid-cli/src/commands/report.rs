//! `piezoid report`: a self-contained page on a model and how it meets records.

use super::validate::Proof;
use crate::console::Console;
use crate::files;
use anyhow::Result;
use clap::Args;
use piezoid::report::{Trial, report};
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct Report {
    #[command(flatten)]
    proof: Proof,
    /// The page to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl Report {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let (model, proven) = self.proof.run()?;
        let trials: Vec<Trial> =
            proven.iter().map(|p| Trial { name: &p.file, record: &p.record, validation: &p.validation }).collect();
        files::write(&self.output, &report(&model, &trials).html(), console)
    }
}
