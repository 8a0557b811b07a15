//! What the next sample can reach, and the limits of the program's rows.

use super::Predictive;
use super::state::Parts;
use crate::system::System;

impl Predictive {
    /// The voltages that limits and slew allow after `u`.
    pub(super) fn ends(&self, u: f64) -> (f64, f64) {
        let (bottom, top) = self.settings.voltage;
        let reach = self.settings.slew.map_or(f64::INFINITY, |slew| slew * self.model.ts());
        ((u - reach).clamp(bottom, top), (u + reach).clamp(bottom, top))
    }

    /// The limits of the rows.
    pub(super) fn limit(&self, parts: &mut Parts<'_>, ends: (f64, f64)) {
        let mut reached = |u: f64| {
            parts.trial.copy_from_slice(parts.operator);
            self.model.hysteresis().step(parts.trial, u)
        };
        let (low, high) = (reached(ends.0), reached(ends.1));
        let high = high.max(low);
        let n = parts.z.len();
        // Standing still after this sample is always allowed.
        parts.low[..n].fill(self.major.0.min(high));
        parts.high[..n].fill(self.major.1.max(low));
        (parts.low[0], parts.high[0]) = (low, high);
        let slope = if ends.1 > ends.0 { (high - low) / (ends.1 - ends.0) } else { 0.0 };
        let step = self.settings.slew.map_or(f64::INFINITY, |slew| slope * slew * self.model.ts());
        parts.low[n..2 * n - 1].fill(-step);
        parts.high[n..2 * n - 1].fill(step);
        if let Some(allowed) = self.settings.displacement {
            let free = &mut *parts.errors;
            self.horizon.free(parts.s, free);
            for (i, free) in free.iter().enumerate() {
                parts.low[2 * n - 1 + i] = (allowed.0 - self.model.offset() - free) / self.horizon.gain;
                parts.high[2 * n - 1 + i] = (allowed.1 - self.model.offset() - free) / self.horizon.gain;
            }
        }
    }
}
