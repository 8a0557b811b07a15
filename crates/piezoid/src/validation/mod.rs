//! Proof on data the model has not seen: free run, never one step ahead.
//!
//! The model sees the input alone. What happened before the record no input tells: of three beginnings (settled at the
//! first input, at rest before it, in motion as in the record) the free run takes the one that its input makes likely,
//! unless another leaves clearly less of the first tenth of the record, and says which. The first `skip` seconds are left out of the figures. Beside the figures of a whole record stand those by frequency and by amplitude ([`Bin`]), the
//! loops as measured and as the model has them ([`LoopComparison`]), whether what is left is noise ([`Whiteness`]), how much of it
//! the sensor itself leaves ([`Floor`]), and in words what the model was never shown and what the record cannot tell.
//! [`small_signal`] asks a record, without any model, whether it is linear.
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

/// What is done with the mean error of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Offset {
    /// It counts: the offset is the model's own.
    #[default]
    Kept,
    /// It is taken off first: sensors drift.
    Free,
}

const OFFSETS: OptionKind = OptionKind::Choice(&[
    ("kept", "the model's own"),
    ("free", "the one that fits each record best, since sensors drift"),
]);

options! {
    /// How to compare a model with a record.
    #[derive(Copy)]
    pub struct ValidateOptions {
        /// Time at the start of each record that does not count.
        skip: f64 = 0.0, OptionRow::not_negative("s");
        /// Which offset the model has.
        offset: Offset = Offset::Kept, OptionRow::new(OFFSETS);
    }
}

/// A free run beside its record.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// The figures.
    pub metrics: Metrics,
    /// The free run over the whole record, with the mean error added where the offset is free [record's unit].
    pub simulated: Vec<f64>,
    /// First sample that counts.
    pub start: usize,
    /// What the actuator is taken to have done before the record.
    pub initial_condition: InitialCondition,
    /// The mean error that was taken off, where the offset is free [record's unit].
    pub taken_off: Option<f64>,
    /// The error by frequency: of cycles where the input goes to and fro, of spectra where it does not.
    pub by_frequency: Vec<Bin>,
    /// The error by the amplitude of the cycles; empty where the input does not go to and fro.
    pub by_amplitude: Vec<Bin>,
    /// The loops; empty where the input does not go to and fro.
    pub loops: Vec<LoopComparison>,
    /// Whether what is left is noise; none where nothing is left or the record is too short to tell.
    pub whiteness: Option<Whiteness>,
    /// What the sensor leaves by itself; none where the input does not repeat.
    pub floor: Option<Floor>,
    /// What the reader of the figures should know.
    pub remarks: Vec<String>,
    /// What this record cannot tell about the model, however good the figures are.
    pub not_covered: Vec<String>,
}

impl Model {
    /// The free run of this model beside a record that it has not seen, with its own offset.
    ///
    /// # Errors
    /// As [`validate`].
    pub fn validate(&self, record: &Record) -> Result<Validation, Error> {
        self.validate_with(record, &ValidateOptions::default())
    }

    /// Runs the model free over `record` and compares.
    ///
    /// # Errors
    /// Refuses a record of another sampling period, of units that cannot be converted, or shorter than `skip`.
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
        let mut taken_off = None;
        if free_offset {
            let errors = record.y()[start..].iter().zip(&simulated[start..]).map(|(y, s)| y - s);
            let mean = errors.sum::<f64>() / (record.len() - start) as f64;
            simulated.iter_mut().for_each(|y| *y += mean);
            taken_off = Some(mean);
        }
        let counted = record.part(options.skip, f64::INFINITY)?;
        let run = ComparedRun {
            record: &counted,
            simulated: &simulated[start..],
            cycles: &cycles(counted.u(), counted.ts()),
        };
        let metrics = Metrics::of(counted.y(), run.simulated);
        let loops = loops::loops(&run);
        Ok(Validation {
            metrics,
            start,
            initial_condition,
            taken_off,
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

/// The part of a record that counts, the free run over it, and its cycles.
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
