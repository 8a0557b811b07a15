//! The result of an inspection: defects, and the samples that may be fitted.

use super::{Consequence, Detector};
use piezoid_numerics::error::Error;
use std::ops::Range;

/// The smallest share of valid samples of a record that is used.
const MIN_USABLE_SHARE: f64 = 1.0 / 3.0;

/// What a detector found.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// Affected samples; empty for the whole record.
    pub samples: Vec<Range<usize>>,
    /// Description with numbers.
    pub text: String,
}

impl From<String> for Detection {
    /// A defect of the whole record.
    fn from(text: String) -> Self {
        Detection { samples: Vec::new(), text }
    }
}

/// A defect of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The detector that found it.
    pub detector: &'static Detector,
    /// Affected samples; empty for the whole record.
    pub samples: Vec<Range<usize>>,
    /// Description with numbers.
    pub text: String,
}

/// The defects of a record and its usable samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// Defects; empty for a valid record.
    pub findings: Vec<Finding>,
    /// For each sample, true if it may be fitted.
    pub usable: Vec<bool>,
}

impl Inspection {
    /// True if this detector, or another of the same defect, found something.
    pub fn has(&self, detector: &Detector) -> bool {
        self.findings.iter().any(|finding| finding.detector == detector)
    }

    /// Returns an error if nothing can be identified from the record. [`Error::Unidentifiable`] with the first fatal
    /// finding, or if fewer than a third of the samples are usable: the rest may not show what the record is for.
    pub fn require_usable(&self) -> Result<(), Error> {
        let because = match self.findings.iter().find(|f| f.detector.consequence.is_fatal()) {
            Some(finding) => finding.text.clone(),
            None => match self.usable.iter().filter(|usable| **usable).count() {
                0 => "no sample of the record is valid: measure again".into(),
                valid if valid as f64 >= MIN_USABLE_SHARE * self.usable.len() as f64 => return Ok(()),
                valid => {
                    let masked = self.findings.iter().filter(|f| f.detector.consequence == Consequence::Masked);
                    let why: Vec<&str> = masked.map(|finding| finding.text.as_str()).collect();
                    let (all, why) = (self.usable.len(), why.join("; "));
                    format!(
                        "only {valid} of {all} samples of the record are valid: {why}: cut the record or measure again"
                    )
                }
            },
        };
        Err(Error::Unidentifiable { what: "a model".into(), because })
    }

    /// Number of samples that must not be fitted.
    #[cfg(test)]
    pub(crate) fn masked(&self) -> usize {
        self.usable.iter().filter(|usable| !**usable).count()
    }
}
