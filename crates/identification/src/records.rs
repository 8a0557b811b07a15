//! The records of an identification, in the same units.

use super::fit::TrainingRecord;
use crate::common_units;
use piezoid_numerics::error::Error;
use piezoid_numerics::series::ends;
use piezoid_records::record::{Record, Units};

/// Share of the range of the input that the end of a record must have, and its least length.
const MOST_OF_RANGE: f64 = 0.8;
const LEAST_END: usize = 1000;

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
    /// Returns an error if sampling periods are no multiples of the shortest one, units cannot be converted, or there
    /// is no record.
    pub(crate) fn of(small: &[Record], large_signal: &[Record]) -> Result<Self, Error> {
        // Records that were sampled less often have all samples of the model, of which those measured are fitted.
        let ts = small.iter().chain(large_signal).map(Record::ts).fold(f64::INFINITY, f64::min);
        let convert = |records: &[Record]| {
            let one = |record: &Record| record.at("the record that is sampled most often", ts);
            records.iter().map(one).collect::<Result<Vec<_>, _>>()
        };
        let (small, large_signal) = (convert(small)?, convert(large_signal)?);
        let units = common_units(small.iter().chain(&large_signal))?;
        let convert = |records: &[Record]| records.iter().map(|r| r.output_in(&units.y)).collect::<Result<Vec<_>, _>>();
        let (small, large_signal) = (convert(&small)?, convert(&large_signal)?);
        if small.is_empty() && large_signal.is_empty() {
            let remedy = "give small-signal records, large-signal records, or both".into();
            return Err(Error::TooShort { what: "the list of records".into(), have: 0, need: 1, remedy });
        }
        Ok(match large_signal.is_empty() {
            true => Records { large_signal: small.clone(), beside: 0, small, units },
            false => Records { beside: small.len(), small, large_signal, units },
        })
    }

    /// The ends of the records, of about so many samples together, each with most of the range of its input.
    pub(super) fn ends(&self, samples: usize) -> Result<Self, Error> {
        let total: usize = self.iter().map(Record::len).sum();
        let end = |record: &Record| {
            let n = record.len();
            let least = (n * samples).div_ceil(total.max(samples)).max(LEAST_END);
            let (low, high) = ends(record.u().iter().copied());
            let is_most = |from: usize| {
                let (lowest, highest) = ends(record.u()[from..].iter().copied());
                highest - lowest >= MOST_OF_RANGE * (high - low)
            };
            // Each is twice as long as the one before.
            let lengths = std::iter::successors(Some(least), |length| Some(2 * length));
            let length = lengths.take_while(|length| *length < n).find(|length| is_most(n - length)).unwrap_or(n);
            record.slice((n - length) / record.every() * record.every()..n)
        };
        let [small, large_signal] =
            [&self.small, &self.large_signal].map(|records| records.iter().map(end).collect::<Result<Vec<_>, _>>());
        Ok(Records { small: small?, large_signal: large_signal?, beside: self.beside, units: self.units.clone() })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_a_record_has_most_of_the_range_of_its_input() {
        let record = |u: Vec<f64>| Record::new(1e-3, u.clone(), u).unwrap();
        let sine = |n: u32, period: f64| {
            record((0..n).map(|t| (std::f64::consts::TAU * f64::from(t) / period).sin()).collect())
        };
        // The second is half a period; the third is short.
        let records = [sine(20_000, 100.0), sine(20_000, 40_000.0), sine(300, 100.0)];
        let ends = Records::of(&[], &records).unwrap().ends(8000).unwrap();
        let lengths: Vec<usize> = ends.large_signal.iter().map(Record::len).collect();
        assert_eq!(lengths, [3971, 7942, 300]);
        assert_eq!(ends.large_signal[0].u(), &records[0].u()[20_000 - 3971..]);
    }
}
