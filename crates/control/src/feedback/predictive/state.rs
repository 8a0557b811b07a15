//! Layout of the state.

use super::Predictive;
use piezoid_numerics::system::System;

/// The parts of a state, in this order.
pub(super) struct Parts<'x> {
    /// The estimated state of linear block, creep and disturbance.
    pub(super) s: &'x mut [f64],
    /// Predicted measurements, without offset, that have not arrived: one per sample of sensor delay, the oldest first.
    pub(super) unread: &'x mut [f64],
    /// The last z and u.
    pub(super) last: &'x mut [f64],
    /// The state of the model, where only hysteresis and driver change, and a copy for trials.
    pub(super) model: &'x mut [f64],
    pub(super) trial: &'x mut [f64],
    /// s of the next sample.
    pub(super) next: &'x mut [f64],
    /// Over the horizon: r minus the free response, and z.
    pub(super) errors: &'x mut [f64],
    pub(super) z: &'x mut [f64],
    /// Limits of the rows.
    pub(super) low: &'x mut [f64],
    pub(super) high: &'x mut [f64],
    /// Buffer of the quadratic program, with its warm start.
    pub(super) scratch: &'x mut [f64],
}

impl Predictive {
    /// Their lengths.
    pub(super) fn lengths(&self) -> [usize; 11] {
        let (observer, model, horizon) = (self.plant.order(), self.model.order(), self.settings.horizon);
        let (rows, scratch) = (self.horizon.program.sigma.len(), self.horizon.program.scratch());
        let delay_samples = self.settings.delay_samples;
        [observer, delay_samples, 2, model, model, observer, horizon, horizon, rows, rows, scratch]
    }

    pub(super) fn parts<'x>(&self, x: &'x mut [f64]) -> Parts<'x> {
        let mut rest = x;
        let [s, unread, last, model, trial, next, errors, z, low, high, scratch] = self.lengths().map(|length| {
            let (part, left) = std::mem::take(&mut rest).split_at_mut(length);
            rest = left;
            part
        });
        Parts { s, unread, last, model, trial, next, errors, z, low, high, scratch }
    }
}
