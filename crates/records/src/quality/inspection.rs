//! The result of an inspection: defects, and the samples that may be fitted.

use super::Detector;
use piezoid_numerics::error::Error;
use std::ops::Range;

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
    /// finding, or if no sample is usable.
    pub fn require_usable(&self) -> Result<(), Error> {
        let because = match self.findings.iter().find(|f| f.detector.consequence.is_fatal()) {
            Some(finding) => finding.text.clone(),
            None if !self.usable.contains(&true) => "no sample of the record is valid: measure again".into(),
            None => return Ok(()),
        };
        Err(Error::Unidentifiable { what: "a model".into(), because })
    }

    /// Number of samples that must not be fitted.
    #[cfg(test)]
    pub(crate) fn masked(&self) -> usize {
        self.usable.iter().filter(|usable| !**usable).count()
    }
}
