//! `piezoid compensate`: the voltage for a requested displacement, by feed-forward.

use super::plant::RecordsOfModel;
use super::prelude::*;
use crate::values::record;
use crate::words::CommandLine;
use piezoid::validation::Metrics;
use piezoid_numerics::number::{round, short as number};
use piezoid_verbs::{CompensateOptions, Compensation};

const EXAMPLES: &str = "\
Examples:
  The voltage for a displacement, within the limits of a driver:
    piezoid compensate r.csv --model model.json --driver pl140 -o u.csv
  Steps smoothed to moves of 20 ms that do not excite the resonance:
    piezoid compensate steps.csv --model model.json --smooth 20ms --zvd -o u.csv
  The error to expect with and without compensation, on a stand-in for the actuator of the model:
    piezoid compensate r.csv --model model.json --plant records -o u.csv
  Response of a twin to this voltage:
    piezoid simulate u.csv --plant pl140 -o y.csv

The reference is the column r_*, or else y_*, in a unit that can be converted to that of the model's output. Before its first sample it is assumed constant at the first value. Errors are those of the model's free run; effects that the model does not contain add to them.";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid compensate <FILE> --model <FILE> [OPTIONS] -o <FILE>")]
pub(crate) struct Compensate {
    /// The model file.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// The requested displacement.
    #[arg(value_name = "FILE", required_unless_present = "reference")]
    file: Option<PathBuf>,
    /// The same as <FILE>.
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    reference: Option<PathBuf>,
    /// Also play the path on this plant, with and without compensation: records is a stand-in, a second model of the
    /// records of the model; a name (see `piezoid plants`) is a twin, a JSON file a twin or a stand-in.
    #[arg(long, value_name = "NAME|FILE|records")]
    plant: Option<String>,
    #[command(flatten)]
    of_model: RecordsOfModel,
    #[command(flatten)]
    options: Flags<CompensateOptions>,
    /// The file to write: CSV, or .npz or .mat by the extension; - is stdout.
    #[arg(short, long, value_name = "FILE", value_parser = record())]
    output: PathBuf,
    /// Write the results as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Compensate {
    fn run(self, console: &Console) -> Result<()> {
        let Some(reference) = self.file.or(self.reference) else {
            bail!("name the file of the requested displacement")
        };
        let is_free = files::check(&[Some(&self.output), self.json.as_deref()], &[&self.model, &reference])?;
        let columns = self.columns.read()?;
        let plant = self.of_model.some_plant(self.plant.as_deref(), Some(&self.model), console)?;
        let plant = plant.as_ref().map(|(name, actuator)| (&**name, actuator));
        let (model, reference) = (files::read(&self.model)?, files::data(&reference)?);
        let result = self.options.0.run(&model, &reference, &columns, plant).map_err(failed)?;
        if is_free {
            console.print(&tables(&result, console))?;
        }
        let on_plant = result.on_plant.iter().flat_map(|played| &played.notes);
        let smoothing = result.smoothing.as_ref().map(|smoothing| smoothing.note(&CommandLine));
        let notes = result.compensated.notes.iter().chain(&smoothing).chain(on_plant);
        console.remarks(notes.chain([&result.proven()]));
        let record = Results::default().record(Some(&self.output), |name| result.written(name))?;
        record.json(self.json.as_deref(), &result.to_json()).write(console)
    }
}

/// Error of the inverse on its own model that is only rounding [% of peak-to-peak].
const ROUNDING: f64 = 1e-6;

/// Tables of the error to expect, and of the peaks of the input with their limits.
fn tables(result: &Compensation, console: &Console) -> String {
    let (unit, (metrics, of_requested)) = (&result.units.y, result.metrics());
    let (rms, max) = (format!("rms [{unit}]"), format!("max [{unit}]"));
    let figures = |name: &str, m: &Metrics| {
        [vec![name.to_string()], [m.rmse, m.max_abs, m.rms_pp_percent].map(number).to_vec()].concat()
    };
    let expected = result.expected_rms().map(|rms| {
        let percent = number(100.0 * rms / metrics.peak_to_peak);
        let name = if result.is_beyond { "expected on the actuator, at least" } else { "expected on the actuator" };
        vec![name.to_string(), number(rms), "-".into(), percent]
    });
    // What the inverse leaves is rounding, unless it is set to clip or to stop early.
    let left = expected.is_none() || metrics.rms_pp_percent > ROUNDING;
    let name = if of_requested.is_some() { "on the model, shaped reference" } else { "on the model" };
    let on_plant = result.on_plant.iter().flat_map(|played| {
        let [gain, compensated] = &played.errors;
        let name = |how: &str| format!("on {}, {how}", played.plant);
        let range = played.spread.map(|spread| spread.map(number));
        let range = range.map(|[low, high]| format!(" ({low} to {high})")).unwrap_or_default();
        let line = played.line.map_or_else(String::new, |line| {
            let ahead = if line.lead > 0.0 { format!(", {} ms ahead", number(1e3 * line.lead)) } else { String::new() };
            format!(" ({} {}/{unit}{ahead})", number(line.gain), result.units.u)
        });
        [figures(&(name("constant gain") + &line), gain), figures(&(name("compensated") + &range), compensated)]
    });
    let rows = on_plant
        .chain(expected)
        .chain(left.then(|| figures(name, &metrics)))
        .chain(of_requested.map(|m| figures("on the model, requested reference", &m)));
    let error = console.table(&["error", &rms, &max, "% of peak-to-peak of r"], rows);
    let input = &result.units.u;
    let row = |peak: &piezoid_records::excitation::Peak| {
        let (quantity, unit) = (peak.quantity.trim_end_matches(" voltage"), peak.unit.replace('V', input));
        let limit = peak.limit.map_or("-".into(), round);
        let share = peak.share.map_or("-".into(), |share| format!("{:.0}", 100.0 * share));
        vec![format!("{quantity} [{unit}]"), number(peak.value), limit, share]
    };
    let peaks = result.compensated.usage.peaks().map(row);
    error + "\n" + &console.table(&["input", "value", "limit", "% of limit"], peaks)
}
