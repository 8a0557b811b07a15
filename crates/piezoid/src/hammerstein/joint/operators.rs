//! Comparison of the operators, in two steps: with the linear block held, then, those that may be the best, with all
//! parameters.

use super::beginnings::with_other_past;
use super::estimate::Estimate;
use super::free_run_residual;
use super::growth::adopt;
use super::held_out::Smoothness;
use super::refine::{Fitted, StepCallback, refine, refine_from};
use super::runs::TrainingRecord;
use super::search::search;
use super::solve::FreeParameters;
use super::trials::OperatorTrial;
use crate::error::Error;
use crate::hysteresis::{BasisDesign, Operator};
use crate::progress::Stage;
use crate::series::mean;

/// Ratio of held-out errors with the linear block held from which an operator is not refined further.
const HOPELESS: f64 = 3.0;

/// The same ratio from which no other shape or past of an operator is sought.
const FAR: f64 = 30.0;

/// Ratio of held-out errors of two shapes of an operator from which only the better is refined further.
const WORSE: f64 = 1.5;

/// Ratio of the errors of the operator taken, now and in the comparison, below which it is repeated; and ratio of the
/// errors of two operators in the comparison up to which both take part.
const FALLEN: f64 = 0.7;
const CLOSE: f64 = 1.1;

/// The trials of the operators, each with its fit. `blocks` are the other parts of the model.
///
/// # Errors
/// The error of the only operator; those of `report`, which is called with the number of fits done, and after each fit
/// with its errors.
pub(super) fn compare(
    candidates: &[&'static Operator],
    design: &BasisDesign,
    blocks: &Estimate,
    seed: u64,
    runs: &mut [TrainingRecord],
    report: &mut dyn FnMut(Stage) -> Result<(), Error>,
) -> Result<Vec<(OperatorTrial, Option<Fitted>)>, Error> {
    let (total, mut starts, mut least) = (2 * candidates.len() + 1, Vec::new(), f64::INFINITY);
    for (k, row) in candidates.iter().enumerate() {
        let now = Stage::new(row.name, 1 + k, total);
        let found = shapes(row, design, blocks, seed, FAR * least, runs, &mut |_| report(now));
        starts.push(match found {
            Err(why) if matches!(why, Error::Cancelled { .. }) || candidates.len() == 1 => return Err(why),
            found => found.map_err(|why| OperatorTrial::refused(row, why.to_string())),
        });
        if let Some(Ok([best, ..])) = starts.last().map(|fits| fits.as_deref()) {
            least = least.min(best.held_out.rms_pp());
            report(Stage { figures: &[("held_out_percent", 100.0 * best.held_out.rms_pp())], ..now })?;
        }
    }
    let mut trials = Vec::new();
    for (k, (row, start)) in candidates.iter().zip(starts).enumerate() {
        let now = Stage::new(row.name, 1 + candidates.len() + k, total);
        trials.push(match start {
            Err(refused) => (refused, None),
            Ok(shapes) => {
                let most = HOPELESS * least;
                let (trial, fitted) = refined(row, shapes, most, runs, design.range, &mut |_| report(now))?;
                report(Stage { figures: &trial.figures(), ..now })?;
                (trial, Some(fitted))
            }
        });
    }
    Ok(trials)
}

/// Fits the operators that were close to the `taken` one again, with the other parts of its present fit, if these have
/// lowered its held-out error much from `before`: what they lacked may have hidden how the operators differ. Returns
/// true if there was another to fit.
pub(super) fn compare_again(
    trials: &mut [(OperatorTrial, Option<Fitted>)],
    taken: usize,
    before: f64,
    fitted: &Fitted,
    design: &BasisDesign,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<bool, Error> {
    if fitted.held_out.rms_pp() > FALLEN * before {
        return Ok(false);
    }
    let most = CLOSE * trials[taken].0.error();
    let Estimate { driver, seeks_lag, lags, linear, .. } = &fitted.estimate;
    let close = trials.iter_mut().filter(|(trial, _)| trial.error() <= most);
    let mut again = false;
    for (trial, other) in close.filter_map(|(trial, other)| Some((trial, other.as_mut()?))) {
        let row = Operator::find(trial.operator)?;
        let basis = |ts: f64| (row.basis)(&BasisDesign { ts, ..design.clone() });
        let start = adopt(&other.estimate, (*driver, *seeks_lag), lags, linear.clone(), &basis);
        let smoothness = Smoothness::Near(other.held_out.lambda);
        other.begin_again(runs, design.range);
        match start.and_then(|start| refine_from(start, smoothness, runs, FreeParameters::All, watch)) {
            Err(why @ Error::Cancelled { .. }) => return Err(why),
            // It keeps the fit of the comparison.
            Err(_) => {}
            Ok(fit) => (*trial, *other, again) = (trial_of(row, &fit, runs, design.range), fit, true),
        }
    }
    Ok(again)
}

/// Fits with the linear block held, the best first: with the operator's own shape, and, if its error is at most `most`,
/// with the best shape of a swarm, and the better of these with the other past, if that is clearly better. Not every
/// past suits every operator.
fn shapes(
    row: &Operator,
    design: &BasisDesign,
    blocks: &Estimate,
    seed: u64,
    most: f64,
    runs: &mut [TrainingRecord],
    watch: StepCallback,
) -> Result<Vec<Fitted>, Error> {
    let own = || Ok::<_, Error>(blocks.with_basis((row.basis)(design)?));
    watch(0)?;
    let mut fits = vec![refine(own()?, runs, FreeParameters::Creep, watch)?];
    if fits[0].held_out.rms_pp() > most {
        return Ok(fits);
    }
    if let Some(found) = search(&own()?, runs, seed)? {
        fits.push(refine(found, runs, FreeParameters::Creep, watch)?);
    }
    fits.sort_by(|p, q| p.held_out.rms_pp().total_cmp(&q.held_out.rms_pp()));
    if let Some(other) = with_other_past(&fits[0], runs, design.range, watch)? {
        fits.insert(0, other);
    }
    Ok(fits)
}

/// The better refinement, in all parameters, of the best two of these sorted fits; none if their errors exceed `most`.
fn refined(
    row: &Operator,
    mut shapes: Vec<Fitted>,
    most: f64,
    runs: &mut [TrainingRecord],
    range: (f64, f64),
    watch: StepCallback,
) -> Result<(OperatorTrial, Fitted), Error> {
    let near = WORSE * shapes[0].held_out.rms_pp();
    if shapes[0].held_out.rms_pp() > most {
        let fit = shapes.swap_remove(0);
        return Ok((trial_of(row, &fit, runs, range), fit));
    }
    shapes.retain(|fit| fit.held_out.rms_pp() <= near);
    shapes.truncate(2);
    let mut refine = |fit: Fitted| {
        fit.begin_again(runs, range);
        let smoothness = Smoothness::Near(fit.held_out.lambda);
        let fit = refine_from(fit.estimate, smoothness, runs, FreeParameters::All, watch)?;
        Ok((trial_of(row, &fit, runs, range), fit))
    };
    let other = shapes.split_off(1).pop();
    let best = refine(shapes.remove(0))?;
    Ok(match other.map(refine).transpose()? {
        Some(other) if other.0.error() < best.0.error() => other,
        _ => best,
    })
}

/// The trial of a fit, with its free-run error. The runs begin as in the fit.
pub(super) fn trial_of(
    row: &Operator,
    fitted: &Fitted,
    runs: &mut [TrainingRecord],
    range: (f64, f64),
) -> OperatorTrial {
    fitted.begin_again(runs, range);
    OperatorTrial::of(row, fitted, free_run(fitted, runs))
}

/// Free-run rms error of the large-signal records over their peak-to-peak, each with its own offset.
fn free_run(fitted: &Fitted, runs: &[TrainingRecord]) -> f64 {
    let Ok(model) = fitted.estimate.model(0.0) else { return f64::INFINITY };
    let large_signal = runs.iter().filter(|run| run.large_signal);
    let errors: Vec<f64> = large_signal.map(|run| (run.scale * free_run_residual(run, &model).1).powi(2)).collect();
    mean(&errors).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::{runs, testing::estimate};
    use super::*;
    use crate::hammerstein::InitialCondition;
    use crate::linear::Arx;
    use crate::record::Record;
    use crate::system::System;

    #[test]
    fn an_operator_may_have_another_past_than_the_records_began_with() {
        let u: Vec<f64> = (0..3000).map(|t| 3e-2 * f64::from(t).min(900.0) * (0.02 * f64::from(t)).cos()).collect();
        let row = Operator::find("prandtl-ishlinskii").unwrap();
        let pi = (row.example)(5e-4).unwrap();
        let records = [Record::new(5e-4, u.clone(), pi.simulate(&u)).unwrap()];
        let mut runs = runs::of(&[], &records, &mut Vec::new()).unwrap();
        let design = BasisDesign { ts: 5e-4, range: (-27.0, 27.0), elements: Some(20), frequencies: Vec::new() };
        let blocks = estimate("prandtl-ishlinskii", 20).with_linear(Arx::gain(5e-4, 1.0).unwrap()).unwrap();
        for began in [InitialCondition::FromBelow, runs[0].initial] {
            runs[0].begin_from(began, design.range);
            let fits = shapes(row, &design, &blocks, 1, f64::INFINITY, &mut runs, &mut |_| Ok(())).unwrap();
            assert_ne!(fits[0].begun, [InitialCondition::FromBelow], "{began:?}");
            assert_eq!(runs[0].initial, began);
        }
    }

    #[test]
    fn close_operators_are_compared_again_with_the_linear_block_that_lowered_the_error() {
        let gain = Arx::gain(5e-4, 1.3).unwrap();
        let mode = Arx::new(5e-4, vec![1.9, -0.95], vec![0.065]).unwrap();
        let u: Vec<f64> = (0..4000).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.07 * f64::from(t)).sin()).collect();
        let pi = (Operator::find("prandtl-ishlinskii").unwrap().example)(5e-4).unwrap();
        let records = [Record::new(5e-4, u.clone(), mode.simulate(&pi.simulate(&u))).unwrap()];
        let mut runs = runs::of(&[], &records, &mut Vec::new()).unwrap();
        let mut fit = |name: &str, linear: &Arx| {
            let start = estimate(name, 20).with_linear(linear.clone()).unwrap();
            refine(start, &mut runs, FreeParameters::Weights, &mut |_| Ok(())).unwrap()
        };
        let mut trials: Vec<_> = ["stop", "proportional", "prandtl-ishlinskii"]
            .map(|name| (Operator::find(name).unwrap(), fit(name, &gain)))
            .map(|(row, fit)| (OperatorTrial::of(row, &fit, 0.0), Some(fit)))
            .into();
        let taken = fit("prandtl-ishlinskii", &mode);
        let [stop, none] = [0, 1].map(|k| trials[k].0.held_out_percent);
        assert!(none > 1.5 * stop, "{none} {stop}");

        let design = BasisDesign { ts: 5e-4, range: (-30.0, 30.0), elements: Some(20), frequencies: Vec::new() };
        let without_mode = trials[2].1.take().unwrap();
        let before = without_mode.held_out.rms_pp();
        let mut again = |trials: &mut [_], fitted| {
            compare_again(trials, 2, before, fitted, &design, &mut runs, &mut |_| Ok(())).unwrap()
        };
        assert!(!again(&mut trials, &without_mode));
        assert!(again(&mut trials, &taken));
        assert!(trials[0].0.held_out_percent < 0.1 * stop, "{} {stop}", trials[0].0.held_out_percent);
        assert_eq!(trials[0].1.as_ref().unwrap().estimate.linear.a().len(), 2);
        assert_eq!(trials[1].0.held_out_percent, none);
    }

    #[test]
    fn of_operators_with_like_held_out_errors_the_free_run_decides() {
        let u: Vec<f64> = (0..4000).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.07 * f64::from(t)).sin()).collect();
        let pi = (Operator::find("prandtl-ishlinskii").unwrap().example)(5e-4).unwrap();
        let rough = |(t, y): (usize, f64)| y + 0.1 * ((t * t) as f64 * 0.618_034).fract();
        let y = pi.simulate(&u).into_iter().enumerate().map(rough).collect();
        let records = [Record::new(5e-4, u, y).unwrap()];
        let mut runs = runs::of(&[], &records, &mut Vec::new()).unwrap();
        let gain = Arx::gain(5e-4, 1.0).unwrap();
        let mut trial = |name: &str, free_run: f64| {
            let start = estimate(name, 20).with_linear(gain.clone()).unwrap();
            let fit = refine(start, &mut runs, FreeParameters::Weights, &mut |_| Ok(())).unwrap();
            (OperatorTrial::of(Operator::find(name).unwrap(), &fit, free_run), Some(fit))
        };
        // Both are the same law; the proportional one is far from it, whatever its free run.
        for (pi, stop, best) in [(0.01, 0.1, 1), (0.1, 0.01, 2)] {
            let mut trials = [trial("proportional", 0.0), trial("prandtl-ishlinskii", pi), trial("stop", stop)];
            assert_eq!(super::super::trials::choose(&mut trials).unwrap().0, best);
            assert_eq!(trials.map(|(trial, _)| trial.as_good), [false, best == 1, best == 2]);
        }
    }
}
