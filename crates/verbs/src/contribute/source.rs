//! `SOURCE.md`: what a contribution states, for people.

use super::{ContributedFile, DOCUMENT, Document};
use piezoid_numerics::number::round;
use piezoid_numerics::words::{capitalised, wrapped};
use piezoid_records::record::Units;

/// Length of its lines.
const WIDTH: usize = 100;

/// The text.
pub(super) fn text(document: &Document) -> String {
    let Document { statement, files, findings, version, .. } = document;
    let mut text = format!("# {}\n\n", statement.actuator.as_deref().unwrap_or_default().trim());
    let mut item = |line: String| text += &(wrapped(&format!("- {line}"), WIDTH, "  ") + "\n");
    for (name, stated) in statement.texts() {
        let stated = stated.as_deref().map_or("not stated", str::trim);
        item(format!("{}: {stated}", capitalised(if name == "who" { "measured by" } else { name })));
    }
    if let Some([licence, address]) = statement.licence.map(|licence| licence.words()) {
        item(format!("Licence: {licence}, <{address}>"));
    }
    text += "\n## Files\n\n";
    for file in files {
        let ContributedFile { samples, ts, duration, units: Units { u, y }, .. } = file;
        let [every, duration] = [*ts, *duration].map(round);
        let used = file.proposed["use"].as_str().map_or(String::new(), |used| format!("; proposed for {used}"));
        let facts = format!("{samples} samples every {every} s, {duration} s, u in {u}, y in {y}{used}");
        text += &(wrapped(&format!("- `{}`: {facts}", file.file), WIDTH, "  ") + "\n");
        text += &format!("  SHA-256 {}\n", file.sha256);
        for finding in &file.findings {
            text += &(wrapped(&format!("  - {finding}"), WIDTH, "    ") + "\n");
        }
    }
    if !findings.is_empty() {
        text += "\n## Findings\n\n";
        findings.iter().for_each(|finding| text += &(wrapped(&format!("- {finding}"), WIDTH, "  ") + "\n"));
    }
    text + &format!("\nWritten by `piezoid contribute`, version {version}. {DOCUMENT} says the same to programs.\n")
}
