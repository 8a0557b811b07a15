//! The choice of the structure: hysteresis first and mechanics after, or hysteresis in feedback.

use super::{FeedbackFit, STAGE};
use crate::identified::Identified;
use crate::result::{note_on_unknown, notes_on_values};
use crate::search::{OperatorTrial, SELECTED};
use piezoid_models::driver::DriverModel;
use piezoid_models::feedback::Intersample;
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::optimize::Reason;
use piezoid_numerics::progress::Progress;
use piezoid_numerics::series::{ends, mean, scatter};
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
    /// The one that predicts the last part of each record better.
    Auto,
}

/// The first part of each record, from which the feedback model is identified that predicts the rest.
const FIRST_PART: f64 = 0.75;

/// Hysteresis in feedback is selected if its error on the held-out parts is below this share of that of the blocks in
/// series.
const LESS_ERROR: f64 = 0.8;

/// `found`, with hysteresis in feedback if the structure asks for it, or if that predicts the last part of each record
/// better. The blocks in series were identified from the whole `records`, hysteresis in feedback from the first part:
/// the comparison is in favour of the simpler structure.
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
    match Trial::of(&found.model, &records, &inputs, progress) {
        Ok(trial) if structure == Structure::Feedback || trial.percent < LESS_ERROR * trial.of_blocks => {
            match FeedbackFit::from(&trial.fit.model, &records, progress) {
                Ok(fit) => taken(found, fit, &trial),
                Err(cancelled @ Error::Cancelled { .. }) => Ok(Identified { cancelled: Some(cancelled), ..found }),
                Err(other) => Err(other),
            }
        }
        Ok(trial) => {
            let mut found = found;
            found.trials.push(trial.row(""));
            Ok(with_reason(found, &format!("hysteresis first, mechanics after, not {STAGE}: {}", trial.errors())))
        }
        Err(cancelled @ Error::Cancelled { .. }) => Ok(Identified { cancelled: Some(cancelled), ..found }),
        Err(why @ Error::Unidentifiable { .. }) if structure == Structure::Auto => {
            Ok(with_reason(found, &format!("hysteresis first, mechanics after, because {why}")))
        }
        Err(other) => Err(other),
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
    match fit.minimum.reason {
        Reason::Iterations => notes.push(format!("search: {STAGE}: it ended before its minimum")),
        _ => reasons.push(format!("search: {STAGE}: it ended at its minimum")),
    }
    let parameters = fit.parameters;
    notes.extend(note_on_unknown(&parameters));
    trials.iter_mut().filter(|trial| trial.verdict == SELECTED).for_each(|trial| trial.verdict = "");
    trials.push(trial.row(SELECTED));
    let model = found.model.with_feedback(fit.model)?;
    Ok(Identified { model, parameters, trials, reasons, notes, left_percent: None, ..found })
}

/// A feedback model from the first part of the records, and how it predicts the rest.
struct Trial {
    fit: FeedbackFit,
    /// The error on the rest, and that of the blocks in series, which were identified from all [% of peak-to-peak].
    percent: f64,
    of_blocks: f64,
}

impl Trial {
    fn of(blocks: &Model, records: &[Record], inputs: &[Intersample], progress: &mut Progress) -> Result<Self, Error> {
        let first = |record: &Record| record.slice(0..first_part(record));
        let parts = records.iter().map(first).collect::<Result<Vec<_>, _>>()?;
        let fit = FeedbackFit::oscillator(&parts, inputs, progress)?;
        let in_feedback = blocks.clone().with_feedback(fit.model.clone())?;
        let [percent, of_blocks] = [&in_feedback, blocks].map(|model| held_out_percent(model, records));
        Ok(Trial { fit, percent, of_blocks })
    }

    fn errors(&self) -> String {
        let [percent, of_blocks] = [self.percent, self.of_blocks].map(short);
        format!(
            "identified from the first part of the records, its error on the rest is {percent} % of peak-to-peak; that \
             of hysteresis first and mechanics after is {of_blocks} %"
        )
    }

    /// Its row in the table of operators.
    fn row(&self, verdict: &'static str) -> OperatorTrial {
        OperatorTrial {
            operator: "bouc-wen, in feedback",
            parameters: self.fit.parameters.len(),
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

/// Number of samples of the first part.
fn first_part(record: &Record) -> usize {
    (FIRST_PART * record.len() as f64).round() as usize
}

/// The rms error of a free run on the last part of each record, about its mean, in % of peak-to-peak. The initial
/// condition is the one that suits the first part best.
fn held_out_percent(model: &Model, records: &[Record]) -> f64 {
    let square = |record: &Record| {
        let (u, cut) = (record.u(), first_part(record));
        let errors = |initial: InitialCondition| {
            let run = model.follow(&mut model.before(u, initial), u);
            let mut errors: Vec<f64> = record.y().iter().zip(run).map(|(y, run)| y - run).collect();
            let rest = errors.split_off(cut);
            let offset = mean(&errors);
            (scatter(&errors), rest.iter().map(|e| (e - offset).powi(2)).sum::<f64>())
        };
        let each = InitialCondition::of(u).map(errors).into_iter();
        let (_, square) = each.min_by(|p, q| p.0.total_cmp(&q.0)).unwrap_or_default();
        let (low, high) = ends(record.y().iter().copied());
        (square / (high - low).powi(2), record.len() - cut)
    };
    let (sum, samples) = records.iter().map(square).fold((0.0, 0), |(sum, n), (square, m)| (sum + square, n + m));
    100.0 * (sum / samples as f64).sqrt()
}
