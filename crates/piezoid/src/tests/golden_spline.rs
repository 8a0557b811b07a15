//! Splines compared with scipy; `golden/cubic_spline.py` writes the numbers.

use super::golden::{numbers, rows, text};
use piezoid_numerics::spline::Spline;
use piezoid_testing::assert_named_close;

/// Relative to the value, plus the same share of the largest knot: near zero, the rounding error is relative to the
/// knots.
const TOLERANCE: f64 = 1e-12;

#[track_caller]
fn assert_close_beside_knots(name: &str, ours: &[f64], theirs: &[f64], knots: &[f64]) {
    let largest = knots.iter().fold(0.0f64, |m, y| m.max(y.abs()));
    assert_named_close(name, ours, theirs, TOLERANCE, TOLERANCE * largest);
}

#[test]
fn a_spline_is_scipys_not_a_knot_spline_between_and_beyond_its_knots() {
    let rows = rows(include_str!("../../tests/golden/cubic_spline.json"));
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
    for row in rows(include_str!("../../tests/golden/cubic_spline.json")) {
        let (x, y) = (numbers(&row, "x"), numbers(&row, "y"));
        let spline = Spline::new(&x, &y).expect("knots that scipy takes");
        let at_knots: Vec<f64> = x.iter().map(|&x| spline.at(x)).collect();
        // Every knot except the last is the start of a piece, whose value there is exact.
        let last = x.len() - 1;
        assert_eq!(at_knots[..last], y[..last], "{}", row["name"]);
        assert_close_beside_knots(text(&row, "name"), &at_knots[last..], &y[last..], &y);
    }
}
