//! The regression of equation (1): one row `[y_t, psi_t]` a sample, and the cost the paper's swarm minimises over it.
//!
//! ```text
//! f(theta) = sum_t |y_t - psi_t' theta|,   psi_t = [y_{t-1}, ..., u_{t-d}, u_{t-d-1}, ...]
//! ```

use crate::error::Error;
use crate::optimize::swarm::Cost;
use crate::record::{Record, same_sampling};
use multiversion::{multiversion, target::target_cfg_f};
use serde::{Deserialize, Serialize};

/// How many coefficients the block has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Orders {
    /// Number of a coefficients.
    pub na: usize,
    /// Number of b coefficients after the delay.
    pub nb: usize,
    /// Samples between an input and its first effect.
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

    /// Samples before the first row is complete.
    pub(crate) fn history(&self) -> usize {
        self.na.max(self.nb + self.delay - 1)
    }
}

/// The rows of one or more records, stacked. No row spans two records.
#[derive(Debug, Clone, PartialEq)]
pub struct Regression {
    pub(crate) ts: f64,
    pub(crate) orders: Orders,
    /// `[y_t, psi_t...]` one after another.
    pub(crate) rows: Vec<f64>,
    /// For each record, its number of rows.
    pub(crate) lengths: Vec<usize>,
}

impl Regression {
    /// The regression of `records` for a block of `orders`.
    ///
    /// # Errors
    /// Refuses no b at all, records of different sampling periods, and too few samples: at least twice as many rows
    /// as there are parameters.
    pub fn new(records: &[Record], orders: Orders) -> Result<Self, Error> {
        if orders.nb == 0 {
            return Err(Error::parameter("nb", 0, "must be at least 1: the block needs an input"));
        }
        let Some(first) = records.first() else {
            let remedy = "give at least one record".into();
            return Err(Error::TooShort { what: "the list of records".into(), have: 0, need: 1, remedy });
        };
        let mut regression = Regression { ts: first.ts(), orders, rows: Vec::new(), lengths: Vec::new() };
        for (k, record) in records.iter().enumerate() {
            same_sampling("record 1", first.ts(), &format!("record {}", k + 1), record.ts())?;
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
            let remedy = format!("record longer, or choose an order below {}", orders.na.max(orders.nb - 1));
            return Err(Error::TooShort { what: "the regression".into(), have, need, remedy });
        }
        Ok(regression)
    }

    /// Number of rows.
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.rows.len() / self.stride()
    }

    /// Numbers a row.
    pub(crate) fn stride(&self) -> usize {
        self.orders.parameters() + 1
    }

    /// The same rows with each record's own output offset taken off.
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

/// "a, b and c".
pub(crate) fn join(items: &[impl ToString]) -> String {
    let texts: Vec<String> = items.iter().map(ToString::to_string).collect();
    match texts.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => texts.concat(),
    }
}

/// The paper's fitness: the sum of absolute one-step prediction errors, for many particles at once.
///
/// The lanes of the vector unit are particles: each sums its own rows in order, so its cost is the same to the bit
/// whatever the width, the company it is evaluated in, and the number of threads.
#[derive(Debug, Clone, Copy)]
pub struct AbsoluteError<'a> {
    rows: &'a [f64],
    stride: usize,
}

/// Rows between two looks at which particles can still beat their limits.
const BLOCK: usize = 128;

impl<'a> AbsoluteError<'a> {
    /// The cost over `rows`, which hold `[y, psi...]` one after another, `dimension` numbers in psi.
    pub fn new(rows: &'a [f64], dimension: usize) -> Self {
        AbsoluteError { rows, stride: dimension + 1 }
    }
}

impl<'a> From<&'a Regression> for AbsoluteError<'a> {
    fn from(regression: &'a Regression) -> Self {
        AbsoluteError { rows: &regression.rows, stride: regression.stride() }
    }
}

impl Cost for AbsoluteError<'_> {
    fn evaluate(&self, positions: &[f64], limits: &[f64], costs: &mut [f64]) {
        costs.fill(0.0);
        let d = self.stride - 1;
        let mut theta = vec![0.0; 32 * d];
        let mut live: Vec<usize> = (0..costs.len()).collect();
        for block in self.rows.chunks(BLOCK * self.stride) {
            let mut rest = live.as_slice();
            while !rest.is_empty() {
                let (company, others) = rest.split_at(rest.len().min(32));
                match company.len() {
                    1..=8 => together::<8>(block, company, positions, &mut theta, costs),
                    9..=16 => together::<16>(block, company, positions, &mut theta, costs),
                    17..=24 => together::<24>(block, company, positions, &mut theta, costs),
                    _ => together::<32>(block, company, positions, &mut theta, costs),
                }
                rest = others;
            }
            live.retain(|&m| costs[m] < limits[m]);
        }
    }
}

/// Adds the rows' errors to the costs of a company of at most `L` particles.
fn together<const L: usize>(rows: &[f64], company: &[usize], positions: &[f64], theta: &mut [f64], costs: &mut [f64]) {
    let d = theta.len() / 32;
    let (theta, _) = theta.as_chunks_mut::<L>();
    let mut sums = [0.0; L];
    for (lane, &m) in company.iter().enumerate() {
        sums[lane] = costs[m];
        for (k, theta) in theta[..d].iter_mut().enumerate() {
            theta[lane] = positions[m * d + k];
        }
    }
    accumulate::<L>(rows, &theta[..d], &mut sums);
    for (lane, &m) in company.iter().enumerate() {
        costs[m] = sums[lane];
    }
}

/// sums[lane] += sum over rows of |y - psi' theta[lane]|.
#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn accumulate<const L: usize>(rows: &[f64], theta: &[[f64; L]], sums: &mut [f64; L]) {
    let mut sum = *sums;
    for row in rows.chunks_exact(theta.len() + 1) {
        let mut error = [row[0]; L];
        for (psi, theta) in row[1..].iter().zip(theta) {
            for lane in 0..L {
                // A fused step only where it is an instruction: elsewhere it is a slow library call.
                error[lane] = if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
                    (-psi).mul_add(theta[lane], error[lane])
                } else {
                    error[lane] - psi * theta[lane]
                };
            }
        }
        for lane in 0..L {
            sum[lane] += error[lane].abs();
        }
    }
    *sums = sum;
}
