//! Folding: a drive above half the sampling frequency appears at the mirrored frequency, and the output leads there.

use super::tone::Tone;
use super::{Defect, Finding};
use crate::number::round;

/// Lines above this frequency have too few samples to show a loop [periods/sample].
const FAST: f64 = 0.2;

/// The phases of a loop that is turned by folding [degrees]. A sine above a resonance has the opposite sign.
const LEAD: std::ops::Range<f64> = 2.0..45.0;

/// A finding if the output leads a tone of a few samples.
pub(super) fn folded(tone: Option<&Tone>) -> Option<Finding> {
    let tone = tone.filter(|tone| tone.frequency > FAST && LEAD.contains(&tone.phase))?;
    let text = format!(
        "the input has {} samples in a period, and the output leads it by {} degrees: the drive is probably faster \
         than half the sampling frequency and appears folded: sample at least 20 times in a period",
        round(1.0 / tone.frequency),
        round(tone.phase)
    );
    Some(Finding { defect: Defect::Folded, samples: Vec::new(), text })
}
