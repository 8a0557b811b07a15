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

/// Width and height of the picture, and what stays free at its edges.
const SIZE: (f64, f64) = (192.0, 128.0);
const MARGIN: f64 = 4.0;

/// The path data of an SVG of 192 by 128: the loop of the typical operator, major, then minor. Whole steps from point
/// to point are short: a browser loads the pictures of all operators.
pub(crate) fn of(operator: &Operator) -> String {
    let (u, y) = path(operator);
    let slope = LESS * range(&y) / range(&u);
    let bare: Vec<f64> = u.iter().zip(&y).map(|(u, y)| y - slope * u).collect();
    let scaled = |samples: &[f64], size: f64| -> Vec<i64> {
        let (low, high) = ends(samples.iter().copied());
        let scaled = |value: &f64| MARGIN + (size - 2.0 * MARGIN) * (value - low) / (high - low);
        samples.iter().map(|value| scaled(value).round() as i64).collect()
    };
    let (x, y) = (scaled(&u, SIZE.0), scaled(&bare, SIZE.1));
    let points: Vec<_> = x.into_iter().zip(y.into_iter().map(|y| SIZE.1 as i64 - y)).collect();
    let mut data = points.first().map_or_else(String::new, |(x, y)| format!("M{x} {y}l"));
    for step in points.windows(2) {
        let _ = write!(data, "{} {} ", step[1].0 - step[0].0, step[1].1 - step[0].1);
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
            let (start, steps) = picture.split_once('l').unwrap();
            let numbers: Vec<i64> = steps.split_whitespace().map(|step| step.parse().unwrap()).collect();
            assert!(start.starts_with('M') && numbers.len() > 200 && picture.len() < 1000, "{picture}");
            assert!(!pictures[..k].contains(picture), "{}", OPERATORS[k].name);
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
