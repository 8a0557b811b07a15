//! Defects of a record that is too long to be held: each of its sections is inspected alone.
//!
//! It does not find: what only the whole shows, such as a drift that no section shows.

use super::{DETECTORS, Finding, inspect};
use crate::record::Record;
use piezoid_numerics::number::round;
use std::ops::Range;

/// Most ranges of samples that are kept of a defect.
const MAX_RANGES: usize = 100;

/// The defects of sections.
#[derive(Debug, Default)]
pub struct InSections {
    /// Number of sections so far.
    count: usize,
    found: Vec<Found>,
}

/// A defect: what was found first, in which section [s], and in how many.
#[derive(Debug)]
struct Found {
    first: Finding,
    section: [f64; 2],
    count: usize,
}

impl InSections {
    /// Inspects the next section, whose first sample is sample `start` of the record.
    pub fn add(&mut self, section: &Record, start: usize) {
        self.count += 1;
        for Finding { detector, samples, text } in inspect(section).findings {
            let all = samples.is_empty().then_some(0..section.len());
            let ranges = samples.into_iter().chain(all).map(|range| range.start + start..range.end + start);
            let known = self.found.iter_mut().find(|found| std::ptr::eq(found.first.detector, detector));
            let kept = match known {
                Some(known) => {
                    known.count += 1;
                    &mut known.first.samples
                }
                None => {
                    let section = [start, start + section.len()].map(|t| t as f64 * section.ts());
                    let first = Finding { detector, samples: Vec::new(), text };
                    self.found.push(Found { first, section, count: 1 });
                    let Some(last) = self.found.last_mut() else { continue };
                    &mut last.first.samples
                }
            };
            let room = MAX_RANGES.saturating_sub(kept.len());
            kept.extend(ranges.take(room).collect::<Vec<Range<usize>>>());
        }
    }

    /// The defects, in the order of [`DETECTORS`], as those of the first section that has them; if there are several
    /// sections, the text says so.
    pub fn findings(self) -> Vec<Finding> {
        let place = |found: &Found| DETECTORS.iter().position(|row| std::ptr::eq(*row, found.first.detector));
        let (mut found, sections) = (self.found, self.count);
        found.sort_by_key(place);
        let one = |Found { first, section, count }| {
            let [from, to] = section.map(round);
            let places = if count == 1 { String::new() } else { format!("; found in {count} of {sections} sections") };
            let section = format!(" (in the section from {from} s to {to} s, with times from its start{places})");
            Finding { text: if sections == 1 { first.text } else { first.text + &section }, ..first }
        };
        found.into_iter().map(one).collect()
    }
}
