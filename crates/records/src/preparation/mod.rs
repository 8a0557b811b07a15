//! Preparation of records: from what was measured to what is identified.
//!
//! The steps always happen in this order, each only if it is asked for:
//!
//! ```text
//! 1 cut         Record::part, or the options `from` and `to` while a file is read
//! 2 scale       Record::scaled, or `input_scale` and `output_scale` while a file is read
//! 3 offset      u + input_offset, y + output_offset
//! 4 outliers    single spikes of y, replaced by interpolation
//! 5 detrend     y without its mean, or without a straight line
//! 6 average     the mean of all periods, one period long
//! 7 delay       y earlier against u
//! 8 rate        decimate by a whole number, or resample to a sampling period
//! ```
//! Outliers are found before a filter spreads them. A drift is removed before it counts as noise between periods. After
//! the average the record is one period and is continued periodically, so that the filters have no transients at its
//! ends. Each step adds a sentence with its figures to [`Record::history`].
//!
//! It does not do: estimate a delay, which cannot be distinguished from the lag of the actuator without a model
//! (`identify` states the delay of its linear block); replace more than single spikes; separate drift from creep.

mod kernel;
mod periods;
mod rate;
mod repair;
#[cfg(test)]
mod tests;

use crate::record::Record;
use kernel::Ends;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::exact;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use serde::{Deserialize, Serialize};

/// What is subtracted from an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Trend {
    /// Its mean.
    Mean,
    /// The straight line that fits it best, with its mean.
    Line,
}

const TRENDS: OptionKind = OptionKind::Choice(&[
    ("mean", "its mean"),
    ("line", "the straight line that fits it best; over few periods, this line holds a part of the response"),
]);

options! {
    /// How to prepare a record. Nothing happens by default.
    ///
    /// ```
    /// use piezoid::{PrepareOptions, Record};
    /// let u: Vec<f64> = (0..4000).map(|t| (f64::from(t) * std::f64::consts::TAU / 400.0).sin()).collect();
    /// let y = u.iter().map(|u| 30.0 * u + 2.0).collect();
    /// let options = PrepareOptions { average: true, decimate: Some(4), ..PrepareOptions::default() };
    /// let record = options.run(&Record::new(5e-5, u, y)?)?;
    /// assert_eq!((record.ts(), record.len()), (2e-4, 100));
    /// assert!(record.history()[0].starts_with("averaged 10 periods of 0.02 s"));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct PrepareOptions {
        /// Offset that is added to the input after scaling, in the unit of the input.
        input_offset: f64 = 0.0, OptionRow::number("");
        /// Offset that is added to the output after scaling, in the unit of the output.
        output_offset: f64 = 0.0, OptionRow::number("");
        /// Replace single spikes of the output by interpolation.
        outliers: bool = false, OptionRow::new(OptionKind::Switch);
        /// Subtract the mean or a straight line from the output.
        detrend: Option<Trend> = None, OptionRow::new(TRENDS);
        /// Average all periods: the result is one period long.
        average: bool = false, OptionRow::new(OptionKind::Switch);
        /// Period of the input.
        period: Option<f64> = None, OptionRow::positive("s").absent("found in the input").requires("average");
        /// Delay of the output. The output is shifted earlier by this time; later if the value is negative.
        delay: Option<f64> = None, OptionRow::number("s");
        /// Keep every N-th sample, after an anti-alias filter.
        decimate: Option<usize> = None, OptionRow::new(OptionKind::Integer(1, u64::MAX));
        /// New sampling period, by band-limited interpolation; uneven times of a file are made even first.
        resample: Option<f64> = None, OptionRow::positive("s");
    }
}

impl PrepareOptions {
    /// The record after these steps, which its history lists.
    ///
    /// # Errors
    /// Returns an error for options that exclude each other, an input without a period to average, and values that do
    /// not suit the record: too long a delay, period or sampling period, too large a factor.
    pub fn run(&self, record: &Record) -> Result<Record, Error> {
        if let (Some(_), Some(ts)) = (self.decimate, self.resample) {
            return Err(Error::parameter("resample", format!("{ts} s"), "give either decimate or resample"));
        }
        if let (Some(period), false) = (self.period, self.average) {
            let error = Error::parameter("period", format!("{period} s"), "is needed only for an average: ");
            return Err(error.advised(vec![("average", true.into())]));
        }
        let mut record = self.offset(record)?;
        if self.outliers {
            record = repair::without_outliers(&record)?;
        }
        if let Some(trend) = self.detrend {
            record = repair::detrended(&record, trend)?;
        }
        let mut ends = Ends::Turned;
        if self.average {
            record = periods::averaged(&record, self.period)?;
            ends = Ends::Periodic;
        }
        if let Some(delay) = self.delay {
            record = rate::shifted(&record, delay, ends)?;
        }
        match (self.decimate, self.resample) {
            (Some(factor), _) => rate::decimated(&record, factor, ends),
            (_, Some(ts)) => rate::resampled(&record, ts, ends),
            _ => Ok(record),
        }
    }

    fn offset(&self, record: &Record) -> Result<Record, Error> {
        let units = record.units();
        let all = [("input", self.input_offset, &units.u), ("output", self.output_offset, &units.y)];
        let steps = all.iter().filter(|(_, offset, _)| *offset != 0.0);
        let steps = steps.map(|(what, offset, unit)| format!("{} {unit} added to the {what}", exact(*offset)));
        let by = |x: &[f64], offset: f64| x.iter().map(|x| x + offset).collect();
        let (u, y) = (by(record.u(), self.input_offset), by(record.y(), self.output_offset));
        Ok(steps.fold(record.with_samples(record.ts(), u, y)?, Record::with_step))
    }
}
