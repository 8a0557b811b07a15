//! The operators to try, their results, and the selection of one.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "The larger of two errors decides between operators".
//! Why: docs/decisions/structure-and-operator-selection.md, "Without minor loops, auto tries fewer operators".

use super::super::records::Records;
use super::POLICY;
use super::fit::Fitted;
use libm::hypot;
use piezoid_models::hysteresis::{Operator, is_auto};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::series::ends;
use piezoid_records::record::Record;
use piezoid_records::waveform::reversals;
use serde::Serialize;

/// Error that is rounding [%].
const ROUNDING_PERCENT: f64 = 1e-5;

/// The verdict on the operator that is selected.
pub(crate) const SELECTED: &str = "taken";

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
    /// Free-run rms error of the training records over peak-to-peak [%], each with its own offset; infinite if the fit
    /// failed.
    pub free_run_percent: f64,
    /// The larger of the two errors, by which operators are ranked [%]: the state before a part that is held out is
    /// known; before a record it is not.
    pub error_percent: f64,
    /// True if it is as good as the best, within its uncertainty.
    pub as_good: bool,
    /// `taken`, `as good`, `refused`, or empty.
    pub verdict: &'static str,
    /// The shape parameters by name.
    pub shape: Vec<(&'static str, f64)>,
    /// Why the fit failed, if it did.
    pub refused: Option<String>,
}

/// The operators to try: those listed, and with `auto` only those that suit the records. Without minor loops in the
/// records, operators that differ only there cannot be distinguished. Then only those are tried that follow and wipe
/// out minor loops, as measured ceramics do, and whose minor loops the major loops determine. If there are only
/// large-signal records, rate-dependent operators are left out: their dynamics cannot be separated from the linear
/// block.
pub(crate) fn suitable_operators(
    name: &str,
    records: &Records,
    notes: &mut Vec<String>,
) -> Result<Vec<&'static Operator>, Error> {
    let listed = Operator::list(name)?;
    if !is_auto(name) {
        return Ok(listed);
    }
    let all = || listed.iter().copied().filter(|o| o.rate_independent || !records.is_large_signal_alone());
    let (low, high) = ends(records.large_signal.iter().flat_map(|record| record.u()).copied());
    let margin = POLICY.minor_loop_margin * (high - low);
    let inner = |record: &Record| {
        let inside = |&&t: &&usize| (low + margin..high - margin).contains(&record.u()[t]);
        reversals(record.u(), 0.5 * POLICY.minor_loop_margin).iter().filter(inside).count()
    };
    let any = |suited: Vec<&'static Operator>| match suited.is_empty() {
        true => Err(Error::parameter("operator", name, "leaves out every operator that suits the records: name one")),
        false => Ok(suited),
    };
    let inside = records.large_signal.iter().map(inner).sum::<usize>();
    if inside >= POLICY.min_minor_loops {
        return any(all().collect());
    }
    let times = match inside {
        0 => "never turn back inside the range of the input".into(),
        1 => "turn back only once inside the range of the input".into(),
        _ => format!("turn back only {inside} times inside the range of the input"),
    };
    notes.push(format!(
        "the records {times}, so they do not show which operator has the right minor loops. Only operators whose minor \
         loops follow from the major loops were tried, as in measured ceramics. To compare all \
         operators, add a rising sine"
    ));
    any(all().filter(|o| o.minor_loops && o.wipes_out && !o.needs_minor_loops).collect())
}

/// An operator that was compared, with its fit if it may be the best.
#[derive(Debug)]
pub(super) struct Trial {
    pub(super) result: OperatorTrial,
    pub(super) fitted: Option<Fitted>,
}

impl Trial {
    pub(super) fn of(result: OperatorTrial, fitted: Fitted) -> Self {
        Trial { result, fitted: Some(fitted) }
    }

    /// The selected one.
    pub(super) fn selected(result: OperatorTrial, fitted: Fitted) -> Self {
        Trial::of(OperatorTrial { as_good: true, verdict: SELECTED, ..result }, fitted)
    }
}

/// Selects the operator with the fewest parameters of those as good as the best; returns its number, and its fit. Of
/// those with nearly the smallest error, the best has the smallest held-out error.
pub(super) fn select(trials: &mut [Trial]) -> Result<(usize, Fitted), Error> {
    let fitted = || trials.iter().filter_map(|trial| Some((&trial.result, &trial.fitted.as_ref()?.held_out)));
    let held_out = |trial: &OperatorTrial| trial.factor() * hypot(trial.held_out_percent, ROUNDING_PERCENT);
    let least = fitted().map(|(trial, _)| held_out(trial)).fold(f64::INFINITY, f64::min);
    let most = POLICY.free_run_decides_ratio * least;
    let near = || fitted().filter(|(trial, _)| held_out(trial) <= most);
    let most_error =
        POLICY.as_good_operator_ratio * near().map(|(trial, _)| trial.error()).fold(f64::INFINITY, f64::min);
    let good = near().filter(|(trial, _)| trial.error() <= most_error);
    let best = good.min_by(|p, q| held_out(p.0).total_cmp(&held_out(q.0))).map(|(_, best)| best.clone());
    for Trial { result, fitted } in trials.iter_mut() {
        let is_as_good = |fitted: &Fitted| {
            best.as_ref().is_some_and(|best| fitted.held_out.is_as_good_as(best, POLICY.as_good_operator_ratio))
        };
        result.as_good = result.error() <= most_error && fitted.as_ref().is_some_and(is_as_good);
        result.verdict = match (result.as_good, result.refused.is_some()) {
            (true, _) => "as good",
            (_, true) => "refused",
            _ => "",
        };
    }
    let good = (0..trials.len()).filter(|&k| trials[k].result.as_good);
    let selected = good.min_by_key(|&k| trials[k].result.parameters);
    let Some((k, fitted)) = selected.and_then(|k| Some((k, trials[k].fitted.clone()?))) else {
        let each = trials.iter().map(|trial| {
            let why = trial.result.refused.as_deref();
            let why = why.unwrap_or("its equations have no solution: check units and columns");
            format!("{}: {why}", trial.result.operator)
        });
        let because = each.collect::<Vec<_>>().join("; ");
        return Err(Error::Unidentifiable { what: "a hysteresis block of any kind".into(), because });
    };
    trials[k].result.verdict = SELECTED;
    for trial in trials.iter_mut() {
        trial.fitted = trial.fitted.take().map(Fitted::without_segments);
    }
    Ok((k, fitted))
}

/// The factor by which the errors of an operator count more than those of others.
fn factor(row: &Operator) -> f64 {
    if row.minor_loops { 1.0 } else { POLICY.jumping_operator_factor }
}

/// The held-out error of a fit with this operator, as it counts among operators: rms over peak-to-peak.
pub(super) fn counted_error(row: &Operator, fitted: &Fitted) -> f64 {
    factor(row) * fitted.held_out.rms_pp()
}

/// The cost of a fit with this operator, as it counts among operators.
pub(super) fn counted_cost(row: &Operator, cost: f64) -> f64 {
    factor(row).powi(2) * cost
}

/// The cost of a fit with this operator that counts as much as `counted`.
pub(super) fn cost_of(row: &Operator, counted: f64) -> f64 {
    counted / factor(row).powi(2)
}

/// The reason for the selected operator; `None` if only one was tried.
pub(crate) fn reason_for_operator(trials: &[OperatorTrial]) -> Option<String> {
    let by =
        |error: fn(&OperatorTrial) -> f64| move |p: &&OperatorTrial, q: &&OperatorTrial| error(p).total_cmp(&error(q));
    let good = || trials.iter().filter(|t| t.as_good);
    let (best, selected) = (good().min_by(by(|t| t.held_out_percent))?, trials.iter().find(|t| t.is_selected())?);
    let others = trials.iter().filter(|t| !t.as_good && t.refused.is_none() && t.error() >= best.error());
    let next = others.min_by(by(OperatorTrial::error));
    let (name, error) = (selected.operator, short(selected.error_percent));
    let simplest = match (best.operator == name, good().count()) {
        (true, 1) => format!("{name} predicts best: {error} % rms/pp, held out or in free run"),
        (true, _) => format!(
            "{name} predicts best: {error} % rms/pp, held out or in free run; it is the simplest of those that are as good"
        ),
        (false, _) => format!(
            "{name} has an error of {error} % rms/pp, held out or in free run, equal to the {} % of {} within \
             uncertainty, and is simpler",
            short(best.error_percent),
            best.operator
        ),
    };
    let then = next.map(|next| format!("; the next is {} with {} %", next.operator, short(next.error_percent)));
    let jumping = trials.iter().filter(|t| !t.as_good && t.factor() > 1.0 && t.error_percent < best.error_percent);
    let jumping = jumping.min_by(by(OperatorTrial::error)).map(|t| {
        format!(
            "; {} has {} %, which counts {} times, because its minor loops jump",
            t.operator,
            short(t.error_percent),
            t.factor()
        )
    });
    (trials.len() > 1).then(|| simplest + &then.unwrap_or_default() + &jumping.unwrap_or_default())
}

impl OperatorTrial {
    /// `free_run` is the free-run rms error over peak-to-peak.
    pub(crate) fn of(row: &Operator, fitted: &Fitted, free_run: f64) -> Self {
        let shape = fitted.estimate.basis.shape();
        let (held_out_percent, free_run_percent) = (100.0 * fitted.held_out.rms_pp(), 100.0 * free_run);
        OperatorTrial {
            operator: row.name,
            parameters: fitted.estimate.weights.len() + shape.len(),
            held_out_percent,
            free_run_percent,
            error_percent: held_out_percent.max(free_run_percent),
            as_good: false,
            verdict: "",
            shape: shape.iter().map(|shape| (shape.name, shape.value)).collect(),
            refused: None,
        }
    }

    /// The errors by name, for progress.
    pub(super) fn figures(&self) -> [(&'static str, f64); 4] {
        [
            ("held_out_percent", self.held_out_percent),
            ("free_run_percent", self.free_run_percent),
            ("error_percent", self.error_percent),
            ("parameters", self.parameters as f64),
        ]
    }

    /// True if this operator is selected.
    pub(super) fn is_selected(&self) -> bool {
        self.verdict == SELECTED
    }

    /// The factor by which its errors count more than those of other operators.
    fn factor(&self) -> f64 {
        Operator::find(self.operator).map_or(1.0, factor)
    }

    /// The larger of the two errors, with rounding, as it counts among operators [%].
    pub(super) fn error(&self) -> f64 {
        self.factor() * hypot(self.error_percent, ROUNDING_PERCENT)
    }

    /// The result of an operator that could not be fitted.
    pub fn refused(row: &Operator, why: String) -> Self {
        OperatorTrial {
            operator: row.name,
            parameters: 0,
            held_out_percent: f64::INFINITY,
            free_run_percent: f64::INFINITY,
            error_percent: f64::INFINITY,
            as_good: false,
            verdict: "refused",
            shape: Vec::new(),
            refused: Some(why),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::OPERATORS;

    #[test]
    fn the_reason_names_an_operator_that_is_better_and_jumps() {
        let trial = |name: &str, error: f64, as_good: bool| OperatorTrial {
            held_out_percent: error,
            free_run_percent: error,
            error_percent: error,
            as_good,
            verdict: if as_good { SELECTED } else { "" },
            refused: None,
            ..OperatorTrial::refused(Operator::find(name).unwrap(), String::new())
        };
        let trials = [trial("preisach", 2.5, true), trial("stop", 2.9, false), trial("rate-scheduled", 1.9, false)];
        let reason = reason_for_operator(&trials).unwrap();
        assert!(
            reason.contains("the next is stop with 2.900 %; rate-scheduled has 1.900 %, which counts 2 times"),
            "{reason}"
        );
        let jumps = |row: &&&Operator| factor(row) > 1.0;
        let names: Vec<_> = OPERATORS.iter().filter(jumps).map(|row| row.name).collect();
        assert_eq!(names, ["two-branch", "rate-scheduled"]);
    }

    #[test]
    fn auto_tries_what_suits_the_records_and_is_not_left_out() {
        let u: Vec<f64> = (0..4000).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.07 * f64::from(t)).sin()).collect();
        let records = Records::of(&[], &[Record::new(5e-4, u.clone(), u).unwrap()]).unwrap();
        let tried = |list: &str| {
            let found = suitable_operators(list, &records, &mut Vec::new());
            found.map(|tried| tried.iter().map(|o| o.name).collect::<Vec<_>>()).map_err(|error| error.to_string())
        };
        let mut without = tried("auto").unwrap();
        without.retain(|name| *name != "preisach");
        assert_eq!(tried("auto,-preisach"), Ok(without));
        let none = OPERATORS.iter().filter(|o| o.rate_independent).fold("auto".to_string(), |s, o| s + ",-" + o.name);
        assert!(tried(&none).unwrap_err().contains("leaves out every operator that suits the records"));
    }

    #[test]
    fn the_reason_states_what_the_selected_operator_has_before_the_others() {
        let trial = |name: &str, error: f64, as_good: bool, verdict: &'static str| OperatorTrial {
            held_out_percent: error,
            free_run_percent: error,
            error_percent: error,
            as_good,
            verdict,
            refused: (verdict == "refused").then(String::new),
            ..OperatorTrial::refused(Operator::find(name).unwrap(), String::new())
        };
        let best = trial("preisach", 2.5, true, SELECTED);
        assert_eq!(reason_for_operator(std::slice::from_ref(&best)), None);
        let (stop, dahl) = (trial("stop", 2.9, false, ""), trial("dahl", 3.5, false, ""));
        // One that is refused, and one that has a smaller error but is not as good, are not the next.
        let others = [trial("bouc-wen", 2.6, false, "refused"), trial("duhem", 2.4, false, "")];
        let (alone, next) = ("preisach predicts best: 2.500 % rms/pp, held out or in free run", "; the next is stop");
        let trials = [&[best.clone(), dahl, stop][..], &others].concat();
        assert_eq!(reason_for_operator(&trials), Some(format!("{alone}{next} with 2.900 %")));
        let simpler = trial("preisach", 2.6, true, SELECTED);
        let found = reason_for_operator(&[simpler, trial("stop", 2.5, true, "as good")]);
        let equal = "preisach has an error of 2.600 % rms/pp, held out or in free run, equal to the 2.500 % of stop \
                     within uncertainty, and is simpler";
        assert_eq!(found.as_deref(), Some(equal));
        let found = reason_for_operator(&[best, trial("stop", 2.52, true, "as good")]);
        assert_eq!(found, Some(format!("{alone}; it is the simplest of those that are as good")));
    }

    #[test]
    fn auto_tries_fewer_operators_without_minor_loops_and_notes_how_few_there_are() {
        let through = |levels: &[f64]| -> Record {
            let line = |w: &[f64]| {
                let (from, to) = (w[0], w[1]);
                (0..50).map(move |t| from + (to - from) * f64::from(t) / 50.0)
            };
            let u: Vec<f64> = levels.windows(2).flat_map(line).chain(levels.last().copied()).collect();
            Record::new(5e-4, u.clone(), u).unwrap()
        };
        let tried = |small: &[Record], levels: &[f64]| {
            let mut notes = Vec::new();
            let records = Records::of(small, &[through(levels)]).unwrap();
            let operators = suitable_operators("auto", &records, &mut notes).unwrap();
            (operators, notes.join(""))
        };
        // Reversals within a tenth of the range from its ends start no minor loop.
        let inner = [10.0, -10.0, 10.0, -10.0, 10.0, -10.0, 10.0, -10.0];
        for (levels, times) in [
            (vec![0.0, 30.0, -30.0, 27.0, -27.0, 30.0, -30.0], "turn back inside"),
            (vec![0.0, 30.0, -30.0, 10.0, -27.0, 30.0], "turn back only once inside"),
            (vec![0.0, 30.0, -30.0, 27.0, -10.0, 30.0], "turn back only once inside"),
            ([&[0.0, 30.0, -30.0][..], &inner[..7], &[-30.0]].concat(), "turn back only 7 times inside"),
        ] {
            let (operators, note) = tried(&[], &levels);
            assert!(note.contains(times), "{times}: {note}");
            assert!(operators.iter().all(|o| o.minor_loops && o.wipes_out && !o.needs_minor_loops));
        }
        let levels = [&[0.0, 30.0, -30.0][..], &inner, &[30.0]].concat();
        let (alone, note) = tried(&[], &levels);
        assert!(note.is_empty() && alone.iter().all(|o| o.rate_independent), "{note}");
        assert!(alone.iter().any(|o| o.needs_minor_loops) && alone.iter().any(|o| !o.wipes_out));
        let (beside, _) = tried(&[through(&[0.0, 1.0, -1.0])], &levels);
        assert!(beside.iter().any(|o| !o.rate_independent) && beside.len() > alone.len());
    }
}
