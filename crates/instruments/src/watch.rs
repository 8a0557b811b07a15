//! The work as its user sees it, and whether it was cancelled.
//!
//! All waiting is in pieces of [`TICK`], so that a cancelled progress is noticed at any moment.

use piezoid::Error;
use piezoid::progress::{Progress, Stage};
use std::cell::RefCell;
use std::rc::Rc;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest time in which nothing is checked.
pub(crate) const TICK: Duration = Duration::from_millis(10);

pub(crate) struct Watch<'a> {
    progress: Rc<RefCell<&'a mut Progress<'a>>>,
    stage: (String, usize, usize),
    /// What all this is a part of, with which stages begin; often empty.
    part: String,
    begin: Instant,
    /// False while the axis is brought to a stop, whatever the user does.
    is_heeded: bool,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(progress: &'a mut Progress<'a>) -> Self {
        let (progress, stage) = (Rc::new(RefCell::new(progress)), ("connection to the controller".into(), 0, 1));
        Watch { progress, stage, part: String::new(), begin: Instant::now(), is_heeded: true }
    }

    /// The same for another line of the same work.
    pub(crate) fn beside(&self) -> Self {
        Watch { progress: self.progress.clone(), stage: self.stage.clone(), part: self.part.clone(), ..*self }
    }

    /// From now on, cancelling ends nothing any more.
    pub(crate) fn ignore(&mut self) {
        (self.is_heeded, self.stage) = (false, ("stop of the wave generator".into(), 0, 1));
    }

    /// From now on, stages begin with the name of this part.
    pub(crate) fn enter(&mut self, part: &str) {
        self.part = part.into();
    }

    /// Returns an error if the work was cancelled.
    pub(crate) fn check(&mut self) -> Result<(), Error> {
        self.check_with(&[])
    }

    /// The same, and reports what the actuator does now, by the names that columns of a record have; once, because each
    /// is a message to the user.
    pub(crate) fn report(&mut self, state: &[(String, f64)]) -> Result<(), Error> {
        let time = ("t_s", self.begin.elapsed().as_secs_f64());
        let figures: Vec<_> = state.iter().map(|(name, value)| (&**name, *value)).chain([time]).collect();
        self.check_with(if state.is_empty() { &[] } else { &figures })
    }

    fn check_with(&mut self, figures: &[(&str, f64)]) -> Result<(), Error> {
        let (what, done, total) = &self.stage;
        let cancelled = (self.progress.borrow_mut())(Stage { figures, ..Stage::new(what, *done, *total) }).is_break();
        if !(cancelled && self.is_heeded) {
            return Ok(());
        }
        Err(Error::Cancelled { what: what.clone(), done: *done, total: *total })
    }

    /// States what is done now.
    pub(crate) fn stage(&mut self, what: &str, done: usize, total: usize) -> Result<(), Error> {
        self.stage = (within(&self.part, what), done, total);
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

/// One progress for an instrument, which keeps it, and for the work that is done with the instrument.
pub fn shared<T>(progress: &mut Progress, work: impl FnOnce(&mut Progress, &mut Progress) -> T) -> T {
    let shared = RefCell::new(progress);
    let mut of_instrument = |stage: Stage| (shared.borrow_mut())(stage);
    let mut own = |stage: Stage| (shared.borrow_mut())(stage);
    work(&mut of_instrument, &mut own)
}

/// What is done, as a part of something larger, if it is one.
pub(crate) fn within(part: &str, what: &str) -> String {
    if part.is_empty() { what.into() } else { format!("{part}: {what}") }
}
