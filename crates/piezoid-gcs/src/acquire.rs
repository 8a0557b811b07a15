//! A drive played by the wave generator of a controller in open loop, while its recorder measures.
//!
//! All checks come before the first move. [`Run`] makes the moves.

use crate::controller::{Axis, ConnectOptions, Controller};
use crate::recording::{Sources, points, record};
use crate::run::{Play, Run};
use piezoid::formats::ColumnSelection;
use piezoid::progress::Progress;
use piezoid::{Error, Record, Units};
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_verbs::DataFile;
use serde_json::{Value, json};

const SECONDS: OptionRow =
    OptionRow { unit: "s", ..OptionRow::new(OptionKind::Number { least: 0.0, open: false, below: 3600.0 }) };

options! {
    /// How to measure on a controller.
    pub struct AcquireOptions {
        /// Axis to drive.
        axis: Option<String> = None, OptionRow::new(OptionKind::Text("AXIS")).absent("the first");
        /// Lowest and highest voltage that the actuator may get, within those of the controller.
        range: Option<(f64, f64)> = None, OptionRow { unit: "V", ..OptionRow::new(OptionKind::Pair) }.absent("those of the controller");
        /// Voltage that an open-loop value of 1 gives; some controllers count open-loop values in micrometres.
        gain: Option<f64> = None, OptionRow::positive("V").absent("1");
        /// Number of the output channel and wave generator of the axis.
        channel: Option<usize> = None, OptionRow::new(OptionKind::Integer(1, 64)).absent("that of the axis");
        /// Time of the move to the first voltage, and of the move back.
        ramp: f64 = 1.0, SECONDS;
        /// Wait at the first voltage before the drive.
        settle: f64 = 0.5, SECONDS;
        /// Servo cycle of the controller.
        cycle: Option<f64> = None, OptionRow::positive("s").absent("the one it reports");
    } with connection: ConnectOptions
}

/// A record from a controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Acquired {
    /// Measured voltage and position.
    pub record: Record,
    /// What the controller answers to `*IDN?`.
    pub identity: String,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Share of the drive by which the recorded voltage may differ without a note.
const DIFFERENCE: f64 = 0.05;

impl AcquireOptions {
    /// Plays the drive in a file, and returns what was measured. The axis is in open loop afterwards, at the value that
    /// it had before. After an error, and if the work is cancelled, the generator is stopped and the voltage stays
    /// where it is.
    ///
    /// # Errors
    /// Returns an error for a file without a drive, a drive that the controller cannot play or record or that leaves
    /// the range, a `gain` that differs from that of the controller, a controller that does not answer or refuses, and
    /// a cancelled measurement.
    pub fn run(&self, drive: &DataFile, columns: &ColumnSelection, progress: &mut Progress) -> Result<Acquired, Error> {
        let signal = drive.input(columns)?;
        let factor = Units::factor(&signal.unit, "V").ok_or_else(|| {
            let (what, found) = (format!("the drive in {}", drive.name), signal.unit.clone());
            Error::Units { what, found, expected: "V".into() }
        })?;
        let u: Vec<f64> = signal.samples.iter().map(|u| u * factor).collect();
        let mut controller = self.connection.connect()?;
        let (axis, number) = self.axis(&controller)?;
        let channel = self.channel.unwrap_or(number);
        let cycle = self.cycle.or(controller.cycle).ok_or_else(|| {
            let message = "must be given, because the controller does not report it (parameter 0x0E000200)";
            Error::parameter("cycle", "(not given)", message)
        })?;
        let play = Play { u: &u, ts: signal.ts, cycles: cycles(signal.ts, cycle)? };
        let range = self.range(&axis)?;
        fits(&play, range, &controller)?;
        let sources = Sources::of(&mut controller.line)?;
        if controller.runs(channel)? {
            return Err(Error::Content(format!(
                "wave generator {channel} runs already: stop it, and end the program that uses the controller"
            )));
        }
        let identity = controller.identity.clone();
        let mut run = Run { controller: &mut controller, axis: &axis, channel, gain: self.gain, range, progress };
        run.upload(&play)?;
        let mut notes = Vec::new();
        if axis.servo == Some(true) {
            run.command(&format!("SVO {} 0", axis.name))?;
            notes.push(format!("the servo of axis {} was on; it is off now", axis.name));
        }
        let start = run.start()?;
        let outcome = run.check_gain(&play, start).and_then(|()| {
            run.ramp(start, u[0], self.ramp)?;
            run.wait(self.settle)?;
            run.play(&play, &sources)
        });
        // Whatever happened, the generator must not go on.
        let stopped = run.command(&format!("WGO {channel} 0")).map_err(|error| {
            Error::Content(format!("{error}; wave generator {channel} could not be stopped, and may run on"))
        });
        let message = |error: Error| match &error {
            Error::Cancelled { .. } => error,
            other => Error::Content(format!("{other}; axis {} is in open loop", axis.name)),
        };
        stopped.and(outcome).map_err(message)?;
        let answer = points(run.controller, u.len());
        if let Err(error) = run.ramp(u[u.len() - 1], start, self.ramp) {
            notes.push(format!("the axis did not move back to where it was: {error}"));
        }
        let record = record(answer?, u.len(), &axis.unit, &identity)?;
        if (record.ts() / signal.ts - 1.0).abs() > 1e-3 {
            let (target, found) = (signal.ts, record.ts());
            notes.push(format!("the controller reports a sampling period of {found} s, not {target} s as requested"));
        }
        notes.extend(difference(&u, record.u()));
        Ok(Acquired { record, identity, notes })
    }

    /// The axis, and its number: its name if that is one, otherwise its place.
    fn axis(&self, controller: &Controller) -> Result<(Axis, usize), Error> {
        let axes = &controller.axes;
        if axes.is_empty() {
            return Err(Error::Content("the controller reports no axes: configure its stages first".into()));
        }
        let k = self.axis.as_ref().map_or(Some(0), |name| axes.iter().position(|axis| axis.name == *name));
        let unknown = || {
            let name = self.axis.as_deref().unwrap_or_default();
            Error::unknown("axis", name, axes.iter().map(|axis| &*axis.name))
        };
        let k = k.ok_or_else(unknown)?;
        let number = axes[k].name.parse().ok().filter(|number| (1..=64).contains(number));
        Ok((axes[k].clone(), number.unwrap_or(k + 1)))
    }

    /// Lowest and highest voltage: what is given, within what the controller reports.
    fn range(&self, axis: &Axis) -> Result<(f64, f64), Error> {
        match (self.range, axis.range) {
            (Some((low, high)), Some((lowest, highest))) => Ok((low.max(lowest), high.min(highest))),
            (Some(range), None) | (None, Some(range)) => Ok(range),
            (None, None) => {
                let rule = "must be two numbers [V], because the controller reports no limits";
                Err(Error::parameter("range", "(not given)", rule))
            }
        }
    }
}

/// Returns an error if the drive leaves the range, or has more samples than the controller holds.
fn fits(play: &Play, (low, high): (f64, f64), controller: &Controller) -> Result<(), Error> {
    let Play { u, ts, .. } = play;
    if let Some((k, value)) = u.iter().enumerate().find(|(_, u)| !(low..=high).contains(*u)) {
        let time = k as f64 * ts;
        return Err(Error::Content(format!(
            "the drive is {value:.4} V at {time:.6} s, outside {low} to {high} V: make it smaller, or give another range"
        )));
    }
    for (what, points) in [("a wave table", controller.table), ("a table of the recorder", controller.recorder)] {
        if let Some(points) = points.filter(|points| *points < u.len()) {
            let (n, longest) = (u.len(), points as f64 * ts);
            return Err(Error::Content(format!(
                "the drive has {n} samples, but {what} of the controller holds {points}: make it {longest} s or \
                 shorter, or sample it less often"
            )));
        }
    }
    Ok(())
}

/// The servo cycles in a sampling period [s].
fn cycles(ts: f64, cycle: f64) -> Result<u64, Error> {
    let cycles = (ts / cycle).round().max(1.0);
    if (ts / cycle / cycles - 1.0).abs() < 1e-6 {
        return Ok(cycles as u64);
    }
    let nearest = cycles * cycle;
    Err(Error::Content(format!(
        "the drive is sampled every {ts} s, but the controller plays multiples of its servo cycle of {cycle} s: sample \
         the drive every {nearest} s"
    )))
}

/// What to say if the recorded voltage is another one than the voltage that was asked for.
fn difference(requested: &[f64], measured: &[f64]) -> Option<String> {
    let largest = requested.iter().zip(measured).map(|(a, m)| (a - m).abs()).fold(0.0, f64::max);
    let peak = requested.iter().fold(0.0, |peak: f64, u| peak.max(u.abs()));
    (largest > DIFFERENCE * peak).then(|| {
        format!("the recorded voltage, which the record contains, differs from the drive by up to {largest:.3} V")
    })
}

impl Acquired {
    /// The result as a document, with the number of samples in place of the record.
    pub fn to_json(&self) -> Value {
        let Acquired { record, identity, notes } = self;
        let (ts, samples, units) = (record.ts(), record.len(), record.units());
        json!({"identity": identity, "notes": notes, "ts": ts, "samples": samples, "units": units})
    }
}
