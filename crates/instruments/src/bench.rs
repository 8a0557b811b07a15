//! An instrument at work on drives that begin in a known state: a decaying sine brings the hysteresis to the middle of
//! its loop, creep decays in a wait, and the displacement at rest is measured there.

use crate::{Drive, Instrument, Setup};
use piezoid::{Error, Record};
use piezoid_numerics::number::round;
use piezoid_verbs::PlannedDrive;

/// Time at rest over which the displacement is averaged before a path [s].
const STILL: f64 = 0.2;

/// An instrument, and what it plays before each path.
pub(crate) struct Bench<'b> {
    pub(crate) instrument: &'b mut dyn Instrument,
    pub(crate) demagnetisation: &'b PlannedDrive,
    /// Voltage at which the demagnetisation ends [V].
    pub(crate) middle: f64,
    /// Sampling period of paths [s].
    pub(crate) ts: f64,
    /// Least time of slow moves [s].
    pub(crate) ramp: f64,
    /// Wait after a demagnetisation [s].
    pub(crate) wait: f64,
    /// What is measured now, for the progress.
    pub(crate) part: String,
}

impl Bench<'_> {
    /// Brings the hysteresis to the middle of its loop.
    pub(crate) fn demagnetise(&mut self) -> Result<(), Error> {
        let drive = self.demagnetisation;
        self.play(", demagnetisation", &drive.u, drive.ts, 0.0).map(drop)
    }

    /// Plays voltages after a wait [s], and returns what was measured. `what` follows the name of the part.
    pub(crate) fn play(&mut self, what: &str, u: &[f64], ts: f64, settle: f64) -> Result<Record, Error> {
        let what = format!("{}{what}", self.part);
        let drive = Drive { settle, ..drive_of((&what, u), (ts, self.ts), self.ramp) };
        self.instrument.prepare(&drive)?;
        self.instrument.play(&drive)
    }

    /// Demagnetises, waits, and returns the mean displacement at rest.
    pub(crate) fn at_rest(&mut self) -> Result<f64, Error> {
        self.demagnetise()?;
        let record = self.play(", displacement at rest", &still(self.middle, self.ts), self.ts, self.wait)?;
        Ok(piezoid_numerics::series::mean(record.y()))
    }
}

/// The voltages at rest.
pub(crate) fn still(middle: f64, ts: f64) -> Vec<f64> {
    vec![middle; (STILL / ts).ceil().max(2.0) as usize]
}

/// A drive without a wait before it. One that is sampled less often than a path is joined by straight lines.
pub(crate) fn drive_of<'u>((what, u): (&'u str, &'u [f64]), (ts, of_path): (f64, f64), ramp: f64) -> Drive<'u> {
    Drive { what, u, ts, ramp, settle: 0.0, joined: ts > 1.5 * of_path }
}

/// What is to move, between which voltages [V] and how long [s], as text.
pub(crate) fn to_move(setup: &Setup, (low, high): (f64, f64), seconds: f64) -> String {
    let ([low, high], seconds) = ([low, high].map(round), seconds.ceil());
    let Setup { identity, axis, .. } = setup;
    format!("{identity}: axis {axis} is to move between {low} and {high} V, for {seconds} s or more.")
}
