//! A controller, and what it reports about itself.

use crate::line::Line;
use piezoid::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use serde::Serialize;
use serde_json::{Value, json};
use std::time::Duration;

/// More axes are not asked.
const MOST_AXES: usize = 64;

/// Parameters of a controller, by the numbers of PI's manuals.
const SERVO_UPDATE_TIME: u32 = 0x0E00_0200;
const RECORDER_POINTS: u32 = 0x1600_0200;
const RECORDER_POINTS_PER_TABLE: u32 = 0x1600_0201;
const RECORDER_TABLES: u32 = 0x1600_0300;

options! {
    /// How to connect to a controller.
    pub struct ConnectOptions {
        /// Address or name of the controller in the network.
        host: String = "127.0.0.1".into(), OptionRow::new(OptionKind::Text("HOST"));
        /// TCP port of the controller.
        port: u16 = 50000, OptionRow::new(OptionKind::Integer(1, 65535));
        /// Time to wait for an answer.
        timeout: f64 = 5.0, OptionRow { unit: "s", ..OptionRow::new(OptionKind::Number { least: 0.0, open: true, below: 3600.0 }) };
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
        let mut controller = Controller { line, identity, cycle: None, table: None, recorder: None, axes: Vec::new() };
        controller.cycle = controller.parameter(SERVO_UPDATE_TIME)?.filter(|cycle| *cycle > 0.0);
        controller.table = controller.value("WMS? 1")?.map(|points| points as usize);
        controller.recorder = controller.capacity()?;
        for (k, name) in names.into_iter().enumerate().take(MOST_AXES) {
            let axis = controller.axis(name, k + 1)?;
            controller.axes.push(axis);
        }
        Ok(controller)
    }
}

/// A controller that is connected.
#[derive(Debug, Serialize)]
pub struct Controller {
    #[serde(skip)]
    pub(crate) line: Line,
    /// What it answers to `*IDN?`.
    pub identity: String,
    /// Servo update time, the period of its wave generators and recorder, if it reports it [s].
    pub cycle: Option<f64>,
    /// Points of a wave table, if it reports them.
    pub table: Option<usize>,
    /// Points of a table of the recorder, if it reports them.
    pub recorder: Option<usize>,
    /// Its axes.
    pub axes: Vec<Axis>,
}

/// An axis of a controller, as it was found. What the controller does not report of it is `None`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Unit of its position.
    pub unit: String,
    /// True in closed loop.
    pub servo: Option<bool>,
    /// Its position [`unit`](Self::unit).
    pub position: Option<f64>,
    /// Voltage of the output channel with the number of the axis, if it is reported [V].
    pub voltage: Option<f64>,
    /// Lowest and highest voltage of that channel, if they are reported [V].
    pub range: Option<(f64, f64)>,
}

impl Controller {
    /// What the controller reported, as a document.
    pub fn to_json(&self) -> Value {
        json!(self)
    }

    /// The number that answers a query; `None` if the controller refuses it.
    pub(crate) fn value(&mut self, query: &str) -> Result<Option<f64>, Error> {
        let Some(lines) = self.line.optional_query(query)? else { return Ok(None) };
        let text = lines[0].rsplit('=').next().unwrap_or_default().trim().to_string();
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.map(Some).ok_or_else(|| self.line.strange(&lines[0], "a number"))
    }

    /// The number that answers a query that every controller knows.
    pub(crate) fn needed(&mut self, query: &str) -> Result<f64, Error> {
        let refused = || Error::Content(format!("the controller does not answer `{query}`, which is needed"));
        self.value(query)?.ok_or_else(refused)
    }

    /// True while the wave generator of this number runs.
    pub(crate) fn runs(&mut self, generator: usize) -> Result<bool, Error> {
        let all = self.line.number(9)?;
        Ok(all.checked_shr(generator as u32 - 1).is_some_and(|one| one & 1 == 1))
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
        let unit = self.line.optional_query(&format!("PUN? {name}"))?.map_or_else(String::new, |lines| lines.concat());
        let unit = unit.rsplit('=').next().unwrap_or_default().trim().to_lowercase();
        let lowest = self.value(&format!("VMI? {channel}"))?;
        Ok(Axis {
            unit: if unit.is_empty() { "um".into() } else { unit.replace('\u{b5}', "u") },
            servo: self.value(&format!("SVO? {name}"))?.map(|servo| servo != 0.0),
            position: self.value(&format!("POS? {name}"))?,
            voltage: self.value(&format!("VOL? {channel}"))?,
            range: lowest.zip(self.value(&format!("VMA? {channel}"))?),
            name,
        })
    }
}
