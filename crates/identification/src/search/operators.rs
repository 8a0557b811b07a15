//! Comparison of the operators, in two steps: with the linear block held, then, those that may be the best, with all
//! parameters.

use super::fit::{
    Estimate, Fitted, FreeParameters, Smoothness, StepCallback, TrainingRecord, free_run_residual, refine, refine_from,
    refine_further, refine_within_reach, with_selected_terms,
};
use super::initial_conditions::{fit_with_other_initial_conditions, select_initial_conditions};
use super::shape_search::best_shape;
use super::structure::with_other_blocks;
use super::trials::{OperatorTrial, Trial, cost_of, counted_cost, counted_error, select};
use super::{Candidate, JointOptions, POLICY, Reporter, Search, creep_lags, structure_search};
use crate::Effort;
use crate::side_by_side::side_by_side;
use piezoid_models::hammerstein::InitialCondition;
use piezoid_models::hysteresis::{BasisDesign, Operator};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::progress::Stage;
use piezoid_numerics::series::mean;
use std::cmp::Ordering;
use std::slice::from_ref;
use tracing::trace_span;

/// The move: the candidate with the operator that is the simplest of those as good as the best.
pub(super) fn compare(candidate: &Candidate, search: &mut Search) -> Result<Option<Candidate>, Error> {
    let blocks = &candidate.fitted.estimate;
    let _stage = trace_span!(target: "stage", "operators").entered();
    let design = search.design_for(blocks);
    let Search { settings, operators, runs, reporter, trials, .. } = search;
    let held = with_block_held(operators, &design, blocks, settings, runs, reporter)?;
    if let [(_, Err(why))] = &held[..] {
        return Err(why.clone());
    }
    *trials = with_all_parameters(held, design.range, settings, runs, reporter)?;
    let (selected, fitted) = select(trials)?;
    Ok(Some(Candidate { operator: operators[selected], ..candidate.with_fit(fitted) }))
}

/// True if the structure search has lowered the held-out error of the selected operator so much, from the first value
/// to the second, that the closest operators are compared again.
pub(super) fn is_worth_repeating((before, after): (f64, f64)) -> bool {
    after <= POLICY.repeated_comparison_ratio * before
}

/// The move: the operators that were close to the selected one are fitted again with the other parts of the candidate.
pub(super) fn compare_closest(candidate: &Candidate, search: &mut Search) -> Result<Option<Candidate>, Error> {
    let _stage = trace_span!(target: "stage", "operators again").entered();
    let Some((before, after)) = search.errors_of(structure_search::NAME) else { return Ok(None) };
    let design = search.design_for(&candidate.fitted.estimate);
    let Search { settings, operators, runs, reporter, trials, notes, .. } = search;
    let operator = candidate.operator;
    let reach = reachable(settings, operator, &candidate.fitted, runs);
    let Some(previous) = trials.iter().position(|trial| trial.result.is_selected()) else { return Ok(None) };
    let last = reporter.total - 1;
    let closest = {
        let watch = &mut reporter.last_stage(operator.name);
        refit_closest(trials, previous, &candidate.fitted, &design, reach, runs, watch)?
    };
    if closest.is_empty() {
        return Ok(None);
    }
    for k in closest {
        reporter.tried_apart(&trials[k], last, runs)?;
    }
    let result = trial_of(operator, &candidate.fitted, runs, design.range);
    trials[previous] = Trial::of(result, candidate.fitted.clone());
    let (selected, fitted) = select(trials)?;
    notes.push(format!(
        "operators: a better linear block lowered the held-out error of {} from {} to {} % rms/pp, so the \
         operators with similar errors were compared again with this block",
        operator.name,
        short(100.0 * before),
        short(100.0 * after)
    ));
    Ok(Some(Candidate { operator: operators[selected], ..candidate.with_fit(fitted) }))
}

/// The move: of the operators that were best in parts of the records, the one that is best in all samples, with the
/// slow lags of creep that only whole records show.
pub(super) fn compare_on_all_samples(candidate: &Candidate, search: &mut Search) -> Result<Option<Candidate>, Error> {
    let _stage = trace_span!(target: "stage", "all samples").entered();
    let design = search.design_for(&candidate.fitted.estimate);
    let Search { settings, operators, whole, runs, reporter, trials, .. } = search;
    let Some(previous) = operators.iter().position(|row| row.name == candidate.operator.name) else { return Ok(None) };
    let most = POLICY.finalist_ratio * trials[previous].result.error();
    let finalists: Vec<usize> = (0..operators.len()).filter(|&k| trials[k].result.error() <= most).collect();
    let lags = if settings.creep { creep_lags(whole) } else { Vec::new() };
    let blocks = &candidate.fitted.estimate;
    let fit = |k: usize, watch: StepCallback| -> Result<Trial, Error> {
        let in_parts = trials[k].fitted.as_ref().filter(|_| k != previous).unwrap_or(&candidate.fitted);
        let basis = |ts: f64| (operators[k].basis)(&BasisDesign { ts, ..design.clone() });
        let mut start = match k == previous {
            true => blocks.clone(),
            false => {
                let driver = (blocks.driver, blocks.seeks_lag);
                with_other_blocks(&in_parts.estimate, driver, &blocks.lags, blocks.linear.clone(), &basis)?
            }
        };
        start.lags.extend(lags.iter().skip(blocks.lags.len()));
        let mut all = starting_as_parts(whole, runs, in_parts, design.range);
        let smoothness = Smoothness::Near(in_parts.held_out.lambda);
        let mut fit = refine_from(start, smoothness, &mut all, FreeParameters::All, watch)?;
        if select_initial_conditions(&fit, &mut all, design.range)? {
            let smoothness = Smoothness::Near(fit.held_out.lambda);
            fit = refine_from(fit.estimate, smoothness, &mut all, FreeParameters::All, watch)?;
        }
        Ok(Trial::of(trial_of(operators[k], &fit, &mut all, design.range), fit))
    };
    let last = reporter.total - 1;
    let fits = {
        let mut watch = reporter.last_stage(candidate.operator.name);
        side_by_side(finalists.clone(), fit, |k, _| watch(k))?
    };
    // The errors of the others are those in parts: they are not candidates any more.
    trials.iter_mut().for_each(|trial| trial.fitted = None);
    for (k, trial) in finalists.into_iter().zip(fits) {
        match trial {
            Err(why) if k == previous => return Err(why),
            Err(_) => {}
            Ok(trial) => trials[k] = trial,
        }
        reporter.tried_apart(&trials[k], last, whole)?;
    }
    let (selected, fitted) = select(trials)?;
    search.runs = whole.to_vec();
    Ok(Some(Candidate { operator: operators[selected], ..candidate.with_fit(fitted) }))
}

/// The whole records with the initial conditions and weights that their first parts have in a fit.
fn starting_as_parts<'a>(
    whole: &[TrainingRecord<'a>],
    parts: &[TrainingRecord],
    fitted: &Fitted,
    range: (f64, f64),
) -> Vec<TrainingRecord<'a>> {
    let of_parts = parts.iter().zip(fitted.initial_conditions.iter().zip(&fitted.heavier));
    let of_first_parts = of_parts.filter(|(part, _)| !part.is_later_part).map(|(_, of_part)| of_part);
    let starting = |(run, (initial, heavier)): (&TrainingRecord<'a>, (&InitialCondition, &f64))| TrainingRecord {
        heavier: *heavier,
        ..run.clone().starting_from(*initial, range)
    };
    whole.iter().zip(of_first_parts).map(starting).collect()
}

/// The fits of an operator with the linear block held, the best first.
type Shapes = Result<Vec<Fitted>, Error>;

/// Operators, each with its fits.
type Held = Vec<(&'static Operator, Shapes)>;

/// The fits of each operator with the other parts of the model, `blocks`, held: with its own shape, and with others
/// unless it is hopeless.
///
/// # Errors
/// Those of the reporter, which gets the number of fits done, and after each fit its errors.
fn with_block_held(
    operators: &[&'static Operator],
    design: &BasisDesign,
    blocks: &Estimate,
    settings: &JointOptions,
    runs: &[TrainingRecord],
    reporter: &mut Reporter,
) -> Result<Held, Error> {
    let own = |row: &'static Operator, watch: StepCallback| with_own_shape(row, design, blocks, runs, watch);
    let mut report = |phase: usize, k: usize, fits: Option<&Shapes>| {
        let (row, done) = (operators[k], 1 + phase * operators.len() + k);
        match fits.and_then(|fits| fits.as_ref().ok()?.first()) {
            None => reporter.report(Stage::new(row.name, done, 0)),
            Some(fit) => reporter.tried((row, fit), &[("held_out_percent", 100.0 * fit.held_out.rms_pp())], done, runs),
        }
    };
    let paired = |fits: Vec<Shapes>| -> Held { operators.iter().copied().zip(fits).collect() };
    let held = paired(side_by_side(operators.to_vec(), own, |k, fits| report(0, k, fits))?);
    let most = POLICY.searched_shape_ratio * least(&held);
    let with_others = |(row, fits): (&'static Operator, Shapes), watch: StepCallback| match fits {
        Ok(own) if settings.effort != Effort::Quick && counted_error(row, &own[0]) <= most => {
            shapes(own, design, blocks, settings, &mut runs.to_vec(), watch)
        }
        fits => fits,
    };
    side_by_side(held, with_others, |k, fits| report(1, k, fits)).map(paired)
}

/// The trial of each operator: of those with the best fits, the fit in all parameters.
///
/// # Errors
/// Those of the reporter.
fn with_all_parameters(
    held: Held,
    range: (f64, f64),
    settings: &JointOptions,
    runs: &[TrainingRecord],
    reporter: &mut Reporter,
) -> Result<Vec<Trial>, Error> {
    let of_all = held.len();
    let most = POLICY.refined_operator_ratio * least(&held);
    let minima = held.iter().filter_map(|(row, fits)| Some(counted_cost(row, fits.as_ref().ok()?[0].minimum)));
    let least_minimum = minima.fold(f64::INFINITY, f64::min).max(f64::MIN_POSITIVE);
    let mut reach = settings.effort.breadth().reachable_operator_ratio.powi(2) * least_minimum;
    // The best ones show what the others have to reach.
    let mut first: Vec<(usize, _)> = held.into_iter().enumerate().collect();
    first.sort_by(|(_, p), (_, q)| least(from_ref(p)).total_cmp(&least(from_ref(q))));
    let others = first.split_off(if reach.is_finite() { POLICY.first_refined.min(of_all) } else { of_all });
    let mut trials: Vec<(usize, Trial)> = Vec::new();
    for round in [first, others] {
        let rows: Vec<(usize, &'static Operator)> = round.iter().map(|(k, (row, _))| (*k, *row)).collect();
        let finish = |(_, (row, fits)): (usize, (&'static Operator, Shapes)), watch: StepCallback| match fits {
            Err(why) => Ok(Trial { result: OperatorTrial::refused(row, why.to_string()), fitted: None }),
            Ok(shapes) => {
                let (result, fitted) = refined(row, shapes, (most, reach), &mut runs.to_vec(), range, watch)?;
                Ok(Trial::of(result, fitted))
            }
        };
        let report = |k: usize, trial: Option<&Result<Trial, Error>>| {
            let (row, done) = (rows[k].1, 1 + 2 * of_all + trials.len() + k);
            match trial.and_then(|trial| trial.as_ref().ok()) {
                None => reporter.report(Stage::new(row.name, done, 0)),
                Some(Trial { result, fitted: Some(fit) }) => reporter.tried((row, fit), &result.figures(), done, runs),
                Some(Trial { result, fitted: None }) => {
                    reporter.report(Stage { figures: &result.figures(), ..Stage::new(row.name, done, 0) })
                }
            }
        };
        let fits: Vec<Trial> = side_by_side(round, finish, report)?.into_iter().collect::<Result<_, Error>>()?;
        let reached = rows.iter().zip(&fits).filter_map(|((_, row), trial)| Some((row, trial.fitted.as_ref()?)));
        reach = reached.map(|(row, fit)| reachable(settings, row, fit, runs)).fold(reach, f64::min);
        trials.extend(rows.iter().map(|(k, _)| *k).zip(fits));
    }
    trials.sort_by_key(|(k, _)| *k);
    Ok(trials.into_iter().map(|(_, trial)| trial).collect())
}

/// The cost, as it counts among operators, that another operator must come within reach of, beside this fit.
fn reachable(settings: &JointOptions, row: &Operator, fitted: &Fitted, runs: &[TrainingRecord]) -> f64 {
    let ratio = settings.effort.breadth().reachable_operator_ratio;
    ratio.powi(2) * counted_cost(row, fitted.held_out_minimum(runs))
}

/// The least error, as it counts among operators, of the best fits.
fn least(held: &[(&'static Operator, Shapes)]) -> f64 {
    let best = held.iter().filter_map(|(row, fits)| Some(counted_error(row, fits.as_ref().ok()?.first()?)));
    best.fold(f64::INFINITY, f64::min)
}

/// Fits the operators that were close to the `selected` one again, with the other parts of its present fit: what they
/// lacked may have hidden how the operators differ. Returns the numbers of these.
fn refit_closest(
    trials: &mut [Trial],
    selected: usize,
    fitted: &Fitted,
    design: &BasisDesign,
    reach: f64,
    runs: &[TrainingRecord],
    watch: StepCallback,
) -> Result<Vec<usize>, Error> {
    let most = POLICY.close_operator_ratio * trials[selected].result.error();
    let Estimate { driver, seeks_lag, lags, linear, .. } = &fitted.estimate;
    let closest = (0..trials.len()).filter(|k| *k != selected && trials[*k].result.error() <= most);
    let closest: Vec<_> = closest.filter_map(|k| Some((k, trials[k].fitted.as_ref()?))).collect();
    let fit = |(k, other): (usize, &Fitted), watch: StepCallback| -> Result<_, Error> {
        let row = Operator::find(trials[k].result.operator)?;
        let basis = |ts: f64| (row.basis)(&BasisDesign { ts, ..design.clone() });
        let start = with_other_blocks(&other.estimate, (*driver, *seeks_lag), lags, linear.clone(), &basis)?;
        let smoothness = Smoothness::Near(other.held_out.lambda);
        let mut runs = runs.to_vec();
        other.apply_to(&mut runs, design.range);
        let fit = refine_within_reach(start, smoothness, cost_of(row, reach), &mut runs, watch)?;
        Ok((k, Trial::of(trial_of(row, &fit, &mut runs, design.range), fit)))
    };
    let fits: Vec<_> = side_by_side(closest, fit, |_, _| watch(0))?.into_iter().flatten().collect();
    let fitted = fits.iter().map(|(k, _)| *k).collect();
    for (k, trial) in fits {
        // A fit of the comparison stays if this one ended because it cannot win.
        if trial.result.error() < trials[k].result.error() {
            trials[k] = trial;
        }
    }
    Ok(fitted)
}

/// The fits of an operator with its own shape, the best first: of one that selects terms there are two.
pub(super) fn with_own_shape(
    row: &Operator,
    design: &BasisDesign,
    blocks: &Estimate,
    runs: &[TrainingRecord],
    watch: StepCallback,
) -> Shapes {
    watch(0)?;
    let starts = with_selected_terms(blocks.with_basis((row.basis)(design)?), runs, watch)?;
    let fit = |start: Estimate| refine(start, &mut runs.to_vec(), FreeParameters::Creep, &mut *watch);
    let mut fits = starts.into_iter().map(fit).collect::<Result<Vec<_>, _>>()?;
    fits.sort_by(by_error);
    Ok(fits)
}

/// The order of fits by their held-out errors.
fn by_error(p: &Fitted, q: &Fitted) -> Ordering {
    p.held_out.rms_pp().total_cmp(&q.held_out.rms_pp())
}

/// Fits with the linear block held, the best first: those with the operator's own shape, one with the best shape that
/// is found, and the better of these with other initial conditions, if that is clearly better. Not all initial
/// conditions suit every operator.
pub(super) fn shapes(
    mut fits: Vec<Fitted>,
    design: &BasisDesign,
    blocks: &Estimate,
    settings: &JointOptions,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Vec<Fitted>, Error> {
    let own = &fits[0].estimate;
    let start = blocks.with_basis(own.basis.reshaped(&own.shape())?);
    let stage = trace_span!(target: "stage", "shapes");
    if let Some(reshaped) = stage.in_scope(|| best_shape(&start, runs, settings, watch))? {
        fits.push(refine(reshaped, runs, FreeParameters::Creep, watch)?);
    }
    fits.sort_by(by_error);
    if let Some(other) = fit_with_other_initial_conditions(&fits[0], runs, design.range, watch)? {
        fits.insert(0, other);
    }
    Ok(fits)
}

/// The better refinement, in all parameters, of the best two of these sorted fits; none if their errors exceed `most`.
/// A refinement ends where a cost of `reach` is out of reach. Both limits are as they count among operators.
pub(super) fn refined(
    row: &Operator,
    mut shapes: Vec<Fitted>,
    (most, reach): (f64, f64),
    runs: &mut [TrainingRecord],
    range: (f64, f64),
    watch: StepCallback,
) -> Result<(OperatorTrial, Fitted), Error> {
    let (near, reach) = (POLICY.second_shape_ratio * shapes[0].held_out.rms_pp(), cost_of(row, reach));
    if counted_error(row, &shapes[0]) > most {
        let fit = shapes.swap_remove(0);
        return Ok((trial_of(row, &fit, runs, range), fit));
    }
    shapes.retain(|fit| fit.held_out.rms_pp() <= near);
    shapes.truncate(POLICY.refined_shapes);
    let mut refine = |fit: Fitted, reach: f64, runs: &mut [TrainingRecord]| {
        fit.apply_to(runs, range);
        let fit = refine_further(&fit, reach, runs, watch)?;
        Ok((trial_of(row, &fit, runs, range), fit))
    };
    let other = shapes.split_off(1).pop();
    let best = refine(shapes.remove(0), reach, runs)?;
    // In a thorough search, no fit ends early.
    let lower = if reach.is_finite() { reach.min(best.1.held_out_minimum(runs)) } else { reach };
    Ok(match other.map(|other| refine(other, lower, runs)).transpose()? {
        Some(other) if other.0.error() < best.0.error() => other,
        _ => best,
    })
}

/// The trial of a fit, with its free-run error. The runs start as in the fit.
pub(super) fn trial_of(
    row: &Operator,
    fitted: &Fitted,
    runs: &mut [TrainingRecord],
    range: (f64, f64),
) -> OperatorTrial {
    fitted.apply_to(runs, range);
    OperatorTrial::of(row, fitted, free_run(fitted, runs))
}

/// Free-run rms error of the large-signal records over their peak-to-peak, each with its own offset.
fn free_run(fitted: &Fitted, runs: &[TrainingRecord]) -> f64 {
    let Ok(model) = fitted.estimate.model(0.0) else { return f64::INFINITY };
    let large_signal = runs.iter().filter(|run| run.large_signal && !run.is_later_part);
    let errors: Vec<f64> = large_signal.map(|run| (run.scale * free_run_residual(run, &model).1).powi(2)).collect();
    mean(&errors).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::fit::{estimate, training_records};
    use super::*;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::system::System;
    use piezoid_records::record::Record;

    #[test]
    fn an_operator_may_have_other_initial_conditions_than_the_records_started_with() {
        let u: Vec<f64> = (0..3000).map(|t| 3e-2 * f64::from(t).min(900.0) * (0.02 * f64::from(t)).cos()).collect();
        let row = Operator::find("prandtl-ishlinskii").unwrap();
        let pi = (row.example)(5e-4).unwrap();
        let records = [Record::new(5e-4, u.clone(), pi.simulate(&u)).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let design = BasisDesign { ts: 5e-4, range: (-27.0, 27.0), elements: Some(20), frequencies: Vec::new() };
        let blocks = estimate("prandtl-ishlinskii", 20).with_linear(Arx::gain(5e-4, 1.0).unwrap());
        for initial in [InitialCondition::FromBelow, runs[0].initial] {
            runs[0].start_from(initial, design.range);
            let start = blocks.with_basis((row.basis)(&design).unwrap());
            let own = refine(start, &mut runs, FreeParameters::Creep, &mut |_| Ok(())).unwrap();
            let fits =
                shapes(vec![own], &design, &blocks, &JointOptions::default(), &mut runs, &mut |_| Ok(())).unwrap();
            assert_ne!(fits[0].initial_conditions, [InitialCondition::FromBelow], "{initial:?}");
            assert_eq!(runs[0].initial, initial);
        }
    }

    #[test]
    fn close_operators_are_compared_again_with_the_linear_block_that_lowered_the_error() {
        let gain = Arx::gain(5e-4, 1.3).unwrap();
        let mode = Arx::new(5e-4, vec![1.9, -0.95], vec![0.065]).unwrap();
        let u: Vec<f64> = (0..4000).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.07 * f64::from(t)).sin()).collect();
        let pi = (Operator::find("prandtl-ishlinskii").unwrap().example)(5e-4).unwrap();
        let records = [Record::new(5e-4, u.clone(), mode.simulate(&pi.simulate(&u))).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let mut fit = |name: &str, linear: &Arx| {
            let start = estimate(name, 20).with_linear(linear.clone());
            refine(start, &mut runs, FreeParameters::Weights, &mut |_| Ok(())).unwrap()
        };
        let mut trials: Vec<_> = ["stop", "proportional", "prandtl-ishlinskii"]
            .map(|name| (Operator::find(name).unwrap(), fit(name, &gain)))
            .map(|(row, fit)| Trial::of(OperatorTrial::of(row, &fit, 0.0), fit))
            .into();
        let with_mode = fit("prandtl-ishlinskii", &mode);
        let [stop, none] = [0, 1].map(|k| trials[k].result.held_out_percent);
        assert!(none > 1.5 * stop, "{none} {stop}");

        let design = BasisDesign { ts: 5e-4, range: (-30.0, 30.0), elements: Some(20), frequencies: Vec::new() };
        let before = trials[2].result.held_out_percent / 100.0;
        let after = with_mode.held_out.rms_pp();
        assert!(is_worth_repeating((before, after)) && !is_worth_repeating((before, before)));
        assert!(
            refit_closest(&mut trials, 2, &with_mode, &design, f64::INFINITY, &runs, &mut |_| Ok(())).unwrap() == [0]
        );
        assert!(trials[0].result.held_out_percent < 0.1 * stop, "{} {stop}", trials[0].result.held_out_percent);
        assert_eq!(trials[0].fitted.as_ref().unwrap().estimate.linear.a().len(), 2);
        assert_eq!(trials[1].result.held_out_percent, none);
    }

    #[test]
    fn of_operators_with_like_held_out_errors_the_free_run_decides() {
        let u: Vec<f64> = (0..4000).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.07 * f64::from(t)).sin()).collect();
        let pi = (Operator::find("prandtl-ishlinskii").unwrap().example)(5e-4).unwrap();
        let rough = |(t, y): (usize, f64)| y + 0.1 * ((t * t) as f64 * 0.618_034).fract();
        let y = pi.simulate(&u).into_iter().enumerate().map(rough).collect();
        let records = [Record::new(5e-4, u, y).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let gain = Arx::gain(5e-4, 1.0).unwrap();
        let mut trial = |name: &str, free_run: f64| {
            let start = estimate(name, 20).with_linear(gain.clone());
            let fit = refine(start, &mut runs, FreeParameters::Weights, &mut |_| Ok(())).unwrap();
            Trial::of(OperatorTrial::of(Operator::find(name).unwrap(), &fit, free_run), fit)
        };
        // Both are the same law; the proportional one is far from it, whatever its free run.
        for (pi, stop, best) in [(0.01, 0.1, 1), (0.1, 0.01, 2)] {
            let mut trials = [trial("proportional", 0.0), trial("prandtl-ishlinskii", pi), trial("stop", stop)];
            assert_eq!(select(&mut trials).unwrap().0, best);
            assert_eq!(trials.map(|trial| trial.result.as_good), [false, best == 1, best == 2]);
        }
    }
}
