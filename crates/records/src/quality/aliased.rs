//! Aliasing: a drive above half the sampling frequency appears at the mirrored frequency, and the output leads there.

use super::Detection;
use super::detector::{Consequence, Context, Detector};
use piezoid_numerics::number::round;
use std::ops::Range;

/// Lines above this frequency have too few samples to show a loop [periods/sample].
const MIN_FREQUENCY: f64 = 0.2;

/// The phases of a loop that is turned by aliasing [degrees]. A sine above a resonance has the opposite sign.
const ALIASED_PHASE_DEG: Range<f64> = 2.0..45.0;

pub(super) static ALIASED: Detector = Detector {
    name: "aliased",
    criterion: "the output leads a sine of fewer than 5 samples a period: it is above half the sampling frequency",
    consequence: Consequence::Reported,
    loop_remedy: None,
    run: aliased,
};

fn aliased(context: &Context) -> Option<Detection> {
    let tone = context.tone()?;
    if tone.frequency <= MIN_FREQUENCY || !ALIASED_PHASE_DEG.contains(&tone.phase) {
        return None;
    }
    let [samples, phase] = [1.0 / tone.frequency, tone.phase].map(round);
    let text = format!(
        "the input has {samples} samples in a period, and the output leads it by {phase} degrees: the drive is \
         probably faster than half the sampling frequency and appears aliased: sample at least 20 times in a period"
    );
    Some(text.into())
}
