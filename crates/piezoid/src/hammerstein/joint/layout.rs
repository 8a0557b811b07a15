//! Which column of the linearised error belongs to which parameter.

use super::estimate::Estimate;
use std::ops::Range;

/// The columns: those of the parameters, then those of a record's own past and constant.
#[derive(Debug, Clone)]
pub(super) struct ColumnLayout {
    /// Weights of the hysteresis.
    pub(super) weights: Range<usize>,
    /// Gains of creep.
    pub(super) gains: Range<usize>,
    /// ShapeParameter of the hysteresis.
    pub(super) shape: Range<usize>,
    /// a1, a2, ...
    pub(super) a: Range<usize>,
    /// b from the first that is not a delay.
    pub(super) b: Range<usize>,
    /// A record's own: the state its creep began in.
    pub(super) crept: Range<usize>,
    /// The state its G began in.
    pub(super) state: Range<usize>,
    /// The constant in its output.
    pub(super) constant: usize,
    /// The trend of its output, where it drifts.
    pub(super) trend: usize,
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
            shape: next(estimate.basis.shape().len()),
            a: next(na),
            b: next(nb - estimate.linear.delay()),
            crept: next(lags),
            state: next(na.max(nb - 1)),
            constant: next(1).start,
            trend: next(1).start,
        }
    }

    /// Number of parameters.
    pub(super) fn parameters(&self) -> usize {
        self.b.end
    }

    /// Number of a record's own coefficients.
    pub(super) fn own(&self) -> usize {
        self.columns() - self.parameters()
    }

    /// Number of columns; y stands behind the last.
    pub(super) fn columns(&self) -> usize {
        self.trend + 1
    }
}
