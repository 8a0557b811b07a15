//! `piezoid export`: the model, its inverse and its controller for other machines.

use super::prelude::*;
use crate::values::Ended::Misused;
use crate::values::apart;
use piezoid::formats::ColumnSelection;
use piezoid_export::ExportOptions;
use piezoid_host::compiler;
use piezoid_host::files::FileSet;

const EXAMPLES: &str = "\
Examples:
  C for a microcontroller, in single precision, its feed-forward within a driver's limits:
    piezoid export --model model.json --target c --float --driver pl140 --name bender -o bender
  An FMU for co-simulation, with a library for this machine where there is a C compiler:
    piezoid export --model model.json --target fmu2 --name bender -o fmus
  One period of a reference as a wave table for amplifiers and controllers:
    piezoid export --model model.json --target waveform --reference r.csv --range -20 130 \\
        --name scan -o scan";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "piezoid export --model <FILE> --target <NAME>\n           [OPTIONS] -o <FOLDER>")]
pub(crate) struct Export {
    /// The model file.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Target language or format (see `piezoid targets`).
    #[arg(long, value_name = "NAME")]
    target: String,
    #[command(flatten)]
    options: Flags<ExportOptions>,
    /// One period of the requested displacement, for the target waveform.
    #[arg(long, value_name = "FILE", help_heading = "Waveforms")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// The folder to write to; created if it does not exist.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Write even if the folder holds another export; files of the same names are replaced.
    #[arg(long)]
    force: bool,
    /// Write files, operations of each function and notes as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Run for Export {
    fn run(self, console: &Console) -> Result<()> {
        let (options, columns) = (self.options.0, self.columns.read()?);
        if self.reference.is_none() && columns != ColumnSelection::default() {
            bail!(Misused("options of data files apply to a reference: give --reference, or leave them out".into()));
        }
        apart(&[self.json.as_deref()], &self.reference.iter().chain([&self.model]).collect::<Vec<_>>())?;
        if self.output == Path::new("-") {
            bail!(Misused("-o must be a folder, because several files are written".into()));
        }
        files::ready(&[self.json.as_deref()])?;
        let file = files::read(&self.model)?;
        let reference = self.reference.as_deref().map(files::data).transpose()?;
        let along = reference.as_ref().map(|file| (file, &columns));
        let result = options.run(&self.target, &file, along, compiler::here()).map_err(failed)?;
        let named = (self.target.as_str(), options.name.as_str());
        let files = FileSet::export(&self.output, named, &result, self.force).map_err(failed)?;
        Results::of(files).json(self.json.as_deref(), &result.to_json()).write(console)?;
        console.remarks(&result.notes);
        Ok(())
    }
}
