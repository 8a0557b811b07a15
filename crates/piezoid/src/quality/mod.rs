//! What is wrong with a record, before anybody fits it.
//!
//! | defect | how it is told | what follows |
//! |---|---|---|
//! | too short, constant input, constant output | counted | refused |
//! | saturated output | y stays at its extreme while u moves | masked |
//! | clipped input | y arches while u stays at its extreme | masked |
//! | wild values | far beyond all others, while the input is not | masked |
//! | outliers | one sample off its neighbours beyond all that is usual there (Hampel) | masked |
//! | frozen output | y repeats to the bit while u moves | masked |
//! | missing rows | a smooth u jumps | masked from there until u has been as high and as low as before |
//! | drift | what u does not explain moves, and does not slow down as creep does | told |
//! | poor excitation | u has no power in the band that is needed | told |
//!
//! Rows that must not be fitted are masked in [`Inspection::usable`]; nothing is repaired. A spike of less than 1 % of
//! peak-to-peak, a drift as small as creep, and a clipped square wave look like sound data, and pass.
//!
//! Reference: Pearson 2002, Outliers in process modeling and identification, doi:10.1109/87.974338 (Hampel's rule).

mod bridge;
mod drift;
mod explained;
mod flat;
mod outliers;
mod runs;
mod wild;

pub(crate) use bridge::bridged;

use crate::error::Error;
use crate::fourier::power;
use crate::number::round;
use crate::record::Record;
use crate::series::ends;
use serde::Serialize;
use std::ops::Range;

/// Share of the input's power below which a band counts as not excited.
const DARK: f64 = 1e-4;

/// What can be wrong with a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Defect {
    /// Fewer samples than are needed.
    TooShort,
    /// The input never moves.
    ConstantInput,
    /// The output never moves.
    ConstantOutput,
    /// The output stays at its extreme although the input moves.
    SaturatedOutput,
    /// The recorded input stays at its extreme although the output says it went on.
    ClippedInput,
    /// Single samples of the output far off their neighbours.
    Outliers,
    /// The output repeats to the bit although the input moves.
    FrozenOutput,
    /// A smooth input jumps: rows are missing there.
    MissingRows,
    /// A slow trend of the output that the input does not explain.
    Drift,
    /// The input has no power in the band that is needed.
    PoorExcitation,
}

impl Defect {
    /// Whether nothing can be identified from such a record.
    pub(crate) fn is_fatal(self) -> bool {
        matches!(self, Defect::TooShort | Defect::ConstantInput | Defect::ConstantOutput)
    }
}

/// One thing that is wrong with a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Finding {
    /// Which.
    pub defect: Defect,
    /// Where, each range from its first sample up to, not including, its last; all of it if nowhere in particular.
    pub samples: Vec<Range<usize>>,
    /// What is wrong, with its numbers, and what follows.
    pub text: String,
}

/// What a record is needed for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Need {
    /// The fewest samples that are enough.
    pub samples: usize,
    /// The frequencies that the input must excite [Hz], where that is known.
    pub band_hz: Option<(f64, f64)>,
}

impl Default for Need {
    /// 16 samples, of any frequency.
    fn default() -> Self {
        Need { samples: 16, band_hz: None }
    }
}

/// What is wrong with a record, and which of its samples may be fitted.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Inspection {
    /// What was found; nothing in a sound record.
    pub findings: Vec<Finding>,
    /// For each sample, whether it may be fitted.
    pub usable: Vec<bool>,
}

impl Inspection {
    /// Refuses what nothing can be identified from.
    ///
    /// # Errors
    /// [`Error::Unidentifiable`] with the first fatal finding, or when no sample is usable.
    pub(crate) fn sound(&self) -> Result<(), Error> {
        let what = || "a model".to_string();
        match self.findings.iter().find(|f| f.defect.is_fatal()) {
            Some(finding) => Err(Error::Unidentifiable { what: what(), because: finding.text.clone() }),
            None if !self.usable.contains(&true) => Err(Error::Unidentifiable {
                what: what(),
                because: "no sample of the record is sound: measure again".into(),
            }),
            None => Ok(()),
        }
    }

    /// Adds a finding and masks its samples.
    fn mask(&mut self, finding: Option<Finding>) {
        for range in finding.iter().flat_map(|finding| finding.samples.clone()) {
            self.usable[range].fill(false);
        }
        self.findings.extend(finding);
    }

    /// Samples that must not be fitted.
    #[cfg(test)]
    pub(crate) fn masked(&self) -> usize {
        self.usable.iter().filter(|usable| !**usable).count()
    }
}

/// Looks a record over.
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
    }
    seen.findings.extend(need.band_hz.and_then(|band| dark(record, band)));
    seen
}

/// What makes a record no record to identify from.
fn unfit(record: &Record, need: &Need) -> Option<Finding> {
    let (n, units) = (record.len(), record.units());
    let fatal = |defect, text| Some(Finding { defect, samples: Vec::new(), text });
    let still = |x: &[f64]| ends(x.iter().copied()).0 == ends(x.iter().copied()).1;
    if n < need.samples {
        return fatal(
            Defect::TooShort,
            format!("the record has {n} samples, but at least {} are needed: record longer", need.samples),
        );
    }
    if still(record.u()) {
        let text = format!(
            "the input is constant at {} {} over all {n} samples: drive the actuator with a sine or a PRBS",
            round(record.u()[0]),
            units.u
        );
        return fatal(Defect::ConstantInput, text);
    }
    if still(record.y()) {
        let text = format!(
            "the output is constant at {} {} over all {n} samples: is the sensor connected, and the column the right one?",
            round(record.y()[0]),
            units.y
        );
        return fatal(Defect::ConstantOutput, text);
    }
    None
}

/// Half an octave to either side of a frequency [Hz]: the band that shows a resonance there.
pub(crate) fn around(hz: f64) -> (f64, f64) {
    (hz / 2f64.sqrt(), hz * 2f64.sqrt())
}

/// Whether an input, sampled every `ts` [s], has power worth the name in a band [Hz].
pub(crate) fn excites(u: &[f64], ts: f64, band: (f64, f64)) -> bool {
    share(u, ts, band) > DARK
}

/// The share of the input's power in a band [Hz]; 0 where it does not move.
fn share(u: &[f64], ts: f64, (low, high): (f64, f64)) -> f64 {
    let spectrum = power(u);
    let bin = 1.0 / (u.len() as f64 * ts);
    let within = (1..spectrum.len()).filter(|k| (low..=high).contains(&(*k as f64 * bin)));
    let (band, all) = (within.map(|k| spectrum[k]).sum::<f64>(), spectrum.iter().skip(1).sum::<f64>());
    if all > 0.0 { band / all } else { 0.0 }
}

/// Says that the input leaves the band unexcited, if it does.
fn dark(record: &Record, (low, high): (f64, f64)) -> Option<Finding> {
    let share = share(record.u(), record.ts(), (low, high));
    let text = format!(
        "the input has {} % of its power from {} to {} Hz, so nothing there can be identified from it: add a record that excites \
         this band, a PRBS or a multisine",
        round(100.0 * share),
        round(low),
        round(high)
    );
    (share <= DARK).then_some(Finding { defect: Defect::PoorExcitation, samples: Vec::new(), text })
}

/// "12 samples, from 0.15 s to 0.1555 s", of ranges in order.
fn places(ranges: &[Range<usize>], ts: f64) -> String {
    let count: usize = ranges.iter().map(|r| r.len()).sum();
    let at = |k: usize| round(k as f64 * ts);
    let noun = if count == 1 { "sample" } else { "samples" };
    let (Some(first), Some(last)) = (ranges.first(), ranges.last()) else { return format!("{count} {noun}") };
    match (ranges.len(), count) {
        (1, 1) => format!("{count} {noun} (at {} s)", at(first.start)),
        (1, _) => format!("{count} {noun} (from {} s to {} s)", at(first.start), at(first.end - 1)),
        (many, _) => format!(
            "{count} {noun} in {many} places (the first at {} s, the last at {} s)",
            at(first.start),
            at(last.start)
        ),
    }
}

#[cfg(test)]
mod tests;
