//! Counts of samples in which a plant or its sensor reached a limit.

use std::fmt;

/// Samples in which a limit was reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Saturation {
    /// Samples whose input the driver clamped to its range.
    pub clamped: usize,
    /// Samples in which the driver's current was at its limit.
    pub current_limited: usize,
    /// Samples that the sensor clipped to its range.
    pub sensor_clipped: usize,
}

impl Saturation {
    /// True if any limit was reached.
    pub fn any(&self) -> bool {
        *self != Saturation::default()
    }
}

impl fmt::Display for Saturation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts: Vec<String> = [
            (self.clamped, "clamped to the driver's voltage range"),
            (self.current_limited, "limited by the driver's current"),
            (self.sensor_clipped, "clipped by the sensor's range"),
        ]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {} {what}", if count == 1 { "sample" } else { "samples" }))
        .collect();
        if parts.is_empty() { f.write_str("no limit was reached") } else { f.write_str(&parts.join(", ")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_described_in_words() {
        assert_eq!(Saturation::default().to_string(), "no limit was reached");
        let some = Saturation { clamped: 1, sensor_clipped: 12, ..Saturation::default() };
        let words = "1 sample clamped to the driver's voltage range, 12 samples clipped by the sensor's range";
        assert_eq!(some.to_string(), words);
        assert!(some.any());
    }
}
