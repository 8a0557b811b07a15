//! The records of an identification, in the same units.

use super::fit::TrainingRecord;
use crate::common_units;
use piezoid_numerics::error::Error;
use piezoid_records::record::{Record, Units};

/// Records in the same units.
pub(super) struct Records {
    pub(super) small: Vec<Record>,
    /// At least one: without large-signal records, the hysteresis is identified from the small-signal records.
    pub(super) large_signal: Vec<Record>,
    /// Number of small-signal records beside the large-signal ones.
    beside: usize,
    pub(super) units: Units,
}

impl Records {
    /// # Errors
    /// Returns an error if sampling periods differ, units cannot be converted, or there is no record.
    pub(crate) fn of(small: &[Record], large_signal: &[Record]) -> Result<Self, Error> {
        let units = common_units(small.iter().chain(large_signal))?;
        let convert = |records: &[Record]| records.iter().map(|r| r.output_in(&units.y)).collect::<Result<Vec<_>, _>>();
        let (small, large_signal) = (convert(small)?, convert(large_signal)?);
        if small.is_empty() && large_signal.is_empty() {
            let remedy = "give small-signal records, large-signal records, or both".into();
            return Err(Error::TooShort { what: "the list of records".into(), have: 0, need: 1, remedy });
        }
        Ok(match large_signal.is_empty() {
            true => Records { large_signal: small.clone(), beside: 0, small, units },
            false => Records { beside: small.len(), small, large_signal, units },
        })
    }

    /// Sampling period [s].
    pub(super) fn ts(&self) -> f64 {
        self.large_signal[0].ts()
    }

    /// True if there are no small-signal records.
    pub(super) fn is_large_signal_alone(&self) -> bool {
        self.small.is_empty()
    }

    /// The small-signal records beside the large-signal ones.
    pub(super) fn beside(&self) -> &[Record] {
        &self.small[..self.beside]
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Record> {
        self.small.iter().chain(&self.large_signal)
    }

    /// A record of the fit with unusable samples interpolated.
    pub(crate) fn bridged(&self, run: &TrainingRecord) -> Result<Record, Error> {
        match run.usable.contains(&false) {
            true => {
                let (u, y) = (run.record.u().to_vec(), run.bridged());
                Ok(Record::new(self.ts(), u, y)?.with_units(self.units.clone()))
            }
            false => Ok(run.record.clone()),
        }
    }
}
