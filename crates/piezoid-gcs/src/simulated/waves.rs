//! Wave tables, the wave generator and the recorder.

use super::CYCLE;
use super::axis::SimulatedAxis;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Wave tables.
pub(super) const WAVES: usize = 16;

/// Points of a wave table.
pub(super) const POINTS: usize = 1 << 18;

/// Points of a table of the recorder.
pub(super) const RECORDED: usize = 1 << 15;

/// Tables of the recorder.
pub(super) const TABLES: usize = 4;

/// What is recorded, as `HDR?` lists it.
pub(super) const SOURCES: [(u32, &str); 4] = [
    (1, "Target Position of axis"),
    (2, "Current Position of axis"),
    (3, "Position Error of axis"),
    (16, "Voltage of Output Channel"),
];

#[derive(Debug)]
pub(super) struct Waves {
    /// Wave tables by their numbers.
    pub(super) tables: BTreeMap<usize, Vec<f64>>,
    /// Table that the generator plays.
    pub(super) selected: usize,
    /// How often; 0 is endless.
    pub(super) times: u64,
    /// Servo cycles a point.
    pub(super) rate: u64,
    pub(super) offset: f64,
    /// Servo cycles a recorded point.
    pub(super) record_rate: u64,
    /// What each table of the recorder records.
    pub(super) options: [u32; TABLES],
    recorded: [Vec<f64>; TABLES],
    /// When the generator was started, and how long it runs; without an end if it is endless.
    run: Option<(Instant, Option<Duration>)>,
}

impl Default for Waves {
    fn default() -> Self {
        Waves {
            tables: BTreeMap::new(),
            selected: 0,
            times: 0,
            rate: 1,
            offset: 0.0,
            record_rate: 1,
            options: [2, 16, 1, 3],
            recorded: Default::default(),
            run: None,
        }
    }
}

impl Waves {
    /// True while the generator runs.
    pub(super) fn running(&self) -> bool {
        self.run.is_some_and(|(begin, length)| length.is_none_or(|length| begin.elapsed() < length))
    }

    /// Ends the wave. What a real recorder would not have yet is gone.
    pub(super) fn stop(&mut self) {
        for table in 1..=TABLES {
            let by_now = self.recorded(table).len();
            self.recorded[table - 1].truncate(by_now);
        }
        self.run = None;
    }

    /// The table that is played, if it has points.
    fn table(&self) -> Option<&Vec<f64>> {
        self.tables.get(&self.selected).filter(|table| !table.is_empty())
    }

    /// Servo cycles of the wave, if a table is selected. An endless wave is played until the recorder is full.
    pub(super) fn cycles(&self) -> Option<u64> {
        let period = (self.table()?.len() as u64).saturating_mul(self.rate);
        let endless = (RECORDED as u64).saturating_mul(self.record_rate).max(period);
        Some(if self.times == 0 { endless } else { period.saturating_mul(self.times) })
    }

    /// Plays the selected table on the axis, and records it.
    pub(super) fn start(&mut self, axis: &mut SimulatedAxis) {
        let (Some(table), Some(cycles)) = (self.table(), self.cycles()) else { return };
        let mut recorded: [Vec<f64>; TABLES] = Default::default();
        for k in 0..cycles {
            axis.follow(table[(k / self.rate) as usize % table.len()] + self.offset);
            if k % self.record_rate == 0 && k / self.record_rate < RECORDED as u64 {
                for (option, recorded) in self.options.iter().zip(&mut recorded) {
                    recorded.push(axis.reading(*option));
                }
            }
        }
        self.recorded = recorded;
        let length = Duration::from_secs_f64(cycles as f64 * CYCLE);
        self.run = Some((Instant::now(), (self.times > 0).then_some(length)));
    }

    /// The points that are recorded by now.
    pub(super) fn recorded(&self, table: usize) -> &[f64] {
        let recorded = &self.recorded[table - 1];
        let ended = |(begin, _): (Instant, _)| (begin.elapsed().as_secs_f64() / CYCLE) as u64 / self.record_rate;
        let by_now = if self.running() { self.run.map_or(0, ended) as usize } else { RECORDED };
        &recorded[..recorded.len().min(by_now)]
    }
}
