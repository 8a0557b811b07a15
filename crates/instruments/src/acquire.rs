//! A drive played by a controller, while it records: voltages in open loop, or positions in closed loop.
//!
//! All checks come before the first move, and the loop is opened after them.

use crate::gcs::Gcs;
use crate::nv200::Nv200;
use crate::rest::RESTS;
use crate::scpi::Scpi;
use crate::{ConnectOptions, Drive, Instrument, Left, Protocol, Rest, ScpiOptions};
use piezoid::excitation::LimitOptions;
use piezoid::formats::ColumnSelection;
use piezoid::progress::Progress;
use piezoid::validation::Metrics;
use piezoid::{Error, Record, Units};
use piezoid_numerics::number::round;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_verbs::DataFile;
use serde_json::{Value, json};

/// A time [s].
pub(crate) const SECONDS: OptionRow =
    OptionRow { unit: "s", ..OptionRow::new(OptionKind::Number { least: 0.0, open: false, below: 3600.0 }) };

options! {
    /// How to drive an axis of a controller.
    pub struct InstrumentOptions {
        /// Axis to drive.
        axis: Option<String> = None, OptionRow::new(OptionKind::Text("AXIS")).absent("the first");
        /// Voltage that an open-loop value of 1 gives; some controllers count open-loop values in micrometres.
        /// With SCPI, the gain of the amplifier.
        gain: Option<f64> = None, OptionRow::positive("V").absent("1");
        /// Number of the output channel and wave generator of the axis.
        channel: Option<usize> = None, OptionRow::new(OptionKind::Integer(1, 64)).absent("that of the axis");
        /// Time of the move to the first value, and of the move to {rest}; longer if the limits need it.
        ramp: f64 = 1.0, SECONDS;
        /// Where the axis goes after the drive.
        rest: Rest = Rest::Start, OptionRow::new(RESTS);
        /// Servo cycle of the controller.
        cycle: Option<f64> = None, OptionRow::positive("s").absent("the one it reports");
    } with connection: ConnectOptions with limits: LimitOptions with scpi: ScpiOptions
}

options! {
    /// How to measure on a controller.
    pub struct AcquireOptions {
        /// Wait at the first value before the drive.
        settle: f64 = 0.5, SECONDS;
        /// Join the values by straight lines, instead of holding each for a sampling period.
        join: bool = false, OptionRow::new(OptionKind::Switch);
        /// The drive is positions: play them in closed loop. The servo must be on, and stays on.
        closed_loop: bool = false, OptionRow::new(OptionKind::Switch);
    } with instrument: InstrumentOptions
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
    /// Why the axis is not where [`InstrumentOptions::rest`] says, and where it is instead; `None` if it is there.
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
        let what = format!("the drive in {}", drive.name);
        let signal = if self.closed_loop { drive.path(columns) } else { drive.input(columns) }?;
        // A wrong unit is found before anything is connected.
        if !self.closed_loop && Units::factor(&signal.unit, "V").is_none() {
            return Err(Error::units(&what, &signal.unit, "V"));
        }
        let mut unmoved = |error: &Error| {
            if let Error::Cancelled { .. } = error {
                notes.push("nothing has moved".into());
            }
        };
        let mut instrument = self.instrument.opened(self.closed_loop, progress).inspect_err(&mut unmoved)?;
        let (ts, ramp, settle) = (signal.ts, self.instrument.ramp, self.settle);
        let u = signal.samples_in(&instrument.setup().unit, &what)?;
        let drive = Drive { what: "", u: &u, ts, ramp, settle, joined: self.join };
        instrument.prepare(&drive).inspect_err(&mut unmoved)?;
        let record = instrument.play(&drive).map_err(|error| stopped(&mut *instrument, error, notes))?;
        notes.extend(remarks(&drive, &record, self.closed_loop));
        let unfinished = Some("the axis has not moved to its rest yet".into());
        let setup = instrument.setup().clone();
        let (identity, axis, notes_now) = (setup.identity, setup.axis.clone(), notes.clone());
        let mut acquired =
            Acquired { record, identity, axis, notes: notes_now, unfinished, voltage: None, servo: None };
        let kept = keep(&acquired);
        let (left, unfinished) = at_rest(&mut *instrument, self.instrument.rest);
        if !self.closed_loop || left.servo != Some(true) {
            notes.extend(servo_remark(setup.servo, left, &setup.axis));
        }
        if kept.is_err() {
            notes.push(unfinished.clone().unwrap_or_else(|| left.text(&setup.axis)));
        }
        (acquired.unfinished, acquired.notes) = (unfinished, notes.clone());
        Left { voltage: acquired.voltage, servo: acquired.servo } = left;
        kept.map(|()| acquired)
    }
}

impl InstrumentOptions {
    /// Connects to the controller, for drives of voltages. Nothing moves.
    ///
    /// # Errors
    /// Returns an error for a controller that does not answer or is in use, an unknown axis, and limits that leave no
    /// voltage, or not that of [`InstrumentOptions::rest`].
    pub fn open<'a>(&self, progress: &'a mut Progress<'_>) -> Result<Box<dyn Instrument + 'a>, Error> {
        self.opened(false, progress)
    }

    /// The same, or for drives of positions in closed loop.
    fn opened<'a>(&self, is_closed: bool, progress: &'a mut Progress<'_>) -> Result<Box<dyn Instrument + 'a>, Error> {
        let instrument: Box<dyn Instrument + 'a> = match self.connection.protocol {
            Protocol::Gcs => Box::new(Gcs::open(self, is_closed, progress)?),
            _ if is_closed => {
                let rule = "is possible with the protocol gcs alone";
                return Err(Error::parameter("closed_loop", "true", rule));
            }
            Protocol::Nv200 => Box::new(Nv200::open(self, progress)?),
            Protocol::Scpi => Box::new(Scpi::open(self, progress)?),
        };
        let (low, high) = instrument.setup().range;
        if !is_closed && self.rest == Rest::Zero && !(low..=high).contains(&0.0) {
            let rule = format!("is outside {low} to {high} V: let the axis rest elsewhere");
            return Err(Error::parameter("rest", "zero", rule));
        }
        Ok(instrument)
    }
}

/// Stops the instrument after an error, which then states where the axis is; if work was cancelled, a note does.
pub(crate) fn stopped(instrument: &mut dyn Instrument, error: Error, notes: &mut Vec<String>) -> Error {
    let (_, state) = instrument.stop();
    match error {
        Error::Cancelled { .. } => {
            notes.push(state);
            error
        }
        other => Error::Content(format!("{other}; {state}")),
    }
}

/// Moves the axis to its rest. Where it is then, and why that is not its rest.
pub(crate) fn at_rest(instrument: &mut dyn Instrument, rest: Rest) -> (Left, Option<String>) {
    match instrument.rest(rest) {
        Ok(left) => (left, None),
        Err(error) => {
            let (left, state) = instrument.stop();
            (left, Some(format!("{error}; {state}")))
        }
    }
}

/// What became of a servo that was on.
pub(crate) fn servo_remark(before: Option<bool>, left: Left, axis: &str) -> Option<String> {
    let state = match left.servo {
        Some(true) => "is on again",
        Some(false) => "is off now",
        None => "may be off now",
    };
    (before == Some(true)).then(|| format!("the servo of axis {axis} was on; it {state}"))
}

/// What to say if the record is not what was requested.
fn remarks(drive: &Drive, record: &Record, is_closed: bool) -> Vec<String> {
    let (target, found) = (drive.ts, record.ts());
    let period = (found / target - 1.0).abs() > 1e-3;
    let period =
        period.then(|| format!("the controller reports a sampling period of {found} s, not {target} s as requested"));
    if is_closed {
        let Metrics { rmse, max_abs, .. } = Metrics::of(drive.u, record.y());
        let (rms, most, unit) = (round(rmse), round(max_abs), &record.units().y);
        let error = format!("the position differs from the drive by {rms} {unit} rms, and by up to {most} {unit}");
        return period.into_iter().chain([error]).collect();
    }
    let largest = drive.u.iter().zip(record.u()).map(|(a, m)| (a - m).abs()).fold(0.0, f64::max);
    let peak = drive.u.iter().fold(0.0, |peak: f64, u| peak.max(u.abs()));
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
