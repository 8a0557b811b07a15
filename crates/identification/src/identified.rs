//! The result of an identification, by whichever method.

use crate::fit::FittedParameter;
use crate::search::OperatorTrial;
use piezoid_models::hammerstein::{HiddenLoop, Model};
use piezoid_models::linear::{Arx, Fit};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
pub(crate) use piezoid_records::quality::{around, excites};
use piezoid_records::record::{Record, Units};

/// The linear block with its offset and its origin.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearPart {
    /// The block.
    pub arx: Arx,
    /// Offset of the output [output unit].
    pub offset: f64,
    /// The fit to small-signal or large-signal records; `None` if only a gain was found.
    pub fit: Option<Fit>,
    /// How it was found, and why.
    pub reason: String,
}

/// A model and the results of its identification.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The model.
    pub model: Model,
    /// The linear block with its fit.
    pub linear: LinearPart,
    /// The loops of the hysteresis block, by rising frequency.
    pub loops: Vec<HiddenLoop>,
    /// The operators tried; only the joint method tries several.
    pub trials: Vec<OperatorTrial>,
    /// Physical parameters with standard errors; only the joint method has them.
    pub parameters: Vec<FittedParameter>,
    /// The model as fitted without each fold: the spread of its parameters; only the joint method has them.
    pub spread: Vec<Model>,
    /// Predicted decrease of the sum of squared errors by another step of the search, if the fit is not at its minimum
    /// [%]; only the joint method knows it.
    pub left_percent: Option<f64>,
    /// The [`Error::Cancelled`] that ended the search, if it was cancelled: the model is the best until then.
    pub cancelled: Option<Error>,
    /// Why this linear block and this operator, and how the search ended.
    pub reasons: Vec<String>,
    /// Remarks for the user.
    pub notes: Vec<String>,
}

impl Identified {
    /// The reasons, then the notes.
    pub fn remarks(&self) -> Vec<String> {
        [&self.reasons[..], &self.notes].concat()
    }

    /// The stage in which the search was cancelled, if it was.
    pub fn cancelled_in(&self) -> Option<&str> {
        match &self.cancelled {
            Some(Error::Cancelled { what, .. }) => Some(what),
            _ => None,
        }
    }

    /// The same, for work that has no use for the best model of a search that was cancelled.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if it was.
    pub fn finished(self) -> Result<Self, Error> {
        match self.cancelled {
            Some(cancelled) => Err(cancelled),
            None => Ok(self),
        }
    }
}

/// The name of record `k`, from 0, of `of` records of the kind `which`; the kind alone for a single one.
pub fn called(which: &str, k: usize, of: usize) -> String {
    if of > 1 { format!("{which} {}", k + 1) } else { which.to_string() }
}

/// A note if no record excites the resonance of the linear block.
pub fn unexcited_resonance<'a>(arx: &Arx, mut records: impl Iterator<Item = &'a Record>) -> Option<String> {
    let resonance = arx.resonance()?;
    let excited = |record: &Record| excites(record.u(), record.ts(), around(resonance.hz));
    (!records.any(excited)).then(|| {
        format!(
            "linear block: no record has power near its resonance at {} Hz, so it is uncertain: add a PRBS",
            short(resonance.hz)
        )
    })
}

/// The units of the first record; the others must agree in sampling and input unit.
pub fn common_units<'a>(mut records: impl Iterator<Item = &'a Record>) -> Result<Units, Error> {
    let Some(first) = records.next() else { return Ok(Units::default()) };
    for record in records {
        Record::same_sampling("the first record", first.ts(), "another record", record.ts())?;
        if record.units().u != first.units().u {
            let (found, expected) = (record.units().u.clone(), first.units().u.clone());
            return Err(Error::Units { what: "the input of a record".into(), found, expected });
        }
    }
    Ok(first.units().clone())
}
