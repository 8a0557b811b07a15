//! docs/feedback.md: systems in which the mechanics drive the hysteresis.

mod benchmark;
mod bender;

use std::path::Path;

/// Measures, and writes the tables of the page.
pub fn write(docs: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let page = docs.join("feedback.md");
    benchmark::write(&page)?;
    bender::write(&page)
}
