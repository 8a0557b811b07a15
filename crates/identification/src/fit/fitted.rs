//! A fitted estimate, with the coefficients of single records and the held-out errors.

use super::estimate::Estimate;
use super::held_out::HeldOut;
use super::products::Segment;
use super::runs::TrainingRecord;
use nalgebra::DMatrix;
use piezoid_models::hammerstein::InitialCondition;
use piezoid_numerics::series::mean;
use std::sync::Arc;

/// A fitted estimate.
#[derive(Debug, Clone)]
pub(crate) struct Fitted {
    pub(crate) estimate: Estimate,
    /// The initial condition of each run, and the weight of its kind.
    pub(crate) initial_conditions: Vec<InitialCondition>,
    pub(crate) heavier: Vec<f64>,
    /// Initial states and constant of each run.
    pub(crate) own: Vec<Vec<f64>>,
    pub(crate) held_out: HeldOut,
    /// For each run, the mean squared error over the squared peak-to-peak.
    pub(crate) residuals: Vec<f64>,
    /// The products of the columns of the weights with each other.
    pub(crate) products: DMatrix<f64>,
    /// Those of all columns, if they are kept: at this estimate, for runs with these initial conditions and weights.
    pub(super) segments: Option<Arc<[Segment]>>,
    /// The minimised sum of squares and penalties.
    pub(crate) minimum: f64,
}

impl Fitted {
    /// Mean over the runs of the mean squared error over the squared peak-to-peak.
    pub(crate) fn cost(&self) -> f64 {
        mean(&self.residuals)
    }

    /// The sum of squares and penalties of a fit whose errors are as large as the held-out ones of this fit.
    pub(crate) fn held_out_minimum(&self, runs: &[TrainingRecord]) -> f64 {
        let large_signal = self.residuals.iter().zip(runs).filter(|(_, run)| run.large_signal);
        let fitted = mean(&large_signal.map(|(residual, _)| *residual).collect::<Vec<_>>());
        // Not 0: a ratio of costs may be infinite.
        self.minimum.max(f64::MIN_POSITIVE) * (self.held_out.rms_pp().powi(2) / fitted).max(1.0)
    }

    /// The same without the products of all columns, which take much memory.
    pub(crate) fn without_segments(self) -> Self {
        Fitted { segments: None, ..self }
    }

    /// True if the runs have the initial conditions and the weights of this fit.
    pub(super) fn is_of(&self, runs: &[TrainingRecord]) -> bool {
        let of_fit = self.initial_conditions.iter().zip(&self.heavier);
        runs.iter().map(|run| (&run.initial, &run.heavier)).eq(of_fit)
    }

    /// Sets the initial conditions and the weights of the runs to those of this fit: later fits may have tried others.
    pub(crate) fn apply_to(&self, runs: &mut [TrainingRecord], range: (f64, f64)) {
        runs.iter_mut().zip(&self.heavier).for_each(|(run, heavier)| run.heavier = *heavier);
        let others = runs.iter_mut().zip(&self.initial_conditions).filter(|(run, initial)| run.initial != **initial);
        others.for_each(|(run, initial)| run.start_from(*initial, range));
    }
}

#[cfg(test)]
mod tests {
    use super::super::refine::refine;
    use super::super::solve::FreeParameters;
    use super::super::{runs::training_records, testing::estimate};
    use super::*;
    use piezoid_records::record::Record;

    #[test]
    fn the_initial_conditions_of_a_fit_are_applied_to_the_runs() {
        let u: Vec<f64> = (0..900).map(|t| 28.0 * (0.01 * f64::from(t)).cos()).collect();
        let records = [Record::new(5e-4, u.clone(), u).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let start = estimate("prandtl-ishlinskii", 6);
        let fit = refine(start, &mut runs, FreeParameters::Weights, &mut |_| Ok(())).unwrap();
        let (initial, before) = (runs[0].initial, runs[0].before.clone());
        runs[0].start_from(InitialCondition::FromAbove, (-28.0, 28.0));
        assert_ne!(runs[0].before, before);
        fit.apply_to(&mut runs, (-28.0, 28.0));
        assert_eq!((runs[0].initial, &runs[0].before), (initial, &before));
    }
}
