//! Cubic interpolation with the not-a-knot end condition, like MATLAB's `spline` and scipy's `CubicSpline`.
//!
//! Between two knots the curve is a cubic; value, slope and curvature are continuous. At the second and the last but
//! one knot the third derivative is continuous too: the first two pieces are one cubic, and so are the last two (de
//! Boor 1978, A Practical Guide to Splines, chapter IV). Two knots give a line, three a parabola.

use crate::error::{Error, finite};
use crate::intervals::Intervals;

/// An interpolating cubic spline.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    knots: Intervals,
    /// For each piece, the value, slope, half curvature and sixth of the third derivative at its left knot.
    pieces: Vec<[f64; 4]>,
}

impl Spline {
    /// Interpolates `y` at the knots `x`, which must be strictly ascending. Returns an error if there are no knots, if
    /// lengths differ, if a number is not finite, if knots are not ascending, or if the coefficients overflow.
    pub fn new(x: &[f64], y: &[f64]) -> Result<Self, Error> {
        finite("knots x", x)?;
        finite("knots y", y)?;
        if x.len() != y.len() {
            let (left, right) = ("knots x".into(), "knots y".into());
            return Err(Error::Lengths { left, left_len: x.len(), right, right_len: y.len() });
        }
        if x.is_empty() {
            let remedy = "give at least one".into();
            return Err(Error::TooShort { what: "the list of knots".into(), have: 0, need: 1, remedy });
        }
        if let Some(i) = (1..x.len()).find(|&i| x[i] <= x[i - 1]) {
            return Err(Error::parameter(format!("knots x[{i}]"), x[i], format!("must be above {}", x[i - 1])));
        }
        let h: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
        let m: Vec<f64> = y.windows(2).zip(&h).map(|(w, h)| (w[1] - w[0]) / h).collect();
        let s = slopes(&h, &m);
        let mut pieces: Vec<[f64; 4]> = (0..h.len())
            .map(|i| {
                let bend = (s[i] + s[i + 1] - 2.0 * m[i]) / h[i];
                [y[i], s[i], (m[i] - s[i]) / h[i] - bend, bend / h[i]]
            })
            .collect();
        if pieces.is_empty() {
            pieces.push([y[0], 0.0, 0.0, 0.0]);
        }
        if let Some(i) = pieces.iter().position(|piece| !piece.iter().all(|c| c.is_finite())) {
            let (name, value) = (format!("knots {i} and {}", i + 1), format!("{} and {}", x[i], x[i + 1]));
            return Err(Error::parameter(name, value, "are too steep: the curve between them overflows"));
        }
        Ok(Spline { knots: Intervals::new(x.to_vec()), pieces })
    }

    /// The curve at `x`; outside the knots, the cubic of the outermost piece.
    pub fn at(&self, x: f64) -> f64 {
        self.on(self.place(x))
    }

    /// The piece of `x`, and the distance from its left knot.
    #[inline]
    pub fn place(&self, x: f64) -> (usize, f64) {
        let i = self.knots.of(x);
        (i, x - self.knots.edges()[i])
    }

    /// The curve at a place of this spline or of another one with the same knots.
    #[inline]
    pub fn on(&self, (piece, t): (usize, f64)) -> f64 {
        let [c0, c1, c2, c3] = self.pieces[piece];
        c0 + t * (c1 + t * (c2 + t * c3))
    }

    /// The slope of the curve at a place of this spline.
    #[inline]
    pub fn slope_on(&self, (piece, t): (usize, f64)) -> f64 {
        let [_, c1, c2, c3] = self.pieces[piece];
        c1 + t * (2.0 * c2 + t * (3.0 * c3))
    }

    /// For each piece, the coefficients of 1, t, t^2 and t^3, with t the distance from its left knot.
    pub fn pieces(&self) -> &[[f64; 4]] {
        &self.pieces
    }
}

/// Slopes at the knots for intervals `h` with secants `m`: a tridiagonal system.
fn slopes(h: &[f64], m: &[f64]) -> Vec<f64> {
    let n = h.len();
    match n {
        0 => return vec![0.0],
        1 => return vec![m[0]; 2],
        2 => {
            let bend = (m[1] - m[0]) / (h[0] + h[1]);
            return vec![m[0] - bend * h[0], m[0] + bend * h[0], m[1] + bend * h[1]];
        }
        _ => {}
    }
    // Row i: below[i] s[i-1] + diagonal[i] s[i] + above[i] s[i+1] = right[i]; the ends are not-a-knot.
    let end = |h0: f64, h1: f64, m0: f64, m1: f64| {
        let d = h0 + h1;
        (h1, d, ((h0 + 2.0 * d) * h1 * m0 + h0 * h0 * m1) / d)
    };
    let (mut diagonal, mut above, mut right) = (vec![0.0; n + 1], vec![0.0; n + 1], vec![0.0; n + 1]);
    (diagonal[0], above[0], right[0]) = end(h[0], h[1], m[0], m[1]);
    let (last, below_last, right_last) = end(h[n - 1], h[n - 2], m[n - 1], m[n - 2]);
    for i in 1..=n {
        let below;
        if i < n {
            below = h[i];
            diagonal[i] = 2.0 * (h[i - 1] + h[i]);
            above[i] = h[i - 1];
            right[i] = 3.0 * (h[i] * m[i - 1] + h[i - 1] * m[i]);
        } else {
            (diagonal[n], below, right[n]) = (last, below_last, right_last);
        }
        let factor = below / diagonal[i - 1];
        diagonal[i] -= factor * above[i - 1];
        right[i] -= factor * right[i - 1];
    }
    let mut s = right;
    s[n] /= diagonal[n];
    for i in (0..n).rev() {
        s[i] = (s[i] - above[i] * s[i + 1]) / diagonal[i];
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::golden::{numbers, rows, text};
    use piezoid_testing::random::largest;
    use piezoid_testing::{assert_close, assert_named_close};

    #[test]
    fn cubics_are_reproduced_between_and_outside_the_knots() {
        let x: [f64; 5] = [-2.0, -1.5, 0.25, 1.0, 4.0];
        let cubic = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x - 0.25 * x * x * x;
        let spline = Spline::new(&x, &x.map(cubic)).unwrap();
        for at in [-3.0, -1.7, 0.0, 0.9, 2.5, 5.0] {
            assert_close(&[spline.at(at)], &[cubic(at)], 1e-12, 1e-12);
        }
    }

    #[test]
    fn few_knots_give_a_constant_a_line_a_parabola() {
        assert_eq!(Spline::new(&[1.0], &[5.0]).unwrap().at(9.0), 5.0);
        assert_eq!(Spline::new(&[0.0, 2.0], &[0.0, 4.0]).unwrap().at(1.5), 3.0);
        assert_close(&[Spline::new(&[0.0, 1.0, 3.0], &[0.0, 1.0, 9.0]).unwrap().at(2.0)], &[4.0], 1e-12, 0.0);
    }

    #[test]
    fn knots_that_are_not_ascending_are_an_error() {
        let error = Spline::new(&[0.0, 1.0, 1.0], &[0.0; 3]).unwrap_err().to_string();
        assert_eq!(error, "knots x[2] = 1: must be above 1");
    }

    /// Relative to the value, plus the same share of the largest knot: near zero, the rounding error is relative to the
    /// knots.
    const TOLERANCE: f64 = 1e-12;

    #[track_caller]
    fn assert_close_beside_knots(name: &str, ours: &[f64], theirs: &[f64], knots: &[f64]) {
        assert_named_close(name, ours, theirs, TOLERANCE, TOLERANCE * largest(knots));
    }

    #[test]
    fn a_spline_is_scipys_not_a_knot_spline_between_and_beyond_its_knots() {
        let rows = rows("cubic_spline");
        assert_eq!(rows.len(), 40);
        for row in &rows {
            let [x, y, at, value] = ["x", "y", "at", "value"].map(|key| numbers(row, key));
            let spline = Spline::new(&x, &y).expect("knots that scipy takes");
            let ours: Vec<f64> = at.iter().map(|&x| spline.at(x)).collect();
            assert_close_beside_knots(text(row, "name"), &ours, &value, &y);
        }
    }

    #[test]
    fn a_spline_passes_through_its_knots() {
        for row in rows("cubic_spline") {
            let (x, y) = (numbers(&row, "x"), numbers(&row, "y"));
            let spline = Spline::new(&x, &y).expect("knots that scipy takes");
            let at_knots: Vec<f64> = x.iter().map(|&x| spline.at(x)).collect();
            // Every knot except the last is the start of a piece, whose value there is exact.
            let last = x.len() - 1;
            assert_eq!(at_knots[..last], y[..last], "{}", row["name"]);
            assert_close_beside_knots(text(&row, "name"), &at_knots[last..], &y[last..], &y);
        }
    }
}
