//! How close a fit is to its minimum: the decrease that the linearised equations still promise, and the parameters at a
//! limit.

use super::fitted::Fitted;
use super::iterate::Iterate;
use super::runs::TrainingRecord;
use piezoid_numerics::number::short;

/// Decrease of the sum of squares from which a fit is not at its minimum, and one that is next to nothing [%].
const UNFINISHED_PERCENT: f64 = 0.1;
const NEGLIGIBLE_PERCENT: f64 = 0.01;

/// How a search ended.
pub(crate) struct Optimality {
    /// Decrease of the sum of squares that another step promises, if the fit is not at its minimum [%].
    pub(crate) left_percent: Option<f64>,
    /// The end of the search in words.
    pub(crate) note: String,
}

/// The optimality of a fit; the runs start as in the fit.
pub(crate) fn optimality(fitted: &Fitted, runs: &[TrainingRecord]) -> Optimality {
    let (estimate, lambda) = (&fitted.estimate, fitted.held_out.lambda);
    let point = Iterate::at_end_of(fitted, runs);
    let signed: Vec<f64> = point.prior.signed().collect();
    let zeros = signed.iter().filter(|value| **value == 0.0).count();
    let shape = estimate.basis.shape().into_iter();
    let limits: Vec<String> = shape
        .filter(|p| p.value <= p.low || p.value >= p.high)
        .map(|p| format!("{} = {}", p.name, short(p.value)))
        .collect();
    let (cost, predicted) = (point.cost(lambda), point.predicted(lambda));
    let left = match cost {
        0.0 => 0.0,
        // Without a step, nothing says that this is a minimum.
        _ if !(predicted / cost).is_finite() => 100.0,
        cost => 100.0 * (1.0 - predicted / cost),
    };
    let left_percent = Some(left).filter(|left| *left >= UNFINISHED_PERCENT);
    let promised = match left {
        least if least < NEGLIGIBLE_PERCENT => format!("by less than {NEGLIGIBLE_PERCENT} %"),
        more => format!("by {} %", short(more)),
    };
    let ends = match left_percent {
        None => format!("the fit is at its minimum (another step would lower the sum of squared errors {promised})"),
        Some(_) => format!(
            "the fit ended before its minimum (another step would still lower the sum of squared errors {promised})"
        ),
    };
    let mut note = format!("search: {ends}; {zeros} of {} weights and creep gains are zero", signed.len());
    if !limits.is_empty() {
        note += &format!("; at a bound of their range: {}", limits.join(", "));
    }
    Optimality { left_percent, note }
}

#[cfg(test)]
mod tests {
    use super::super::held_out::Smoothness;
    use super::super::refine::refine_from;
    use super::super::solve::FreeParameters;
    use super::super::{runs::training_records, testing::estimate};
    use super::*;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::system::System;
    use piezoid_records::record::Record;

    #[test]
    fn a_fit_is_at_its_minimum_and_one_that_was_moved_is_not() {
        let block = Arx::new(5e-4, vec![0.9], vec![0.1]).unwrap();
        let u: Vec<f64> = (0..900).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let rough = |(t, y): (usize, f64)| y + 0.1 * ((t * t) as f64 * 0.618_034).fract();
        let y = block.simulate(&u).into_iter().enumerate().map(rough).collect();
        let records = [Record::new(5e-4, u, y).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let start = estimate("prandtl-ishlinskii", 6).with_linear(block);
        let mut fit = refine_from(start, Smoothness::Any, &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
        let Optimality { left_percent, note } = optimality(&fit, &runs);
        assert!(
            left_percent.is_none()
                && note.starts_with("search: the fit is at its minimum (another step would lower")
                && note.contains(" by less than 0.01 %)"),
            "{note}"
        );
        assert!(note.contains(" of 7 weights and creep gains are zero"), "{note}");
        fit.estimate = fit.estimate.with_linear(Arx::new(5e-4, vec![0.8], vec![0.2]).unwrap());
        fit.segments = None;
        let Optimality { left_percent, note } = optimality(&fit, &runs);
        assert!(
            left_percent.is_some_and(|left| left > UNFINISHED_PERCENT)
                && note.starts_with("search: the fit ended before its minimum"),
            "{note}"
        );
    }
}
