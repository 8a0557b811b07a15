//! Wave tables, the wave generator and the recorder.

use super::CYCLE;
use super::axis::SimulatedAxis;
use std::collections::BTreeMap;
use std::time::Instant;

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
    /// What the generator plays.
    run: Option<Playing>,
}

/// A wave that is played.
#[derive(Debug)]
struct Playing {
    begin: Instant,
    points: Vec<f64>,
    /// Servo cycles that it takes; without an end if it is endless.
    cycles: Option<u64>,
    /// Servo cycles that are played by now.
    played: u64,
}

/// Servo cycles that are computed at once at most: an endless wave that nobody asked about for long goes on elsewhere.
const AT_ONCE: u64 = 400_000;

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
        self.run.is_some()
    }

    /// Ends the wave where it is.
    pub(super) fn stop(&mut self) {
        self.run = None;
    }

    /// The table that is played, if it has points.
    fn table(&self) -> Option<&Vec<f64>> {
        self.tables.get(&self.selected).filter(|table| !table.is_empty())
    }

    /// Servo cycles of the wave, if a table is selected; 0 if it is endless.
    pub(super) fn cycles(&self) -> Option<u64> {
        Some((self.table()?.len() as u64).saturating_mul(self.rate).saturating_mul(self.times))
    }

    /// Begins to play and to record the selected table.
    pub(super) fn start(&mut self) {
        let (Some(points), Some(cycles)) = (self.table().cloned(), self.cycles()) else { return };
        self.recorded = Default::default();
        let cycles = (self.times > 0).then_some(cycles);
        self.run = Some(Playing { begin: Instant::now(), points, cycles, played: 0 });
    }

    /// Plays on the axis what was due until now, and records it.
    pub(super) fn go_on(&mut self, axis: &mut SimulatedAxis) {
        let Some(run) = &mut self.run else { return };
        let now = (run.begin.elapsed().as_secs_f64() / CYCLE) as u64;
        let until = run.cycles.map_or(now, |cycles| cycles.min(now));
        let full = self.record_rate.saturating_mul(RECORDED as u64);
        if run.cycles.is_none() && run.played > full && until - run.played > AT_ONCE {
            run.played = until - AT_ONCE;
        }
        for k in run.played..until {
            axis.follow(run.points[(k / self.rate) as usize % run.points.len()] + self.offset);
            if k % self.record_rate == 0 && k < full {
                for (option, recorded) in self.options.iter().zip(&mut self.recorded) {
                    recorded.push(axis.reading(*option));
                }
            }
        }
        run.played = until;
        if run.cycles == Some(until) {
            self.run = None;
        }
    }

    /// The points that are recorded by now.
    pub(super) fn recorded(&self, table: usize) -> &[f64] {
        &self.recorded[table - 1]
    }
}
