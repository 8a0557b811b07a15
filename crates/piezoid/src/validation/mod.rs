//! Validation: free run on data that was not used for identification, never one step ahead.
//!
//! The model uses only the input. The input does not determine what happened before the record: of three initial
//! conditions (settled at the first input, at rest, in motion as in the record) the free run uses the most likely one
//! for its input, unless another has a clearly smaller error in the first tenth of the record; the result states which.
//! The first `skip` seconds are left out of the figures. Further results: errors by frequency and amplitude ([`Bin`]),
//! loops of record and model ([`LoopComparison`]), residual tests ([`Whiteness`]), the noise floor ([`Floor`]), remarks
//! on extrapolation, and what the record does not test. [`Linearity`] tests whether a record is linear, without a
//! model.
//!
//! Reference: Ljung 1998, System Identification: Theory for the User, chapter 16.

mod best_block;
mod bins;
mod floor;
mod initial_condition;
mod loops;
mod metrics;
mod remarks;
mod residual_noise;
mod small_signal;
mod whiteness;

pub use bins::{Bin, Source};
pub use floor::Floor;
pub use loops::{LoopComparison, LoopShape};
pub use metrics::Metrics;
pub use small_signal::Linearity;
pub use whiteness::Whiteness;

use crate::error::Error;
use crate::hammerstein::{InitialCondition, Model};
use crate::options::{OptionKind, OptionRow, options};
use crate::record::{Record, Units};
use crate::system::System;
use crate::waveform::cycles;
use serde::{Deserialize, Serialize};

/// Treatment of the mean error of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Offset {
    /// It is kept: the offset is the model's own.
    #[default]
    Kept,
    /// It is subtracted first, because sensors drift.
    Free,
}

const OFFSETS: OptionKind =
    OptionKind::Choice(&[("kept", "the model's own"), ("free", "estimated for each record, because sensors drift")]);

options! {
    /// Options of the comparison of a model with a record.
    #[derive(Copy)]
    pub struct ValidateOptions {
        /// Time at the start of each record that the error figures leave out.
        skip: f64 = 0.0, OptionRow::not_negative("s");
        /// Offset of the model.
        offset: Offset = Offset::Kept, OptionRow::new(OFFSETS);
    }
}

/// A free run compared with its record.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Error figures of the whole record.
    pub metrics: Metrics,
    /// The free run over the whole record, with the mean error added if the offset is free [record's unit].
    pub simulated: Vec<f64>,
    /// First sample of the figures.
    pub start: usize,
    /// Initial condition of the free run.
    pub initial_condition: InitialCondition,
    /// The subtracted mean error, if the offset is free [record's unit].
    pub offset_removed: Option<f64>,
    /// The error by frequency: of cycles if the input oscillates, otherwise of spectra.
    pub by_frequency: Vec<Bin>,
    /// The error by amplitude of the cycles; empty if the input does not oscillate.
    pub by_amplitude: Vec<Bin>,
    /// The loops; empty if the input does not oscillate.
    pub loops: Vec<LoopComparison>,
    /// Tests of the residuals; `None` if there are none, or the record is too short.
    pub whiteness: Option<Whiteness>,
    /// The noise floor; `None` if the input is not periodic.
    pub floor: Option<Floor>,
    /// Remarks on the figures.
    pub remarks: Vec<String>,
    /// Properties of the model that this record does not test.
    pub not_covered: Vec<String>,
}

impl Model {
    /// Compares the free run of this model with a validation record, with the model's offset.
    ///
    /// # Errors
    /// The errors of [`Model::validate_with`].
    pub fn validate(&self, record: &Record) -> Result<Validation, Error> {
        self.validate_with(record, &ValidateOptions::default())
    }

    /// Compares the free run of this model with `record`.
    ///
    /// # Errors
    /// Returns an error if the sampling period differs, the units cannot be converted, or the record is shorter than
    /// `skip`.
    pub fn validate_with(&self, record: &Record, options: &ValidateOptions) -> Result<Validation, Error> {
        Record::same_sampling("the model", self.ts(), "the record", record.ts())?;
        if record.units().u != self.units().u {
            let (found, wanted) = (record.units().u.clone(), self.units().u.clone());
            return Err(Error::Units { what: "the input of the record".into(), found, wanted });
        }
        let known = Units::factor(&self.units().y, &record.units().y);
        let k = known.ok_or_else(|| Error::Units {
            what: "the output of the record".into(),
            found: record.units().y.clone(),
            wanted: self.units().y.clone(),
        })?;
        let free_offset = options.offset == Offset::Free;
        let start = Record::span(options.skip, f64::INFINITY, record.ts(), record.len())?.start;
        let (mut simulated, initial_condition) = initial_condition::free_run_from(self, record, k, free_offset);
        let mut offset_removed = None;
        if free_offset {
            let errors = record.y()[start..].iter().zip(&simulated[start..]).map(|(y, s)| y - s);
            let mean = errors.sum::<f64>() / (record.len() - start) as f64;
            simulated.iter_mut().for_each(|y| *y += mean);
            offset_removed = Some(mean);
        }
        let counted = record.part(options.skip, f64::INFINITY)?;
        let cycles = cycles(counted.u(), counted.ts());
        let run = ComparedRun { record: &counted, simulated: &simulated[start..], cycles: &cycles };
        let metrics = Metrics::of(counted.y(), run.simulated);
        let loops = loops::loops(&run);
        Ok(Validation {
            metrics,
            start,
            initial_condition,
            offset_removed,
            by_frequency: bins::by_frequency(&run),
            by_amplitude: bins::by_amplitude(&run),
            whiteness: Whiteness::of(counted.u(), &run.errors()),
            floor: Floor::of(&counted, metrics.rmse),
            remarks: remarks::remarks(self, &counted, &metrics),
            not_covered: remarks::not_covered(self, &counted, &loops),
            loops,
            simulated,
        })
    }
}

/// The part of a record that counts, its free run and its cycles.
#[derive(Debug, Clone, Copy)]
struct ComparedRun<'a> {
    record: &'a Record,
    simulated: &'a [f64],
    cycles: &'a [crate::waveform::Cycle],
}

impl ComparedRun<'_> {
    /// Measured minus simulated.
    fn errors(&self) -> Vec<f64> {
        self.record.y().iter().zip(self.simulated).map(|(y, s)| y - s).collect()
    }
}
