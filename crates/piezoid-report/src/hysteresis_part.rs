//! The hysteresis of a loop without its slope: y less the least-squares straight line over u.
//!
//! A loop whose width is a tenth of its height is thin over u. Without the line the width takes the whole panel.

/// A straight line, y = mean of y + slope (u - mean of u).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StraightLine {
    slope: f64,
    u: f64,
    y: f64,
}

impl StraightLine {
    /// The least-squares line through the points; level if all `u` are equal.
    pub(crate) fn through(u: &[f64], y: &[f64]) -> Self {
        let n = u.len().min(y.len());
        let mean = |x: &[f64]| x[..n].iter().sum::<f64>() / n.max(1) as f64;
        let (mu, my) = (mean(u), mean(y));
        let (uu, uy) = u.iter().zip(y).fold((0.0, 0.0), |(uu, uy), (u, y)| {
            let from_mean = u - mu;
            (uu + from_mean * from_mean, uy + from_mean * (y - my))
        });
        StraightLine { slope: if uu > 0.0 { uy / uu } else { 0.0 }, u: mu, y: my }
    }

    /// What of `y` is left above the line.
    pub(crate) fn taken_from(&self, u: &[f64], y: &[f64]) -> Vec<f64> {
        u.iter().zip(y).map(|(u, y)| y - self.y - self.slope * (u - self.u)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn a_straight_line_leaves_nothing_and_a_loop_its_width() {
        let u = [0.0, 1.0, 2.0, 1.0];
        let left = |y: &[f64]| StraightLine::through(&u, y).taken_from(&u, y);
        assert_close(&left(&[3.0, 5.0, 7.0, 5.0]), &[0.0; 4], 0.0, 1e-12);
        assert_close(&left(&[3.0, 4.5, 7.0, 5.5]), &[0.0, -0.5, 0.0, 0.5], 0.0, 1e-12);
        assert_eq!(StraightLine::through(&[2.0, 2.0], &[1.0, 3.0]).taken_from(&[2.0], &[4.0]), [2.0]);
        assert!(StraightLine::through(&[], &[]).taken_from(&[], &[]).is_empty());
    }
}
