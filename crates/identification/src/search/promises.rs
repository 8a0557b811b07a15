//! What the linearised equations of few signals promise for changes of a fit: most starts need no equations with all
//! weights.

use super::fit::{
    Estimate, Fitted, FreeParameters, Iterate, Reduced, StepCallback, TrainingRecord, creep_pole, refine_promising,
};
use piezoid_numerics::error::Error;

/// The promises for a fit.
pub(super) struct Promises {
    pub(super) reduced: Reduced,
    /// True if they do not show what creep would take over from a lag that is as slow.
    is_blind: bool,
    /// The sum of squares that they promise for the fit itself, and one that is next to nothing.
    least: f64,
    negligible: f64,
}

impl Promises {
    /// `slowest` is the frequency of the slowest lag that is not creep [Hz].
    pub(super) fn of(fit: &Fitted, runs: &[TrainingRecord], slowest: f64) -> Result<Self, Error> {
        let reduced = Reduced::of(&fit.estimate, &fit.own, &fit.products, runs)?;
        let point = Iterate::at(reduced.estimate.clone(), &reduced.runs(runs), &[], FreeParameters::All);
        let (least, negligible) = (point.predicted(reduced.smoothness(fit.held_out.lambda)), point.negligible());
        let is_blind = reduced.holds_creep && creep_pole(&fit.estimate.linear, slowest).is_some();
        Ok(Promises { reduced, is_blind, least, negligible })
    }

    /// Fits all parameters from each start that promises less than `ratio` times the minimum of `fit`, first with few
    /// signals, then with all weights.
    pub(super) fn refine(
        &self,
        fit: &Fitted,
        starts: Vec<(String, Estimate)>,
        ratio: f64,
        runs: &[TrainingRecord],
        watch: StepCallback,
    ) -> Result<Vec<(String, Fitted)>, Error> {
        let most = (ratio * self.least).max(self.negligible);
        let mut promising = Vec::new();
        for (name, start) in starts {
            if self.is_blind || self.sum(fit, &start, runs)? < most {
                promising.push((name, start));
            }
        }
        refine_promising(promising, fit, ratio, &|_| true, runs, watch)
    }

    /// The sum of squares that a start promises.
    fn sum(&self, fit: &Fitted, start: &Estimate, runs: &[TrainingRecord]) -> Result<f64, Error> {
        let promised = |reduced: &Reduced, estimate: Estimate| {
            let lambda = reduced.smoothness(fit.held_out.lambda);
            Iterate::at(estimate, &reduced.runs(runs), &[], FreeParameters::All).predicted(lambda)
        };
        if start.driver == fit.estimate.driver {
            return Ok(promised(&self.reduced, self.reduced.estimate.with_linear(start.linear.clone())));
        }
        let other = Reduced::of(start, &fit.own, &fit.products, runs)?;
        Ok(promised(&other, other.estimate.clone()))
    }
}
