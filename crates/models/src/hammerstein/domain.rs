//! The range of the data that a model was identified from: outside it the model extrapolates.
//!
//! Why: docs/decisions/identification.md, "The range of the training data is stored once".

use piezoid_numerics::error::Error;
use piezoid_numerics::series::{ends, mean};
use piezoid_records::record::Record;
use piezoid_records::waveform::band;
use serde::{Deserialize, Serialize};

/// The range of the inputs that a model was identified from. A record of small fast steps and one of large slow sines
/// cover both frequencies, but not large fast sines: `slew` shows this.
///
/// ```
/// use piezoid::{Record, hammerstein::Domain};
/// let u: Vec<f64> = (0..2000).map(|t| 10.0 + 5.0 * (0.05 * f64::from(t)).sin()).collect();
/// let domain = Domain::of(&[Record::new(1e-3, u.clone(), u)?]).ok_or("no records")?;
/// assert!((domain.u[1] - 15.0).abs() < 0.01 && (domain.slew - 250.0).abs() < 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Lowest and highest input [input unit].
    pub u: [f64; 2],
    /// Lowest and highest frequency with significant power [Hz]; `None` if all inputs are constant.
    pub hz: Option<[f64; 2]>,
    /// Largest change of the input from one sample to the next [input unit/s].
    pub slew: f64,
    /// Lowest and highest mean input of a record [input unit].
    pub mean: [f64; 2],
}

impl Domain {
    /// How far an input may leave the range without a remark, as a share of its width.
    const RANGE_MARGIN: f64 = 0.01;

    /// How much faster an input may change without a remark, as a share of the largest rate.
    const RATE_MARGIN: f64 = 0.1;

    /// The domain of these records together; `None` if there are none.
    pub fn of<'a>(records: impl IntoIterator<Item = &'a Record>) -> Option<Self> {
        Domain::together(records.into_iter().map(|r| Domain::of_input(r.u(), r.ts())))
    }

    /// The domain of all these; `None` if there are none.
    pub fn together(domains: impl IntoIterator<Item = Domain>) -> Option<Self> {
        domains.into_iter().reduce(|a, b| Domain {
            u: union(a.u, b.u),
            hz: a.hz.zip(b.hz).map(|(a, b)| union(a, b)).or(a.hz).or(b.hz),
            slew: a.slew.max(b.slew),
            mean: union(a.mean, b.mean),
        })
    }

    /// The domain of one input, not empty, sampled every `ts` [s].
    pub fn of_input(u: &[f64], ts: f64) -> Self {
        let (low, high) = ends(u.iter().copied());
        let hz = band(u, ts).map(|(low, high)| [low, high]);
        Domain { u: [low, high], hz, slew: Domain::slew_of(u, ts), mean: [mean(u); 2] }
    }

    /// True if no input from `low` to `high` leaves the range by more than the margin.
    pub fn spans(&self, [low, high]: [f64; 2]) -> bool {
        let slack = Domain::RANGE_MARGIN * (self.u[1] - self.u[0]);
        low >= self.u[0] - slack && high <= self.u[1] + slack
    }

    /// True if an input that changes so fast [input unit/s] exceeds the rates by more than the margin.
    pub fn is_slower_than(&self, slew: f64) -> bool {
        slew > (1.0 + Domain::RATE_MARGIN) * self.slew
    }

    /// The largest change of an input from one sample to the next [input unit/s].
    pub fn slew_of(u: &[f64], ts: f64) -> f64 {
        u.windows(2).fold(0.0, |m: f64, w| m.max((w[1] - w[0]).abs())) / ts
    }

    /// Checks the order of the ends, which come from a file.
    pub fn checked(self) -> Result<Self, Error> {
        let ordered = |[low, high]: [f64; 2]| low <= high;
        if ordered(self.u) && ordered(self.mean) && self.hz.is_none_or(ordered) && self.slew >= 0.0 {
            return Ok(self);
        }
        let rule = "must contain ends from low to high, and a slew of 0 or more";
        Err(Error::parameter("identified", format!("{self:?}"), rule))
    }
}

/// The union of two ranges.
fn union(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    #[test]
    fn records_together_cover_the_range_of_each() {
        let record = |bias: f64, height: f64, hz: f64| {
            let u: Vec<f64> = (0..4000).map(|t| bias + height * (TAU * hz * f64::from(t) * 5e-4).sin()).collect();
            Record::new(5e-4, u.clone(), u).unwrap()
        };
        let domain = Domain::of(&[record(0.0, 20.0, 5.0), record(15.0, 10.0, 80.0)]).unwrap();
        assert_close(&domain.u, &[-20.0, 25.0], 1e-2, 0.0);
        assert_close(&domain.mean, &[0.0, 15.0], 1e-9, 1e-9);
        assert_close(&domain.hz.unwrap(), &[5.0, 80.0], 1e-2, 0.0);
        assert_close(&[domain.slew], &[10.0 * TAU * 80.0], 2e-2, 0.0);
        assert_eq!(Domain::of(&[]), None);
        let still = Record::new(1.0, vec![2.0; 9], vec![0.0; 9]).unwrap();
        assert_eq!(Domain::of(&[still, record(0.0, 1.0, 5.0)]).unwrap().hz, Some([5.0, 5.0]));
    }
}
