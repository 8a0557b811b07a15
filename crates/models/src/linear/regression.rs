//! The regression of equation (1): one row `[y_t, psi_t]` per sample, psi_t = [y_{t-1}, ..., u_{t-d}, u_{t-d-1}, ...].

use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::Bounds;
use piezoid_records::record::Record;
use serde::{Deserialize, Serialize};

/// Numbers of coefficients of the block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Orders {
    /// Number of a coefficients.
    pub na: usize,
    /// Number of b coefficients after the delay.
    pub nb: usize,
    /// Delay [samples].
    pub delay: usize,
}

impl Orders {
    /// n poles and n zeros, as the paper's equation (1) with n = 2.
    pub fn of(n: usize) -> Self {
        Orders { na: n, nb: n + 1, delay: 0 }
    }

    /// Length of theta.
    pub fn parameters(&self) -> usize {
        self.na + self.nb
    }

    /// Checks the orders and that `records` have one sampling period; returns the first record.
    pub fn check<'r>(&self, records: &'r [Record]) -> Result<&'r Record, Error> {
        let Orders { na, nb, delay } = *self;
        if !(1..=512).contains(&nb) || na > 512 || delay > 512 {
            let value = format!("{na}, {nb}, {delay}");
            return Err(Error::parameter("na, nb, delay", value, "must be at most 512, and nb at least 1"));
        }
        let Some(first) = records.first() else {
            let remedy = "give at least one record".into();
            return Err(Error::TooShort { what: "the list of records".into(), have: 0, need: 1, remedy });
        };
        for (k, record) in records.iter().enumerate() {
            Record::same_sampling("record 1", first.ts(), &format!("record {}", k + 1), record.ts())?;
        }
        Ok(first)
    }

    /// Samples before the first row is complete.
    pub(crate) fn history(&self) -> usize {
        self.na.max(self.nb.saturating_add(self.delay).saturating_sub(1))
    }
}

/// The rows of one or more records, stacked. No row spans two records.
#[derive(Debug, Clone, PartialEq)]
pub struct Regression {
    pub(crate) ts: f64,
    pub(crate) orders: Orders,
    /// `[y_t, psi_t...]` one after another.
    pub(crate) rows: Vec<f64>,
    /// Number of rows of each record.
    pub(crate) lengths: Vec<usize>,
}

impl Regression {
    /// The regression of `records` for a block of `orders`.
    ///
    /// # Errors
    /// Returns an error for orders out of range, records of different sampling periods, or fewer rows than twice the
    /// parameters.
    pub fn new(records: &[Record], orders: Orders) -> Result<Self, Error> {
        let first = orders.check(records)?;
        let mut regression = Regression { ts: first.ts(), orders, rows: Vec::new(), lengths: Vec::new() };
        for record in records {
            let before = regression.rows.len();
            let (u, y) = (record.u(), record.y());
            for t in orders.history()..record.len() {
                regression.rows.push(y[t]);
                regression.rows.extend((1..=orders.na).map(|k| y[t - k]));
                regression.rows.extend((0..orders.nb).map(|k| u[t - orders.delay - k]));
            }
            regression.lengths.push((regression.rows.len() - before) / regression.stride());
        }
        let (have, need) = (regression.len(), 2 * orders.parameters());
        if have < need {
            let remedy = "record longer, or choose a lower order or delay".into();
            return Err(Error::TooShort { what: "the regression".into(), have, need, remedy });
        }
        Ok(regression)
    }

    /// Number of rows.
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.rows.len() / self.stride()
    }

    /// The rows, `[y_t, psi_t...]` each.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.rows.chunks_exact(self.stride())
    }

    /// The search range of theta. The coefficients of a stable 1 - a1 q^-1 - ... - an q^-n are at most binomial(n, k)
    /// in size; each b is assumed to be at most the largest output over the largest input. If a coefficient of `around`
    /// (from least squares, say) is larger, its range is twice that.
    ///
    /// # Errors
    /// Returns an error if inputs or outputs are all zero.
    pub fn search_box(&self, around: &[f64]) -> Result<Bounds, Error> {
        let Orders { na, nb, .. } = self.orders;
        let peak = |columns: std::ops::Range<usize>| {
            self.rows().flat_map(|row| &row[columns.clone()]).fold(0.0f64, |m, v| m.max(v.abs()))
        };
        let b_max = peak(0..1) / peak(1 + na..self.stride());
        let binomial = |k: usize| (1..=k).fold(1.0, |c, i| c * (na + 1 - i) as f64 / i as f64);
        let mut high: Vec<f64> = (1..=na).map(binomial).chain(std::iter::repeat_n(b_max, nb)).collect();
        for (high, around) in high.iter_mut().zip(around).filter(|(high, around)| around.abs() >= **high) {
            *high = 2.0 * around.abs();
        }
        Bounds::new(high.iter().map(|h| -h).collect(), high)
    }

    /// Numbers per row.
    pub(crate) fn stride(&self) -> usize {
        self.orders.parameters() + 1
    }

    /// The same rows without the output offset of each record.
    pub(crate) fn centred(&self, offsets: &[f64]) -> Self {
        let mut centred = self.clone();
        let (stride, na) = (self.stride(), self.orders.na);
        let mut rows = centred.rows.chunks_exact_mut(stride);
        for (&offset, &length) in offsets.iter().zip(&self.lengths) {
            for row in rows.by_ref().take(length) {
                row[..=na].iter_mut().for_each(|y| *y -= offset);
            }
        }
        centred
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(ts: f64, n: i32) -> Record {
        let [u, y] = [2.0, 10.0].map(|scale| (0..n).map(|k| scale * f64::from(k)).collect());
        Record::new(ts, u, y).unwrap()
    }

    const ORDERS: Orders = Orders { na: 2, nb: 1, delay: 3 };

    #[test]
    fn a_row_is_an_output_the_outputs_before_it_and_delayed_inputs() {
        let records = [record(0.1, 8), record(0.1, 5)];
        let regression = Regression::new(&records, ORDERS).unwrap();
        assert_eq!((regression.len(), ORDERS.parameters()), (7, 3));
        let rows: Vec<&[f64]> = regression.rows().collect();
        assert_eq!(rows[0], [30.0, 20.0, 10.0, 0.0]);
        assert_eq!(rows[4], [70.0, 60.0, 50.0, 8.0]);
        assert_eq!(rows[5], rows[0]);
        let centred = regression.centred(&[1.0, -1.0]);
        let centred: Vec<&[f64]> = centred.rows().collect();
        assert_eq!(centred[4], [69.0, 59.0, 49.0, 8.0]);
        assert_eq!(centred[5], [31.0, 21.0, 11.0, 0.0]);
    }

    #[test]
    fn orders_out_of_range_and_too_few_samples_are_errors() {
        let records = [record(0.1, 30)];
        for (na, nb, delay) in [(513, 1, 0), (0, 0, 0), (0, 513, 0), (0, 1, 513)] {
            let message = Regression::new(&records, Orders { na, nb, delay }).unwrap_err().to_string();
            assert!(message.contains(&format!("{na}, {nb}, {delay}")), "{message}");
        }
        for (na, nb, delay) in [(512, 1, 0), (0, 512, 0), (0, 1, 512)] {
            let message = Regression::new(&records, Orders { na, nb, delay }).unwrap_err().to_string();
            assert!(message.contains("record longer"), "{message}");
        }
        assert!(Regression::new(&[record(0.1, 9)], ORDERS).is_ok());
        assert!(Regression::new(&[record(0.1, 8)], ORDERS).is_err());
        assert!(Regression::new(&[], ORDERS).is_err());
        assert!(Regression::new(&[record(0.1, 30), record(0.2, 30)], ORDERS).is_err());
    }

    #[test]
    fn the_box_of_the_search_holds_every_stable_denominator_and_what_was_found() {
        let regression = Regression::new(&[record(0.1, 30)], Orders { na: 3, nb: 2, delay: 0 }).unwrap();
        // Binomial coefficients, and 290 um over 58 V.
        let around = [0.0; 5];
        let expected = [3.0, 3.0, 1.0, 5.0, 5.0];
        let bounds = |around: &[f64]| regression.search_box(around).unwrap();
        assert_eq!(bounds(&around), Bounds::new(expected.map(|h| -h).to_vec(), expected.to_vec()).unwrap());
        let wide = [6.0, 3.0, 1.0, 5.0, 14.0];
        let found = bounds(&[-3.0, 2.9, 0.0, 4.9, 7.0]);
        assert_eq!(found, Bounds::new(wide.map(|h| -h).to_vec(), wide.to_vec()).unwrap());
        let still = Record::new(0.1, vec![0.0; 30], vec![0.0; 30]).unwrap();
        assert!(Regression::new(&[still], ORDERS).unwrap().search_box(&[0.0; 3]).is_err());
    }
}
