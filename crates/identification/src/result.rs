//! The result of the search: the model, the reasons for it, and what the user should know.

use super::fit::{Estimate, MAX_CREEP_GAIN, offset, optimality, parameters};
use super::records::Records;
use super::search::{Candidate, Search, reason_for_operator};
use super::{FittedParameter, JointOptions, check};
use crate::LinearPart;
use crate::{Identified, unexcited_resonance};
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use tracing::trace_span;

/// The result.
///
/// # Errors
/// [`Error::Unidentifiable`] if the model does not predict the held-out data.
pub(super) fn identified(
    candidate: Candidate,
    search: &Search,
    records: &Records,
    settings: &JointOptions,
) -> Result<Identified, Error> {
    let _stage = trace_span!(target: "stage", "result").entered();
    let Candidate { structure, fitted, .. } = candidate;
    let (trials, runs) = (search.operator_trials(), &search.runs);
    let (mut notes, mut reasons) = (search.notes.clone(), Vec::new());
    // Of a specified order it says if it is too low.
    let of_block = if settings.order.is_some() { &mut notes } else { &mut reasons };
    of_block.push(format!("linear block: {}", structure.reason));
    let left_percent = match &search.cancelled {
        Some(Error::Cancelled { what: stage, .. }) => {
            notes.push(format!("search: it was cancelled in the stage \"{stage}\": the model is the best until then"));
            None
        }
        _ => {
            let end = optimality(&fitted, runs);
            if end.left_percent.is_none() { &mut reasons } else { &mut notes }.push(end.note);
            end.left_percent
        }
    };
    notes.extend(check::check_fit(&fitted, runs)?);
    reasons.extend(reason_for_operator(&trials).map(|why| format!("operator: {why}")));
    let offset = offset(&fitted, runs, &mut notes, &records.units.y);
    let of = |estimate: &Estimate| Ok(estimate.model(offset)?.with_units(records.units.clone()));
    let without = fitted.held_out.without.iter().filter_map(|x| fitted.estimate.moved(x.as_slice()));
    let spread = without.map(|estimate| of(&estimate)).collect::<Result<_, Error>>()?;
    let model = of(&fitted.estimate)?;
    let model = match Domain::of(records.iter()) {
        Some(domain) => model.with_identified(domain),
        None => model,
    };
    let parameters = parameters(&fitted);
    notes.extend(notes_on_values(&model, &parameters));
    let is_in_free_decays = model.linear().resonance().is_some_and(|mode| search.is_in_free_decays(mode.hz));
    notes.extend(unexcited_resonance(model.linear(), records.iter()).filter(|_| !is_in_free_decays));
    let linear = LinearPart { arx: model.linear().clone(), offset, fit: None, reason: structure.reason };
    Ok(Identified {
        model,
        linear,
        loops: Vec::new(),
        trials,
        parameters,
        spread,
        left_percent,
        cancelled: search.cancelled.clone(),
        reasons,
        notes,
    })
}

/// The notes on the values of a model and its parameters.
pub(super) fn notes_on_values(model: &Model, parameters: &[FittedParameter]) -> Vec<String> {
    let unknown = note_on_unknown(parameters).into_iter();
    unknown.chain(notes_on_creep(model)).chain(check::long_delay(model.linear())).collect()
}

/// The note on parameters that the records do not determine.
pub(super) fn note_on_unknown(parameters: &[FittedParameter]) -> Option<String> {
    let unknown = parameters.iter().filter(|p| p.is_unknown());
    let unknown = unknown.map(|p| format!("{} = {} (standard error {})", p.name, short(p.value), short(p.error)));
    let unknown = unknown.collect::<Vec<_>>().join(", ");
    let is_any = !unknown.is_empty();
    is_any.then(|| format!("these records do not determine {unknown}: ignore these values, or add records"))
}

/// The notes on lags of creep with the largest gain that creep has.
fn notes_on_creep(model: &Model) -> impl Iterator<Item = String> {
    model.creep().lags().iter().filter(|lag| lag.gain >= MAX_CREEP_GAIN).map(|lag| {
        let (tau, percent) = (short(lag.tau_s), short(100.0 * lag.gain));
        format!(
            "creep of {tau} s adds {percent} %, more than creep of ceramics: it may represent a lag of driver, \
             mechanics or sensor that is missing in the linear block"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::creep::{Creep, Lag};
    use piezoid_models::hysteresis::Operator;
    use piezoid_models::linear::Arx;

    #[test]
    fn values_that_the_records_do_not_determine_and_creep_that_is_none_are_noted() {
        let law = (Operator::find("stop").unwrap().example)(1e-3).unwrap();
        let lags = vec![Lag { tau_s: 0.5, gain: MAX_CREEP_GAIN }, Lag { tau_s: 5.0, gain: 0.05 }];
        let model = Model::new(law, Arx::gain(1e-3, 2.0).unwrap(), 0.0).unwrap();
        let model = model.with_creep(Creep::new(1e-3, lags).unwrap()).unwrap();
        let parameter = |name: &str, error: f64| FittedParameter { name: name.into(), value: 2.0, error };
        let notes = notes_on_values(&model, &[parameter("a [s]", 1.5), parameter("b", 0.5), parameter("c", 3.0)]);
        let unknown = "these records do not determine a [s] = 2.000 (standard error 1.500), c = 2.000 (standard error \
                       3.000): ignore these values, or add records";
        let creep = "creep of 0.5000 s adds 10.00 %, more than creep of ceramics: ";
        assert!(notes.len() == 2 && notes[0] == unknown && notes[1].starts_with(creep), "{notes:?}");
    }
}
