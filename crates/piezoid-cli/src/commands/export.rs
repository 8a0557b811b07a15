//! `piezoid export`: the model, its inverse and its controller for other machines.

use super::driver::Amplifier;
use super::tuning::Tuning;
use crate::console::Console;
use crate::files::{self, Columns};
use crate::values::{Misused, argument, period};
use anyhow::{Error, Result, anyhow, bail};
use clap::Args;
use piezoid::Model;
use piezoid::compensation::How;
use piezoid::control::{Drive, Law, Scheme};
use piezoid_export::{Playback, TARGETS, Target, Wanted, target};
use piezoid_host::{compiler, files as host};
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  C for a microcontroller, in single precision, its feed-forward within a driver's limits:
    piezoid export --model model.json --target c --float --driver pl140 --name bender -o bender
  An FMU for co-simulation, with a library for this machine where there is a C compiler:
    piezoid export --model model.json --target fmu2 --name bender -o fmus
  One period of a path as a wave table for controllers:
    piezoid export --model model.json --target waveform --reference r.csv --range -20 130 \\
        --name scan -o scan";

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
    /// A controller to go with it, tuned to the model: any of `piezoid controllers` that has a law, so not predictive.
    #[arg(long, value_name = "NAME")]
    controller: Option<String>,
    #[command(flatten)]
    tuning: Tuning,
    /// One period of the wanted displacement, for the target waveform.
    #[arg(long, value_name = "FILE")]
    #[arg(help_heading = "Waveforms")]
    reference: Option<PathBuf>,
    /// Come as close to it as the limits allow instead of refusing.
    #[arg(long, requires = "reference")]
    #[arg(help_heading = "Waveforms")]
    clip: bool,
    /// Servo cycle of the GCS controller [default: 5e-5].
    #[arg(long, value_name = "SECONDS", requires = "reference", value_parser = period, allow_negative_numbers = true)]
    #[arg(help_heading = "Waveforms")]
    servo_cycle: Option<f64>,
    /// The voltages that are 0 % and 100 % for the NV200 amplifier: what it answers to avmin and avmax.
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"], requires = "reference", allow_negative_numbers = true)]
    #[arg(help_heading = "Waveforms")]
    range: Option<Vec<f64>>,
    #[command(flatten)]
    columns: Columns,
    /// The folder to write to; made if it is not there.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

/// Settings of the library that are options here, under the same name.
const OPTIONS: [&str; 3] = ["name", "preview", "range"];

impl Export {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let target = argument(target(&self.target))?;
        self.fits(target)?;
        let limits = self.amplifier.limits()?.unwrap_or_default();
        let model = files::model(&self.model)?;
        let how = How { limits, clip: self.clip, ..How::default() };
        let reference = self.reference.as_deref().map(|path| self.columns.reference(path, &model)).transpose()?;
        let drive = self.controller.as_deref().map(|name| self.tuned(name, &model, how)).transpose()?;
        let controller = drive.as_ref().map(Drive::controller);
        let (single, preview, compiler) = (self.float, self.preview, compiler::here());
        let (reference, playback) = (reference.as_deref(), self.playback());
        let wanted = Wanted {
            single,
            how,
            preview,
            controller,
            compiler,
            reference,
            playback,
            ..Wanted::new(&model, &self.name)
        };
        let made = (target.make)(&wanted).map_err(|e| self.blamed(e))?;
        host::write_all(&self.output, &made.files)?;
        for note in &made.notes {
            console.remark(note);
        }
        Ok(())
    }

    /// Refuses options that would count for nothing.
    fn fits(&self, target: &Target) -> Result<()> {
        let given = [
            ("float", self.float),
            ("preview", self.preview > 0),
            ("controller", self.controller.is_some()),
            ("reference", self.reference.is_some()),
        ];
        let heeded = |option: &str| target.heeds.contains(&option);
        let (name, in_vain) = (target.name, given.iter().find(|(option, given)| *given && !heeded(option)));
        let wrong = if let Some((option, _)) = in_vain {
            let others = TARGETS.iter().filter(|t| t.heeds.contains(option)).map(|t| t.name);
            format!("--{option} is not for --target {name}, but for {}", others.collect::<Vec<_>>().join(", "))
        } else if heeded("reference") && self.reference.is_none() {
            format!("--target {name} is a table for a --reference: name its file")
        } else if self.controller.is_none() && self.tuning.any() {
            "--late, --gain-margin and --phase-margin are what a --controller is tuned to: name one".into()
        } else if self.reference.is_none() && self.columns.any() {
            "options of data files are for a --reference".into()
        } else if self.output == Path::new("-") {
            "-o names a folder: what is written is several files".into()
        } else {
            return Ok(());
        };
        bail!(Misused(wrong))
    }

    /// What an error is about: an option, or a file. Of a drive it is the reference that asks too much.
    fn blamed(&self, error: piezoid::Error) -> Error {
        match &error {
            piezoid::Error::Parameter { name, value, rule } if OPTIONS.contains(&name.as_str()) => {
                anyhow!(Misused(format!("--{name} {value}: {rule}")))
            }
            _ => {
                let file = self.reference.as_ref().unwrap_or(&self.model).display().to_string();
                self.amplifier.advised(error).context(file)
            }
        }
    }

    /// How controllers play a table.
    fn playback(&self) -> Playback {
        let Playback { servo_cycle, .. } = Playback::default();
        let range = self.range.as_deref().and_then(|range| Some((*range.first()?, *range.last()?)));
        Playback { servo_cycle: self.servo_cycle.unwrap_or(servo_cycle), range }
    }

    /// The controller of this name for the model.
    fn tuned(&self, name: &str, model: &Model, how: How) -> Result<Drive> {
        let law = argument(Law::find(name))?;
        // What takes no feed-forward plans for itself.
        if !law.fed {
            bail!(Misused(format!("--controller {name} plans anew in every sample, which is no law to export")));
        }
        let scheme = Scheme { law: Some(law), ..argument(Scheme::named("gain"))? };
        Drive::new(scheme, model, how, self.tuning.late, &self.tuning.target()).map_err(|e| self.amplifier.advised(e))
    }
}
