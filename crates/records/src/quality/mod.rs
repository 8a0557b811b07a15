//! Defects of a record, found before identification. Each is found by a detector, a row of [`DETECTORS`]: its
//! criterion, and what it means for the record.
//!
//! Samples that must not be fitted are masked in [`Inspection::usable`]; nothing is repaired. It does not detect:
//! spikes below 1 % of stroke, drift as small as creep, a clipped square wave. [`compare`] finds records with
//! another sign or gain than the others of their set.
//!
//! Reference: Pearson 2002, Outliers in process modeling and identification, doi:10.1109/87.974338 (Hampel's rule).
//!
//! Why: docs/decisions/data-and-records.md, "Defects are masked, never repaired".

mod aliased;
mod bridge;
mod closed;
pub mod compare;
mod constant;
mod detector;
mod drift;
mod explained;
mod flat;
mod increments;
mod inspection;
mod lags;
mod missing;
mod order;
mod outliers;
mod plays;
mod power;
mod runs;
mod scale;
mod sections;
mod tone;
mod units;
mod uses;
mod wild;

pub use bridge::bridged;
pub use compare::compare;
pub use detector::{Consequence, Context, Detector};
pub use drift::DRIFT;
pub use inspection::{Detection, Finding, Inspection};
pub(crate) use outliers::OUTLIERS;
pub use power::{around, excites};
pub(crate) use runs::{places, runs};
pub use scale::likely_cause;
pub use sections::InSections;
pub use uses::{Drive, Proposal, Use, uses};

use crate::record::Record;

/// The detectors of defects, in the order in which they run. One that masks samples stands before those that leave
/// masked samples out.
pub static DETECTORS: &[&Detector] = &[
    &constant::TOO_SHORT,
    &constant::CONSTANT_INPUT,
    &constant::CONSTANT_OUTPUT,
    &wild::WILD_VALUES,
    &flat::SATURATED_OUTPUT,
    &flat::CLIPPED_INPUT,
    &flat::FROZEN_OUTPUT,
    &missing::MISSING_ROWS,
    &outliers::OUTLIERS,
    &drift::DRIFT,
    &order::SWAPPED,
    &order::SHIFTED,
    &aliased::ALIASED,
    &closed::CLOSED_LOOP,
    &units::UNITS,
];

/// Finds the defects of a record.
pub fn inspect(record: &Record) -> Inspection {
    let mut context = Context::new(record);
    let mut findings = Vec::new();
    for detector in DETECTORS {
        let Some(Detection { samples, text }) = (detector.run)(&context) else { continue };
        if detector.consequence == Consequence::Masked {
            samples.iter().for_each(|range| context.usable[range.clone()].fill(false));
        }
        findings.push(Finding { detector, samples, text });
        if detector.consequence == Consequence::Unusable {
            break;
        }
    }
    Inspection { findings, usable: context.usable }
}

/// Defects of a record that make its loop wrong, and what to do, one sentence each. Drawing a loop must be quick, so
/// only these are looked for.
pub fn loop_defects(record: &Record) -> Vec<String> {
    let context = Context::new(record).into_measured();
    let is_unusable = |detector: &&&Detector| detector.consequence == Consequence::Unusable;
    if DETECTORS.iter().filter(is_unusable).any(|detector| (detector.run)(&context).is_some()) {
        return Vec::new();
    }
    let wrong = |detector: &&Detector| {
        let remedy = detector.loop_remedy?;
        let text = (detector.run)(&context)?.text;
        Some(format!("Width and branches of this loop are wrong, because {text}: {remedy}"))
    };
    DETECTORS.iter().filter_map(wrong).collect()
}

#[cfg(test)]
mod tests;
