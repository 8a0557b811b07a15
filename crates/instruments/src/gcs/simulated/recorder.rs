//! The recorder: tables that fill as time goes, each from its own trigger.

use super::errors::{RANGE, RECORDER_TABLE, TOO_FEW_POINTS, refused};
use super::words::{once, whole};
use crate::simulated::axis::Axis;

/// Tables of the recorder.
pub(super) const TABLES: usize = 4;

/// Points of a table.
pub(super) const RECORDED: usize = 1 << 15;

/// What is recorded, as `HDR?` lists it.
pub(super) const SOURCES: [(u32, &str); 10] = [
    (0, "Nothing is recorded"),
    (1, "Target Position of axis"),
    (2, "Current Position of axis"),
    (3, "Position Error of axis"),
    (7, "Control Voltage of Output Channel"),
    (13, "DDL Output of axis"),
    (14, "Open-Loop Control of axis"),
    (15, "Control Output of axis"),
    (16, "Voltage of Output Channel"),
    (17, "Sensor normalized of Input Channel"),
];

/// What starts a recording, as `HDR?` lists it.
pub(super) const TRIGGERS: [(u32, &str); 4] = [
    (WAVE, "default setting: STE, IMP, WGO, WGR"),
    (MOVE, "any command changing the target position"),
    (COMMAND, "next command, then 0"),
    (NOW, "immediately, then 0"),
];

/// The trigger of waves and steps, of moves, of the next command, and none at all.
const WAVE: u32 = 0;
const MOVE: u32 = 1;
const COMMAND: u32 = 2;
const NOW: u32 = 4;

/// A table.
#[derive(Debug)]
pub(super) struct Table {
    /// Place of the axis, and what of it is recorded.
    pub(super) source: usize,
    pub(super) option: u32,
    pub(super) trigger: u32,
    pub(super) points: Vec<f64>,
    /// Servo cycles until the next point; without, it does not record.
    wait: Option<u64>,
}

impl Table {
    pub(super) fn records(&self) -> bool {
        self.wait.is_some()
    }
}

#[derive(Debug)]
pub(super) struct Recorder {
    /// Servo cycles a point.
    pub(super) rate: u64,
    pub(super) tables: [Table; TABLES],
}

impl Default for Recorder {
    fn default() -> Self {
        let table = |option| Table { source: 0, option, trigger: WAVE, points: Vec::new(), wait: None };
        Recorder { rate: 1, tables: [2, 16, 1, 3].map(table) }
    }
}

impl Recorder {
    pub(super) fn is_running(&self) -> bool {
        self.tables.iter().any(Table::records)
    }

    /// Records this servo cycle.
    pub(super) fn cycle(&mut self, axes: &[Axis]) {
        for table in &mut self.tables {
            let Some(wait) = table.wait else { continue };
            table.wait = Some(wait.saturating_sub(1));
            if wait == 0 {
                table.points.push(reading(&axes[table.source], table.option));
                table.wait = (table.points.len() < RECORDED).then_some(self.rate - 1);
            }
        }
    }

    fn start(&mut self, is_due: impl Fn(u32) -> bool) {
        for table in self.tables.iter_mut().filter(|table| is_due(table.trigger)) {
            (table.points, table.wait) = (Vec::new(), Some(0));
            if table.trigger > MOVE {
                table.trigger = WAVE;
            }
        }
    }

    /// A line has come.
    pub(super) fn command(&mut self) {
        self.start(|trigger| trigger == COMMAND);
    }

    /// A command changes a target.
    pub(super) fn moves(&mut self) {
        self.start(|trigger| trigger == MOVE);
    }

    /// A wave, step or impulse starts.
    pub(super) fn plays(&mut self) {
        self.start(|trigger| trigger == WAVE || trigger == MOVE);
    }

    /// Sets the triggers of tables; 4 starts at once.
    pub(super) fn arm(&mut self, triggers: &[(Vec<usize>, u32)]) -> Result<(), i32> {
        let is_unknown = |trigger: u32| TRIGGERS.iter().all(|(number, _)| *number != trigger);
        refused(&[(triggers.iter().any(|(_, trigger)| is_unknown(*trigger)), RANGE)])?;
        for (tables, trigger) in triggers {
            tables.iter().for_each(|table| self.tables[table - 1].trigger = *trigger);
        }
        self.start(|trigger| trigger == NOW);
        Ok(())
    }
}

/// What a table reads.
fn reading(axis: &Axis, option: u32) -> f64 {
    let target = if axis.servo { axis.target } else { axis.position };
    match option {
        1 => target,
        2 | 17 => axis.position,
        3 => target - axis.position,
        14 => axis.demand() / axis.gain,
        7 | 15 | 16 => axis.voltage,
        _ => 0.0,
    }
}

/// What an option records.
pub(super) fn source(option: u32) -> Option<&'static str> {
    SOURCES.iter().find(|(number, _)| *number == option).map(|(_, what)| *what)
}

/// Tables by their numbers, or all.
pub(super) fn tables(arguments: &[&str]) -> Result<Vec<usize>, i32> {
    let table = |word: &&str| whole(word).ok().filter(|table| (1..=TABLES).contains(table)).ok_or(RECORDER_TABLE);
    if arguments.is_empty() {
        return Ok((1..=TABLES).collect());
    }
    once(arguments.iter().map(table).collect::<Result<_, _>>()?)
}

/// So many points from a first one on.
pub(super) fn part<'a>(points: &'a [f64], first: &str, count: &str) -> Result<&'a [f64], i32> {
    let (first, count) = (whole(first)?, whole(count)?);
    let from = first.checked_sub(1).ok_or(RANGE)?;
    let to = from.checked_add(count).ok_or(RANGE)?;
    points.get(from..to).ok_or(TOO_FEW_POINTS)
}
