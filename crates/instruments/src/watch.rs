//! The work as its user sees it, and whether it was cancelled.
//!
//! All waiting is in pieces of [`TICK`], so that a cancelled progress is noticed at any moment.

use piezoid::Error;
use piezoid::progress::{Progress, Stage};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest time in which nothing is checked.
pub(crate) const TICK: Duration = Duration::from_millis(10);

pub(crate) struct Watch<'a> {
    progress: &'a mut Progress<'a>,
    stage: (String, usize, usize),
    /// False while the axis is brought to a stop, whatever the user does.
    is_heeded: bool,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(progress: &'a mut Progress<'a>) -> Self {
        Watch { progress, stage: ("connection to the controller".into(), 0, 1), is_heeded: true }
    }

    /// From now on, cancelling ends nothing any more.
    pub(crate) fn ignore(&mut self) {
        (self.is_heeded, self.stage) = (false, ("stop of the wave generator".into(), 0, 1));
    }

    /// Returns an error if the work was cancelled.
    pub(crate) fn check(&mut self) -> Result<(), Error> {
        let (what, done, total) = &self.stage;
        let cancelled = (self.progress)(Stage::new(what, *done, *total)).is_break();
        if !(cancelled && self.is_heeded) {
            return Ok(());
        }
        Err(Error::Cancelled { what: what.clone(), done: *done, total: *total })
    }

    /// States what is done now.
    pub(crate) fn stage(&mut self, what: &str, done: usize, total: usize) -> Result<(), Error> {
        self.stage = (what.into(), done, total);
        self.check()
    }

    /// Waits.
    pub(crate) fn pause(&mut self, time: Duration) -> Result<(), Error> {
        let begin = Instant::now();
        while let Some(left) = time.checked_sub(begin.elapsed()).filter(|left| !left.is_zero()) {
            self.check()?;
            sleep(left.min(TICK));
        }
        Ok(())
    }
}
