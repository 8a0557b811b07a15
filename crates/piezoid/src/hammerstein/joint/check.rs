//! Whether a model tells anything of its records, and they of it.
//!
//! Errors are shares of the rms of y about its mean: at 1 a constant does as well. A model that leaves that much of what was
//! held out is refused. Noise, too, leaves much of a record: a share tells that something is wrong, not what.

use super::refine::Fitted;
use super::runs::TrainingRecord;
use crate::error::Error;
use crate::number::short;
use crate::series::mean;
use crate::waveform::reversals;

/// Share of a record from which that is told, and share of what was held out from which there is no model.
const MUCH: f64 = 0.3;
const ALL: f64 = 0.98;

/// Samples a parameter of the hysteresis below which that is told.
const FEW: usize = 5;

/// How far an input must turn back, over its range, to begin a loop.
const BACK: f64 = 0.05;

/// What is to be said.
///
/// # Errors
/// Refuses a model that foretells nothing of what was held out.
pub(super) fn check_fit(fitted: &Fitted, runs: &[TrainingRecord]) -> Result<Vec<String>, Error> {
    let share = |(run, left): (&TrainingRecord, &f64)| 100.0 * (left / run.power()).sqrt();
    let shares: Vec<f64> = runs.iter().zip(&fitted.left).map(share).collect();
    let large_signal: Vec<&TrainingRecord> = runs.iter().filter(|run| run.large_signal).collect();
    let power = mean(&large_signal.iter().map(|run| run.power()).collect::<Vec<_>>());
    let held_out = fitted.held_out.rms_pp() / power.sqrt();
    if held_out.is_nan() || held_out > ALL {
        let each = runs.iter().zip(&shares).map(|(run, share)| format!("{} {} %", run.name, short(*share)));
        let because = format!(
            "what was held out is foretold no better than by a constant (left of the rms of each: {}): does the output follow \
             the input, and with the same sign in all records?",
            each.collect::<Vec<_>>().join(", ")
        );
        return Err(Error::Unidentifiable { what: "a model".into(), because });
    }
    let mut notes = Vec::new();
    for (run, share) in runs.iter().zip(&shares).filter(|(_, share)| **share > 100.0 * MUCH) {
        let (name, share) = (&run.name, short(*share));
        notes.push(format!(
            "{name}: the model leaves {share} % of the rms of its output: too much noise, rows that are missing, or another \
             sign, column or actuator than in the other records; look at it, or leave it out"
        ));
    }
    let estimate = &fitted.estimate;
    let parameters = estimate.weights.len() + estimate.basis.shape().len();
    let samples = large_signal.iter().flat_map(|run| &run.usable).filter(|usable| **usable).count();
    if samples < FEW * parameters {
        notes.push(format!(
            "{samples} samples of rich records are few for {parameters} parameters of the hysteresis: record longer, or ask for \
             fewer elements"
        ));
    }
    // An end of a record is no turn.
    let inner =
        |run: &&TrainingRecord| reversals(run.record.u(), BACK).into_iter().any(|t| t > 0 && t + 1 < run.record.len());
    if !large_signal.iter().any(inner) {
        notes
            .push("the input of no rich record turns back, so nothing tells the hysteresis: record whole loops".into());
    }
    for (k, run) in large_signal.iter().enumerate() {
        let same = |other: &&&TrainingRecord| other.record.u() == run.record.u() && other.record.y() == run.record.y();
        if let Some(twin) = large_signal[..k].iter().find(same) {
            notes.push(format!(
                "{} and {} are the same: what is held out of one is foretold by the other; give it once",
                twin.name, run.name
            ));
        }
    }
    Ok(notes)
}
