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
