//! A controller, and what it says of itself.

use crate::line::Line;
use piezoid::{Error, OptionKind, OptionRow, options};
use serde::Serialize;
use serde_json::{Value, json};
use std::time::Duration;

/// Parameters of a controller, by the numbers of PI's manuals.
const SERVO_UPDATE_TIME: u32 = 0x0E00_0200;
const RECORDER_POINTS: u32 = 0x1600_0200;
const RECORDER_POINTS_PER_TABLE: u32 = 0x1600_0201;
const RECORDER_TABLES: u32 = 0x1600_0300;

options! {
    /// Where a controller is.
    pub struct ConnectOptions {
        /// Address or name of the controller in the network.
        host: String = "127.0.0.1".into(), OptionRow::new(OptionKind::Text("HOST"));
        /// TCP port of the controller.
        port: u16 = 50000, OptionRow::new(OptionKind::Integer(1, 65535));
        /// Time to wait for an answer.
        timeout: f64 = 5.0, OptionRow::positive("s");
    }
}

impl ConnectOptions {
    /// Connects to the controller, and asks what it is. Nothing moves.
    ///
    /// # Errors
    /// Returns an error if nothing answers there in time, or something else than a controller with GCS 2.0.
    pub fn connect(&self) -> Result<Controller, Error> {
        let patience = Duration::from_secs_f64(self.timeout.clamp(1e-3, 3600.0));
        let mut line = Line::open(&self.host, self.port, patience)?;
        let version = line.query("CSV?")?.concat();
        if !version.trim().starts_with('2') {
            return Err(line.strange(&version, "the version of GCS 2.0"));
        }
        let identity = line.query("*IDN?")?.concat();
        let names: Vec<String> =
            line.query("SAI?")?.iter().flat_map(|l| l.split_whitespace()).map(String::from).collect();
        let mut controller = Controller { line, identity, cycle: 0.0, table: None, recorder: None, axes: Vec::new() };
        controller.cycle = controller.parameter(SERVO_UPDATE_TIME)?.filter(|cycle| *cycle > 0.0).ok_or_else(|| {
            Error::Content(
                "the controller does not tell its servo update time (parameter 0x0E000200): it has no known rate"
                    .into(),
            )
        })?;
        controller.table = controller.value("WMS? 1")?.map(|points| points as usize);
        controller.recorder = controller.capacity()?;
        for (k, name) in names.into_iter().enumerate() {
            let axis = controller.axis(name, k + 1)?;
            controller.axes.push(axis);
        }
        Ok(controller)
    }
}

/// A controller that is connected.
#[derive(Debug)]
pub struct Controller {
    pub(crate) line: Line,
    /// What it answers to `*IDN?`.
    pub identity: String,
    /// Servo update time, the period of its wave generators and recorder [s].
    pub cycle: f64,
    /// Points of a wave table, if it tells them.
    pub table: Option<usize>,
    /// Points of a table of the recorder, if it tells them.
    pub recorder: Option<usize>,
    /// Its axes.
    pub axes: Vec<Axis>,
}

/// An axis of a controller, as it was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Unit of its position.
    pub unit: String,
    /// True in closed loop.
    pub servo: bool,
    /// Its open-loop value.
    pub value: f64,
    /// Its position.
    pub position: f64,
    /// Voltage of the output channel with the number of the axis, if it is told [V].
    pub voltage: Option<f64>,
    /// Lowest and highest voltage of that channel, if they are told [V].
    pub range: Option<(f64, f64)>,
}

impl Controller {
    /// What it said, as a document.
    pub fn to_json(&self) -> Value {
        json!({
            "identity": self.identity, "cycle": self.cycle, "table": self.table, "recorder": self.recorder,
            "axes": self.axes,
        })
    }

    /// The number that answers a query; `None` if the controller refuses it.
    pub(crate) fn value(&mut self, query: &str) -> Result<Option<f64>, Error> {
        let Some(lines) = self.line.asked(query)? else { return Ok(None) };
        let text = lines[0].rsplit('=').next().unwrap_or_default().trim().to_string();
        text.parse().map(Some).map_err(|_| self.line.strange(&lines[0], "a number"))
    }

    /// The number that answers a query that every controller knows.
    pub(crate) fn needed(&mut self, query: &str) -> Result<f64, Error> {
        let refused = || Error::Content(format!("the controller does not answer `{query}`, which is needed"));
        self.value(query)?.ok_or_else(refused)
    }

    fn parameter(&mut self, number: u32) -> Result<Option<f64>, Error> {
        self.value(&format!("SPA? 1 0x{number:08X}"))
    }

    /// Points of a table of the recorder.
    fn capacity(&mut self) -> Result<Option<usize>, Error> {
        if let Some(points) = self.parameter(RECORDER_POINTS_PER_TABLE)? {
            return Ok(Some(points as usize));
        }
        let (all, tables) = (self.parameter(RECORDER_POINTS)?, self.parameter(RECORDER_TABLES)?);
        Ok(all.zip(tables).map(|(all, tables)| (all / tables.max(1.0)) as usize))
    }

    fn axis(&mut self, name: String, channel: usize) -> Result<Axis, Error> {
        let unit = self.line.asked(&format!("PUN? {name}"))?.map_or_else(String::new, |lines| lines.concat());
        let unit = unit.rsplit('=').next().unwrap_or_default().trim().to_lowercase();
        let lowest = self.value(&format!("VMI? {channel}"))?;
        Ok(Axis {
            unit: if unit.is_empty() { "um".into() } else { unit.replace('\u{b5}', "u") },
            servo: self.needed(&format!("SVO? {name}"))? != 0.0,
            value: self.needed(&format!("SVA? {name}"))?,
            position: self.needed(&format!("POS? {name}"))?,
            voltage: self.value(&format!("VOL? {channel}"))?,
            range: lowest.zip(self.value(&format!("VMA? {channel}"))?),
            name,
        })
    }
}
