//! A drive played by the wave generator of a controller in open loop, while its recorder measures.
//!
//! All checks come before the first move, and the loop is opened after them. [`Run`] makes the moves.

use crate::gcs::checks::{cycles, fits, range, speed, within};
use crate::gcs::controller::{Axis, ConnectOptions, Controller, MOVING, RUNNING};
use crate::gcs::recording::{Sources, read};
use crate::gcs::rest::{Before, RESTS, Rest};
use crate::gcs::run::{Play, Run};
use crate::gcs::stop::Left;
use piezoid::excitation::LimitOptions;
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
        /// Voltage that an open-loop value of 1 gives; some controllers count open-loop values in micrometres.
        gain: Option<f64> = None, OptionRow::positive("V").absent("1");
        /// Number of the output channel and wave generator of the axis.
        channel: Option<usize> = None, OptionRow::new(OptionKind::Integer(1, 64)).absent("that of the axis");
        /// Time of the move to the first voltage, and of the move to {rest}; longer if the limits need it.
        ramp: f64 = 1.0, SECONDS;
        /// Wait at the first voltage before the drive.
        settle: f64 = 0.5, SECONDS;
        /// Where the axis goes after the drive.
        rest: Rest = Rest::Start, OptionRow::new(RESTS);
        /// Servo cycle of the controller.
        cycle: Option<f64> = None, OptionRow::positive("s").absent("the one it reports");
    } with connection: ConnectOptions with limits: LimitOptions
}

/// A record from a controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Acquired {
    /// Measured voltage and position.
    pub record: Record,
    /// What the controller answers to `*IDN?`.
    pub identity: String,
    /// The axis.
    pub axis: String,
    /// What the user should know.
    pub notes: Vec<String>,
    /// Why the axis is not where [`AcquireOptions::rest`] says, and where it is instead; `None` if it is there.
    pub unfinished: Option<String>,
    /// Voltage at the end, as the controller measures it, if it does [V].
    pub voltage: Option<f64>,
    /// True in closed loop at the end, if that is known.
    pub servo: Option<bool>,
}

/// Takes a record as soon as it is measured.
pub type Keep<'a> = dyn FnMut(&Acquired) -> Result<(), Error> + 'a;

/// Share of the drive by which the recorded voltage may differ without a note.
const DIFFERENCE: f64 = 0.05;

impl AcquireOptions {
    /// Plays the drive in a file, and returns what was measured. `keep` gets it before the axis moves to its rest, with
    /// [`Acquired::unfinished`].
    ///
    /// After an error, and if `progress` cancels, the generator is stopped, if need be after the client has connected
    /// again. Nothing moves any more. Where the axis is stands in the error, or in `notes` if it was cancelled. Once
    /// `keep` has the record, this is a result that is unfinished, and no error.
    ///
    /// # Errors
    /// Returns an error for a file without a drive, a drive that the controller cannot play or record or that exceeds
    /// the limits, a `gain` that differs from that of the controller, a controller that does not answer, refuses or is
    /// in use, a cancelled measurement, and the error of `keep`.
    pub fn run(
        &self,
        drive: &DataFile,
        columns: &ColumnSelection,
        notes: &mut Vec<String>,
        keep: &mut Keep,
        progress: &mut Progress,
    ) -> Result<Acquired, Error> {
        let signal = drive.input(columns)?;
        let factor = Units::factor(&signal.unit, "V").ok_or_else(|| {
            let (what, found) = (format!("the drive in {}", drive.name), signal.unit.clone());
            Error::Units { what, found, expected: "V".into() }
        })?;
        let u: Vec<f64> = signal.samples.iter().map(|u| u * factor).collect();
        let (mut run, play, identity) = self.ready(&u, signal.ts, progress).inspect_err(|error| {
            if let Error::Cancelled { .. } = error {
                notes.push("nothing has moved".into());
            }
        })?;
        let (before, record) = self.measure(&mut run, &play, &identity).map_err(|error| {
            let (_, state) = run.stop();
            match error {
                Error::Cancelled { .. } => {
                    notes.push(state);
                    error
                }
                other => Error::Content(format!("{other}; {state}")),
            }
        })?;
        notes.extend(remarks(&play, &record));
        let unfinished = Some("the axis has not moved to its rest yet".into());
        let (axis, notes_now) = (run.axis.name.clone(), notes.clone());
        let mut acquired =
            Acquired { record, identity, axis, notes: notes_now, unfinished, voltage: None, servo: None };
        let kept = keep(&acquired);
        let last = play.u.last().copied().unwrap_or_default();
        let (left, unfinished) = match self.rest.reach(&mut run, &before, last, self.ramp) {
            Ok(left) => (left, None),
            Err(error) => {
                let (left, state) = run.stop();
                (left, Some(format!("{error}; {state}")))
            }
        };
        if run.axis.servo == Some(true) {
            let state = match left.servo {
                Some(true) => "is on again",
                Some(false) => "is off now",
                None => "may be off now",
            };
            notes.push(format!("the servo of axis {} was on; it {state}", run.axis.name));
        }
        if kept.is_err() {
            notes.push(unfinished.clone().unwrap_or_else(|| left.text(&run.axis.name)));
        }
        (acquired.unfinished, acquired.notes) = (unfinished, notes.clone());
        Left { voltage: acquired.voltage, servo: acquired.servo } = left;
        kept.map(|()| acquired)
    }

    /// Checks everything, then writes the drive to the controller and sets it. Nothing moves, and the servo stays as it
    /// is.
    fn ready<'a, 'u>(
        &self,
        u: &'u [f64],
        ts: f64,
        progress: &'a mut Progress<'_>,
    ) -> Result<(Run<'a>, Play<'u>, String), Error> {
        let limits = self.limits.limits()?.unwrap_or_default();
        let (line, controller) = self.connection.open(progress)?;
        if let Some(signs) = controller.in_use() {
            return Err(in_use(&signs));
        }
        let (axis, number) = self.axis(&controller)?;
        let cycle = self.cycle.or(controller.cycle).ok_or_else(|| {
            let message = "must be given, because the controller does not report it (parameter 0x0E000200)";
            Error::parameter("cycle", "(not given)", message)
        })?;
        let play = Play { u, ts, cycles: cycles(ts, cycle)? };
        let range = range(&limits, &axis)?;
        within(&play, range)?;
        fits(&play, &controller)?;
        speed(&play, &limits, range)?;
        if self.rest == Rest::Zero && !(range.0..=range.1).contains(&0.0) {
            let rule = format!("is outside {} to {} V: let the axis rest elsewhere", range.0, range.1);
            return Err(Error::parameter("rest", "zero", rule));
        }
        let (channel, fastest) = (self.channel.unwrap_or(number), limits.fastest());
        let mut run = Run { line, axis, channel, gain: self.gain, range, fastest };
        let sources = Sources::of(&mut run.line)?;
        let place = run.place()?;
        run.upload(&play)?;
        run.configure(&play, &sources)?;
        let is_open = run.axis.servo != Some(true);
        let has_moved = run.line.bits(MOVING)? != 0 || is_open && run.place()? != place;
        if has_moved || run.line.bits(RUNNING)? != 0 {
            return Err(in_use("it moves while it is being set"));
        }
        Ok((run, play, controller.identity))
    }

    /// Moves the axis to the first voltage, plays the drive, and reads the record.
    fn measure(&self, run: &mut Run, play: &Play, identity: &str) -> Result<(Before, Record), Error> {
        let (start, first) = run.open_loop()?;
        if let Some(first) = first {
            run.check_gain(play, start, first)?;
        }
        run.ramp(start, play.u[0], self.ramp)?;
        run.settle(self.settle)?;
        run.play(play)?;
        let unit = run.axis.unit.clone();
        let record = read(&mut run.line, play.u.len(), &unit, identity)?;
        Ok((Before { start, first }, record))
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
}

fn in_use(signs: &str) -> Error {
    let advice = "end the program that uses it, then try again";
    Error::Content(format!("the controller is in use: {signs}; nothing has moved: {advice}"))
}

/// What to say if the record is not what was requested.
fn remarks(play: &Play, record: &Record) -> Vec<String> {
    let (target, found) = (play.ts, record.ts());
    let period = (found / target - 1.0).abs() > 1e-3;
    let period =
        period.then(|| format!("the controller reports a sampling period of {found} s, not {target} s as requested"));
    let largest = play.u.iter().zip(record.u()).map(|(a, m)| (a - m).abs()).fold(0.0, f64::max);
    let peak = play.u.iter().fold(0.0, |peak: f64, u| peak.max(u.abs()));
    let difference = (largest > DIFFERENCE * peak).then(|| {
        format!("the recorded voltage, which the record contains, differs from the drive by up to {largest:.3} V")
    });
    period.into_iter().chain(difference).collect()
}

impl Acquired {
    /// Where the axis is, as text.
    pub fn state(&self) -> String {
        Left { voltage: self.voltage, servo: self.servo }.text(&self.axis)
    }

    /// The result as a document, with the number of samples in place of the record.
    pub fn to_json(&self) -> Value {
        let Acquired { record, identity, axis, notes, unfinished, voltage, servo } = self;
        let (ts, samples, units) = (record.ts(), record.len(), record.units());
        json!({
            "identity": identity, "axis": axis, "notes": notes, "ts": ts, "samples": samples, "units": units,
            "unfinished": unfinished, "voltage": voltage, "servo": servo, "state": unfinished.is_none().then(|| self.state()),
        })
    }
}
