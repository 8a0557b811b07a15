//! From values to places on the drawing.

/// Where values lie between two ends, linearly or logarithmically.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    /// Value at the start.
    pub(super) low: f64,
    /// Value at the end.
    pub(super) high: f64,
    log: bool,
    /// Places of the two ends [units of the drawing].
    ends: (f64, f64),
}

impl Scale {
    pub(super) fn linear(low: f64, high: f64) -> Self {
        Scale { low, high, log: false, ends: (0.0, 1.0) }
    }

    pub(super) fn log(low: f64, high: f64) -> Self {
        Scale { low, high, log: true, ends: (0.0, 1.0) }
    }

    /// The same scale with its ends at these places.
    pub(super) fn onto(self, start: f64, end: f64) -> Self {
        Scale { ends: (start, end), ..self }
    }

    /// The place of a value; `None` for what is not finite, or not positive on a logarithmic scale.
    pub(super) fn at(&self, value: f64) -> Option<f64> {
        if !value.is_finite() || (self.log && value <= 0.0) {
            return None;
        }
        let share = if self.log {
            (value.ln() - self.low.ln()) / (self.high.ln() - self.low.ln())
        } else {
            // Halves, because the difference of the largest numbers overflows.
            (value / 2.0 - self.low / 2.0) / (self.high / 2.0 - self.low / 2.0)
        };
        Some((self.ends.0 + share * (self.ends.1 - self.ends.0)).clamp(-1e5, 1e5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_close;

    #[test]
    fn the_middle_of_a_scale_is_the_mean_of_its_kind() {
        let linear = Scale::linear(10.0, 1000.0).onto(0.0, 100.0).at(505.0).unwrap();
        let log = Scale::log(10.0, 1000.0).onto(100.0, 0.0).at(100.0).unwrap();
        assert_close(&[linear, log], &[50.0, 50.0], 0.0, 1e-9);
    }

    #[test]
    fn what_cannot_be_drawn_has_no_place() {
        assert_eq!(Scale::linear(0.0, 1.0).at(f64::NAN), None);
        assert_eq!(Scale::log(1.0, 10.0).at(0.0), None);
        assert_eq!(Scale::log(1.0, 10.0).at(-1.0), None);
    }
}
