//! `piezoid campaign`: from a controller to a model and a compensated path that was measured.

use super::agreed::agreed;
use super::plant::RecordsOfModel;
use super::prelude::*;
use crate::values::Ended;
use piezoid::Error;
use piezoid_host::files::FileSet;
use piezoid_instruments::{Agenda, Campaign as Found, CampaignOptions, Journal, Track};
use piezoid_numerics::number::{round, short};
use piezoid_verbs::File;

const EXAMPLES: &str = "\
Examples:
  A bender on a controller, up to 40 Hz, within the limits of its amplifier:
    piezoid campaign --host 192.168.0.10 --bandwidth 40 --actuator pl140 --driver pl140 -o bender
  A stack between 0 and 100 V, and the path that it is to follow:
    piezoid campaign path.csv --host 192.168.0.10 --bandwidth 50 --range 0 100 --driver e-610 --capacitance 1.5e-6 \
-o stack
  The same without hardware, with `piezoid instrument` in another terminal:
    piezoid campaign --bandwidth 40 --actuator pl140 --driver pl140 --wait 2 --yes -o rehearsal

  A rehearsal without hardware and without its waits, on a stand-in for your own actuator:
    piezoid campaign --bandwidth 40 --plant records --model model.json --driver pl140 -o rehearsal

The folder gets each drive and record as soon as it is measured, the model, both measured paths (straight.csv, \
compensated.csv), campaign.json, and campaign.html, the page on all of it. If a campaign is broken off, the same command \
measures only what is missing.

The actuator moves over the whole range. Ctrl-C stops the wave generator; the voltage then stays where it is, and is \
shown.";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid campaign [<FILE>] --bandwidth <Hz> [OPTIONS] -o <FOLDER>")]
pub(crate) struct Campaign {
    /// The path to follow, as for `compensate`. Without it, the campaign has one of its own.
    #[arg(value_name = "FILE")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    options: Flags<CampaignOptions>,
    /// Rehearse on this plant, in place of a controller: records is a stand-in, a second model of the records of
    /// --model; a name (see `piezoid plants`) is a twin, a JSON file a twin or a stand-in.
    #[arg(long, value_name = "NAME|FILE|records")]
    plant: Option<String>,
    /// The model of the actuator, for --plant records.
    #[arg(long, value_name = "FILE", requires = "plant")]
    model: Option<PathBuf>,
    #[command(flatten)]
    of_model: RecordsOfModel,
    #[command(flatten)]
    columns: Columns,
    /// Do not ask before the actuator moves.
    #[arg(short, long)]
    yes: bool,
    /// The folder to write to; created if it does not exist.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

impl Run for Campaign {
    fn run(self, console: &Console) -> Result<()> {
        let reference = self.reference.as_deref().map(files::data).transpose()?;
        let (columns, options) = (self.columns.read()?, &self.options.0);
        let (plant, model) = (self.plant.as_deref(), self.model.as_deref());
        plant.map_or(Ok(()), |name| RecordsOfModel::needed(name, model))?;
        let plant = self.of_model.some_plant(plant, model, console)?;
        FileSet::in_folder(&self.output, &[])?;
        let mut folder = Folder { path: self.output, is_agreed: self.yes || plant.is_some(), console };
        let (reference, mut notes) = (reference.as_ref().map(|file| (file, &columns)), Vec::new());
        // Records are kept whatever becomes of the rest.
        let (outcome, is_cancelled) = console.work_on_instrument(|progress| {
            Ok(match &plant {
                Some((name, plant)) => options.rehearse((name, plant), reference, &mut folder, &mut notes, progress),
                None => options.run(reference, &mut folder, &mut notes, progress),
            })
        })?;
        console.remarks(&notes);
        let found = match outcome {
            Err(error @ Error::Cancelled { .. }) => {
                bail!(Ended::Cancelled(format!("{error}: the records so far are in {}", folder.path.display())))
            }
            other => other.map_err(failed)?,
        };
        console.print(&summary(&found, console))?;
        match &found.unfinished {
            Some(unfinished) if is_cancelled => bail!(Ended::Cancelled(unfinished.clone())),
            Some(unfinished) => bail!(unfinished.clone()),
            None => console.sentence(&format!("The page is {}", folder.path.join("campaign.html").display())),
        }
    }
}

/// The errors of both paths, and how good the model is.
fn summary(found: &Found, console: &Console) -> String {
    let unit = &found.compensated.record.units().y;
    let header = ["path", &format!("rms [{unit}]"), "rms/pp %", &format!("largest [{unit}]")];
    let row = |name: &str, Track { metrics: m, .. }: &Track| {
        vec![name.into(), round(m.rmse), short(m.rms_pp_percent), short(m.max_abs)]
    };
    let rows = [row("straight line", &found.straight), row("compensated", &found.compensated)];
    let model = &found.identification.found.model;
    let verdict = crate::tables::verdict(found.validated.verdict(model).as_ref());
    let text =
        format!("The rms error is {} times smaller than with a straight line. {verdict}.", short(found.better()));
    console.table(&header, rows) + &console.paragraph(&text, "")
}

/// The folder of a campaign.
struct Folder<'c> {
    path: PathBuf,
    is_agreed: bool,
    console: &'c Console,
}

impl Journal for Folder<'_> {
    fn agree(&mut self, agenda: &Agenda) -> Result<(), Error> {
        agreed(&agenda.text(), self.is_agreed)
    }

    fn earlier(&self, name: &str) -> Option<File> {
        Some(File::new(name, std::fs::read(self.path.join(name)).ok()?))
    }

    fn keep(&mut self, files: Vec<File>) -> Result<(), Error> {
        let written = FileSet::in_folder(&self.path, &files)
            .map_err(anyhow::Error::from)
            .and_then(|set| Results::of(set).write(self.console));
        written.map_err(|error| Error::Content(format!("{error:#}")))
    }
}
