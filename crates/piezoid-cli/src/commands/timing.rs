//! `piezoid timing`: settling, overshoot and scan lag along a path, and the fastest moves.

use super::agreed::agreed;
use super::plant::RecordsOfModel;
use super::prelude::*;
use crate::values::{Ended, apart, record};
use crate::words::flag;
use piezoid::control::SimulatedActuator;
use piezoid::formats::ColumnSelection;
use piezoid_instruments::{InstrumentOptions, MeasuredTiming, MeasuredTimingOptions};
use piezoid_numerics::number::short as number;
use piezoid_numerics::options::Options;
use piezoid_verbs::{FastestMove, Players, RunTiming, ScanLag, StepTiming, Timing, TimingOptions};
use serde_json::Value;

const EXAMPLES: &str = "\
Examples:
  A step of a tenth of the stroke, and the fastest moves within the limits of a driver:
    piezoid timing --model model.json --tolerance 0.1um --driver pl140
  Every step of a path smoothed to moves of 10 ms, on the model and on a plant:
    piezoid timing --model model.json --path steps.csv --tolerance 0.5um --smooth 10ms --plant pl140
  What a controller measured along a path:
    piezoid timing --model model.json --path scan.csv --tolerance 50nm --measured measured.csv
  On a controller itself, within the limits of its amplifier; the actuator moves:
    piezoid timing --model model.json --path steps.csv --tolerance 0.5um --smooth 10ms --driver pl140 --controller \
--host 192.168.0.10

Settling is the time from the first sample of a step until the error stays within the tolerance, overshoot the largest error beyond the goal, lag the delay that leaves the least rms error along a periodic path. The path is clipped to the limits. Plants are read without the noise of their sensor. A controller is demagnetised before each voltage, and the displacement at rest is set to that of the model. Ctrl-C stops its wave generator; the voltage then stays where it is, and is shown.";

/// Largest number of steps in the table.
const SHOWN: usize = 8;

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid timing --model <FILE> [OPTIONS]")]
pub(crate) struct TimingCall {
    /// The model file.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// The requested displacement [default: a step up and down].
    #[arg(long, value_name = "FILE")]
    path: Option<PathBuf>,
    /// The displacement that was measured along the path, such as by `piezoid acquire`.
    #[arg(long, value_name = "FILE", requires = "path")]
    measured: Option<PathBuf>,
    /// Also play the path on this plant: records is a stand-in, a second model of the records of the model; a name (see
    /// `piezoid plants`) is a twin, a JSON file a twin or a stand-in.
    #[arg(long, value_name = "NAME|FILE|records")]
    plant: Option<String>,
    #[command(flatten)]
    of_model: RecordsOfModel,
    /// Also play both voltages on a controller, which `acquire` describes. The actuator moves.
    #[arg(long, conflicts_with = "measured")]
    controller: bool,
    /// Do not ask before the actuator moves.
    #[arg(short, long, requires = "controller")]
    yes: bool,
    #[command(flatten)]
    options: Flags<MeasuredTimingOptions>,
    /// Write path, voltage and displacements: CSV, or .npz or .mat by the extension; - is stdout.
    #[arg(short, long, value_name = "FILE", value_parser = record())]
    output: Option<PathBuf>,
    /// Write the results as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Run for TimingCall {
    fn run(self, console: &Console) -> Result<()> {
        let results = [self.output.as_deref(), self.json.as_deref()];
        let inputs: Vec<&PathBuf> = [&self.model].into_iter().chain(&self.path).chain(&self.measured).collect();
        apart(&results, &inputs)?;
        files::ready(&results)?;
        let columns = self.columns.read()?;
        let plant = self.of_model.some_plant(self.plant.as_deref(), Some(&self.model), console)?;
        let plant = plant.as_ref().map(|(name, actuator)| (&**name, actuator));
        if self.controller {
            return self.on_controller(plant, &columns, console);
        }
        let options = self.options.0.clone();
        apart_from_controllers(&options)?;
        let options = TimingOptions { moves: options.moves, limits: options.instrument.limits };
        let model = files::read(&self.model)?;
        let path = self.path.as_deref().map(files::data).transpose()?;
        let measured = self.measured.as_deref().map(files::data).transpose()?;
        let data = (path.as_ref(), measured.as_ref());
        let result = console.work(|progress| options.run(&model, data, plant, &columns, progress))?;
        self.show(&result, &result.to_json(), console)
    }
}

/// Returns an error if options of a controller are named, but no controller is meant.
fn apart_from_controllers(options: &MeasuredTimingOptions) -> Result<()> {
    let instrument = InstrumentOptions { limits: Default::default(), ..options.instrument.clone() };
    let alone = MeasuredTimingOptions { moves: Default::default(), instrument, ..options.clone() };
    match alone.changed().first() {
        Some((row, _)) => {
            let name = flag(row.name);
            bail!(Ended::Misused(format!("--{name} has no effect without --controller")))
        }
        None => Ok(()),
    }
}

impl TimingCall {
    fn on_controller(
        &self,
        plant: Option<(&str, &SimulatedActuator)>,
        columns: &ColumnSelection,
        console: &Console,
    ) -> Result<()> {
        let model = files::read(&self.model)?.model().map_err(failed)?;
        let path = self.path.as_deref().map(files::data).transpose()?;
        let path = path.map(|path| path.reference(columns, &model)).transpose().map_err(failed)?;
        let (players, mut notes) = (Players { plant, measured: None }, Vec::new());
        let mut agree = |text: &str| agreed(text, self.yes);
        let outcome = console.work_on_instrument(|progress| {
            let outcome = self.options.0.run((&model, path), &players, &mut agree, &mut notes, progress);
            Ok((outcome, std::mem::take(&mut notes)))
        });
        let ((outcome, notes), is_cancelled) = outcome?;
        let found: MeasuredTiming = match outcome {
            Ok(found) => found,
            Err(error) => {
                console.remarks(&notes);
                match error {
                    piezoid::Error::Cancelled { .. } => {
                        bail!(Ended::Cancelled(format!("{error}: nothing was written")))
                    }
                    other => return Err(failed(other)),
                }
            }
        };
        let shown = self.show(&found.timing, &found.to_json(), console);
        let Some(unfinished) = &found.unfinished else {
            // Where the axis is does not depend on what could be written.
            if shown.is_err() || self.is_piped() {
                console.remark(&found.state());
                return shown;
            }
            return console.sentence(&found.state());
        };
        if let Err(error) = shown {
            console.remark(&format!("{error:#}"));
        }
        if is_cancelled { bail!(Ended::Cancelled(unfinished.clone())) } else { bail!(unfinished.clone()) }
    }

    fn show(&self, timing: &Timing, document: &Value, console: &Console) -> Result<()> {
        if !self.is_piped() {
            console.print(&tables(timing, console))?;
        }
        console.remarks(timing.notes.iter().chain([&timing.proven()]));
        let record = Results::default().record(self.output.as_deref(), |name| timing.written(name))?;
        record.json(self.json.as_deref(), document).write(console)
    }

    /// True if a result goes to stdout, where nothing else may be then.
    fn is_piped(&self) -> bool {
        [&self.output, &self.json].into_iter().flatten().any(|path| files::is_stream(path))
    }
}

/// A time in milliseconds, or a dash.
fn ms(seconds: Option<f64>) -> String {
    seconds.map_or("-".into(), |seconds| number(1e3 * seconds))
}

fn tables(timing: &Timing, console: &Console) -> String {
    let parts = [runs(timing, console), steps(timing, console), fastest(timing, console)];
    parts.into_iter().flatten().collect::<Vec<_>>().join("\n")
}

/// One row a run.
fn runs(timing: &Timing, console: &Console) -> Option<String> {
    let within = format!("within {} {} [%]", number(timing.tolerance), timing.units.y);
    let (rms, left) = (format!("rms [{}]", timing.units.y), format!("rms without lag [{}]", timing.units.y));
    let row = |run: &RunTiming| {
        let scan = |of: fn(&ScanLag) -> f64| run.scan.as_ref().map_or("-".into(), |scan| number(of(scan)));
        let settled = run.steps.iter().filter(|step| step.settling_s.is_some()).count();
        let all = run.steps.len();
        let count = if all > 0 { format!("{settled} of {all}") } else { "-".into() };
        let overshoot = run.overshoot_percent().map_or("-".into(), number);
        vec![
            run.name.clone(),
            number(run.within_percent),
            count,
            ms(run.slowest_s()),
            overshoot,
            scan(|scan| 1e3 * scan.lag_s),
            scan(|scan| scan.rms),
            scan(|scan| scan.rms_without_lag),
        ]
    };
    let header = ["path", &within, "steps that settle", "slowest [ms]", "most overshoot [%]", "lag [ms]", &rms, &left];
    Some(console.table(&header, timing.runs.iter().map(row)))
}

/// The first steps, with the settling time in each run.
fn steps(timing: &Timing, console: &Console) -> Option<String> {
    let first = timing.runs.first().filter(|run| !run.steps.is_empty())?;
    let unit = &timing.units.y;
    let row = |(k, step): (usize, &StepTiming)| {
        let settled = timing.runs.iter().map(|run| run.steps.get(k));
        let settled = settled.map(|step| {
            let Some(step) = step else { return "-".into() };
            format!("{}, {} %", ms(step.settling_s), number(step.overshoot_percent))
        });
        let at = [number(1e3 * step.at_s), number(step.from), number(step.to), number(1e3 * step.move_s)];
        at.into_iter().chain(settled).collect()
    };
    let (from, to) = (format!("from [{unit}]"), format!("to [{unit}]"));
    let names = timing.runs.iter().map(|run| &*run.name);
    let header: Vec<&str> = ["step at [ms]", &from, &to, "move [ms]"].into_iter().chain(names).collect();
    let table = console.table(&header, first.steps.iter().take(SHOWN).enumerate().map(row));
    let more = first.steps.len().saturating_sub(SHOWN);
    let more = if more > 0 { format!("{more} further steps are in the JSON document.\n") } else { String::new() };
    Some(format!(
        "{table}Settling [ms], overshoot [% of the step]; -: it does not settle before the next step.\n{more}"
    ))
}

/// The fastest moves.
fn fastest(timing: &Timing, console: &Console) -> Option<String> {
    let unit = &timing.units.y;
    let with_plant = timing.fastest.iter().any(|m| m.on_plant.is_some());
    let row = |m: &FastestMove| {
        let name = format!("{} from {} to {}", m.purpose, number(m.from), number(m.to));
        let mark = if timing.shortest(m.purpose) == Some(m) { " (shortest)" } else { "" };
        let least = if timing.smoothest(m.purpose) == Some(m) { " (least overshoot)" } else { "" };
        let mut row = vec![
            name,
            format!("{}{mark}{least}", m.shape),
            ms(m.move_s),
            ms(m.settling_s),
            m.overshoot.map_or("-".into(), number),
        ];
        if with_plant {
            row.push(ms(m.on_plant.and_then(|landing| landing.settling_s)));
            row.push(m.on_plant.map_or("-".into(), |landing| number(landing.overshoot)));
        }
        row
    };
    let (name, over) = (format!("fastest [{unit}]"), format!("overshoot [{unit}]"));
    let plant_over = format!("on plant [{unit}]");
    let mut header = vec![&*name, "shape", "move [ms]", "settling [ms]", &*over];
    if with_plant {
        header.extend(["on plant [ms]", &*plant_over]);
    }
    let table = console.table(&header, timing.fastest.iter().map(row));
    let none = timing.fastest.iter().filter(|m| !m.because.is_empty());
    let reasons: String = none.map(|m| format!("{}, {}: {}\n", m.purpose, m.shape, m.because)).collect();
    Some(table + &reasons)
}
