//! A controller, and what it reports about itself.

use crate::ConnectOptions;
use crate::gcs::codes::meaning;
use crate::gcs::line::Line;
use crate::watch::Watch;
use piezoid::Error;
use piezoid::progress::Progress;
use piezoid_numerics::number::join;
use serde::Serialize;
use serde_json::{Value, json};

/// More axes are not asked.
const MOST_AXES: usize = 64;

/// Parameters of a controller, by the numbers of PI's manuals.
const SERVO_UPDATE_TIME: u32 = 0x0E00_0200;
const RECORDER_POINTS: u32 = 0x1600_0200;
const RECORDER_POINTS_PER_TABLE: u32 = 0x1600_0201;
const RECORDER_TABLES: u32 = 0x1600_0300;

/// Bytes that ask for axes in motion, and for wave generators that run.
pub(crate) const MOVING: u8 = 5;
pub(crate) const RUNNING: u8 = 9;

/// A controller, as it was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Controller {
    /// What it answers to `*IDN?`.
    pub identity: String,
    /// The error that was pending, which the query has cleared; 0 without one.
    pub error: i32,
    /// True if an axis was in motion.
    pub is_moving: bool,
    /// Numbers of the wave generators that ran.
    pub generators: Vec<usize>,
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
        let mut document = json!(self);
        document["in_use"] = json!(self.in_use());
        document
    }

    /// What shows that another program uses the controller; `None` if nothing does.
    pub fn in_use(&self) -> Option<String> {
        let running: Vec<String> = self.generators.iter().map(|k| format!("wave generator {k} runs already")).collect();
        let moving = self.is_moving.then(|| "an axis is in motion".to_string());
        let error = self.error;
        let pending = (error != 0)
            .then(|| format!("error {error} of another program was pending ({}); it is cleared now", meaning(error)));
        let signs: Vec<String> = running.into_iter().chain(moving).chain(pending).collect();
        (!signs.is_empty()).then(|| join(&signs))
    }

    /// Connects to a controller with GCS 2.0.
    pub(crate) fn open<'a>(
        options: &ConnectOptions,
        progress: &'a mut Progress<'_>,
    ) -> Result<(Line<'a>, Controller), Error> {
        let mut line = Line::open((&options.host, options.port), options.patience(), Watch::new(progress))?;
        let controller = Controller::of(&mut line)?;
        Ok((line, controller))
    }

    fn of(line: &mut Line) -> Result<Self, Error> {
        let error = line.pending()?;
        let identity = line.query("*IDN?")?.concat();
        let names: Vec<String> =
            line.query("SAI?")?.iter().flat_map(|l| l.split_whitespace()).map(String::from).collect();
        let (moving, running) = (line.bits(MOVING)?, line.bits(RUNNING)?);
        let mut axes = Vec::new();
        let cycle = parameter(line, SERVO_UPDATE_TIME)?.filter(|cycle| *cycle > 0.0);
        let table = line.value("WMS? 1")?.map(|points| points as usize);
        let recorder = capacity(line)?;
        for (k, name) in names.into_iter().enumerate().take(MOST_AXES) {
            axes.push(Axis::of(line, name, k + 1)?);
        }
        let generators = (1..=64).filter(|k| running >> (k - 1) & 1 == 1).collect();
        Ok(Controller { identity, error, is_moving: moving != 0, generators, cycle, table, recorder, axes })
    }
}

fn parameter(line: &mut Line, number: u32) -> Result<Option<f64>, Error> {
    line.value(&format!("SPA? 1 0x{number:08X}"))
}

/// Points of a table of the recorder.
fn capacity(line: &mut Line) -> Result<Option<usize>, Error> {
    if let Some(points) = parameter(line, RECORDER_POINTS_PER_TABLE)? {
        return Ok(Some(points as usize));
    }
    let (all, tables) = (parameter(line, RECORDER_POINTS)?, parameter(line, RECORDER_TABLES)?);
    Ok(all.zip(tables).map(|(all, tables)| (all / tables.max(1.0)) as usize))
}

impl Axis {
    fn of(line: &mut Line, name: String, channel: usize) -> Result<Axis, Error> {
        let unit = line.optional_query(&format!("PUN? {name}"))?.map_or_else(String::new, |lines| lines.concat());
        let unit = unit.rsplit('=').next().unwrap_or_default().trim().to_lowercase();
        let lowest = line.value(&format!("VMI? {channel}"))?;
        Ok(Axis {
            unit: if unit.is_empty() { "um".into() } else { unit.replace('\u{b5}', "u") },
            servo: line.value(&format!("SVO? {name}"))?.map(|servo| servo != 0.0),
            position: line.value(&format!("POS? {name}"))?,
            voltage: line.value(&format!("VOL? {channel}"))?,
            range: lowest.zip(line.value(&format!("VMA? {channel}"))?),
            name,
        })
    }
}
