//! A measured (or simulated) voltage/displacement record, the input of every identification.
//!
//! Why: docs/decisions/data-and-records.md, "Records keep the units of their files".

use piezoid_numerics::error::{Error, finite, positive};
use piezoid_numerics::number::{self, ascii_unit, exact, round};
use piezoid_numerics::series::upsampled;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Largest sampling period of a record, in those of the model.
const MAX_EVERY: f64 = 1000.0;

/// Most samples of a record whose samples are joined: 1.6 GB.
const MAX_SAMPLES: f64 = 1e8;

/// The units of a record. A record keeps the units of its file; models inherit them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Unit of the input, normally `V`.
    pub u: String,
    /// Unit of the output: `um`, `mm`, `m`, `nm`, or whatever the sensor gives.
    pub y: String,
}

impl Default for Units {
    fn default() -> Self {
        Units { u: "V".into(), y: "um".into() }
    }
}

impl Units {
    /// The factor that converts from one length unit to another: 1 between equal names, `None` if unknown.
    ///
    /// ```
    /// assert_eq!(piezoid::Units::factor("mm", "um"), Some(1e3));
    /// assert_eq!(piezoid::Units::factor("mV", "V"), Some(1e-3));
    /// assert_eq!(piezoid::Units::factor("counts", "um"), None);
    /// ```
    pub fn factor(from: &str, to: &str) -> Option<f64> {
        // Powers of ten below the metre and the volt: the factor is then correctly rounded.
        let below = |unit: &str| match unit {
            "m" => Some(('m', 0)),
            "mm" => Some(('m', 3)),
            "um" => Some(('m', 6)),
            "nm" => Some(('m', 9)),
            "kV" => Some(('V', -3)),
            "V" => Some(('V', 0)),
            "mV" => Some(('V', 3)),
            "uV" => Some(('V', 6)),
            _ => None,
        };
        if from == to {
            return Some(1.0);
        }
        let ((of, from), (into, to)) = (below(from)?, below(to)?);
        let power: i32 = to - from;
        (of == into).then(|| number::power(10.0, power))
    }
}

/// Input and output, sampled together at a constant rate: `u[t]` and `y[t]` belong to the same row.
///
/// An instrument logs `y[t]` either before or after `u[t]` acts. The first coefficient of the identified linear block
/// absorbs the difference.
///
/// ```
/// let record = piezoid::Record::new(5e-4, vec![0.0, 1.0, 1.0], vec![0.0, 20.0, 33.0])?;
/// assert_eq!(record.len(), 3);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Record {
    ts: f64,
    // Shared, because a fit, its validation and its report keep the same samples.
    u: Arc<[f64]>,
    y: Arc<[f64]>,
    units: Units,
    history: Vec<String>,
    every: usize,
}

/// Records are equal if their samples, sampling periods and units are.
impl PartialEq for Record {
    fn eq(&self, other: &Self) -> bool {
        (self.ts, &self.u, &self.y, &self.units) == (other.ts, &other.u, &other.y, &other.units)
    }
}

impl Record {
    /// A record in volts and micrometres.
    ///
    /// # Errors
    /// Returns an error unless `ts` [s] is positive, and `u` and `y` are equally long, not empty and finite.
    pub fn new(ts: f64, u: Vec<f64>, y: Vec<f64>) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        if u.len() != y.len() {
            return Err(Error::Lengths { left: "u".into(), left_len: u.len(), right: "y".into(), right_len: y.len() });
        }
        if u.is_empty() {
            let (what, remedy) = ("the record".into(), "it must not be empty".into());
            return Err(Error::TooShort { what, have: 0, need: 1, remedy });
        }
        finite("u", &u)?;
        finite("y", &y)?;
        Ok(Record { ts, u: u.into(), y: y.into(), units: Units::default(), history: Vec::new(), every: 1 })
    }

    /// The same numbers with other units. The Greek letter of micro is written as `u`.
    pub fn with_units(self, units: Units) -> Self {
        Record { units: Units { u: ascii_unit(&units.u), y: ascii_unit(&units.y) }, ..self }
    }

    /// The same record with one more step in its history.
    #[doc(hidden)]
    pub fn with_step(mut self, step: String) -> Self {
        self.history.push(step);
        self
    }

    /// How the record was made, step by step: the columns that were guessed, scales, cuts, preparation. Empty if a file
    /// was read as it stands.
    pub fn history(&self) -> &[String] {
        &self.history
    }

    /// Sampling period [s].
    pub fn ts(&self) -> f64 {
        self.ts
    }

    /// Input samples.
    pub fn u(&self) -> &[f64] {
        &self.u
    }

    /// Output samples.
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// Units of the samples.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// Number of samples, at least one.
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.u.len()
    }

    /// Length in time [s].
    pub fn duration(&self) -> f64 {
        self.len() as f64 * self.ts
    }

    /// The part from `from` up to, but not including, `to` [s], counted from the first sample.
    ///
    /// # Errors
    /// The errors of [`Record::span`].
    pub fn part(&self, from: f64, to: f64) -> Result<Self, Error> {
        let span = Record::span(from, to, self.ts, self.len())?;
        let whole = span.len() == self.len();
        let part = self.slice(span)?;
        Ok(if whole { part } else { part.with_step(Record::cut(Some(from), Some(to).filter(|to| to.is_finite()))) })
    }

    /// The step of a cut at these times [s].
    pub(crate) fn cut(from: Option<f64>, to: Option<f64>) -> String {
        let end = |t: Option<f64>, name: &str| t.map(|t| format!(" {name} {} s", exact(t))).unwrap_or_default();
        format!("cut{}{}", end(from, "from"), end(to, "to"))
    }

    /// Other samples with the same units and history.
    pub fn with_samples(&self, ts: f64, u: Vec<f64>, y: Vec<f64>) -> Result<Self, Error> {
        Ok(Record { units: self.units.clone(), history: self.history.clone(), ..Record::new(ts, u, y)? })
    }

    /// The samples of a range, which must be inside the record and not empty.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Result<Self, Error> {
        if range == (0..self.len()) {
            // All samples are shared, not copied.
            return Ok(self.clone());
        }
        let every = if range.start.is_multiple_of(self.every) { self.every } else { 1 };
        let part = self.with_samples(self.ts, self.u[range.clone()].to_vec(), self.y[range].to_vec())?;
        Ok(Record { every, ..part })
    }

    /// The same record with the sampling period `ts` [s], of which its own is a multiple: straight lines join its
    /// samples, and [`Record::every`] says which of them were measured.
    ///
    /// ```
    /// let slow = piezoid::Record::new(2e-3, vec![0.0, 4.0], vec![10.0, 20.0])?;
    /// let record = slow.at("the model", 1e-3)?;
    /// assert_eq!((record.u(), record.y(), record.every()), (&[0.0, 2.0, 4.0][..], &[10.0, 15.0, 20.0][..], 2));
    /// assert_eq!(record.measured()?, slow);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Sampling`], with the name of what has this period, if its own is no multiple of `ts`, or more than 1000
    /// times as long: then one of them is wrong. An error if the record would have more than 10^8 samples.
    pub fn at(&self, of: &str, ts: f64) -> Result<Self, Error> {
        let every = (self.ts / ts).round().clamp(1.0, MAX_EVERY);
        if Record::same_sampling(of, ts, "the record", self.ts / every).is_err() {
            let (left, right) = (of.into(), "the record".into());
            return Err(Error::Sampling { left, left_ts: ts, right, right_ts: self.ts });
        }
        let length = every * (self.len() - 1) as f64;
        if length >= MAX_SAMPLES {
            let rule = format!("gives {length:.0} samples for a record of period {} s: decimate the others", self.ts);
            return Err(Error::parameter("ts", format!("{ts} s"), rule));
        }
        let every = every as usize;
        if every == 1 {
            return Ok(self.clone());
        }
        let joined = |x: &[f64]| {
            let mut all = upsampled(x, every, true);
            all.truncate(every * (x.len() - 1) + 1);
            all
        };
        Ok(Record { every: every * self.every, ..self.with_samples(ts, joined(&self.u), joined(&self.y))? })
    }

    /// One of so many samples was measured, beginning with the first; 1 unless [`Record::at`] joined them.
    pub fn every(&self) -> usize {
        self.every
    }

    /// The measured samples alone.
    ///
    /// # Errors
    /// Those of [`Record::new`].
    pub fn measured(&self) -> Result<Self, Error> {
        if self.every == 1 {
            return Ok(self.clone());
        }
        let [u, y] = [&self.u, &self.y].map(|x| x.iter().step_by(self.every).copied().collect());
        self.with_samples(self.ts * self.every as f64, u, y)
    }

    /// The same record with its output in another length unit.
    ///
    /// # Errors
    /// Returns an error if the conversion is unknown (see [`Units::factor`]).
    pub fn output_in(&self, unit: &str) -> Result<Self, Error> {
        let unit = &*ascii_unit(unit);
        let unknown = || Error::units("the output of the record", &self.units.y, unit);
        let k = Units::factor(&self.units.y, unit).ok_or_else(unknown)?;
        let units = Units { y: unit.into(), ..self.units.clone() };
        let y = if k == 1.0 { self.y.clone() } else { self.y.iter().map(|v| v * k).collect() };
        Ok(Record { u: self.u.clone(), y, units, history: self.history.clone(), ..*self })
    }

    /// The samples from `from` up to, but not including, `to` [s], of `n` samples that start at 0 s.
    ///
    /// A time within a millionth of a sampling period of a sample is that sample: 300 x 0.005 s is sample 300, whatever
    /// the rounding.
    ///
    /// # Errors
    /// Returns an error if no sample lies between them, or `from` is negative.
    pub fn span(from: f64, to: f64, ts: f64, n: usize) -> Result<std::ops::Range<usize>, Error> {
        let index = |t: f64| (t / ts - 1e-6).ceil().clamp(0.0, n as f64) as usize;
        let (start, end) = (index(from), index(to));
        if start < end && from >= 0.0 {
            return Ok(start..end);
        }
        Err(Record::outside(from, to, n.saturating_sub(1) as f64 * ts))
    }

    /// The error for a cut that keeps no sample of data that end at `last` [s].
    pub fn outside(from: f64, to: f64, last: f64) -> Error {
        if from.is_nan() || from < 0.0 {
            let rule = "must not lie before the first sample, which is at 0 s";
            return Error::parameter("from", format!("{from} s"), rule);
        }
        let ([start, end], last) = ([from, to].map(exact), round(last));
        let interval = if to.is_finite() { format!("from {start} s to {end} s") } else { format!("from {start} s on") };
        Error::Content(format!("no sample lies {interval}: the data span 0 s to {last} s"))
    }

    /// Checks that two sampling periods agree within a millionth.
    ///
    /// # Errors
    /// [`Error::Sampling`].
    pub fn same_sampling(left: &str, left_ts: f64, right: &str, right_ts: f64) -> Result<(), Error> {
        if (left_ts - right_ts).abs() <= 1e-6 * left_ts {
            return Ok(());
        }
        Err(Error::Sampling { left: left.into(), left_ts, right: right.into(), right_ts })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_errors_about_bad_records_have_their_numbers() {
        let message = |ts, u: &[f64], y: &[f64]| Record::new(ts, u.to_vec(), y.to_vec()).unwrap_err().to_string();
        assert!(message(0.0, &[1.0], &[1.0]).contains("ts = 0"));
        assert!(message(1.0, &[1.0], &[1.0, 2.0]).contains("u has 1 samples but y has 2"));
        assert!(message(1.0, &[1.0, f64::INFINITY], &[1.0, 2.0]).contains("u[1] is inf"));
        assert!(message(1.0, &[], &[]).contains("at least 1"));
    }

    #[test]
    fn a_part_includes_its_start_and_excludes_its_end() {
        let ramp: Vec<f64> = (0..100).map(f64::from).collect();
        let record = Record::new(0.005, ramp.clone(), ramp).unwrap();
        let part = record.part(0.05, 0.1).unwrap();
        assert_eq!(part.u(), &[10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0, 17.0, 18.0, 19.0]);
        assert_eq!(record.part(0.0, f64::INFINITY).unwrap(), record);
        assert!(record.part(0.2, 0.1).is_err());
        assert!(record.part(f64::NAN, f64::NAN).is_err());
    }

    #[test]
    fn the_output_unit_can_be_changed_where_the_factor_is_known() {
        let record = Record::new(1.0, vec![0.0], vec![1.5]).unwrap();
        let mm = record.output_in("mm").unwrap();
        assert_eq!((mm.y()[0], mm.units().y.as_str()), (1.5e-3, "mm"));
        assert!(record.output_in("counts").is_err());
    }

    #[test]
    fn a_record_is_joined_only_at_a_sampling_period_that_its_own_is_a_multiple_of() {
        let record = Record::new(2e-3, vec![0.0, 3.0, 3.0], vec![1.0, 2.0, 0.0]).unwrap();
        let joined = record.at("the model", 5e-4).unwrap();
        assert_eq!((joined.len(), joined.every(), joined.u()[3], joined.y()[6]), (9, 4, 2.25, 1.0));
        assert_eq!(joined.slice(4..9).unwrap().measured().unwrap(), record.slice(1..3).unwrap());
        assert_eq!(joined.slice(5..9).unwrap().every(), 1);
        for ts in [7e-4, 4e-3, 1e-6] {
            let message = record.at("the model", ts).unwrap_err().to_string();
            assert!(message.contains(&format!("the model is sampled every {ts}")), "{message}");
            assert!(message.contains("the record every 0.002 s"), "{message}");
        }
    }
}
