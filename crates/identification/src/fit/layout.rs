//! The columns of the linearised error and their parameters.

use super::estimate::Estimate;
use std::ops::Range;

/// The columns: first the parameters, then the record's own coefficients.
#[derive(Debug, Clone)]
pub(crate) struct ColumnLayout {
    /// Weights of the hysteresis.
    pub(crate) weights: Range<usize>,
    /// Gains of creep.
    pub(crate) gains: Range<usize>,
    /// Shape parameters of the hysteresis, then the lag of the driver if it is sought.
    pub(crate) shape: Range<usize>,
    /// a1, a2, ..., as coefficients of the differences of the outputs.
    pub(crate) a: Range<usize>,
    /// b after the delay, as coefficients of the differences of the inputs.
    pub(crate) b: Range<usize>,
    /// A record's own: the initial state of creep.
    pub(crate) crept: Range<usize>,
    /// The initial state of G, likewise.
    pub(crate) state: Range<usize>,
    /// The offset of its output.
    pub(crate) constant: usize,
    /// The trend of its output.
    pub(crate) trend: usize,
}

impl ColumnLayout {
    pub(super) fn of(estimate: &Estimate) -> Self {
        let mut end = 0;
        let mut next = |n: usize| {
            end += n;
            end - n..end
        };
        let (na, nb) = (estimate.linear.a().len(), estimate.linear.b().len());
        let lags = estimate.lags.len();
        ColumnLayout {
            weights: next(estimate.basis.len()),
            gains: next(lags),
            shape: next(estimate.basis.shape().len() + usize::from(estimate.seeks_lag)),
            a: next(na),
            b: next(nb - estimate.linear.delay()),
            crept: next(lags),
            state: next(na.max(nb - 1)),
            constant: next(1).start,
            trend: next(1).start,
        }
    }

    /// Number of parameters.
    pub(crate) fn parameters(&self) -> usize {
        self.b.end
    }

    /// Number of a record's own coefficients.
    pub(crate) fn own(&self) -> usize {
        self.columns() - self.parameters()
    }

    /// Number of columns; y follows the last.
    pub(crate) fn columns(&self) -> usize {
        self.trend + 1
    }
}
