//! `piezoid validate`: free runs of a model against validation records.

use super::prelude::*;
use crate::tables;
use piezoid::validation::ValidateOptions;
use piezoid::{Error, Model};
use piezoid_verbs::{Source, ValidateRecords, Validated};

const EXAMPLES: &str = "\
Examples:
  Records the model has not seen, without their first half second:
    piezoid validate test5.csv test20.csv --model model.json --skip 0.5
  The second half of a record whose sensor drifts, as JSON:
    piezoid validate record.csv --model model.json --from 20 --offset drift --json -

The model runs free: it sees only the input, and starts from the initial condition that fits the record best. \
nrmse % is 100 rmse / standard deviation of y, noise % the part of it that is noise, rms/pp % is 100 rmse / peak-to-peak of y, fit % is 100 - nrmse %.

The errors by frequency and by amplitude are computed from the cycles of the input, over all files; if the input has no cycles, from spectra, in third-octave bands. Their noise % has the bandwidth of their error. The noise floor is the scatter of y between repetitions of the same input or, if the input does not repeat, the level of the spectrum where the input does not drive y. A better model can remove the part of the error that is neither noise nor drift. The squares of the parts add up. The drift is the slope of the error over time, also if --offset drift removes it. The table of residuals ends with the correlation of each residual with the one before, and the largest correlation with the input. Both are near 0 if only noise is left.";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid validate <FILE>... --model <FILE> [OPTIONS]")]
pub(crate) struct Validate {
    #[command(flatten)]
    flags: ValidationFlags,
    /// Show the errors by frequency and amplitude, the loops and the residuals.
    #[arg(short, long)]
    verbose: bool,
    /// Show all bands and all loops, and the results of the residual tests in words.
    #[arg(long)]
    full: bool,
    /// Write the results as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// A model, records, and how to compare them.
#[derive(Args)]
pub(crate) struct ValidationFlags {
    /// The model file.
    #[arg(long, value_name = "FILE")]
    pub(crate) model: PathBuf,
    /// The records to compare with.
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    options: Flags<ValidateOptions>,
    #[command(flatten)]
    columns: Columns,
}

impl ValidationFlags {
    /// The input files.
    pub(crate) fn inputs(&self) -> Vec<&PathBuf> {
        self.files.iter().chain([&self.model]).collect()
    }

    /// The free runs with their records, all samples held.
    pub(crate) fn run(&self) -> Result<(Model, Validated)> {
        self.with(|options, model, data| options.run(model, data))
    }

    fn with(
        &self,
        run: impl FnOnce(&ValidateOptions, &Model, Vec<Source>) -> std::result::Result<Validated, Error>,
    ) -> Result<(Model, Validated)> {
        let (model, data) = (files::read(&self.model)?.model().map_err(failed)?, files::all(&self.files, files::data)?);
        let data = Source::all(data, &self.columns.read()?);
        let validated = run(&self.options.0, &model, data).map_err(failed)?;
        Ok((model, validated))
    }
}

impl Run for Validate {
    fn run(self, console: &Console) -> Result<()> {
        let is_free = files::check(&[self.json.as_deref()], &self.flags.inputs())?;
        let (model, validated) = self.flags.with(|options, model, data| options.in_pieces(model, data))?;
        if is_free {
            console.print(&match self.full || self.verbose {
                true => tables::all(&validated, self.full, console),
                false => tables::brief(&validated, console),
            })?;
        }
        for compared in &validated.files {
            let remarks = compared.record.history().iter().chain(&compared.validation.remarks);
            console.remarks(remarks.map(|remark| format!("{}: {remark}", compared.name)));
        }
        Results::default().json(self.json.as_deref(), &validated.to_json()).write(console)?;
        let verdict = tables::verdict(validated.verdict(&model).as_ref());
        if !is_free {
            return Ok(());
        }
        console.sentence(&verdict)?;
        let mut advised = validated.files.iter().filter_map(|c| Some((c.short(), c.validation.advice.as_ref()?)));
        advised.try_for_each(|(name, advice)| console.sentence(&format!("{name}: {advice}")))
    }
}
