//! The history of a record in its file: the steps that produced it, for later readers.
//!
//! ```text
//! CSV          # piezoid: decimated by 4, ...     one line a step, before all others
//! .npz, .mat   piezoid_history                    one text, one line a step
//! ```
//! A record without a history is written without any of this.

use super::csv::lines as lines_of;

/// Start of a line of CSV that holds a step.
const MARK: &str = "# piezoid: ";

/// Name of the text in binary files.
pub(super) const NAME: &str = "piezoid_history";

/// The lines of CSV for these steps.
pub(super) fn lines(steps: &[String]) -> String {
    steps.iter().map(|step| format!("{MARK}{}\n", one_line(step))).collect()
}

/// The steps at the start of a text, and the number of its bytes that they take.
pub(super) fn before(text: &str) -> (Vec<String>, usize) {
    let own = lines_of(text).map_while(|(_, line)| Some((line, line.strip_prefix(MARK.trim_end())?)));
    own.fold((Vec::new(), 0), |(mut steps, bytes), (line, step)| {
        steps.push(step.trim().to_string());
        (steps, (bytes + line.len() + 1).min(text.len()))
    })
}

/// The text of these steps in a binary file.
pub(super) fn text(steps: &[String]) -> String {
    steps.iter().map(|step| one_line(step)).collect::<Vec<_>>().join("\n")
}

/// The steps in a text of a binary file.
pub(super) fn steps(text: &str) -> Vec<String> {
    text.lines().map(|step| step.trim().to_string()).filter(|step| !step.is_empty()).collect()
}

/// Names of columns may hold anything.
fn one_line(step: &str) -> String {
    step.replace(char::is_control, " ").trim().to_string()
}
