//! `piezoid plan`: the drives that identify an actuator, and a page on them.

use super::plant::RecordsOfModel;
use super::prelude::*;
use crate::values::Ended::Misused;
use piezoid_host::files::FileSet;
use piezoid_numerics::number::round;
use piezoid_verbs::PlanOptions;

const EXAMPLES: &str = "\
Examples:
  A stack that is to follow paths up to 50 Hz between 0 and 120 V:
    piezoid plan --range 0 120 --bandwidth 50 --driver e-610 --capacitance 1.5uF -o plan
  A known actuator, over its whole range:
    piezoid plan --actuator pl140 --bandwidth 80 --driver pl140 -o plan
  Which record would improve a first model most:
    piezoid plan --actuator pl140 --bandwidth 80 --driver pl140 --model model.json -o next
  What the drives do to an actuator that earlier records are of:
    piezoid plan --bandwidth 80 --model model.json --plant records -o next

Files: small_u.csv (small signal), rise1_u.csv to rise3_u.csv (rising sines), creep_u.csv (held steps), path_u.csv \
(random path, for validation only), and plan.md: why each is measured, its figures, and the commands to run afterwards. \
All start and end at the middle of the range, and use at most 90 % of slew and current.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(
    override_usage = "piezoid plan --range <LOW> <HIGH> --bandwidth <Hz> --driver <NAME>\n           [OPTIONS] -o <FOLDER>"
)]
pub(crate) struct Plan {
    #[command(flatten)]
    options: Flags<PlanOptions>,
    /// A first model: the plan has its sampling period, and says which record would lower its error of prediction most,
    /// and by how much.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Also play the drives on this plant: records is a stand-in, a second model of the records of --model; a name
    /// (see `piezoid plants`) is a twin, a JSON file a twin or a stand-in.
    #[arg(long, value_name = "NAME|FILE|records")]
    plant: Option<String>,
    #[command(flatten)]
    of_model: RecordsOfModel,
    /// The folder to write to; created if it does not exist.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Write drives, use of the limits, notes and advice as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Run for Plan {
    fn run(self, console: &Console) -> Result<()> {
        if self.output == Path::new("-") {
            bail!(Misused("-o must be a folder, because several files are written".into()));
        }
        let is_free = files::check(&[self.json.as_deref()], &self.model.iter().collect::<Vec<_>>())?;
        let model = self.model.as_deref().map(|path| files::read(path)?.model().map_err(failed)).transpose()?;
        let plant = self.of_model.some_plant(self.plant.as_deref(), self.model.as_deref(), console)?;
        let (options, model) = (&self.options.0, model.as_ref());
        let plan = match &plant {
            Some((name, plant)) => options.rehearsed(model, (name, plant)),
            None => options.run(model),
        };
        let plan = plan.map_err(failed)?;
        let files = FileSet::in_folder(&self.output, &plan.files().map_err(failed)?)?;
        Results::of(files).json(self.json.as_deref(), &plan.to_json()).write(console)?;
        console.remarks(&plan.notes);
        if !is_free {
            return Ok(());
        }
        let row = |drive: &piezoid_verbs::PlannedDrive| {
            let [low, high] = [&drive.usage.lowest, &drive.usage.highest].map(|peak| round(peak.value));
            let percent = drive.percent().map_or("-".into(), |percent| format!("{percent:.0}"));
            vec![drive.file(), drive.purpose.into(), round(plan.duration(drive)), format!("{low} to {high}"), percent]
        };
        let header = ["drive", "purpose", "duration [s]", "voltage [V]", "% of limits"];
        let mut text = console.table(&header, plan.drives.iter().map(row));
        if let Some(rehearsal) = &plan.rehearsal {
            let header = ["drive".to_string()].into_iter().chain(rehearsal.header()).collect::<Vec<_>>();
            let row = |drive: &piezoid_verbs::RehearsedDrive| {
                [format!("{}_u.csv", drive.name)].into_iter().chain(rehearsal.cells(drive)).collect()
            };
            let header: Vec<&str> = header.iter().map(String::as_str).collect();
            text += &format!("\n{}", console.table(&header, rehearsal.drives.iter().map(row)));
            text += &console.paragraph(&rehearsal.text(), "");
        }
        let folder = self.output.display();
        let next = format!(
            "Next: measure each drive in this order, every {} s, as small.csv, rise1.csv and so on; {folder}/plan.md \
             says how, and what to run then.",
            plan.ts
        );
        text += &console.paragraph(&next, "");
        if let Some(advice) = &plan.advice {
            text += &console.paragraph(advice, "");
        }
        console.print(&text)
    }
}
