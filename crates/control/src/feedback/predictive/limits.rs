//! The range that the next sample can reach, and the limits of the rows.

use super::state::Parts;
use super::{Predictive, PredictiveSettings};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::system::System;

impl Predictive {
    /// The voltages allowed after `u`, by limits and slew.
    pub(super) fn ends(&self, u: f64) -> (f64, f64) {
        let (bottom, top) = self.settings.voltage;
        // A request above the driver's slew rate would only run away from the driver's output.
        let slew = self.settings.slew.and(fastest(&self.model, &self.settings));
        let reach = slew.map_or(f64::INFINITY, |slew| slew * self.model.ts());
        ((u - reach).clamp(bottom, top), (u + reach).clamp(bottom, top))
    }

    /// Sets the limits of the rows.
    pub(super) fn limit(&self, parts: &mut Parts<'_>, ends: (f64, f64)) {
        let mut reached = |u: f64| {
            parts.trial.copy_from_slice(parts.model);
            self.model.step_hidden(parts.trial, u)
        };
        let (low, high) = (reached(ends.0), reached(ends.1));
        let high = high.max(low);
        let n = parts.z.len();
        // Holding z after this sample is always allowed.
        parts.low[..n].fill(self.major.0.min(high));
        parts.high[..n].fill(self.major.1.max(low));
        (parts.low[0], parts.high[0]) = (low, high);
        let (down, up) = self.steps(parts);
        parts.low[n..2 * n - 1].fill(-down);
        parts.high[n..2 * n - 1].fill(up);
        if let Some(allowed) = self.settings.displacement {
            let free = &mut *parts.errors;
            self.horizon.free(parts.s, free);
            for (i, free) in free.iter().enumerate() {
                parts.low[2 * n - 1 + i] = (allowed.0 - self.model.offset() - free) / self.horizon.gain;
                parts.high[2 * n - 1 + i] = (allowed.1 - self.model.offset() - free) / self.horizon.gain;
            }
        }
    }

    /// Largest steps of z per sample, down and up, by the slopes of the operator at its present state.
    fn steps(&self, parts: &mut Parts<'_>) -> (f64, f64) {
        let Some(slew) = fastest(&self.model, &self.settings) else { return (f64::INFINITY, f64::INFINITY) };
        let (operator, u, reach) = (self.model.hysteresis(), parts.last[1], slew * self.model.ts());
        let (from, trial) = (&parts.model[..operator.order()], &mut parts.trial[..operator.order()]);
        let mut z = |u: f64| {
            trial.copy_from_slice(from);
            operator.step(trial, u)
        };
        let here = z(u);
        ((here - z(u - reach)).max(0.0), (z(u + reach) - here).max(0.0))
    }
}

/// The largest rate of the voltage at the hysteresis [V/s]; `None` for no limit.
fn fastest(model: &Model, settings: &PredictiveSettings) -> Option<f64> {
    let driver = model.driver().and_then(|driver| driver.slew);
    [settings.slew, driver].into_iter().flatten().reduce(f64::min)
}
