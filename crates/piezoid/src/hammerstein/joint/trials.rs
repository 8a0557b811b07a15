//! The operators tried, and the choice among them.

use super::refine::Fitted;
use crate::error::Error;
use crate::hysteresis::{OPERATORS, Operator};
use crate::number::short;
use crate::record::Record;
use crate::series::ends;
use crate::waveform::reversals;
use serde::Serialize;

/// Distance from the ends of the range, as its share, from which a reversal starts a minor loop; and the number of such
/// reversals that show minor loops.
const INSIDE: f64 = 0.1;
const ENOUGH: usize = 8;

/// The result of one operator.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OperatorTrial {
    /// The operator.
    pub operator: &'static str,
    /// Number of weights and shape parameters.
    pub parameters: usize,
    /// Held-out rms error over peak-to-peak [%], each fold predicted by a fit to all others; infinite if the fit
    /// failed.
    pub held_out_percent: f64,
    /// True if it is as good as the best, within its uncertainty.
    pub as_good: bool,
    /// `taken`, `as good`, `refused`, or empty.
    pub verdict: &'static str,
    /// The shape parameters by name.
    pub shape: Vec<(&'static str, f64)>,
    /// Why the fit failed, if it did.
    pub refused: Option<String>,
}

/// The operators to try: those named, or with `auto` those that suit the records. Without minor loops in the records,
/// operators that differ only there cannot be distinguished. Then only those are tried that follow and wipe out minor
/// loops, as measured ceramics do, and whose minor loops the major loops determine. If large-signal records stand
/// `alone`, rate-dependent operators are left out: their dynamics cannot be separated from the linear block.
pub(super) fn candidates(
    name: &str,
    large_signal: &[Record],
    alone: bool,
    notes: &mut Vec<String>,
) -> Result<Vec<&'static Operator>, Error> {
    if name != "auto" {
        return Operator::list(name);
    }
    let all = || OPERATORS.iter().copied().filter(|o| o.rate_independent || !alone);
    let (low, high) = ends(large_signal.iter().flat_map(|record| record.u()).copied());
    let margin = INSIDE * (high - low);
    let inner = |record: &Record| {
        let inside = |&&t: &&usize| (low + margin..high - margin).contains(&record.u()[t]);
        reversals(record.u(), 0.5 * INSIDE).iter().filter(inside).count()
    };
    if large_signal.iter().map(inner).sum::<usize>() >= ENOUGH {
        return Ok(all().collect());
    }
    notes.push(
        "the records have no minor loops, so smaller amplitudes are extrapolated; only operators with the wiping-out \
         property were tried, as for measured ceramics, whose minor loops follow from the major loops: add a rising sine"
            .into(),
    );
    Ok(all().filter(|o| o.minor_loops && o.wipes_out && !o.needs_minor_loops).collect())
}

/// Selects the operator with the fewest parameters of those as good as the best; returns its number, and takes its fit
/// out of the trials.
pub(super) fn choose(trials: &mut [(OperatorTrial, Option<Fitted>)]) -> Result<(usize, Fitted), Error> {
    let found = trials.iter().filter_map(|(_, fitted)| fitted.as_ref()).map(|fitted| &fitted.held_out);
    let best = found.min_by(|p, q| p.rms_pp().total_cmp(&q.rms_pp())).cloned();
    for (trial, fitted) in trials.iter_mut() {
        trial.as_good = fitted.as_ref().zip(best.as_ref()).is_some_and(|(one, best)| one.held_out.is_as_good_as(best));
        trial.verdict = match (trial.as_good, trial.refused.is_some()) {
            (true, _) => "as good",
            (_, true) => "refused",
            _ => "",
        };
    }
    let good = (0..trials.len()).filter(|&k| trials[k].0.as_good);
    let chosen = good.min_by_key(|&k| trials[k].0.parameters).and_then(|k| Some((k, trials[k].1.take()?)));
    let Some((k, fitted)) = chosen else {
        let each = trials.iter().map(|(trial, _)| {
            let why = trial.refused.as_deref();
            let why = why.unwrap_or("its equations have no solution: check units and columns");
            format!("{}: {why}", trial.operator)
        });
        let because = each.collect::<Vec<_>>().join("; ");
        return Err(Error::Unidentifiable { what: "a hysteresis block of any kind".into(), because });
    };
    trials[k].0.verdict = "taken";
    Ok((k, fitted))
}

/// The reason for the selected operator; `None` if only one was tried.
pub(super) fn why(trials: &[OperatorTrial]) -> Option<String> {
    let by_error = |p: &&OperatorTrial, q: &&OperatorTrial| p.held_out_percent.total_cmp(&q.held_out_percent);
    let (best, taken) = (trials.iter().min_by(by_error)?, trials.iter().find(|t| t.verdict == "taken")?);
    let next = trials.iter().filter(|t| !t.as_good && t.refused.is_none()).min_by(by_error);
    let (name, error) = (taken.operator, short(taken.held_out_percent));
    let simplest = match (best.operator == name, trials.iter().filter(|t| t.as_good).count()) {
        (true, 1) => format!("{name} has the smallest held-out error, {error} % rms/pp"),
        (true, _) => {
            format!(
                "{name} has the smallest held-out error, {error} % rms/pp, and is the simplest of those that are \
                     as good"
            )
        }
        (false, _) => {
            let (least, best) = (short(best.held_out_percent), best.operator);
            format!(
                "{name} has a held-out error of {error} %, equal to the {least} % of {best} within uncertainty, and is \
                 simpler"
            )
        }
    };
    let then = next.map(|next| format!("; the next is {} with {} %", next.operator, short(next.held_out_percent)));
    (trials.len() > 1).then(|| simplest + &then.unwrap_or_default())
}

impl OperatorTrial {
    pub(super) fn of(row: &Operator, fitted: &Fitted) -> Self {
        let shape = fitted.estimate.basis.shape();
        OperatorTrial {
            operator: row.name,
            parameters: fitted.estimate.weights.len() + shape.len(),
            held_out_percent: 100.0 * fitted.held_out.rms_pp(),
            as_good: false,
            verdict: "",
            shape: shape.iter().map(|shape| (shape.name, shape.value)).collect(),
            refused: None,
        }
    }

    pub(super) fn refused(row: &Operator, why: String) -> Self {
        OperatorTrial {
            operator: row.name,
            parameters: 0,
            held_out_percent: f64::INFINITY,
            as_good: false,
            verdict: "refused",
            shape: Vec::new(),
            refused: Some(why),
        }
    }
}
