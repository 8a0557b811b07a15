//! What moves: the drive on an axis in open loop.
//!
//! ```text
//! WAV 1 X PNT 1 10 v_1 ...         the drive to wave table 1
//! SVO 1 0                          open loop
//! SVA 1 ..., VOL? 1                what an open-loop value gives, checked by a small move
//! SVA 1 ...                        slowly to the first voltage
//! DRC 1 1 16, DRC 2 1 2, RTR k     voltage and position to tables 1 and 2, every k servo cycles
//! DRT 0 0 0, WOS 1 0               no other trigger, no offset
//! WSL 1 1, WGC 1 1, WTR 1 k 0      generator 1: table 1, once, each point for k servo cycles
//! WGO 1 1                          starts generator and recorder together
//! DRR? 1 n 1 2                     the record
//! SVA 1 ...                        slowly back to where the axis was
//! ```
//! The voltage of the record is the one that the controller measured at its output, not the one that was asked for.

use crate::controller::{Axis, Controller};
use crate::recording::Sources;
use piezoid::Error;
use piezoid::progress::{Progress, Stage};
use std::f64::consts::PI;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time between two values of a slow move [s].
const STEP: f64 = 0.02;

/// Time between two questions whether the generator still runs.
const PAUSE: Duration = Duration::from_millis(50);

/// Points in a line of a wave table.
const POINTS: usize = 10;

/// Relative error at which the gain is said to be another one.
const GAIN_ERROR: f64 = 0.05;

/// Error of a voltage that says nothing [V].
const NOISE: f64 = 0.05;

/// Share of the way to the farthest voltage of the drive by which the gain is checked; the least voltage that shows it
/// [V]; number of steps.
const PROBE: f64 = 0.05;
const LEAST_PROBE: f64 = 0.5;
const PROBES: usize = 10;

/// A drive.
pub(crate) struct Play<'a> {
    /// Voltages [V].
    pub(crate) u: &'a [f64],
    /// Sampling period [s].
    pub(crate) ts: f64,
    /// Servo cycles in it.
    pub(crate) cycles: u64,
}

/// A measurement at work.
pub(crate) struct Run<'a, 'b> {
    pub(crate) controller: &'a mut Controller,
    pub(crate) axis: &'a Axis,
    pub(crate) channel: usize,
    /// Voltage of an open-loop value of 1 [V], if it is given.
    pub(crate) gain: Option<f64>,
    /// Lowest and highest voltage [V].
    pub(crate) range: (f64, f64),
    pub(crate) progress: &'a mut Progress<'b>,
}

impl Run<'_, '_> {
    pub(crate) fn command(&mut self, command: &str) -> Result<(), Error> {
        self.controller.line.command(command)
    }

    fn tell(&mut self, what: &str, done: usize, total: usize) -> Result<(), Error> {
        let cancelled = || Error::Cancelled { what: what.into(), done, total };
        if (self.progress)(Stage::new(what, done, total)).is_break() { Err(cancelled()) } else { Ok(()) }
    }

    fn gain(&self) -> f64 {
        self.gain.unwrap_or(1.0)
    }

    /// The voltage of the axis.
    pub(crate) fn start(&mut self) -> Result<f64, Error> {
        let start = self.controller.needed(&format!("SVA? {}", self.axis.name))? * self.gain();
        let ((low, high), name) = (self.range, &self.axis.name);
        if !(low - NOISE..=high + NOISE).contains(&start) {
            return Err(Error::Content(format!(
                "axis {name} is at {start:.3} V, outside {low} to {high} V: move it there first, or give another range"
            )));
        }
        Ok(start)
    }

    /// The drive to wave table 1, as open-loop values.
    pub(crate) fn upload(&mut self, play: &Play) -> Result<(), Error> {
        let lines = play.u.len().div_ceil(POINTS);
        for (k, points) in play.u.chunks(POINTS).enumerate() {
            self.tell("upload of the drive", k, lines)?;
            let (mode, first, count) = (if k == 0 { 'X' } else { '&' }, k * POINTS + 1, points.len());
            let points: Vec<String> = points.iter().map(|u| format!("{:.6}", u / self.gain())).collect();
            self.command(&format!("WAV 1 {mode} PNT {first} {count} {}", points.join(" ")))?;
        }
        Ok(())
    }

    fn set(&mut self, volts: f64) -> Result<(), Error> {
        let (axis, value) = (&self.axis.name, volts / self.gain());
        self.controller.line.command(&format!("SVA {axis} {value:.6}"))
    }

    /// Moves slowly from one voltage to another, along a half cosine.
    pub(crate) fn ramp(&mut self, from: f64, to: f64, time: f64) -> Result<(), Error> {
        let steps = (time / STEP).ceil() as usize;
        for k in 1..=steps {
            self.tell("ramp to the voltage", k, steps)?;
            self.set(from + (0.5 - 0.5 * (PI * k as f64 / steps as f64).cos()) * (to - from))?;
            sleep(Duration::from_secs_f64(time / steps as f64));
        }
        self.set(to)
    }

    /// Moves by a small part of the drive and back, and checks what the output does.
    pub(crate) fn check_gain(&mut self, play: &Play, start: f64) -> Result<(), Error> {
        let farther = |far: f64, u: f64| if (u - start).abs() > (far - start).abs() { u } else { far };
        let way = play.u.iter().copied().fold(start, farther) - start;
        let probe = way.signum() * (PROBE * way.abs()).max(LEAST_PROBE).min(way.abs());
        let query = format!("VOL? {}", self.channel);
        let Some(first) = self.controller.value(&query)? else {
            let rule = "must be given, because the controller does not report its voltage to check it";
            return if self.gain.is_some() { Ok(()) } else { Err(Error::parameter("gain", "(not given)", rule)) };
        };
        let mut wrong = None;
        for k in 0..=PROBES {
            self.tell("check of the gain", k, PROBES)?;
            let moved = probe * k as f64 / PROBES as f64;
            self.set(start + moved)?;
            sleep(Duration::from_secs_f64(STEP));
            let voltage = self.controller.needed(&query)?;
            if (voltage - start - moved).abs() > GAIN_ERROR * moved.abs() + NOISE {
                wrong = Some((moved, voltage));
                break;
            }
        }
        self.set(start)?;
        wrong.map_or(Ok(()), |(moved, voltage)| Err(self.wrong(start, first, moved, voltage)))
    }

    /// What is wrong if a move from `start` changes the output from `first` to `voltage` [V].
    fn wrong(&self, start: f64, first: f64, moved: f64, voltage: f64) -> Error {
        let (name, channel) = (&self.axis.name, self.channel);
        let gain = self.gain() * (voltage - first) / moved;
        if moved == 0.0 || (first - start).abs() > NOISE + GAIN_ERROR * start.abs() {
            let rule = "is wrong, or the output has an offset: correct the gain, or set the offset to 0";
            let rule = format!("the output is at {first:.3} V, not {start:.3} V: the gain {rule}");
            return Error::parameter("gain", self.gain(), rule);
        }
        if gain < 0.1 * self.gain() {
            let follows = voltage - first;
            return Error::Content(format!(
                "output channel {channel} does not follow axis {name}: a move of {moved:.3} V gives {follows:.3} V; \
                 give the channel of the axis"
            ));
        }
        let rule = format!("the controller gives about {gain:.4} V for an open-loop value of 1: give this gain");
        Error::parameter("gain", self.gain(), rule)
    }

    pub(crate) fn wait(&mut self, time: f64) -> Result<(), Error> {
        let begin = Instant::now();
        while begin.elapsed().as_secs_f64() < time {
            self.tell("settling [ms]", (1e3 * begin.elapsed().as_secs_f64()) as usize, (1e3 * time) as usize)?;
            sleep(PAUSE);
        }
        Ok(())
    }

    /// Starts generator and recorder, and waits until the drive has ended and is recorded.
    pub(crate) fn play(&mut self, play: &Play, sources: &Sources) -> Result<(), Error> {
        let (k, axis, cycles) = (self.channel, &self.axis.name, play.cycles);
        // What others have left there; not every controller has it.
        for command in ["DRT 0 0 0".to_string(), format!("WOS {k} 0")] {
            self.controller.line.command_if_known(&command)?;
        }
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
        let (begin, length) = (Instant::now(), play.u.len() as f64 * play.ts);
        loop {
            let time = begin.elapsed().as_secs_f64();
            self.tell("the drive is played [ms]", (1e3 * time.min(length)) as usize, (1e3 * length) as usize)?;
            // Points of a recording before this one are no points of this one.
            let played = time >= length && !self.controller.runs(k)?;
            if played && self.controller.needed("DRL? 1")? as usize >= play.u.len() {
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
