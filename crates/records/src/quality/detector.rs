//! A row of [`super::DETECTORS`], and what a detector gets to see of a record.

use super::Detection;
use super::closed::closed_loop;
use super::order::{Order, order};
use super::tone::{Tone, tone};
use super::wild::{Wild, wild};
use crate::record::Record;
use std::cell::OnceCell;
use std::fmt::{Debug, Formatter, Result};

/// What a defect means for a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Consequence {
    /// An error: nothing can be identified from the record, and no other defect can be looked for.
    Unusable,
    /// An error: nothing can be identified from the record.
    Error,
    /// A message; the samples must not be fitted.
    Masked,
    /// A message.
    Reported,
}

impl Consequence {
    /// True if nothing can be identified from such a record.
    pub(crate) fn is_fatal(self) -> bool {
        matches!(self, Consequence::Unusable | Consequence::Error)
    }
}

/// One way to find a defect: a row of [`super::DETECTORS`].
pub struct Detector {
    /// Name of the defect, as the JSON of `inspect` gives it. Two detectors may find the same defect.
    pub name: &'static str,
    /// How the defect shows in a record.
    #[cfg_attr(not(test), allow(dead_code))] // The table of docs/measuring.md is compared with it.
    pub criterion: &'static str,
    /// What the defect means for the record.
    pub consequence: Consequence,
    /// What to do before a loop of the record is drawn, if the defect makes its width and branches wrong.
    pub loop_remedy: Option<&'static str>,
    /// Looks for the defect.
    pub run: fn(&Context) -> Option<Detection>,
}

impl PartialEq for Detector {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Debug for Detector {
    fn fmt(&self, f: &mut Formatter) -> Result {
        f.write_str(self.name)
    }
}

/// A record under inspection. What several detectors need is computed once, when the first of them asks for it.
pub struct Context<'a> {
    measured: &'a Record,
    /// For each sample, true if no detector so far has masked it.
    pub(super) usable: Vec<bool>,
    wild: OnceCell<Option<Wild>>,
    tone: OnceCell<Option<Tone>>,
    closed_loop: OnceCell<Option<Detection>>,
    order: OnceCell<Option<Order>>,
}

impl<'a> Context<'a> {
    pub(crate) fn new(measured: &'a Record) -> Self {
        Context {
            measured,
            usable: vec![true; measured.len()],
            wild: OnceCell::new(),
            tone: OnceCell::new(),
            closed_loop: OnceCell::new(),
            order: OnceCell::new(),
        }
    }

    /// The same without the search for wild values, which takes time.
    pub(super) fn into_measured(self) -> Self {
        Context { wild: OnceCell::from(None), ..self }
    }

    /// The record, interpolated over its wild values: they would hide all other defects.
    pub(super) fn record(&self) -> &Record {
        self.wild().map_or(self.measured, |wild| &wild.interpolated)
    }

    /// The record as measured, for the defects that end an inspection.
    pub(super) fn measured(&self) -> &Record {
        self.measured
    }

    pub(super) fn wild(&self) -> Option<&Wild> {
        self.wild.get_or_init(|| wild(self.measured)).as_ref()
    }

    /// The main line of the input; `None` if it has none.
    pub(super) fn tone(&self) -> Option<&Tone> {
        self.tone.get_or_init(|| tone(self.record().u(), self.record().y())).as_ref()
    }

    /// The signs of a closed loop; `None` if the record has none.
    pub fn closed_loop(&self) -> Option<&Detection> {
        self.closed_loop.get_or_init(|| closed_loop(self.record(), &self.usable)).as_ref()
    }

    /// Which of the two signals moves first.
    pub(super) fn order(&self) -> Option<&Order> {
        let found = || order(self.record(), self.tone(), self.closed_loop().is_some());
        self.order.get_or_init(found).as_ref()
    }
}
