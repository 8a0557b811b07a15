//! Scales: from values to coordinates.

/// A linear or logarithmic scale between two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    /// Value at the start.
    pub(super) low: f64,
    /// Value at the end.
    pub(super) high: f64,
    log: bool,
    /// Coordinates of the two ends [units of the drawing].
    ends: (f64, f64),
}

impl Scale {
    pub(super) fn linear(low: f64, high: f64) -> Self {
        Scale { low, high, log: false, ends: (0.0, 1.0) }
    }

    pub(super) fn log(low: f64, high: f64) -> Self {
        Scale { low, high, log: true, ends: (0.0, 1.0) }
    }

    /// The same scale between these coordinates.
    pub(super) fn onto(self, start: f64, end: f64) -> Self {
        Scale { ends: (start, end), ..self }
    }

    /// The coordinate of a value; `None` if it is not finite, or not positive on a logarithmic scale.
    pub(super) fn at(&self, value: f64) -> Option<f64> {
        if !value.is_finite() || (self.log && value <= 0.0) {
            return None;
        }
        let share = if self.log {
            (value.ln() - self.low.ln()) / (self.high.ln() - self.low.ln())
        } else {
            // Halves, because the difference of the largest numbers would overflow.
            (value / 2.0 - self.low / 2.0) / (self.high / 2.0 - self.low / 2.0)
        };
        Some((self.ends.0 + share * (self.ends.1 - self.ends.0)).clamp(-1e5, 1e5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_middle_of_a_scale_is_the_arithmetic_or_geometric_mean() {
        let linear = Scale::linear(10.0, 1000.0).onto(0.0, 100.0).at(505.0).unwrap();
        let log = Scale::log(10.0, 1000.0).onto(100.0, 0.0).at(100.0).unwrap();
        assert_close(&[linear, log], &[50.0, 50.0], 0.0, 1e-9);
    }

    #[test]
    fn values_that_cannot_be_drawn_have_no_coordinate() {
        assert_eq!(Scale::linear(0.0, 1.0).at(f64::NAN), None);
        assert_eq!(Scale::log(1.0, 10.0).at(0.0), None);
        assert_eq!(Scale::log(1.0, 10.0).at(-1.0), None);
    }
}
