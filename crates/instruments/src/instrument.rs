//! What plays voltages on an actuator and records what it does: a controller behind its protocol.

use crate::Rest;
use piezoid::excitation::Limits;
use piezoid::{Error, Record};

/// An actuator at work on one axis: in open loop, or in closed loop if the drives are positions.
///
/// Work is cancelled by the progress that opened it. After an error of [`play`](Self::play) or [`rest`](Self::rest),
/// [`stop`](Self::stop) is all that is allowed.
pub trait Instrument {
    /// What it is, and what it can play.
    fn setup(&self) -> &Setup;

    /// Checks a drive, and sends it to the instrument. Nothing moves, and the servo stays as it is.
    ///
    /// # Errors
    /// Returns an error for a drive that it cannot play or record, or that exceeds the limits.
    fn prepare(&mut self, drive: &Drive) -> Result<(), Error>;

    /// Opens the loop if the drive is voltages, moves slowly to the first value of the drive that was prepared, waits
    /// there, plays it, and returns what was measured. The axis stays at the last value.
    ///
    /// # Errors
    /// Returns an error if the instrument does not answer, refuses, does not follow, or if work was cancelled.
    fn play(&mut self, drive: &Drive) -> Result<Record, Error>;

    /// Moves the axis slowly to its rest, and checks that it is there.
    ///
    /// # Errors
    /// Returns an error if it is not, and the errors of [`play`](Self::play).
    fn rest(&mut self, rest: Rest) -> Result<Left, Error>;

    /// Stops what plays, whatever the line and the user do. Where the axis is then, also as text.
    fn stop(&mut self) -> (Left, String);
}

/// A drive, and the slow move before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive<'u> {
    /// What it is, as a noun phrase: stages of the progress begin with it, unless it is empty.
    pub what: &'u str,
    /// Voltages [V], or positions in [`Setup::unit`].
    pub u: &'u [f64],
    /// Sampling period [s].
    pub ts: f64,
    /// Least time of the move to the first voltage, and of the move to rest after the drive [s].
    pub ramp: f64,
    /// Wait at the first voltage [s].
    pub settle: f64,
    /// True if straight lines join the voltages; otherwise each is held for a sampling period.
    pub joined: bool,
}

/// An instrument, and what limits a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// What it says it is.
    pub identity: String,
    /// Name of the axis.
    pub axis: String,
    /// Unit of its drives: V, or in closed loop that of the positions.
    pub unit: String,
    /// Lowest and highest value of a drive, in this unit.
    pub range: (f64, f64),
    /// Limits of slew and current; in closed loop the slew is that of the position.
    pub limits: Limits,
    /// Sampling periods are multiples of this one [s].
    pub cycle: f64,
    /// What holds a drive or its record, and how many samples.
    pub holds: Vec<(&'static str, usize)>,
    /// True if it can join the voltages of a drive by straight lines.
    pub joins: bool,
    /// True if the axis was in closed loop; `None` if that is unknown.
    pub servo: Option<bool>,
}

/// Where an axis is, as the instrument reports it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Left {
    /// Voltage, if it is reported [V].
    pub voltage: Option<f64>,
    /// True in closed loop, if that is known.
    pub servo: Option<bool>,
}

impl Left {
    /// The same as text.
    pub fn text(self, axis: &str) -> String {
        let place =
            self.voltage.map_or("at a voltage that the controller does not report".into(), |v| format!("at {v:.3} V"));
        let state = if self.servo == Some(true) { "closed" } else { "open" };
        format!("axis {axis} is {place}, in {state} loop")
    }
}

/// Begins the step of a record that names its instrument.
const MEASURED: &str = "measured by ";
const CONTROLLER: &str = "the controller ";

/// The record, with the instrument that measured it.
pub(crate) fn measured_by(instrument: &str, record: Record) -> Record {
    record.with_step(format!("{MEASURED}{instrument}"))
}

/// The same of a controller.
pub(crate) fn measured_by_controller(identity: &str, record: Record) -> Record {
    measured_by(&format!("{CONTROLLER}{identity}"), record)
}

/// The identity of the instrument that measured a record, if the record states it.
pub(crate) fn measuring(record: &Record) -> Option<&str> {
    let by = record.history().iter().find_map(|step| step.strip_prefix(MEASURED))?;
    Some(by.strip_prefix(CONTROLLER).unwrap_or(by).trim())
}
