//! Checks of the fit: model and records must explain each other.
//!
//! Errors are relative to the rms of y about its mean: at 1 a constant predicts as well, and a model with such a
//! held-out error is refused. A large error of one record gives a note: its cause may be noise.

use super::fit::{Fitted, TrainingRecord};
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::mean;
use piezoid_numerics::system::System;
use piezoid_records::waveform::reversals;

/// Residual share from which a record gets a note, and held-out share from which there is no model.
const NOTED_RESIDUAL_SHARE: f64 = 0.3;
const MAX_HELD_OUT_SHARE: f64 = 0.98;

/// Samples per hysteresis parameter below which there is a note.
pub const MIN_SAMPLES_PER_PARAMETER: usize = 5;

/// Distance of an input after a reversal, over its range, from which it starts a loop.
const MIN_REVERSAL_DISTANCE: f64 = 0.05;

/// Delay beyond the lags of the poles from which there is a note [samples].
const NOTED_DELAY: f64 = 4.0;

/// The note on a long delay: [`piezoid_records::quality`] finds one only where the input is sharp.
pub(crate) fn long_delay(linear: &Arx) -> Option<String> {
    let delay_s = linear.modal_form().delay;
    let samples = delay_s / linear.ts();
    (samples > NOTED_DELAY).then(|| {
        format!(
            "the output follows the input {} samples ({} s) later than the poles of the linear block explain: the \
             sensor has this delay, or a lag of driver or sensor is missing in the block, or the channels are shifted. \
             If the channels are shifted, align them",
            round(samples),
            short(delay_s)
        )
    })
}

/// The notes.
///
/// # Errors
/// [`Error::Unidentifiable`] if the model does not predict the held-out data.
pub(crate) fn check_fit(fitted: &Fitted, runs: &[TrainingRecord]) -> Result<Vec<String>, Error> {
    let share = |(run, residual): (&TrainingRecord, &f64)| 100.0 * (residual / run.power()).sqrt();
    let shares: Vec<f64> = runs.iter().zip(&fitted.residuals).map(share).collect();
    let large_signal: Vec<&TrainingRecord> = runs.iter().filter(|run| run.large_signal).collect();
    let power = mean(&large_signal.iter().map(|run| run.power()).collect::<Vec<_>>());
    let held_out = fitted.held_out.rms_pp() / power.sqrt();
    if held_out.is_nan() || held_out > MAX_HELD_OUT_SHARE {
        let each = runs.iter().zip(&shares).map(|(run, share)| format!("{} {} %", run.name, short(*share)));
        let because = format!(
            "the model predicts the held-out data no better than a constant does (residual in % of the output's rms: \
             {}): check that the output depends on the input, with the same sign in all records",
            each.collect::<Vec<_>>().join(", ")
        );
        return Err(Error::Unidentifiable { what: "a model".into(), because });
    }
    let mut notes = Vec::new();
    for (run, share) in runs.iter().zip(&shares).filter(|(_, share)| **share > 100.0 * NOTED_RESIDUAL_SHARE) {
        let (name, share) = (&run.name, short(*share));
        notes.push(format!(
            "{name}: the residual is {share} % of the output's rms: check its noise, missing rows, sign, columns \
             and actuator, or leave the record out"
        ));
    }
    let estimate = &fitted.estimate;
    let parameters = estimate.weights.len() + estimate.basis.shape().len();
    let samples = large_signal.iter().flat_map(|run| &run.usable).filter(|usable| **usable).count();
    if samples < MIN_SAMPLES_PER_PARAMETER * parameters {
        notes.push(format!(
            "{samples} large-signal samples are few for {parameters} hysteresis parameters: record longer, or use \
             fewer elements"
        ));
    }
    // The ends of a record are not reversals.
    let inner = |run: &&TrainingRecord| {
        reversals(run.record.u(), MIN_REVERSAL_DISTANCE).into_iter().any(|t| t > 0 && t + 1 < run.record.len())
    };
    if !large_signal.iter().any(inner) {
        let note = "no large-signal input has a reversal, so the hysteresis is not determined: take records of full \
                    loops";
        notes.push(note.into());
    }
    for (k, run) in large_signal.iter().enumerate() {
        let same = |other: &&&TrainingRecord| other.record.u() == run.record.u() && other.record.y() == run.record.y();
        if let Some(twin) = large_signal[..k].iter().find(same) {
            notes.push(format!(
                "{} and {} are the same, so the held-out error would be too small: give the record once",
                twin.name, run.name
            ));
        }
    }
    Ok(notes)
}

#[cfg(test)]
mod tests {
    use super::super::fit::pair;
    use super::*;

    #[test]
    fn a_delay_of_several_samples_is_noted_and_the_lag_of_a_mode_is_not() {
        let mode = pair(5e-4, 120.0, 0.7);
        let delayed = |n: usize| {
            let b = [vec![0.0; n], mode.b().to_vec()].concat();
            long_delay(&Arx::new(5e-4, mode.a().to_vec(), b).unwrap())
        };
        assert_eq!((long_delay(&mode), delayed(3)), (None, None));
        let note = delayed(6).unwrap();
        assert!(note.starts_with("the output follows the input 4.") && note.contains("align"), "{note}");
    }
}
