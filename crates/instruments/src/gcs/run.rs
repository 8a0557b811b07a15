//! What moves: the drive on an axis, in open loop as follows.
//!
//! ```text
//! WAV 1 X PNT 1 10 v_1 ...         the drive to wave table 1
//! DRT 0 0 0, WOS 1 0               no other trigger, no offset
//! DRC 1 1 16, DRC 2 1 2, RTR k     voltage and position to tables 1 and 2, every k servo cycles
//! WSL 1 1, WGC 1 1, WTR 1 k 0      generator 1: table 1, once, each point for k servo cycles; 1 joins the points
//! SVO 1 0                          open loop
//! SVA 1 ..., VOL? 1                what an open-loop value gives, checked by a small move
//! SVA 1 ...                        slowly to the first voltage
//! WGO 1 1                          starts generator and recorder together
//! DRR? 1 n 1 2                     the record
//! SVA 1 ..., VOL? 1                slowly to the voltage of rest
//! ```
//! The voltage of the record is the one that the controller measured at its output, not the requested one.

use crate::Drive;
use crate::gcs::controller::Axis;
use crate::gcs::line::Line;
use crate::gcs::recording::Sources;
use crate::moves::Moves;
use crate::watch::Watch;
use piezoid::Error;
use std::time::Duration;

/// Time between two questions whether the generator still runs.
const PAUSE: Duration = Duration::from_millis(50);

/// Points in a line of a wave table.
const POINTS: usize = 10;

/// A measurement at work.
pub(crate) struct Run<'a> {
    pub(crate) line: Line<'a>,
    pub(crate) axis: Axis,
    /// True if the drive is positions, which the servo follows.
    pub(crate) is_closed: bool,
    pub(crate) channel: usize,
    /// Voltage of an open-loop value of 1 [V], if it is an option.
    pub(crate) gain: Option<f64>,
    /// Lowest and highest voltage [V], or position.
    pub(crate) range: (f64, f64),
    /// Largest slew rate [V/s], or velocity; infinite without a limit.
    pub(crate) fastest: f64,
}

impl Run<'_> {
    pub(crate) fn gain(&self) -> f64 {
        self.gain.unwrap_or(1.0)
    }

    /// A voltage as an open-loop value, or a position, to well below a nanometre if its unit is mm.
    fn number(&self, value: f64) -> String {
        if self.is_closed { format!("{value:.9}") } else { format!("{:.6}", value / self.gain()) }
    }

    /// The voltage at the output, as the controller measures it, if it does.
    pub(crate) fn measured(&mut self) -> Result<Option<f64>, Error> {
        self.line.value(&format!("VOL? {}", self.channel))
    }

    /// The voltage that is requested in open loop.
    pub(crate) fn requested(&mut self) -> Result<f64, Error> {
        Ok(self.line.needed(&format!("SVA? {}", self.axis.name))? * self.gain())
    }

    /// The drive to wave table 1, as open-loop values.
    pub(crate) fn upload(&mut self, drive: &Drive) -> Result<(), Error> {
        let lines = drive.u.len().div_ceil(POINTS);
        for (k, points) in drive.u.chunks(POINTS).enumerate() {
            self.line.watch.stage("upload of the drive", k, lines)?;
            let (mode, first, count) = (if k == 0 { 'X' } else { '&' }, k * POINTS + 1, points.len());
            let points: Vec<String> = points.iter().map(|u| self.number(*u)).collect();
            self.line.command(&format!("WAV 1 {mode} PNT {first} {count} {}", points.join(" ")))?;
        }
        Ok(())
    }

    /// Sets recorder and generator, with so many servo cycles a sample. Nothing moves.
    pub(crate) fn configure(&mut self, drive: &Drive, cycles: u64, sources: &Sources) -> Result<(), Error> {
        let (k, axis, joined) = (self.channel, &self.axis.name, u8::from(drive.joined));
        // What others have left there; not every controller has it.
        for command in ["DRT 0 0 0".to_string(), format!("WOS {k} 0")] {
            self.line.command_if_known(&command)?;
        }
        let commands = [
            format!("DRC 1 {k} {}", sources.voltage),
            format!("DRC 2 {axis} {}", sources.position),
            format!("RTR {cycles}"),
            format!("WSL {k} 1"),
            format!("WGC {k} 1"),
            format!("WTR {k} {cycles} {joined}"),
        ];
        commands.iter().try_for_each(|command| self.line.command(command))
    }

    /// Starts generator and recorder, and waits until the drive has ended and is recorded.
    pub(crate) fn play(&mut self, drive: &Drive) -> Result<(), Error> {
        let (k, n, length) = (self.channel, drive.u.len(), drive.u.len() as f64 * drive.ts);
        self.played(0.0, length)?;
        self.line.command(&format!("WGO {k} 1"))?;
        // Points of a recording before this one are none of it.
        self.until_played(length, PAUSE, |run, passed| {
            Ok(!run.line.runs(k)? && passed && run.line.needed("DRL? 1")? as usize >= n)
        })
    }
}

impl<'a> Moves<'a> for Run<'a> {
    fn watch(&mut self) -> &mut Watch<'a> {
        &mut self.line.watch
    }

    fn set(&mut self, volts: f64) -> Result<(), Error> {
        let (command, axis) = (if self.is_closed { "MOV" } else { "SVA" }, &self.axis.name);
        self.line.command(&format!("{command} {axis} {}", self.number(volts)))
    }

    /// Both are measured, one right after the other.
    fn present(&mut self, _: Option<f64>) -> Result<Vec<(String, f64)>, Error> {
        let queries = [format!("VOL? {}", self.channel), format!("POS? {}", self.axis.name)];
        let names = ["u_V".to_string(), format!("y_{}", self.axis.unit)];
        Ok(self.line.values(&queries)?.map_or_else(Vec::new, |values| names.into_iter().zip(values).collect()))
    }

    fn bounds(&self) -> (f64, (f64, f64)) {
        (self.fastest, self.range)
    }
}
