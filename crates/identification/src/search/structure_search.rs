//! The structure search: from the simplest linear block on, the extension that lowers the error most is added, until
//! none lowers it clearly.
//!
//! The extended fit starts at the fit before it, with the same response, so its own error is never larger. The error
//! that counts is that of the free run on segments of the records that were left out. Where no extension of the linear
//! block helps, a lag before the hysteresis is tried: it does not commute with the hysteresis.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "The linear block grows from a gain".

use super::candidate::SelectedStructure;
use super::extensions::{PoleLimits, extensions, product};
use super::fit::{
    Estimate, Fitted, FreeParameters, Hidden, Reduced, Smoothness, StepCallback, TrainingRecord, creep_pole, is_lag,
    refine_from, refine_promising, slowest_observable, slowest_pole, without_factor,
};
use super::initial_conditions::select_initial_conditions;
use super::mode_evidence::ModeEvidence;
use super::policy::Breadth;
use super::structure::{MakeBasis, Structure, rescaled, select, with_other_blocks};
use super::{Candidate, JointOptions, POLICY, Search};
use piezoid_models::creep::Lag;
use piezoid_models::driver::DriverModel;
use piezoid_models::hysteresis::BasisDesign;
use piezoid_models::linear::{Arx, Orders, OutputError, Refinement};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::power;
use piezoid_numerics::progress::Stage;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use rayon::prelude::*;
use std::f64::consts::TAU;
use tracing::trace_span;

/// Name of the move that searches the structure with the selected operator.
pub(super) const NAME: &str = "structure search with the operator";

/// What the structure search knows of the records and the settings.
pub(super) struct StructureSearch {
    limits: PoleLimits,
    pub(super) evidence: ModeEvidence,
    /// True if the driver is known.
    has_driver: bool,
    /// The specified order.
    order: Option<usize>,
    /// The lowest and the highest input.
    range: (f64, f64),
    breadth: &'static Breadth,
}

impl StructureSearch {
    /// The search in these records, small-signal ones included.
    pub(super) fn new(records: &[Record], settings: &JointOptions, lags: &[Lag], range: (f64, f64)) -> Self {
        let (has_driver, order, breadth) = (settings.driver.is_some(), settings.order, settings.effort.breadth());
        let longest = records.iter().map(Record::duration).fold(0.0, f64::max);
        let limits = PoleLimits {
            slowest: slowest_pole(lags).max(slowest_observable(records.iter())),
            slowest_mode: POLICY.min_mode_cycles / longest,
            max_order: order.unwrap_or(breadth.max_order),
        };
        StructureSearch {
            limits,
            evidence: ModeEvidence::of(records, order.is_some()),
            has_driver,
            order,
            range,
            breadth,
        }
    }

    /// Extends the last structure of `tried`, and its extensions, until that gains nothing.
    pub(super) fn extend(
        &self,
        tried: &mut Vec<Structure>,
        basis: MakeBasis,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<(), Error> {
        let mut is_lag_tried = self.has_driver;
        for _ in 0..self.breadth.extensions {
            let Some(from) = tried.last() else { break };
            is_lag_tried |= from.fitted.estimate.driver.is_some();
            let Some(best) = tried.iter().min_by(Structure::by_error) else { break };
            let mut longer = self.extended(from, runs, watch)?;
            let imitates_lag = |t: &Structure| t.order() > from.order() + 1 && t.modes() == from.modes();
            let gains = longer.iter().find(|t| t.gains_on(best));
            if !is_lag_tried && gains.is_none_or(imitates_lag) {
                is_lag_tried = gains.is_none();
                longer.extend(self.with_driver_lag(best, basis, runs, watch)?);
            }
            longer.sort_by(|p, q| Structure::by_error(&p, &q));
            let mut longer = longer.into_iter();
            let Some(mut next) = longer.next() else { break };
            if select_initial_conditions(&next.fitted, runs, self.range)? {
                let smoothness = Smoothness::Fixed(next.fitted.held_out.lambda);
                let same = next.fitted.estimate.clone();
                next.fitted = refine_from(same, smoothness, runs, FreeParameters::All, watch)?;
            }
            let gains = next.gains_on(best);
            let next_order = next.order();
            tried.extend(longer.filter(|t| self.is_of_order(t)));
            tried.push(next);
            // Up to the specified order, steps without gain may be needed.
            if !gains && self.order.is_none_or(|order| next_order >= order) {
                break;
            }
        }
        tried.extend(self.of_specified_order(tried, runs, watch)?);
        Ok(())
    }

    /// The extensions of a fit that are possible: found with few signals, and fitted with all weights until one gains;
    /// up to the specified order, all.
    fn extended(
        &self,
        from: &Structure,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<Vec<Structure>, Error> {
        let Fitted { estimate, held_out, .. } = &from.fitted;
        let promises = from.promises(runs, self.limits.slowest)?;
        let reduced = &promises.reduced;
        let possible = |linear: &Arx| self.is_not_creep(linear);
        let mut found: Vec<Structure> = Vec::new();
        for equals in self.extended_with_few(reduced, held_out.lambda, runs, watch)? {
            let starts = equals.into_iter().map(|(name, few)| (name, reduced.whole(&few.estimate, estimate)));
            let fits = refine_promising(starts.collect(), &from.fitted, f64::INFINITY, &possible, runs, watch)?;
            let fits = fits.into_iter().map(|(name, fit)| Structure::new(name, fit));
            found.extend(fits.filter(|t| self.evidence.allows(&t.fitted.estimate.linear, t.error(), from.error())));
            if self.order.is_none() && found.iter().any(|t| t.gains_on(from)) {
                break;
            }
        }
        Ok(found)
    }

    /// The extensions that lower the sum of squares with few signals, those with nearly the smallest first: of those
    /// that the records show, or, if there are none, of the others.
    fn extended_with_few(
        &self,
        reduced: &Reduced,
        lambda: f64,
        runs: &[TrainingRecord],
        watch: StepCallback,
    ) -> Result<[Vec<(String, Fitted)>; 2], Error> {
        let runs = &mut reduced.runs(runs)[..];
        let smoothness = Smoothness::Fixed(reduced.smoothness(lambda));
        let from = &refine_from(reduced.estimate.clone(), smoothness, runs, FreeParameters::All, watch)?;
        for group in extensions(from, runs, &self.limits, &self.evidence, self.breadth.refined_extensions, watch)? {
            let starts = group.into_iter().map(|one| (one.name, from.estimate.with_linear(one.linear)));
            let (ratio, possible) = (POLICY.promised_minimum_ratio, |linear: &Arx| self.is_not_creep(linear));
            let mut fits = refine_promising(starts.collect(), from, ratio, &possible, runs, watch)?;
            let is_lower = |fit: &Fitted| fit.minimum < ratio * from.minimum;
            let is_possible =
                |fit: &Fitted| self.evidence.allows(&fit.estimate.linear, fit.minimum.sqrt(), from.minimum.sqrt());
            fits.retain(|(_, fit)| self.order.is_some() || is_lower(fit) && is_possible(fit));
            if fits.is_empty() {
                continue;
            }
            let minima = fits.iter().map(|(_, fit)| fit.minimum);
            let most = self.breadth.equal_minimum_ratio * minima.fold(f64::INFINITY, f64::min);
            let (equal, others) = fits.into_iter().partition(|(_, fit)| fit.minimum <= most);
            return Ok([equal, others]);
        }
        Ok([Vec::new(), Vec::new()])
    }

    /// True if no pole of a linear block counts as creep.
    fn is_not_creep(&self, linear: &Arx) -> bool {
        creep_pole(linear, self.limits.slowest).is_none()
    }

    /// The best of a fit with a lag before the hysteresis: a new one, or one that was behind it, as a lag or as a
    /// delay; `None` if none gains.
    fn with_driver_lag(
        &self,
        best: &Structure,
        basis: MakeBasis,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<Option<Structure>, Error> {
        let fit = &best.fitted;
        let linear = &fit.estimate.linear;
        let (ts, delay) = (linear.ts(), linear.delay());
        let moved = linear.poles().into_iter().filter(is_lag).map(|pole| {
            let a = without_factor(&linear.denominator(), pole.z.re);
            let b = linear.b().iter().map(|b| b / (1.0 - pole.z.re)).collect();
            (1.0 / (TAU * pole.hz), Arx::new(ts, a[1..].iter().map(|a| -a).collect(), b))
        });
        let undelayed = || Arx::new(ts, linear.a().to_vec(), linear.b()[delay..].to_vec());
        let instead = (delay > 0).then(|| (delay as f64 * ts, undelayed()));
        let start = |(lag_s, linear): (f64, Result<Arx, Error>)| {
            let driver = (Some(DriverModel::new(lag_s, None)?), true);
            let name = "a lag before the hysteresis".to_string();
            Ok((name, with_other_blocks(&fit.estimate, driver, &fit.estimate.lags, linear?, basis)?))
        };
        let starts = moved.chain([(POLICY.new_driver_lag * ts, Ok(linear.clone()))]).chain(instead).map(start);
        let starts = starts.collect::<Result<_, Error>>()?;
        let promises = best.promises(runs, self.limits.slowest)?;
        let found = promises.refine(fit, starts, POLICY.promised_minimum_ratio, runs, watch)?;
        let found = found.into_iter().filter(|(_, fit)| self.evidence.shows(&fit.estimate.linear));
        Ok(found.map(|(name, fit)| Structure::new(name, fit)).min_by(|p, q| Structure::by_error(&p, &q)))
    }

    /// A linear block of lower order that promises as low a minimum, if there is one: poles that nearly cancel zeros
    /// may keep the search from its end.
    fn of_lower_order(
        &self,
        own: &Structure,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<Option<Structure>, Error> {
        let (fitted, promises) = (&own.fitted, own.promises(runs, self.limits.slowest)?);
        let linear = &fitted.estimate.linear;
        let hidden: Vec<Record> = Hidden::crept(fitted, runs)?.into_iter().map(|z| z.record).collect();
        // Side by side, because mostly none of them promises enough.
        let fit = |n: usize| {
            let orders = Orders { delay: linear.delay(), ..Orders::of(n) };
            OutputError::fit(&hidden, orders, &Refinement::default(), &mut Stage::ignore).ok()
        };
        let fits: Vec<_> = (1..linear.a().len()).into_par_iter().map(fit).collect();
        for fit in fits.into_iter().flatten() {
            let start = fitted.estimate.with_linear(rescaled(&fit.arx, linear.dc_gain())?);
            let (starts, ratio) = (vec![(String::new(), start)], POLICY.promised_lower_order_ratio);
            if let Some((name, fit)) = promises.refine(fitted, starts, ratio, runs, watch)?.pop() {
                return Ok(Some(Structure::new(name, fit)));
            }
        }
        Ok(None)
    }

    /// The last structure with further poles, if an order is specified that no structure has.
    fn of_specified_order(
        &self,
        tried: &[Structure],
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<Option<Structure>, Error> {
        let (Some(order), Some(Structure { fitted: last, .. })) = (self.order, tried.last()) else { return Ok(None) };
        if tried.iter().any(|t| self.is_of_order(t)) {
            return Ok(None);
        }
        let start = last.estimate.with_linear(of_order(order, &last.estimate.linear)?);
        let smoothness = Smoothness::Fixed(last.held_out.lambda);
        let fit = refine_from(start, smoothness, runs, FreeParameters::All, watch)?;
        Ok(Some(Structure::new("further poles".into(), fit)))
    }

    /// True if the linear block has the specified order.
    fn is_of_order(&self, structure: &Structure) -> bool {
        self.order == Some(structure.order())
    }
}

/// The move: the simplest structure with the operator that is as good as the best: of those simpler than its own, its
/// own, and extensions.
pub(super) fn search_with_operator(candidate: &Candidate, search: &mut Search) -> Result<Option<Candidate>, Error> {
    let _stage = trace_span!(target: "stage", "structure").entered();
    let Search { runs, design, structures, reporter, .. } = search;
    let operator = candidate.operator;
    let watch = &mut reporter.last_stage(operator.name);
    let basis = |ts: f64| (operator.basis)(&BasisDesign { ts, ..design.clone() });
    let fitted = &candidate.fitted;
    let (mut tried, own) = (Vec::new(), Structure::new(String::new(), fitted.clone()));
    let promises = own.promises(runs, structures.limits.slowest)?;
    for Estimate { driver, seeks_lag, lags, linear, .. } in &candidate.structure.simpler {
        let start = with_other_blocks(&fitted.estimate, (*driver, *seeks_lag), lags, linear.clone(), &basis)?;
        let (starts, ratio) = (vec![(String::new(), start)], POLICY.promised_simpler_ratio);
        let found = promises.refine(fitted, starts, ratio, runs, watch)?;
        tried.extend(found.into_iter().map(|(name, fit)| Structure::new(name, fit)));
    }
    if structures.order.is_none() {
        tried.extend(structures.of_lower_order(&own, runs, watch)?);
    }
    tried.push(own);
    structures.extend(&mut tried, &basis, runs, watch)?;
    let selected = select(tried, structures.order);
    let reason = if selected.of_several { selected.reason } else { candidate.structure.reason.clone() };
    let structure = SelectedStructure { reason, simpler: selected.simpler };
    Ok(Some(Candidate { structure, operator, fitted: selected.fitted }))
}

/// The same response with a linear block of a higher order: further poles cancel further zeros.
fn of_order(order: usize, linear: &Arx) -> Result<Arx, Error> {
    let (mut a, mut b) = (linear.denominator(), linear.b().to_vec());
    for k in 1..=order.saturating_sub(linear.a().len()) {
        let factor = [1.0, -power(POLICY.cancelled_pole, k as i32)];
        (a, b) = (product(&a, &factor), product(&b, &factor));
    }
    Arx::new(linear.ts(), a[1..].iter().map(|a| -a).collect(), b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_creep_no_lag_is_longer_than_the_longest_record() {
        let of = |n: usize| Record::new(0.01, vec![0.0; n], vec![0.0; n]).unwrap();
        let records = [of(300), of(500)];
        let longest = records[1].duration();
        let search = StructureSearch::new(&records, &JointOptions::default(), &[], (-1.0, 1.0));
        assert_eq!(search.limits.slowest, 1.0 / (TAU * longest));
        let creep =
            StructureSearch::new(&records, &JointOptions::default(), &[Lag { tau_s: 0.1, gain: 0.0 }], (-1.0, 1.0));
        assert_eq!(creep.limits.slowest, 1.0 / (TAU * 0.1));
    }
}
