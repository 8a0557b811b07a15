//! Wave tables and wave generators: one generator an axis, of the same number.

use std::collections::BTreeMap;

/// Wave tables.
pub(super) const WAVES: usize = 16;

/// Points of a wave table.
pub(super) const POINTS: usize = 1 << 18;

/// Wave tables by their numbers.
pub(super) type Tables = BTreeMap<usize, Vec<f64>>;

#[derive(Debug)]
pub(super) struct Generator {
    /// Table that it plays.
    pub(super) table: usize,
    /// How often; 0 is endless.
    pub(super) times: u64,
    /// Servo cycles a point, and whether values between points are on a straight line.
    pub(super) rate: u64,
    pub(super) is_linear: bool,
    pub(super) offset: f64,
    run: Option<Run>,
}

/// A wave that is played.
#[derive(Debug)]
struct Run {
    points: Vec<f64>,
    /// Servo cycles that are played by now, and that it takes; 0 if it is endless.
    played: u64,
    cycles: u64,
}

impl Default for Generator {
    fn default() -> Self {
        Generator { table: 0, times: 0, rate: 1, is_linear: false, offset: 0.0, run: None }
    }
}

impl Generator {
    pub(super) fn is_running(&self) -> bool {
        self.run.is_some()
    }

    /// Ends the wave where it is.
    pub(super) fn stop(&mut self) {
        self.run = None;
    }

    /// The points that it is to play, without the offset.
    pub(super) fn points<'a>(&self, tables: &'a Tables) -> Option<&'a [f64]> {
        tables.get(&self.table).map(Vec::as_slice).filter(|points| !points.is_empty())
    }

    /// Begins to play its table.
    pub(super) fn start(&mut self, tables: &Tables) {
        let Some(points) = self.points(tables) else { return };
        let cycles = (points.len() as u64).saturating_mul(self.rate).saturating_mul(self.times);
        self.run = Some(Run { points: points.to_vec(), played: 0, cycles });
    }

    /// The value of this servo cycle, if it runs.
    pub(super) fn next(&mut self) -> Option<f64> {
        let run = self.run.as_mut()?;
        let n = run.points.len();
        let k = (run.played / self.rate) as usize % n;
        let mut value = run.points[k];
        let is_last = run.cycles > 0 && run.played / self.rate + 1 == run.cycles / self.rate;
        if self.is_linear && !is_last {
            let share = (run.played % self.rate) as f64 / self.rate as f64;
            value += share * (run.points[(k + 1) % n] - value);
        }
        run.played += 1;
        if run.played == run.cycles {
            self.run = None;
        }
        Some(value + self.offset)
    }
}
