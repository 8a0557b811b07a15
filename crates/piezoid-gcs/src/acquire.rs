//! A drive played by the wave generator of a controller in open loop, while its recorder measures.
//!
//! ```text
//! SVO 1 0                          open loop
//! WAV 1 X PNT 1 10 v_1 ...         the drive to wave table 1
//! SVA 1 ..., VOL? 1                what an open-loop value gives, checked by a small move
//! SVA 1 ...                        slowly to the first voltage
//! DRC 1 1 16, DRC 2 1 2, RTR k     voltage and position to tables 1 and 2, every k servo cycles
//! WSL 1 1, WGC 1 1, WTR 1 k 0      generator 1: table 1, once, each point for k servo cycles
//! WGO 1 1                          starts generator and recorder together
//! DRR? 1 n 1 2                     the record
//! SVA 1 ...                        slowly back to where the axis was
//! ```
//! The voltage of the record is the one that the controller measured at its output, not the one that was asked for.

use crate::controller::{Axis, ConnectOptions, Controller};
use crate::recording::{Sources, read};
use piezoid::formats::ColumnSelection;
use piezoid::progress::{Progress, Stage};
use piezoid::{Error, File, OptionKind, OptionRow, Record, Units, options};
use serde_json::{Value, json};
use std::thread::sleep;
use std::time::{Duration, Instant};

options! {
    /// How to measure on a controller.
    pub struct AcquireOptions {
        /// Axis to drive.
        axis: Option<String> = None, OptionRow::new(OptionKind::Text("AXIS")).absent("the first");
        /// Lowest and highest voltage that the actuator may get.
        range: Option<(f64, f64)> = None, OptionRow { unit: "V", ..OptionRow::new(OptionKind::Pair) }.absent("those of the controller");
        /// Voltage that an open-loop value of 1 gives; some controllers count open-loop values in micrometres.
        gain: f64 = 1.0, OptionRow::positive("V");
        /// Time of the move to the first voltage, and of the move back.
        ramp: f64 = 1.0, OptionRow::not_negative("s");
        /// Wait at the first voltage before the drive.
        settle: f64 = 0.5, OptionRow::not_negative("s");
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

/// Time between two values of a slow move [s].
const STEP: f64 = 0.02;

/// Time between two questions whether the generator still runs.
const PAUSE: Duration = Duration::from_millis(50);

/// Points in a line of a wave table.
const POINTS: usize = 10;

/// Relative error at which the gain is said to be another one.
const GAIN_ERROR: f64 = 0.05;

/// Error of a voltage that says nothing of the gain [V].
const NOISE: f64 = 0.05;

/// Share of the drive by which the voltage is moved to check the gain, and the time of this move [s].
const PROBE: f64 = 0.05;
const PROBE_TIME: f64 = 0.2;

impl AcquireOptions {
    /// The options for a controller there.
    pub fn at(host: &str, port: u16) -> Self {
        let connection = ConnectOptions { host: host.into(), port, ..ConnectOptions::default() };
        AcquireOptions { connection, ..AcquireOptions::default() }
    }

    /// Plays the drive in a file, and returns what was measured. The axis is in open loop afterwards, at the value that
    /// it had before. If the work is cancelled, the generator is stopped and the voltage stays where it is.
    ///
    /// # Errors
    /// Returns an error for a file without a drive, a drive that the controller cannot play or record or that leaves
    /// the range, a gain that is not the one of the controller, a controller that does not answer or refuses, and a
    /// cancelled measurement.
    pub fn run(&self, drive: &File, columns: &ColumnSelection, progress: &mut Progress) -> Result<Acquired, Error> {
        let signal = drive.input(columns)?;
        let factor = Units::factor(&signal.unit, "V").ok_or_else(|| {
            let (what, found) = (format!("the drive in {}", drive.name), signal.unit.clone());
            Error::Units { what, found, wanted: "V".into() }
        })?;
        let u: Vec<f64> = signal.samples.iter().map(|u| u * factor).collect();
        let mut controller = self.connection.connect()?;
        let (axis, channel) = self.axis(&controller)?;
        let cycles = cycles(signal.ts, controller.cycle)?;
        self.fits(&u, signal.ts, &axis, &controller)?;
        let mut run = Run { controller: &mut controller, axis: &axis, channel, gain: self.gain, progress };
        let sources = Sources::of(&mut run.controller.line)?;
        let mut notes = Vec::new();
        if axis.servo {
            run.command(&format!("SVO {} 0", axis.name))?;
            notes.push(format!("the servo of axis {} was on; it is off now", axis.name));
        }
        run.upload(&u)?;
        let start = run.controller.needed(&format!("SVA? {}", axis.name))? * self.gain;
        let outcome = run.check_gain(&u, start, &mut notes).and_then(|()| {
            run.ramp(start, u[0], self.ramp)?;
            run.wait("settling [ms]", self.settle)?;
            run.play(&u, signal.ts, cycles, &sources)
        });
        // Whatever happened, the generator must not go on.
        let stopped = run.command(&format!("WGO {channel} 0"));
        outcome.and(stopped)?;
        let record = read(run.controller, u.len(), &axis.unit)?;
        if let Err(error) = run.ramp(u[u.len() - 1], start, self.ramp) {
            notes.push(format!("the axis did not move back to where it was: {error}"));
        }
        if (record.ts() / signal.ts - 1.0).abs() > 1e-3 {
            let (wanted, found) = (signal.ts, record.ts());
            return Err(Error::Content(format!(
                "the controller recorded every {found} s, not every {wanted} s as asked"
            )));
        }
        notes.extend(difference(&u, record.u()));
        Ok(Acquired { record, identity: controller.identity, notes })
    }

    /// The axis, and the number of its generator and output channel.
    fn axis(&self, controller: &Controller) -> Result<(Axis, usize), Error> {
        let axes = &controller.axes;
        let k = match &self.axis {
            Some(name) => axes.iter().position(|axis| axis.name == *name),
            None => Some(0),
        };
        let found = k.and_then(|k| Some((axes.get(k)?.clone(), k + 1)));
        let name = self.axis.as_deref().unwrap_or_default();
        found.ok_or_else(|| Error::unknown("axis", name, axes.iter().map(|axis| &*axis.name)))
    }

    /// Returns an error if the drive leaves the range, or has more samples than the controller holds.
    fn fits(&self, u: &[f64], ts: f64, axis: &Axis, controller: &Controller) -> Result<(), Error> {
        let (low, high) = self.range.or(axis.range).ok_or_else(|| {
            Error::parameter("range", "(not given)", "must be two numbers [V], because the controller tells no limits")
        })?;
        if let Some((k, value)) = u.iter().enumerate().find(|(_, u)| **u < low || **u > high) {
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
}

/// The servo cycles in a sampling period [s].
fn cycles(ts: f64, cycle: f64) -> Result<u64, Error> {
    let cycles = (ts / cycle).round().max(1.0);
    if (ts / cycle / cycles - 1.0).abs() < 1e-6 {
        return Ok(cycles as u64);
    }
    let nearest = cycles * cycle;
    Err(Error::Content(format!(
        "the drive is sampled every {ts} s, but the controller plays multiples of its servo cycle of {cycle} s: make \
         the drive with {nearest} s"
    )))
}

/// What to say if the recorded voltage is another one than the voltage that was asked for.
fn difference(asked: &[f64], measured: &[f64]) -> Option<String> {
    let largest = asked.iter().zip(measured).map(|(a, m)| (a - m).abs()).fold(0.0, f64::max);
    let peak = asked.iter().fold(0.0, |peak: f64, u| peak.max(u.abs()));
    (largest > GAIN_ERROR * peak).then(|| {
        format!("the recorded voltage differs from the drive by up to {largest:.3} V: the record has the recorded one")
    })
}

/// A measurement at work.
struct Run<'a, 'b> {
    controller: &'a mut Controller,
    axis: &'a Axis,
    channel: usize,
    gain: f64,
    progress: &'a mut Progress<'b>,
}

impl Run<'_, '_> {
    fn command(&mut self, command: &str) -> Result<(), Error> {
        self.controller.line.command(command)
    }

    fn tell(&mut self, what: &str, done: usize, total: usize) -> Result<(), Error> {
        let cancelled = || Error::Cancelled { what: what.into(), done, total };
        if (self.progress)(Stage::new(what, done, total)).is_break() { Err(cancelled()) } else { Ok(()) }
    }

    /// The drive to wave table 1, as open-loop values.
    fn upload(&mut self, u: &[f64]) -> Result<(), Error> {
        let lines = u.len().div_ceil(POINTS);
        for (k, points) in u.chunks(POINTS).enumerate() {
            self.tell("the drive to the controller", k, lines)?;
            let (mode, first, count) = (if k == 0 { 'X' } else { '&' }, k * POINTS + 1, points.len());
            let points: Vec<String> = points.iter().map(|u| format!("{:.6}", u / self.gain)).collect();
            self.command(&format!("WAV 1 {mode} PNT {first} {count} {}", points.join(" ")))?;
        }
        Ok(())
    }

    fn set(&mut self, volts: f64) -> Result<(), Error> {
        let (axis, value) = (&self.axis.name, volts / self.gain);
        self.controller.line.command(&format!("SVA {axis} {value:.6}"))
    }

    /// Moves slowly from one voltage to another, along a half cosine.
    fn ramp(&mut self, from: f64, to: f64, time: f64) -> Result<(), Error> {
        let steps = (time / STEP).ceil() as usize;
        for k in 1..=steps {
            self.tell("slowly to the voltage", k, steps)?;
            let share = 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / steps as f64).cos();
            self.set(from + share * (to - from))?;
            sleep(Duration::from_secs_f64(time / steps as f64));
        }
        self.set(to)
    }

    /// Moves by a small part of the drive, and checks what the output does.
    fn check_gain(&mut self, u: &[f64], start: f64, notes: &mut Vec<String>) -> Result<(), Error> {
        let farther = |far: f64, u: f64| if (u - start).abs() > (far - start).abs() { u } else { far };
        let step = PROBE * (u.iter().copied().fold(start, farther) - start);
        if step == 0.0 {
            return Ok(());
        }
        let query = format!("VOL? {}", self.channel);
        let before = self.controller.value(&query)?;
        self.ramp(start, start + step, PROBE_TIME)?;
        let after = self.controller.value(&query)?;
        self.ramp(start + step, start, PROBE_TIME)?;
        let Some((before, after)) = before.zip(after) else {
            notes.push("the controller does not tell its voltage: the gain was not checked before the drive".into());
            return Ok(());
        };
        if (after - before - step).abs() <= GAIN_ERROR * step.abs() + NOISE {
            return Ok(());
        }
        let measured = self.gain * (after - before) / step;
        let rule = format!("the controller gives {measured:.4} V for an open-loop value of 1: give this gain");
        Err(Error::parameter("gain", self.gain, rule))
    }

    fn wait(&mut self, what: &str, time: f64) -> Result<(), Error> {
        let begin = Instant::now();
        while begin.elapsed().as_secs_f64() < time {
            self.tell(what, (1e3 * begin.elapsed().as_secs_f64()) as usize, (1e3 * time) as usize)?;
            sleep(PAUSE);
        }
        Ok(())
    }

    /// Starts generator and recorder, and waits until both have ended.
    fn play(&mut self, u: &[f64], ts: f64, cycles: u64, sources: &Sources) -> Result<(), Error> {
        let (k, axis) = (self.channel, &self.axis.name);
        for command in [
            format!("DRC 1 {k} {}", sources.voltage),
            format!("DRC 2 {axis} {}", sources.position),
            format!("RTR {cycles}"),
            format!("WSL {k} 1"),
            format!("WGC {k} 1"),
            format!("WTR {k} {cycles} 0"),
            format!("WGO {k} 1"),
        ] {
            self.controller.line.command(&command)?;
        }
        let (begin, length) = (Instant::now(), u.len() as f64 * ts);
        loop {
            let time = begin.elapsed().as_secs_f64();
            self.tell("the drive is played [ms]", (1e3 * time.min(length)) as usize, (1e3 * length) as usize)?;
            // A byte: which generators run.
            let running = self.controller.line.number(b"\x09", 16)? >> (k - 1) & 1 == 1;
            if !running && self.controller.needed("DRL? 1")? as usize >= u.len() {
                return Ok(());
            }
            if time > 1.5 * length + 10.0 {
                return Err(Error::Content(format!(
                    "the controller has not ended a drive of {length} s after {time:.0} s"
                )));
            }
            sleep(PAUSE);
        }
    }
}

impl Acquired {
    /// What the controller said, and what the user should know, as a document.
    pub fn to_json(&self) -> Value {
        let record = &self.record;
        json!({
            "identity": self.identity, "notes": self.notes, "ts": record.ts(), "samples": record.len(),
            "units": record.units(),
        })
    }
}
