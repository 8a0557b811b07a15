//! Which operators are tried, and which is taken.

use super::refine::Fitted;
use crate::error::Error;
use crate::hysteresis::{OPERATORS, Operator};
use crate::number::short;
use crate::record::Record;
use crate::series::ends;
use crate::waveform::reversals;
use serde::Serialize;

/// Share of the inputs' range by which a turn must stay off its ends to begin a minor loop, and how many such turns show
/// what minor loops do.
const INSIDE: f64 = 0.1;
const ENOUGH: usize = 8;

/// What became of one operator.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OperatorTrial {
    /// The operator.
    pub operator: &'static str,
    /// Weights and shape parameters.
    pub parameters: usize,
    /// Rms error over peak-to-peak of what was held out, in percent, each part foretold by a fit to all others; infinite where
    /// nothing came out.
    pub held_out_percent: f64,
    /// Whether that is as good as the best, within its uncertainty.
    pub as_good: bool,
    /// `taken`, `as good`, `refused`, or nothing.
    pub verdict: &'static str,
    /// The shape parameters by name.
    pub shape: Vec<(&'static str, f64)>,
    /// Why nothing came out, if so.
    pub refused: Option<String>,
}

/// The operators to try: those that are named, or of all what the records allow. Where the records hold no minor loops, nothing in them tells operators apart that differ there; then
/// of all only those are tried that do what measured ceramics do: follow minor loops, and wipe them out. And where rich
/// records stand `alone`, rate belongs to the linear block they tell, for nothing tells the two apart.
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
        "the records hold no minor loops, so what the model makes of smaller amplitudes is a guess; tried were only operators \
         that wipe out minor loops, as measured ceramics do: add a sine whose amplitude rises"
            .into(),
    );
    Ok(all().filter(|o| o.minor_loops && o.wipes_out).collect())
}

/// Of those that are as good as the best the one with the fewest parameters, and all of them as they are told.
pub(super) fn choose(trials: Vec<(OperatorTrial, Option<Fitted>)>) -> Result<(Fitted, Vec<OperatorTrial>), Error> {
    let (mut told, mut fitted): (Vec<OperatorTrial>, Vec<Option<Fitted>>) = trials.into_iter().unzip();
    let found = fitted.iter().flatten().map(|fitted| &fitted.held_out);
    let best = found.min_by(|p, q| p.rms_pp().total_cmp(&q.rms_pp())).cloned();
    for (trial, fitted) in told.iter_mut().zip(&fitted) {
        trial.as_good = fitted.as_ref().zip(best.as_ref()).is_some_and(|(one, best)| one.held_out.is_as_good_as(best));
        if trial.as_good {
            trial.verdict = "as good";
        }
    }
    let good = (0..told.len()).filter(|&k| told[k].as_good);
    let chosen = good.min_by_key(|&k| told[k].parameters).and_then(|k| Some((k, fitted[k].take()?)));
    let Some((k, fitted)) = chosen else {
        let each = told.iter().map(|trial| {
            let why = trial.refused.as_deref();
            let why = why.unwrap_or("its equations have no solution: are units and columns the right ones?");
            format!("{}: {why}", trial.operator)
        });
        let because = each.collect::<Vec<_>>().join("; ");
        return Err(Error::Unidentifiable { what: "a hysteresis block of any kind".into(), because });
    };
    told[k].verdict = "taken";
    Ok((fitted, told))
}

/// Why the operator that was taken was; none where no other was tried.
pub(super) fn why(trials: &[OperatorTrial]) -> Option<String> {
    let by_error = |p: &&OperatorTrial, q: &&OperatorTrial| p.held_out_percent.total_cmp(&q.held_out_percent);
    let (best, taken) = (trials.iter().min_by(by_error)?, trials.iter().find(|t| t.verdict == "taken")?);
    let next = trials.iter().filter(|t| !t.as_good && t.refused.is_none()).min_by(by_error);
    let (name, left) = (taken.operator, short(taken.held_out_percent));
    let simplest = match (best.operator == name, trials.iter().filter(|t| t.as_good).count()) {
        (true, 1) => format!("{name} leaves least of what was held out, {left} % of peak-to-peak"),
        (true, _) => {
            format!("{name} leaves least of what was held out, {left} % of peak-to-peak, and is the simplest as good")
        }
        (false, _) => format!(
            "{name} leaves {left} % of what was held out, as good as the {} % of {} within their uncertainty, and is simpler",
            short(best.held_out_percent),
            best.operator
        ),
    };
    let then = next.map(|next| format!("; next comes {} with {} %", next.operator, short(next.held_out_percent)));
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
