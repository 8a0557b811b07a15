//! Layout of the state.

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

/// Their lengths.
#[derive(Debug, Clone, Copy)]
pub(super) struct StateLayout {
    pub(super) observer: usize,
    pub(super) delay_samples: usize,
    pub(super) model: usize,
    pub(super) horizon: usize,
    pub(super) rows: usize,
    pub(super) scratch: usize,
}

impl StateLayout {
    pub(super) fn length(self) -> usize {
        2 * self.observer + self.delay_samples + 2 + 2 * self.model + 2 * self.horizon + 2 * self.rows + self.scratch
    }

    pub(super) fn parts(self, x: &mut [f64]) -> Parts<'_> {
        let mut rest = x;
        let mut cut = |length: usize| {
            let (part, left) = std::mem::take(&mut rest).split_at_mut(length);
            rest = left;
            part
        };
        Parts {
            s: cut(self.observer),
            unread: cut(self.delay_samples),
            last: cut(2),
            model: cut(self.model),
            trial: cut(self.model),
            next: cut(self.observer),
            errors: cut(self.horizon),
            z: cut(self.horizon),
            low: cut(self.rows),
            high: cut(self.rows),
            scratch: cut(self.scratch),
        }
    }
}
