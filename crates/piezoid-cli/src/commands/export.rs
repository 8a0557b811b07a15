//! `piezoid export`: the model, its inverse and its controller for other machines.

use super::driver::Amplifier;
use super::tuning::Tuning;
use crate::compiler;
use crate::console::Console;
use crate::files;
use crate::values::argument;
use anyhow::{Context, Result};
use clap::Args;
use piezoid::Model;
use piezoid::compensation::How;
use piezoid::control::{Drive, Scheme, controller};
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
    /// Samples of the reference that the feed-forward is given ahead of time.
    #[arg(long, value_name = "N", default_value_t = 0)]
    preview: usize,
    #[command(flatten)]
    amplifier: Amplifier,
    /// A controller to go with it, tuned to the model (see `piezoid controllers`).
    #[arg(long, value_name = "NAME")]
    controller: Option<String>,
    #[command(flatten)]
    tuning: Tuning,
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
        let drive = self.controller.as_deref().map(|name| self.tuned(name, &model, how)).transpose()?;
        let controller = drive.as_ref().map(Drive::controller);
        let (single, preview, compiler) = (self.float, self.preview, compiler::here());
        let wanted = Wanted { single, how, preview, controller, compiler, ..Wanted::new(&model, &self.name) };
        let made = (target.make)(&wanted).with_context(|| self.model.display().to_string())?;
        files::write_all(&self.output, &made.files)?;
        for note in &made.notes {
            console.remark(note);
        }
        Ok(())
    }

    /// The controller of this name for the model.
    fn tuned(&self, name: &str, model: &Model, how: How) -> Result<Drive> {
        let scheme = Scheme { law: Some(argument(controller(name))?), ..argument(Scheme::named("gain"))? };
        Drive::new(scheme, model, how, self.tuning.late, &self.tuning.target()).map_err(|e| self.amplifier.advised(e))
    }
}
