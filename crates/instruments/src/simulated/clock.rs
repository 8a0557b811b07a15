//! The clock of the controller, in servo cycles: that of the machine, or a virtual one that every answer advances.

use super::CYCLE;
use std::time::{Duration, Instant};

#[derive(Debug)]
pub(crate) enum Clock {
    /// Runs with the clock of the machine since this moment.
    Real(Instant),
    /// Stands still but for the time of the answers.
    Virtual { now: u64, answer: u64 },
}

impl Clock {
    /// A virtual clock if a time for each answer is given [s].
    pub(crate) fn new(answer: Option<f64>) -> Self {
        let cycles = |time: f64| (time / CYCLE).round().max(1.0) as u64;
        answer.map_or_else(|| Clock::Real(Instant::now()), |time| Clock::Virtual { now: 0, answer: cycles(time) })
    }

    pub(crate) fn is_real(&self) -> bool {
        matches!(self, Clock::Real(_))
    }

    /// Lets the time of an answer pass, on a virtual clock.
    pub(crate) fn wait(&mut self) {
        if let Clock::Virtual { now, answer } = self {
            *now += *answer;
        }
    }

    /// Stands still for so many servo cycles that have passed.
    pub(crate) fn lose(&mut self, cycles: u64) {
        if let Clock::Real(begin) = self {
            *begin += Duration::from_secs_f64(cycles as f64 * CYCLE);
        }
    }

    /// Servo cycles since the beginning.
    pub(crate) fn now(&self) -> u64 {
        match self {
            Clock::Real(begin) => (begin.elapsed().as_secs_f64() / CYCLE) as u64,
            Clock::Virtual { now, .. } => *now,
        }
    }
}
