//! Pictures of operators: the loop that a typical one draws, less most of its straight line so that it is open.

use piezoid::hysteresis::Operator;
use piezoid_numerics::series::{ends, range};
use std::fmt::Write;

/// Sampling period [s], and samples from one turn to the next.
const TS: f64 = 5e-4;
const LEG: usize = 24;

/// The inputs between which the path runs on straight lines: major loops until they repeat, then minor loops.
const TURNS: [f64; 10] = [0.0, 30.0, -30.0, 30.0, -30.0, 30.0, -4.0, 16.0, -16.0, 4.0];

/// The turn from which on the loop is drawn.
const DRAWN: usize = 3;

/// Share of the straight line that is subtracted.
const LESS: f64 = 0.7;

/// Width and height of the picture.
const SIZE: (f64, f64) = (96.0, 64.0);

/// The path data of an SVG of 96 by 64: the loop of the typical operator, major, then minor.
pub(crate) fn of(operator: &Operator) -> String {
    let (u, y) = path(operator);
    let slope = LESS * range(&y) / range(&u);
    let bare: Vec<f64> = u.iter().zip(&y).map(|(u, y)| y - slope * u).collect();
    let scaled = |samples: &[f64], size: f64| -> Vec<f64> {
        let (low, high) = ends(samples.iter().copied());
        samples.iter().map(|value| 2.0 + (size - 4.0) * (value - low) / (high - low)).collect()
    };
    let mut data = String::new();
    for (k, (x, y)) in scaled(&u, SIZE.0).iter().zip(scaled(&bare, SIZE.1)).enumerate() {
        let _ = write!(data, "{}{x:.0} {:.1}", if k == 0 { 'M' } else { 'L' }, SIZE.1 - y);
    }
    data
}

/// Inputs and outputs of the part that is drawn; nothing of an operator without a typical one.
fn path(operator: &Operator) -> (Vec<f64>, Vec<f64>) {
    let leg = |ends: &[f64]| {
        let (from, to) = (ends[0], ends[1]);
        (1..=LEG).map(move |k| from + (to - from) * k as f64 / LEG as f64)
    };
    let u: Vec<f64> = TURNS.windows(2).flat_map(leg).collect();
    let y = (operator.example)(TS).map(|example| example.simulate(&u)).unwrap_or_default();
    let drawn = y.len().min(DRAWN * LEG - 1);
    (u[drawn..].to_vec(), y[drawn..].to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::hysteresis::OPERATORS;

    #[test]
    fn every_operator_draws_a_loop_of_its_own() {
        let pictures: Vec<String> = OPERATORS.iter().map(|operator| of(operator)).collect();
        for (k, picture) in pictures.iter().enumerate() {
            assert!(picture.matches('L').count() > 100 && picture.len() < 2000, "{}: {picture}", OPERATORS[k].name);
            assert!(!picture.contains("NaN") && !pictures[..k].contains(picture), "{}", OPERATORS[k].name);
        }
    }

    #[test]
    fn a_loop_with_hysteresis_is_open_in_the_middle_and_a_proportional_one_is_not() {
        let open = |name: &str| {
            let (u, y) = path(Operator::find(name).unwrap());
            let at = |falling: bool| {
                let k = (1..u.len()).find(|&k| (u[k] < u[k - 1]) == falling && u[k].abs() < 1e-9);
                k.map(|k| y[k]).unwrap()
            };
            (at(true) - at(false)) / range(&y)
        };
        assert!(open("prandtl-ishlinskii") > 0.03 && open("proportional").abs() < 1e-9);
    }
}
