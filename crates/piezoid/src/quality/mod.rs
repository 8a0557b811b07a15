//! Defects of a record, found before identification.
//!
//! | defect | criterion | consequence |
//! |---|---|---|
//! | too short, constant input, constant output | number of samples, range | error |
//! | saturated output | y is constant at its extreme while u moves | masked |
//! | clipped input | y has an arc while u is constant at its extreme | masked |
//! | wild values | y is far outside the range of all other samples, u is not | masked |
//! | outliers | one sample differs from its neighbours by more than usual (Hampel) | masked |
//! | frozen output | y repeats exactly while u moves | masked |
//! | missing rows | a smooth u jumps | masked until u has again covered its earlier range |
//! | drift | the part of y not explained by u has a trend that does not slow down like creep | reported |
//! | poor excitation | u has no power in the required band | reported |
//! | swapped | loops turn the wrong way, or later inputs explain the output | error |
//! | shifted | y moves before u, or long after it | reported |
//! | closed loop | u answers the noise of y | reported |
//! | folded | y leads a sine of a few samples a period | reported |
//! | units | stroke or voltage of no piezo actuator | reported |
//!
//! Samples that must not be fitted are masked in [`Inspection::usable`]; nothing is repaired. It does not detect:
//! spikes below 1 % of peak-to-peak, drift as small as creep, a clipped square wave. [`compare`] finds records with
//! another sign or gain than the others of their set.
//!
//! Reference: Pearson 2002, Outliers in process modeling and identification, doi:10.1109/87.974338 (Hampel's rule).
//!
//! Why: docs/decisions/data-and-records.md, "Defects are masked, never repaired".

mod bridge;
mod closed;
mod compare;
mod drift;
mod explained;
mod flat;
mod folded;
mod increments;
mod lags;
mod order;
mod outliers;
mod plays;
mod runs;
mod scale;
mod tone;
mod units;
mod wild;

pub(crate) use bridge::bridged;
pub(crate) use compare::compare;
pub(crate) use scale::likely_cause;

use crate::error::Error;
use crate::fourier::power;
use crate::number::round;
use crate::record::Record;
use crate::series::ends;
use serde::Serialize;
use std::ops::Range;

/// A band with less than this share of the input's power counts as not excited.
const DARK: f64 = 1e-4;

/// A kind of defect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Defect {
    /// Fewer samples than required.
    TooShort,
    /// The input is constant.
    ConstantInput,
    /// The output is constant.
    ConstantOutput,
    /// The output is constant at its extreme while the input moves.
    SaturatedOutput,
    /// The recorded input is constant at its extreme while the output still moves.
    ClippedInput,
    /// Single samples of the output far from their neighbours.
    Outliers,
    /// The output repeats exactly while the input moves.
    FrozenOutput,
    /// A smooth input jumps: rows are missing.
    MissingRows,
    /// Input and output are exchanged.
    Swapped,
    /// The output is early or late by samples.
    Shifted,
    /// The input answers the noise of the output.
    ClosedLoop,
    /// The input is sampled less than twice in a period.
    Folded,
    /// Stroke or voltage of no piezo actuator.
    Units,
    /// A slow trend of the output not explained by the input.
    Drift,
    /// The input has no power in the required band.
    PoorExcitation,
}

impl Defect {
    /// True if nothing can be identified from such a record.
    pub(crate) fn is_fatal(self) -> bool {
        matches!(self, Defect::TooShort | Defect::ConstantInput | Defect::ConstantOutput | Defect::Swapped)
    }
}

/// A defect of a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Finding {
    /// Kind of defect.
    pub defect: Defect,
    /// Affected samples; empty for the whole record.
    pub samples: Vec<Range<usize>>,
    /// Description with numbers.
    pub text: String,
}

/// Requirements on a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Need {
    /// Minimum number of samples.
    pub samples: usize,
    /// Band that the input must excite [Hz], if known.
    pub band_hz: Option<(f64, f64)>,
}

impl Default for Need {
    /// 16 samples, any band.
    fn default() -> Self {
        Need { samples: 16, band_hz: None }
    }
}

/// The defects of a record and its usable samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Inspection {
    /// Defects; empty for a valid record.
    pub findings: Vec<Finding>,
    /// For each sample, true if it may be fitted.
    pub usable: Vec<bool>,
}

impl Inspection {
    /// Returns an error if nothing can be identified from the record. [`Error::Unidentifiable`] with the first fatal
    /// finding, or if no sample is usable.
    pub(crate) fn sound(&self) -> Result<(), Error> {
        let because = match self.findings.iter().find(|f| f.defect.is_fatal()) {
            Some(finding) => finding.text.clone(),
            None if !self.usable.contains(&true) => "no sample of the record is valid: measure again".into(),
            None => return Ok(()),
        };
        Err(Error::Unidentifiable { what: "a model".into(), because })
    }

    /// Adds a finding and masks its samples.
    fn mask(&mut self, finding: Option<Finding>) {
        for range in finding.iter().flat_map(|finding| finding.samples.clone()) {
            self.usable[range].fill(false);
        }
        self.findings.extend(finding);
    }

    /// Number of samples that must not be fitted.
    #[cfg(test)]
    pub(crate) fn masked(&self) -> usize {
        self.usable.iter().filter(|usable| !**usable).count()
    }
}

/// Finds the defects of a record.
pub(crate) fn inspect(record: &Record, need: &Need) -> Inspection {
    let mut seen = Inspection { findings: Vec::new(), usable: vec![true; record.len()] };
    seen.findings.extend(unfit(record, need));
    if seen.findings.is_empty() {
        let (wild, tame) = wild::wild(record);
        seen.mask(wild);
        let record = tame.as_ref().unwrap_or(record);
        for finding in [flat::saturated(record), flat::clipped(record), flat::frozen(record), flat::missing(record)] {
            seen.mask(finding);
        }
        seen.mask(outliers::outliers(record, &seen.usable));
        seen.findings.extend(drift::drift(record));
        let (tone, closed) = (tone::tone(record.u(), record.y()), closed::closed(record, &seen.usable));
        seen.findings.extend(order::order(record, tone.as_ref(), closed.is_some()));
        seen.findings.extend([folded::folded(tone.as_ref()), closed, units::units(record)].into_iter().flatten());
    }
    seen.findings.extend(need.band_hz.and_then(|band| dark(record, band)));
    seen
}

/// Defects of a record that make its loop wrong, and what to do, one sentence each. Drawing a loop must be quick, so
/// only these are looked for.
pub(crate) fn loop_defects(record: &Record) -> Vec<String> {
    if unfit(record, &Need::default()).is_some() {
        return Vec::new();
    }
    let saturated = flat::saturated(record).map(|f| (f, "lower the voltage or take a larger range of the sensor"));
    let drifting = drift::drift(record).map(|f| (f, "remove the trend first, or choose a part of few cycles"));
    let wrong = |(Finding { text, .. }, remedy): (Finding, &str)| {
        format!("Width and branches of this loop are wrong, because {text}: {remedy}")
    };
    saturated.into_iter().chain(drifting).map(wrong).collect()
}

/// A fatal defect, if there is one.
fn unfit(record: &Record, need: &Need) -> Option<Finding> {
    let (n, units) = (record.len(), record.units());
    let still = |x: &[f64]| ends(x.iter().copied()).0 == ends(x.iter().copied()).1;
    let (defect, text) = if n < need.samples {
        let text =
            format!("the record has {n} samples, but at least {} are needed: take a longer record", need.samples);
        (Defect::TooShort, text)
    } else if still(record.u()) {
        let at = format!("the input is constant at {} {} over all {n} samples", round(record.u()[0]), units.u);
        (Defect::ConstantInput, format!("{at}: drive the actuator with a sine or a PRBS"))
    } else if still(record.y()) {
        let at = format!("the output is constant at {} {} over all {n} samples", round(record.y()[0]), units.y);
        (Defect::ConstantOutput, format!("{at}: check the connection of the sensor and the selected column"))
    } else {
        return None;
    };
    Some(Finding { defect, samples: Vec::new(), text })
}

/// The band of half an octave on both sides of a frequency [Hz], which shows a resonance there.
pub(crate) fn around(hz: f64) -> (f64, f64) {
    (hz / 2f64.sqrt(), hz * 2f64.sqrt())
}

/// True if an input, with sampling period `ts` [s], has significant power in a band [Hz].
pub(crate) fn excites(u: &[f64], ts: f64, band: (f64, f64)) -> bool {
    share(u, ts, band) > DARK
}

/// The share of the input's power in a band [Hz]; 0 for a constant input.
fn share(u: &[f64], ts: f64, (low, high): (f64, f64)) -> f64 {
    let spectrum = power(u);
    let bin = 1.0 / (u.len() as f64 * ts);
    let within = (1..spectrum.len()).filter(|k| (low..=high).contains(&(*k as f64 * bin)));
    let (band, all) = (within.map(|k| spectrum[k]).sum::<f64>(), spectrum.iter().skip(1).sum::<f64>());
    if all > 0.0 { band / all } else { 0.0 }
}

/// A finding if the input does not excite the band [Hz].
fn dark(record: &Record, (low, high): (f64, f64)) -> Option<Finding> {
    let share = share(record.u(), record.ts(), (low, high));
    let text = format!(
        "the input has {} % of its power from {} to {} Hz, so nothing can be identified in this band: add a record that \
         excites it, for example a PRBS or a multisine",
        round(100.0 * share),
        round(low),
        round(high)
    );
    (share <= DARK).then_some(Finding { defect: Defect::PoorExcitation, samples: Vec::new(), text })
}

/// Number and times of the samples in sorted ranges, for example "12 samples (from 0.15 s to 0.1555 s)".
pub(crate) fn places(ranges: &[Range<usize>], ts: f64) -> String {
    let count: usize = ranges.iter().map(|r| r.len()).sum();
    let at = |k: usize| round(k as f64 * ts);
    let noun = if count == 1 { "sample" } else { "samples" };
    let (Some(first), Some(last)) = (ranges.first(), ranges.last()) else { return format!("{count} {noun}") };
    match (ranges.len(), count) {
        (1, 1) => format!("{count} {noun} (at {} s)", at(first.start)),
        (1, _) => format!("{count} {noun} (from {} s to {} s)", at(first.start), at(first.end - 1)),
        (many, _) => {
            let (first, last) = (at(first.start), at(last.start));
            format!("{count} {noun} in {many} places (the first at {first} s, the last at {last} s)")
        }
    }
}

#[cfg(test)]
mod tests;
