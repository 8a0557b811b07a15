//! What moves: the drive on an NV200 in open loop.
//!
//! ```text
//! gbarb,0,50 ...                     the drive to the generator, in % of avmin to avmax
//! gsarb,0; gearb,0; goarb,0; gcarb,1; grun,1     the generator to its first value, while `set` gives the setpoint
//! set,...                            slowly to the first voltage
//! modsrc,3                           the generator gives the setpoint: the first voltage still
//! recsrc,0,2; recsrc,1,0             voltage and position to the channels of the recorder
//! recstr,k; reclen,n; recast,2; recrun,1         every k servo cycles, from the start of the generator on
//! gearb,n-1; gtarb,k; grun,1         plays the drive
//! set,...; modsrc,0                  `set` gives the setpoint again, at the last voltage
//! recoutf,0; recoutf,1               the record
//! ```
//! The voltage is measured by the recorder alone: `recsrc,0,2; recrun,1; recout,0,0,1`.

use super::line::Line;
use super::look::{GENERATOR, SET};
use crate::Drive;
use crate::moves::Moves;
use crate::watch::Watch;
use piezoid::Error;
use std::time::{Duration, Instant};

/// Sources of the recorder.
pub(super) const POSITION: usize = 0;
pub(super) const VOLTAGE: usize = 2;

/// Values of `recast`.
const BY_COMMAND: usize = 0;
pub(super) const BY_WAVE: usize = 2;

/// Error of a value of the generator that is read back [%], and of a setpoint [V].
const SHARE_ERROR: f64 = 5e-3;
const SET_ERROR: f64 = 2e-3;

/// Pause between two questions, and time in which the recorder or a wave of one value must end.
const PAUSE: Duration = Duration::from_millis(20);
const SOON: Duration = Duration::from_secs(2);

/// A measurement at work.
pub(crate) struct Run<'a> {
    pub(crate) line: Line<'a>,
    /// Voltages of the generator's 0 and 100 % [V].
    pub(crate) output: (f64, f64),
    /// Lowest and highest voltage [V].
    pub(crate) range: (f64, f64),
    /// Largest slew rate [V/s]; infinite without a limit.
    pub(crate) fastest: f64,
    /// Unit of the position.
    pub(crate) unit: String,
}

impl Run<'_> {
    /// Voltage at the output, as the recorder measures it [V].
    pub(crate) fn measured(&mut self) -> Result<f64, Error> {
        self.line.choose("recast", BY_COMMAND)?;
        self.line.choose("recsrc,0", VOLTAGE)?;
        self.line.choose("recstr", 1)?;
        self.line.choose("reclen", 1)?;
        self.line.assign("recrun", "1")?;
        self.ended("recrun", SOON)?;
        // The answer does not repeat the number of values.
        self.line.number_of("recout,0,0,1", "recout,0,0")
    }

    /// Waits until what runs has ended.
    fn ended(&mut self, name: &str, time: Duration) -> Result<(), Error> {
        let begin = Instant::now();
        while self.line.number(name)? != 0.0 {
            if begin.elapsed() > time {
                return Err(Error::Content(format!("the controller has not ended what `{name}` started in {time:?}")));
            }
            self.line.wire.watch.pause(PAUSE)?;
        }
        Ok(())
    }

    /// The setpoint, if the generator gave it, to `set`. The voltage changes by no more than the error of a
    /// measurement.
    pub(crate) fn take_over(&mut self) -> Result<(), Error> {
        if self.line.number("modsrc")? as u8 == GENERATOR {
            let voltage = self.measured()?;
            self.hand_over(voltage.max(self.output.0).min(self.output.1))?;
        }
        Ok(())
    }

    /// `set` gives the setpoint again, from this voltage on.
    pub(crate) fn hand_over(&mut self, voltage: f64) -> Result<(), Error> {
        self.set(voltage)?;
        self.line.choose("modsrc", SET.into())
    }

    /// The drive to the generator, which then stands at its first value.
    pub(crate) fn upload(&mut self, drive: &Drive) -> Result<(), Error> {
        let (low, high) = self.output;
        for (k, u) in drive.u.iter().enumerate() {
            self.line.wire.watch.stage("upload of the drive", k, drive.u.len())?;
            let share = (100.0 * (u - low) / (high - low)).clamp(0.0, 100.0);
            self.line.set(&format!("gbarb,{k}"), share, SHARE_ERROR)?;
        }
        for name in ["goarb", "gsarb", "gearb"] {
            self.line.choose(name, 0)?;
        }
        self.line.choose("gcarb", 1)?;
        self.line.choose("gtarb", 1)?;
        self.line.assign("grun", "1")?;
        self.ended("grun", SOON)
    }

    /// Returns an error if the measured voltage is another one.
    pub(crate) fn expect(&mut self, voltage: f64, allowed: f64, when: &str) -> Result<(), Error> {
        let begin = Instant::now();
        loop {
            let measured = self.measured()?;
            if (measured - voltage).abs() <= allowed {
                return Ok(());
            }
            if begin.elapsed() > SOON {
                let message = format!("the output is at {measured:.3} V, not {voltage:.3} V, {when}");
                return Err(Error::Content(message));
            }
            self.line.wire.watch.pause(PAUSE)?;
        }
    }

    /// Sets the recorder for a drive with so many servo cycles a sample, and lets the generator give the setpoint.
    pub(crate) fn configure(&mut self, drive: &Drive, cycles: usize) -> Result<(), Error> {
        let n = drive.u.len();
        self.line.choose("gearb", n - 1)?;
        self.line.choose("gtarb", cycles)?;
        self.line.choose("recsrc,0", VOLTAGE)?;
        self.line.choose("recsrc,1", POSITION)?;
        self.line.choose("recstr", cycles)?;
        self.line.choose("reclen", n)?;
        self.line.choose("recast", BY_WAVE)?;
        self.line.assign("recrun", "1").map(|_| ())
    }

    pub(crate) fn follow_generator(&mut self) -> Result<(), Error> {
        self.line.choose("modsrc", GENERATOR.into())
    }

    /// Plays the drive, and waits until it has ended and is recorded.
    pub(crate) fn play(&mut self, drive: &Drive) -> Result<(), Error> {
        let length = drive.u.len() as f64 * drive.ts;
        self.played(0.0, length)?;
        self.line.assign("grun", "1")?;
        self.until_played(length, PAUSE, |run, passed| Ok(run.line.number("grun")? == 0.0 && passed))?;
        self.ended("recrun", SOON)
    }

    /// The first `count` values of a channel of the recorder.
    pub(crate) fn read(&mut self, channel: usize, count: usize) -> Result<Vec<f64>, Error> {
        self.line.wire.watch.stage("the record is read", channel, 2)?;
        let mut values = self.line.numbers(&format!("recoutf,{channel}"))?;
        if values.len() < count {
            let have = values.len();
            return Err(Error::Content(format!("the recorder answers {have} samples, not the {count} of the drive")));
        }
        values.truncate(count);
        Ok(values)
    }
}

impl<'a> Moves<'a> for Run<'a> {
    fn watch(&mut self) -> &mut Watch<'a> {
        &mut self.line.wire.watch
    }

    fn set(&mut self, volts: f64) -> Result<(), Error> {
        self.line.set("set", volts, SET_ERROR)
    }

    /// While a drive is played, the recorder is busy, and nothing else measures the voltage.
    fn present(&mut self, requested: Option<f64>) -> Result<Vec<(String, f64)>, Error> {
        let position = (format!("y_{}", self.unit), self.line.number("meas")?);
        Ok(requested.map(|volts| ("u_V".to_string(), volts)).into_iter().chain([position]).collect())
    }

    fn bounds(&self) -> (f64, (f64, f64)) {
        (self.fastest, self.range)
    }
}
