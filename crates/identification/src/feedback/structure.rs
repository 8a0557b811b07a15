//! The choice of the structure: hysteresis first and mechanics after, or hysteresis in feedback.

use super::free_run::{Counted, peak_to_peak};
use super::{FeedbackFit, STAGE};
use crate::identified::Identified;
use crate::result::{note_on_unknown, notes_on_values};
use crate::search::{OperatorTrial, SELECTED};
use piezoid_models::driver::DriverModel;
use piezoid_models::feedback::Intersample;
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::optimize::{Minimum, Reason};
use piezoid_numerics::progress::Progress;
use piezoid_numerics::series::{mean, scatter};
use piezoid_records::record::Record;
use serde::{Deserialize, Serialize};

/// Structure of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Structure {
    /// Hysteresis first, then creep and mechanics.
    #[default]
    Hammerstein,
    /// Mechanics with hysteresis in feedback.
    Feedback,
    /// The one that predicts held-out parts of each record better.
    Auto,
}

/// Hysteresis in feedback is selected if its error on the held-out parts is below this share of that of the blocks in
/// series.
const LESS_ERROR: f64 = 0.8;

/// `found`, with hysteresis in feedback if the structure asks for it, or if that predicts two eighths of each record
/// better. These parts do not count in the fit of hysteresis in feedback, but in that of the blocks in series: the
/// comparison is in favour of the simpler structure.
///
/// # Errors
/// Returns an error if the structure is [`Structure::Feedback`] and cannot be identified from the records. A search
/// that `progress` cancels leaves the blocks in series.
pub fn identify_structure<'r>(
    found: Identified,
    records: impl Iterator<Item = &'r Record>,
    structure: Structure,
    driver: Option<DriverModel>,
    progress: &mut Progress,
) -> Result<Identified, Error> {
    if structure == Structure::Hammerstein || found.cancelled.is_some() {
        return Ok(found);
    }
    let unit = found.model.units().y.clone();
    let records = records.map(|record| record.output_in(&unit)).collect::<Result<Vec<_>, _>>()?;
    let inputs = match driver {
        Some(driver) => vec![Intersample::Driven(driver)],
        None => vec![Intersample::Held, Intersample::BandLimited],
    };
    let trial = match Trial::best(&found.model, &records, &inputs, progress) {
        Ok(trial) => trial,
        Err(why) => return without(found, structure, why),
    };
    let predicts_better = trial.percent < LESS_ERROR * trial.of_blocks;
    if structure == Structure::Auto && !predicts_better {
        let mut found = found;
        found.trials.push(trial.row(""));
        let reason = format!("hysteresis first, mechanics after, not {STAGE}: {}", trial.errors());
        return Ok(with_reason(found, &reason));
    }
    match trial.again(&found.model, &records, &inputs, progress) {
        Ok(fit) => taken(found, fit, &trial),
        Err(why) => without(found, structure, why),
    }
}

/// `found` as it is, if a search was cancelled or the structure may stay; else the error.
fn without(found: Identified, structure: Structure, why: Error) -> Result<Identified, Error> {
    match why {
        cancelled @ Error::Cancelled { .. } => Ok(Identified { cancelled: Some(cancelled), ..found }),
        why if structure == Structure::Auto => {
            Ok(with_reason(found, &format!("hysteresis first, mechanics after, because {why}")))
        }
        other => Err(other),
    }
}

fn with_reason(mut found: Identified, reason: &str) -> Identified {
    found.reasons.push(format!("structure: {reason}"));
    found
}

/// `found` with the feedback model of this fit.
fn taken(found: Identified, fit: FeedbackFit, trial: &Trial) -> Result<Identified, Error> {
    let Identified { mut trials, mut reasons, mut notes, .. } = found;
    let of_blocks = notes_on_values(&found.model, &found.parameters);
    notes.retain(|note| !of_blocks.contains(note));
    reasons.push(format!("structure: {STAGE}: {}", trial.errors()));
    match note_on_end(&fit.minimum) {
        Some(note) => notes.push(note),
        None => reasons.push(format!("search: {STAGE}: it ended at its minimum")),
    }
    let parameters = fit.parameters;
    notes.extend(note_on_unknown(&parameters));
    trials.iter_mut().filter(|trial| trial.verdict == SELECTED).for_each(|trial| trial.verdict = "");
    trials.push(trial.row(SELECTED));
    let model = found.model.with_feedback(fit.model)?;
    Ok(Identified { model, parameters, trials, reasons, notes, spread: Vec::new(), left_percent: None, ..found })
}

/// The note on a search that ended before its minimum, with what its last steps changed; `None` for another end.
fn note_on_end(minimum: &Minimum) -> Option<String> {
    if minimum.reason != Reason::Iterations {
        return None;
    }
    let steps = minimum.history.len() - 1;
    let lowered = short(100.0 * (1.0 - minimum.cost / minimum.history[0]));
    Some(format!(
        "search: {STAGE}: it ended before its minimum; its last {steps} steps lowered the sum of squared errors by \
         {lowered} %"
    ))
}

/// What drives the hysteresis.
#[derive(Clone, Copy)]
enum Kind {
    /// The displacement of an oscillator.
    Displacement,
    /// The input, and the vibration of the mechanics after it.
    Vibration,
}

/// A feedback model from most of the records, and how it predicts the rest.
struct Trial {
    kind: Kind,
    fit: FeedbackFit,
    /// Why there is none of the other kind.
    missing: Option<Error>,
    /// The error on the rest, and that of the blocks in series, which were identified from all [% of peak-to-peak].
    percent: f64,
    of_blocks: f64,
}

impl Trial {
    /// The kind with the lower error on the rest.
    fn best(
        blocks: &Model,
        records: &[Record],
        inputs: &[Intersample],
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        let of_blocks = held_out_percent(blocks, records);
        let mut of = |kind: Kind| {
            let fit = match kind {
                Kind::Displacement => FeedbackFit::oscillator_of(records, Counted::Most, inputs, progress)?,
                Kind::Vibration => FeedbackFit::vibrating_of(blocks, (records, Counted::Most), inputs, progress)?,
            };
            let percent = held_out_percent(&blocks.clone().with_feedback(fit.model.clone())?, records);
            Ok(Trial { kind, fit, missing: None, percent, of_blocks })
        };
        let by_displacement = of(Kind::Displacement);
        if let Err(cancelled @ Error::Cancelled { .. }) = by_displacement {
            return Err(cancelled);
        }
        match (by_displacement, of(Kind::Vibration)) {
            (Ok(one), Ok(other)) => Ok(if other.percent < one.percent { other } else { one }),
            (_, Err(cancelled @ Error::Cancelled { .. })) => Err(cancelled),
            (Ok(one), Err(why)) => Ok(Trial { missing: Some(why), ..one }),
            (Err(why), Ok(one)) => Ok(Trial { missing: Some(why), ..one }),
            (Err(_), Err(why)) => Err(why),
        }
    }

    /// The fit to the whole records.
    fn again(
        &self,
        blocks: &Model,
        records: &[Record],
        inputs: &[Intersample],
        progress: &mut Progress,
    ) -> Result<FeedbackFit, Error> {
        match self.kind {
            Kind::Displacement => FeedbackFit::from(&self.fit.model, records, progress),
            Kind::Vibration => FeedbackFit::vibrating_from(&self.fit.model, blocks, records, inputs, progress),
        }
    }

    fn errors(&self) -> String {
        let [percent, of_blocks] = [self.percent, self.of_blocks].map(short);
        let missing = self.missing.as_ref().map_or(String::new(), |why| format!("; not of the other kind: {why}"));
        format!(
            "where two eighths of each record do not count, its error there is {percent} % of peak-to-peak; that of \
             hysteresis first and mechanics after, identified from all, is {of_blocks} %{missing}"
        )
    }

    /// Its row in the table of operators.
    fn row(&self, verdict: &'static str) -> OperatorTrial {
        OperatorTrial {
            operator: match self.kind {
                Kind::Displacement => "bouc-wen, in feedback",
                Kind::Vibration => "preisach, in feedback",
            },
            parameters: self.fit.model.parameters().len(),
            held_out_percent: self.percent,
            free_run_percent: self.fit.percent,
            error_percent: self.percent.max(self.fit.percent),
            as_good: verdict == SELECTED,
            verdict,
            shape: Vec::new(),
            refused: None,
        }
    }
}

/// The rms error of a free run on the samples of each record that do not count, about the mean of the others, in % of
/// peak-to-peak. The initial condition is the one that suits the others best.
fn held_out_percent(model: &Model, records: &[Record]) -> f64 {
    let square = |record: &Record| {
        let u = record.u();
        let errors = |initial: InitialCondition| {
            let run = model.follow(&mut model.before(u, initial), u);
            let errors = record.y().iter().zip(run).map(|(y, run)| y - run).zip(Counted::Most.of(u.len()));
            let (counted, held_out): (Vec<_>, Vec<_>) = errors.partition(|(_, counts)| *counts);
            let [counted, held_out] =
                [counted, held_out].map(|part| part.into_iter().map(|(e, _)| e).collect::<Vec<_>>());
            let offset = mean(&counted);
            (scatter(&counted), held_out.iter().map(|e| (e - offset).powi(2)).sum::<f64>(), held_out.len())
        };
        let each = InitialCondition::of(u).map(errors).into_iter();
        let (_, square, samples) = each.min_by(|p, q| p.0.total_cmp(&q.0)).unwrap_or_default();
        (square / peak_to_peak(record).powi(2), samples)
    };
    let (sum, samples) = records.iter().map(square).fold((0.0, 0), |(sum, n), (square, m)| (sum + square, n + m));
    100.0 * (sum / samples as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_testing::assert_close;
    use std::sync::Arc;

    #[test]
    fn a_search_that_ends_early_states_what_its_last_steps_lowered() {
        let minimum = |reason| Minimum { x: vec![], cost: 1.0, history: vec![4.0, 2.0, 1.0], courses: vec![], reason };
        let note = note_on_end(&minimum(Reason::Iterations)).unwrap();
        assert!(note.ends_with("its last 2 steps lowered the sum of squared errors by 75.00 %"), "{note}");
        assert_eq!(note_on_end(&minimum(Reason::Converged)), None);
    }

    #[test]
    fn the_held_out_error_is_about_the_offset_of_the_rest_over_the_height_of_each_record() {
        const TS: f64 = 1e-3;
        let gain = Arc::new(Proportional::new(TS, 1.0).unwrap());
        let model = Model::new(gain, Arx::gain(TS, 2.0).unwrap(), 0.0).unwrap();
        let record = |n: usize, height: f64, offset: f64, error: f64| {
            // Two levels in turn, whose heights the errors do not change.
            let u: Vec<f64> = (0..n).map(|t| if t % 4 < 2 { 0.0 } else { 0.5 * height }).collect();
            let y = |(t, u): (usize, &f64)| 2.0 * u + offset + if [2, 5].contains(&(8 * t / n)) { error } else { 0.0 };
            let y = u.iter().enumerate().map(y).collect();
            Record::new(TS, u, y).unwrap()
        };
        // A quarter of the samples is held out: 200 with 3 of 23, and 100 with 1 of 11.
        let records = [record(800, 20.0, 5.0, 3.0), record(400, 10.0, -7.0, 1.0)];
        let expected = 100.0 * ((200.0 * (3.0f64 / 23.0).powi(2) + 100.0 * (1.0f64 / 11.0).powi(2)) / 300.0).sqrt();
        assert_close(&[held_out_percent(&model, &records)], &[expected], 1e-9, 0.0);
    }
}
