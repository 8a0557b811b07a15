//! `piezoid acquire`: a drive played and recorded by a controller.

use super::prelude::*;
use crate::values::{Ended, record};
use piezoid::Error;
use piezoid_instruments::{AcquireOptions, Acquired, Controller};
use piezoid_numerics::number::{round, short};

const EXAMPLES: &str = "\
Examples:
  The identity of a controller, and the limits it reports; nothing moves:
    piezoid acquire --host 192.168.0.10
  A drive of `piezoid plan` or `piezoid excite`, played in open loop and recorded:
    piezoid acquire sine20.csv --host 192.168.0.10 --low -20 --high 120 -o record.csv
  The same on an NV200 of piezosystem jena, which holds 1024 samples:
    piezoid acquire sine20.csv --protocol nv200 --host 192.168.0.11 --port 23 -o record.csv
  The same by a generator, an amplifier with a gain of 20 and an oscilloscope, with a sensor of 5 um/V:
    piezoid acquire sine20.csv --protocol scpi --host 192.168.0.12 --port 5025 --oscilloscope 192.168.0.13 --gain 20 \
--low -20 --high 120 --monitor-channel 1 --monitor-gain 100 --sensitivity 5 -o record.csv
  The first within the current of an amplifier, and to 0 V at the end:
    piezoid acquire sine20.csv --host 192.168.0.10 --driver e-610 --capacitance 1.5e-6 --rest zero -o record.csv
  The first without hardware, with `piezoid instrument` in another terminal:
    piezoid acquire sine20.csv -o record.csv

The actuator moves. Ctrl-C stops the wave generator; the voltage then stays where it is, and is shown. The record is
written before the axis moves to its rest. The exit status is 0 only if the axis is where --rest says.";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid acquire [<FILE> -o <FILE>] [--host <HOST>] [OPTIONS]")]
pub(crate) struct Acquire {
    /// The drive signal. Without it, the command prints the identity and the limits of the controller.
    #[arg(value_name = "FILE", requires = "output")]
    drive: Option<PathBuf>,
    /// The record to write: CSV, or .npz or .mat by the extension; - is stdout.
    #[arg(short, long, value_name = "FILE", value_parser = record(), requires = "drive")]
    output: Option<PathBuf>,
    /// Write what the controller reports as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    options: Flags<AcquireOptions>,
    #[command(flatten)]
    columns: Columns,
}

impl Run for Acquire {
    fn run(self, console: &Console) -> Result<()> {
        let drives: Vec<&PathBuf> = self.drive.iter().collect();
        let is_free = files::check(&[self.output.as_deref(), self.json.as_deref()], &drives)?;
        let options = self.options.0;
        let Some(drive) = &self.drive else {
            let controller = console.work(|progress| options.instrument.connection.connect(progress))?;
            if is_free {
                console.print(&summary(&controller, console))?;
            }
            return Results::default().json(self.json.as_deref(), &controller.to_json()).write(console);
        };
        let Some(output) = &self.output else { bail!("name the file of the record by -o") };
        let (drive, columns) = (files::data(drive)?, self.columns.read()?);
        let mut notes = Vec::new();
        let mut keep = |acquired: &Acquired| {
            let results = Results::default().record(Some(output), |name| acquired.record.written(name));
            // A file is replaced once the axis is at rest; what goes elsewhere is written only then.
            let document = self.json.as_deref().filter(|path| !files::is_stream(path));
            let written = results.and_then(|results| results.json(document, &acquired.to_json()).write(console));
            written.map_err(|error| Error::Content(format!("{error:#}")))
        };
        let outcome =
            console.work_on_instrument(|progress| options.run(&drive, &columns, &mut notes, &mut keep, progress));
        console.remarks(&notes);
        let (acquired, is_cancelled) = outcome?;
        Results::default().json(self.json.as_deref(), &acquired.to_json()).write(console)?;
        let Some(unfinished) = &acquired.unfinished else {
            return if is_free { console.sentence(&acquired.state()) } else { Ok(()) };
        };
        let message = format!("{unfinished}; the record is written");
        if is_cancelled { bail!(Ended::Cancelled(message)) } else { bail!(message) }
    }
}

/// What a controller said of itself.
fn summary(controller: &Controller, console: &Console) -> String {
    let Controller { identity, cycle, table: points, recorder, axes, .. } = controller;
    let reported = |value: Option<String>| value.unwrap_or_else(|| "not reported".into());
    let head = format!(
        "{identity}\nservo cycle {}; points of a wave table: {}; points of a recorder table: {}\n\n",
        reported(cycle.map(|cycle| format!("{} us", short(1e6 * cycle)))),
        reported(points.map(|points| points.to_string())),
        reported(recorder.map(|points| points.to_string()))
    );
    let rows = axes.iter().map(|axis| {
        vec![
            axis.name.clone(),
            reported(axis.position.map(|position| format!("{} {}", round(position), axis.unit))),
            reported(axis.voltage.map(|voltage| format!("{} V", round(voltage)))),
            reported(axis.range.map(|(low, high)| format!("{low} to {high} V"))),
            reported(axis.servo.map(|servo| if servo { "on".into() } else { "off".into() })),
        ]
    });
    let used = controller.in_use().map(|signs| format!("\nin use: {signs}\n")).unwrap_or_default();
    head + &console.table(&["axis", "position", "voltage", "limits", "servo"], rows) + &used
}
