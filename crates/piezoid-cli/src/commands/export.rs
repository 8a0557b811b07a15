//! `piezoid export`: the model, its inverse and its controller for other machines.

use super::driver::Amplifier;
use crate::compiler;
use crate::console::Console;
use crate::files;
use crate::values::argument;
use anyhow::{Context, Result};
use clap::Args;
use piezoid::compensation::How;
use piezoid::export::{Wanted, target};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  C for a microcontroller, in single precision, its feed-forward within a driver's limits:
    piezoid export --model model.json --target c --float --driver pl140 --name bender -o bender
  An FMU for co-simulation, with a library for this machine where there is a C compiler:
    piezoid export --model model.json --target fmu2 --name bender -o fmus";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "piezoid export --model <FILE> --target <NAME>\n           [OPTIONS] -o <FOLDER>")]
pub(crate) struct Export {
    /// The model file.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// For what (see `piezoid targets`).
    #[arg(long, value_name = "NAME")]
    target: String,
    /// What functions, types and files are called after.
    #[arg(long, value_name = "NAME", default_value = "piezo_model")]
    name: String,
    /// Numbers of single precision.
    #[arg(long)]
    float: bool,
    /// Samples by which the feed-forward may be late, to look as many ahead.
    #[arg(long, value_name = "SAMPLES", default_value_t = 0)]
    late: usize,
    #[command(flatten)]
    amplifier: Amplifier,
    /// The folder to write to; made if it is not there.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

impl Export {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let target = argument(target(&self.target))?;
        let limits = self.amplifier.limits()?.unwrap_or_default();
        let model = files::model(&self.model)?;
        let how = How { limits, ..How::default() };
        let wanted = Wanted {
            single: self.float,
            how,
            late: self.late,
            compiler: compiler::here(),
            ..Wanted::new(&model, &self.name)
        };
        let made = (target.make)(&wanted).with_context(|| self.model.display().to_string())?;
        files::write_all(&self.output, &made.files)?;
        for note in &made.notes {
            console.remark(note);
        }
        Ok(())
    }
}
